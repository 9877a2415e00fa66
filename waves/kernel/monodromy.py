r"""Floquet multipliers of an orbit of a finite chain: Taylor steps over half a period.

In tau = Omega t a perturbation moves by y'' = -B(tau) y, B = (dG_n/dq_m)/Omega^2, which is
symmetric, even and 2 pi periodic. With the propagator P = [[a, b], [c, d]] of (y, y') from 0 to pi
and R = diag(1, -1), the monodromy matrix is M = R P^-1 R P, and as P is symplectic,

    M + M^-1 = diag(2 A, 2 A^T),   A = 1 + 2 b^T c.

The multipliers z thus satisfy z + 1/z = 2 mu for the eigenvalues mu of A. One mu is 1, by the
perturbation q', and belongs to the multiplier 1, twice.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from flint import acb, acb_mat, arb, arb_mat

from .cosine_series import Series, largest, upper
from .limits import CertificateError, require_size
from .orbit import Index, OrbitCentre
from .periodic import identity

DISC = 8
"""Radius of the disc on which a step's solution is bounded, in steps."""


@dataclass(frozen=True)
class Monodromy:
    """The perturbations of the orbit within ``radius`` of a centre: Taylor steps of an order."""

    centre: OrbitCentre
    radius: arb
    steps: int
    order: int

    @property
    def count(self) -> int:
        """Number of sites."""
        return len(self.centre.sites)

    @property
    def step(self) -> arb:
        """Length of a step."""
        return arb.pi() / self.steps

    @cached_property
    def frequency_squared(self) -> arb:
        """Squared frequency Omega^2 of the orbit, as a ball."""
        return self.centre.frequency_squared_within(self.radius)

    @cached_property
    def coefficients(self) -> dict[Index, Series]:
        """Modes of the matrix B at the centre, by its entries."""
        known = self.centre.stiffness_of(lambda law: law.stiffness)
        return {key: [c / self.frequency_squared for c in g] for key, g in known.items()}

    @cached_property
    def error(self) -> arb:
        """Bound of the largest row sum of the difference between B of the orbit and the centre."""
        errors = (
            len(bond.ends) * (law.stiffness_rest + law.third * self.radius)
            for bond, law in self.centre.laws
        )
        return upper(self.centre.over_bonds(errors) / self.frequency_squared)

    @cached_property
    def step_error(self) -> arb:
        """Bound of the error of each entry of a step's propagator.

        If |B| <= s^2, s >= 1, the propagator from 0 to t has entries of at most s exp(s t). This on
        the disc of radius rho about the start bounds the rest of the Taylor series; an error e of B
        changes an entry by at most h e exp((s + e) h).
        """
        h, rho = self.step, DISC * self.step
        disc, real = self._root_of_size(rho), self._root_of_size(arb(0))
        series = disc * (disc * rho).exp() * arb(DISC) ** -self.order / (1 - arb(1) / DISC)
        return upper(series + h * self.error * ((real + self.error) * h).exp())

    def _root_of_size(self, height: arb) -> arb:
        """Return s >= 1 with |B| <= s^2 up to this distance from the real axis."""
        top = max(map(len, self.coefficients.values()))
        waves = [2 * (height * k).cosh() if k else arb(1) for k in range(top)]
        rows = [arb(0)] * self.count
        for (n, _), g in self.coefficients.items():
            rows[n] += sum((abs(c) * wave for c, wave in zip(g, waves, strict=False)), arb(0))
        return upper(largest([arb(1), *rows]).sqrt())

    def half(self) -> arb_mat:
        """Return the propagator P over half a period."""
        require_size(self.count * self.count * self.order * self.order)
        total = identity(2 * self.count)
        for i in range(self.steps):
            total = self._propagator(i * self.step) * total
        return total

    def _propagator(self, start: arb) -> arb_mat:
        """Return the propagator of a step, by the Taylor series of y about its start."""
        taylor, size = self._taylor(start), self.count
        unit, nothing = identity(size).tolist(), [arb(0)] * size
        y = [
            arb_mat([[*row, *nothing] for row in unit]),
            arb_mat([[*nothing, *row] for row in unit]),
        ]
        for j in range(self.order - 1):
            total = taylor[0] * y[j]
            for i in range(1, j + 1):
                total += taylor[i] * y[j - i]
            y.append(total * (arb(-1) / ((j + 1) * (j + 2))))
        value, slope = y[-1], y[-1] * arb(self.order)
        for j in range(self.order - 1, 0, -1):
            value, slope = value * self.step + y[j], slope * self.step + y[j] * arb(j)
        value = value * self.step + y[0]
        error = arb(0, self.step_error)
        return arb_mat([[c + error for c in row] for row in (*value.tolist(), *slope.tolist())])

    def _taylor(self, start: arb) -> list[arb_mat]:
        """Return the Taylor coefficients of B about ``start``."""
        keys = list(self.coefficients)
        top = max(map(len, self.coefficients.values()))
        angles = [start * k for k in range(top)]
        turns = [(a.cos(), -a.sin(), -a.cos(), a.sin()) for a in angles]
        factors, rows = [arb(1), *[arb(2)] * (top - 1)], []
        for m in range(self.order):
            rows.append([f * turn[m % 4] for f, turn in zip(factors, turns, strict=True)])
            factors = [f * k / (m + 1) for k, f in enumerate(factors)]
        modes = [[*g, *[arb(0)] * (top - len(g))] for g in self.coefficients.values()]
        products = (arb_mat(rows) * arb_mat(modes).transpose()).tolist()
        result = []
        for values in products:
            entries = dict(zip(keys, values, strict=True))
            sites = range(self.count)
            result.append(arb_mat([[entries.get((n, m), arb(0)) for m in sites] for n in sites]))
        return result


