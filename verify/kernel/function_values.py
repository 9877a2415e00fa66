"""Values in ball arithmetic of special functions that FLINT does not provide.

Weierstrass' function of any invariants has the series
p(z) = 1/z**2 + sum of c_k z**(2 k - 2), k >= 2, with c_2 = g2/20, c_3 = g3/28 and, from k = 4 on,
(2 k + 1)(k - 3) c_k = 3 sum of c_i c_(k - i), 2 <= i <= k - 2.  If B**2 >= |g2|/60 and
B**3 >= |g3|/84 then |c_k| <= 3 B**k, by induction: of k - 3 products each is at most 9 B**k.

Jacobi functions come from theta functions.  For m > 1, sn(z, m) = sn(w, 1/m)/sqrt(m),
cn(z, m) = dn(w, 1/m) and dn(z, m) = cn(w, 1/m) with w = sqrt(m) z; so the integral of dn(z, m)**2
is (1 - m) z + sqrt(m) times that of dn(w, 1/m)**2.
"""

from __future__ import annotations

from flint import acb, acb_series, arb, ctx, fmpq

from .limits import CertificateError

THETA = tuple(f"jacobi_theta_{place}" for place in (1, 2, 3, 4))
"""Names of the theta functions of z and the nome q, 0 < q < 1."""

Jet = tuple[str, int]
"""Name of a function, and order of its derivative."""

TERMS = 80
"""Number of terms of Weierstrass' series, which is used where B |z|**2 < 1/16."""

POSITIVE_SHIFT = arb(2) ** -60
"""Number added to a radicand that may be 0, since FLINT has no cube root of 0."""


class Jacobi:
    """The Jacobi functions of a real parameter ``m``, not 0 or 1, at any argument."""

    def __init__(self, m: acb) -> None:
        above = m.real > 1
        if m.imag != 0 or not (above or m.real < 1) or m.contains(0):
            got = m.str(10)
            raise CertificateError(f"elliptic parameters must be real, not 0 or 1, got m = {got}")
        self.m, self._root, self._places = m, acb(1), (1, 2)
        if above:
            m, self._root, self._places = 1 / m, m.sqrt(), (2, 1)
        self.K, self.E = m.elliptic_k(), m.elliptic_e()
        self._tau = acb(0, 1) * (1 - m).elliptic_k() / self.K
        self._zeros = self._thetas(acb(0))
        self.root_k = self._zeros[1] / self._zeros[2]

    def sn(self, z: acb) -> acb:
        """Return sn(z, m)."""
        one, _, _, four = self._thetas(self._root * z)
        return one / (self.root_k * four * self._root)

    def cn(self, z: acb) -> acb:
        """Return cn(z, m)."""
        return self._ratio(z, self._places[0])

    def dn(self, z: acb) -> acb:
        """Return dn(z, m)."""
        return self._ratio(z, self._places[1])

    def _ratio(self, z: acb, place: int) -> acb:
        thetas = self._thetas(self._root * z)
        return self._zeros[3] * thetas[place] / (self._zeros[place] * thetas[3])

    def epsilon(self, z: acb) -> acb:
        """Return epsilon(z, m), the integral of dn**2 from 0 to z."""
        w = self._root * z
        below = self._zeta(w) + self.E / self.K * w
        return below if self._root == 1 else (1 - self.m) * z + self._root * below

    def zeta(self, z: acb) -> acb:
        """Return Jacobi's zeta(z, m) = Theta'/Theta."""
        return self._zeta(self._below_one(z))

    def theta(self, z: acb) -> acb:
        """Return Jacobi's Theta(z, m)."""
        return self._thetas(self._below_one(z))[3]

    def eta(self, z: acb) -> acb:
        """Return H = sqrt(k) sn Theta."""
        return self.root_k * self.sn(z) * self.theta(z)

    def _below_one(self, z: acb) -> acb:
        if self._root != 1:
            raise CertificateError(f"zeta and theta need m < 1, got m = {self.m.str(10)}")
        return z

    def _zeta(self, z: acb) -> acb:
        """Return Jacobi's zeta, from Weierstrass' zeta function with periods 1 and tau."""
        v = z / (2 * self.K) + self._tau / 2
        eta = acb(0.5).elliptic_zeta(self._tau)
        slope = v.elliptic_zeta(self._tau) - 2 * eta * v + acb(0, 1) * acb.pi()
        return slope / (2 * self.K)

    def _thetas(self, z: acb) -> tuple[acb, ...]:
        return tuple(acb.modular_theta(z / (2 * self.K), self._tau))


def weierstrass(z: acb, g2: acb, g3: acb) -> tuple[acb, acb]:
    """Return p(z) and p'(z) with invariants g2, g3: the series at z/2**n, then n doublings."""
    bound = _upper(abs(g2) / 60).sqrt() + _upper(abs(g3) / 84 + POSITIVE_SHIFT).root(3)
    halvings = 0
    while not bound * abs(z) ** 2 < arb(1) / 16 and halvings < 64:
        z, halvings = z / 2, halvings + 1
    p, slope = _series(z, g2, g3, _upper(bound))
    for _ in range(halvings):
        tangent = (6 * p * p - g2 / 2) / slope
        doubled = tangent * tangent / 4 - 2 * p
        p, slope = doubled, -slope - tangent * (doubled - p)
    return p, slope


def _series(z: acb, g2: acb, g3: acb, bound: arb) -> tuple[acb, acb]:
    """Return enclosures of p and p': terms k < `TERMS`, and the rest by |c_k| <= 3 ``bound``**k."""
    c = [acb(0), acb(0), g2 / 20, g3 / 28]
    for k in range(4, TERMS):
        products = sum((c[i] * c[k - i] for i in range(2, k - 1)), acb(0))
        c.append(3 * products / ((2 * k + 1) * (k - 3)))
    square = z * z
    p = 1 / square + sum((c[k] * square ** (k - 1) for k in range(2, TERMS)), acb(0))
    slope = sum(((2 * k - 2) * c[k] * square ** (k - 2) for k in range(2, TERMS)), acb(0)) * z
    slope -= 2 / (square * z)
    ratio = bound * _upper(abs(square))
    rest = 3 * bound * ratio ** (TERMS - 1) / (1 - ratio)
    return _blurred(p, rest), _blurred(slope, rest * 4 * TERMS / abs(z))


def _upper(value: arb) -> arb:
    """Return the upper end of a ball, as an exact ball."""
    return arb(value.upper())


def _blurred(value: acb, error: arb) -> acb:
    radius = arb(0, error.upper())
    return value + acb(radius, radius)


def theta_ball(z: acb, q: acb, jet: Jet) -> acb:
    """Return the derivative of a theta function that ``jet`` names, at z and the nome q."""
    label, order = jet
    tau = q.log() / (acb(0, 1) * acb.pi())
    values = (z / acb.pi()).modular_theta(tau, order)
    return values[THETA.index(label)] / acb.pi() ** order


def jet_ball(z: acb, jet: Jet) -> acb:
    """Return a derivative of 1/gamma(z + s), which stands for the arbitrary function of ``jet``."""
    label, order = jet
    place = z + acb(arb(generic_shift(label)))
    terms, ctx.cap = ctx.cap, order + 1  # FLINT's series take the terms beyond for 0
    series = acb_series([place, 1], order + 1).rgamma()
    ctx.cap = terms
    return series[order] * acb(order + 1).gamma()


def generic_shift(label: str) -> fmpq:
    """Return the shift s for a function's name: 1/gamma(z + s) stands for an arbitrary function."""
    return fmpq(sum(map(ord, label)) % 89, 97)
