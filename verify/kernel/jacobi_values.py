"""Values of the Jacobi functions in ball arithmetic, by theta functions.

For m > 1, sn(z, m) = sn(w, 1/m)/sqrt(m), cn(z, m) = dn(w, 1/m) and dn(z, m) = cn(w, 1/m) with
w = sqrt(m) z; so the integral of dn(z, m)**2 is (1 - m) z + sqrt(m) times that of dn(w, 1/m)**2.
"""

from __future__ import annotations

from flint import acb

from .limits import CertificateError


class Jacobi:
    """The Jacobi functions of a real parameter ``m``, not 0 or 1, at any argument."""

    def __init__(self, m: acb) -> None:
        above = m.real > 1
        if m.imag != 0 or not (above or m.real < 1) or m.contains(0):
            shown = m.str(10)
            raise CertificateError(f"elliptic parameters must be real, not 0 or 1, got m = {shown}")
        self.m, self._root, self._places = m, acb(1), (1, 2)
        if above:
            m, self._root, self._places = 1 / m, m.sqrt(), (2, 1)
        self.K, self.E = m.elliptic_k(), m.elliptic_e()
        self._tau = acb(0, 1) * (1 - m).elliptic_k() / self.K
        self._zeros = self._thetas(acb(0))
        self.root_k = self._zeros[1] / self._zeros[2]

    def sn(self, z: acb) -> acb:
        """sn."""
        one, _, _, four = self._thetas(self._root * z)
        return one / (self.root_k * four * self._root)

    def cn(self, z: acb) -> acb:
        """cn."""
        return self._ratio(z, self._places[0])

    def dn(self, z: acb) -> acb:
        """dn."""
        return self._ratio(z, self._places[1])

    def _ratio(self, z: acb, place: int) -> acb:
        found = self._thetas(self._root * z)
        return self._zeros[3] * found[place] / (self._zeros[place] * found[3])

    def epsilon(self, z: acb) -> acb:
        """The integral of dn**2 from 0."""
        w = self._root * z
        below = self._zeta(w) + self.E / self.K * w
        return below if self._root == 1 else (1 - self.m) * z + self._root * below

    def zeta(self, z: acb) -> acb:
        """Theta'/Theta."""
        return self._zeta(self._below_one(z))

    def theta(self, z: acb) -> acb:
        """Theta."""
        return self._thetas(self._below_one(z))[3]

    def eta(self, z: acb) -> acb:
        """H = sqrt(k) sn Theta."""
        return self.root_k * self.sn(z) * self.theta(z)

    def _below_one(self, z: acb) -> acb:
        if self._root != 1:
            raise CertificateError(f"zeta and theta need m < 1, got m = {self.m.str(10)}")
        return z

    def _zeta(self, z: acb) -> acb:
        """Zeta, from Weierstrass' zeta function of the periods 1 and tau."""
        v = z / (2 * self.K) + self._tau / 2
        eta = acb(0.5).elliptic_zeta(self._tau)
        slope = v.elliptic_zeta(self._tau) - 2 * eta * v + acb(0, 1) * acb.pi()
        return slope / (2 * self.K)

    def _thetas(self, z: acb) -> tuple[acb, ...]:
        return tuple(acb.modular_theta(z / (2 * self.K), self._tau))