@dataclass(frozen=True)
class Multiplier:
    """The multiplier z of a pair z, 1/z with |z| > 1, or |z| = 1 and Im z > 0."""

    value: acb
    is_on_circle: bool


def multipliers(half: arb_mat) -> list[Multiplier]:
    """Return one of each pair z, 1/z but the pair 1, 1, from the propagator P.

    Raises CertificateError unless the pairs are proved to be different.
    """
    table = half.tolist()
    size = len(table) // 2
    b, c = arb_mat([row[size:] for row in table[:size]]), arb_mat([r[:size] for r in table[size:]])
    try:
        values = acb_mat(identity(size) + 2 * (b.transpose() * c)).eig(algorithm="rump")
    except ValueError:
        raise CertificateError("the multipliers are not proved to be different") from None
    pairs = []
    for i, mu in enumerate(values):
        if not mu.contains(1):
            others = [*values[:i], *values[i + 1 :]]
            is_real = not any(mu.conjugate().overlaps(other) for other in others)
            pairs.append(_on_real_axis(mu.real) if is_real else _off_circle(mu))
    if len(pairs) != size - 1:
        raise CertificateError("the multiplier 1 is not separated from the others")
    return sorted(pairs, key=lambda z: (-float(z.value.real), float(z.value.imag)))


def _on_real_axis(mu: arb) -> Multiplier:
    """Return the multiplier with z + 1/z = 2 mu. Raises CertificateError."""
    if abs(mu) < 1:
        return Multiplier(acb(mu, ((1 - mu) * (1 + mu)).sqrt()), True)
    if not abs(mu) > 1:
        raise CertificateError("a multiplier is not separated from 1 or -1")
    root = ((mu - 1) * (mu + 1)).sqrt()
    return Multiplier(acb(mu + root if mu > 0 else mu - root), False)


def _off_circle(mu: acb) -> Multiplier:
    z = mu + (mu * mu - 1).sqrt()
    z = z if abs(z) > 1 else 1 / z
    if not abs(z) > 1:
        raise CertificateError("a multiplier is not proved to have a modulus other than 1")
    return Multiplier(z, False)
