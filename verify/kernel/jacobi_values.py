"""Values of the Jacobi functions in ball arithmetic, by theta functions."""

from __future__ import annotations

from flint import acb


class Jacobi:
    """The Jacobi functions of a real parameter ``m < 1``, ``m != 0``, at any argument."""

    def __init__(self, m: acb) -> None:
        if not (m.imag == 0 and m.real < 1 and m.real != 0):
            raise ValueError(f"m must satisfy m < 1 and m != 0, got {m.str(10)} (take 0 < k < 1)")
        self.m, self.K, self.E = m, m.elliptic_k(), m.elliptic_e()
        self._tau = acb(0, 1) * (1 - m).elliptic_k() / self.K
        _, self._two, self._three, self._four = self._thetas(acb(0))
        self.root_k = self._two / self._three

    def sn(self, z: acb) -> acb:
        """sn."""
        one, _, _, four = self._thetas(z)
        return self._three * one / (self._two * four)

    def cn(self, z: acb) -> acb:
        """cn."""
        _, two, _, four = self._thetas(z)
        return self._four * two / (self._two * four)

    def dn(self, z: acb) -> acb:
        """dn."""
        _, _, three, four = self._thetas(z)
        return self._four * three / (self._three * four)

    def epsilon(self, z: acb) -> acb:
        """The integral of dn**2 from 0."""
        return self.zeta(z) + self.E / self.K * z

    def zeta(self, z: acb) -> acb:
        """Theta'/Theta, from Weierstrass' zeta function of the periods 1 and tau."""
        v = z / (2 * self.K) + self._tau / 2
        eta = acb(0.5).elliptic_zeta(self._tau)
        slope = v.elliptic_zeta(self._tau) - 2 * eta * v + acb(0, 1) * acb.pi()
        return slope / (2 * self.K)

    def theta(self, z: acb) -> acb:
        """Theta."""
        return self._thetas(z)[3]

    def eta(self, z: acb) -> acb:
        """H = sqrt(k) sn Theta."""
        return self.root_k * self.sn(z) * self.theta(z)

    def _thetas(self, z: acb) -> tuple[acb, ...]:
        return tuple(acb.modular_theta(z / (2 * self.K), self._tau))
