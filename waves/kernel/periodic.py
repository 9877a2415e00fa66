"""Periodic waves of a chain of equal masses: the contraction that proves one (Theorem 1).

The strain f(n - v t), f(x) = f_0 + 2 (f_1 cos q_1 x + f_2 cos q_2 x + ...), q_j = 2 pi j/P, moves
on the chain with forces V_m' between m-th neighbours if, for all j >= 1,

    F_j = v^2 f_j - mu_j sum_m S_mj [V_m'(S_m f)]_j = 0,

mu_j = (sin(q_j/2)/(q_j/2))^2, S_mj = sin(m q_j/2)/sin(q_j/2). P, f_0 and f_1 are given; v^2 and
f_2, f_3, ... are unknown, with the norm weight |v^2| + 2 (|f_2| nu^2 + |f_3| nu^3 + ...).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from flint import arb, arb_mat

from .composition import Composed, Strip, composed, trimmed
from .cosine_series import Series, entry, largest, norm, polynomial_of, shifted_sum, upper
from .force_text import Force
from .limits import CertificateError, require_size

STIFFNESS_CUT = 1e-6
"""Norm below which the highest coefficients of V''(f) are only bounded, not known."""


@dataclass(frozen=True)
class Spring:
    """A force V_m'(r) between m-th neighbours."""

    neighbour: int
    force: Force


@dataclass(frozen=True)
class PeriodicCentre:
    """Approximation f_0 ... f_N of a wave with v^2, weights of the norm, and largest radius."""

    springs: tuple[Spring, ...]
    period: arb
    modes: Series
    speed_squared: arb
    nu: arb
    weight: arb
    radius_bound: arb
    strip: Strip | None = None

    @property
    def top(self) -> int:
        """N, the index of the highest mode."""
        return len(self.modes) - 1

    def phase(self, j: int) -> arb:
        """Return q_j/2 = pi j/P."""
        return arb.pi() * j / self.period

    def mobility(self, j: int) -> arb:
        """Return mu_j = (sin(q_j/2)/(q_j/2))^2."""
        ratio = self.phase(j).sin() / self.phase(j)
        return ratio * ratio

    def stretch(self, m: int, j: int) -> arb:
        """Return S_mj = sin(m q_j/2)/sin(q_j/2), as a sum of cosines without a denominator."""
        return sum(((2 * self.phase(j) * arb(2 * i + 1 - m) / 2).cos() for i in range(m)), arb(0))

    @cached_property
    def laws(self) -> list[tuple[int, Composed]]:
        """For each spring, its neighbour m and its force composed with the stretch S_m f."""
        result = []
        for spring in self.springs:
            m = spring.neighbour
            strain = [c * self.stretch(m, j) if m > 1 else c for j, c in enumerate(self.modes)]
            reach = m * self.radius_bound
            result.append((m, composed(spring.force, strain, self.nu, reach, self.strip)))
        return result

    @cached_property
    def coarse_stiffness(self) -> list[tuple[int, Series, arb]]:
        """For each spring: its largest coefficients of V''(f), and the norm of the others."""
        result = []
        for m, law in self.laws:
            known, rest = trimmed(law.stiffness, self.nu, STIFFNESS_CUT)
            result.append((m, known, upper(rest + law.stiffness_rest)))
        return result

    @cached_property
    def bandwidth(self) -> int:
        """Largest index of a known coefficient of V'(f) or of the coarse V''(f)."""
        lengths = [len(law.force) for _, law in self.laws]
        return max([*lengths, *(len(known) for _, known, _ in self.coarse_stiffness)]) - 1

    def residual(self, j: int) -> arb:
        """Return F_j at the approximate wave."""
        total = sum((self._factor(m, j) * entry(law.force, j) for m, law in self.laws), arb(0))
        return self.speed_squared * entry(self.modes, j) - self._mobility[j] * total

    def coupling(self, j: int, k: int) -> arb:
        """Return mu_j sum_m S_mj S_mk (g_{j-k} + g_{j+k}), g the modes of V''."""
        total = arb(0)
        for m, known, _ in self.coarse_stiffness:
            total += self._factor(m, j) * self._factor(m, k) * shifted_sum(known, j, k)
        return self._mobility[j] * total

    @cached_property
    def _mobility(self) -> list[arb]:
        return [arb(1), *(self.mobility(j) for j in range(1, self.top + self.bandwidth + 2))]

    @cached_property
    def _stretches(self) -> dict[int, list[arb]]:
        count = self.top + self.bandwidth + 2
        return {m: [self.stretch(m, j) for j in range(count)] for m, _ in self.laws if m > 1}

    def _factor(self, m: int, j: int) -> arb:
        return self._stretches[m][j] if m > 1 else arb(1)


@dataclass(frozen=True)
class Contraction:
    """Bounds of a Newton-like map: defect Y0, contraction Z0 + Z1 + Z2 r, on balls of radius r."""

    y0: arb
    z0: arb
    z1: arb
    z2: arb

    def require(self, radius: arb, radius_bound: arb | None = None) -> None:
        """Raise CertificateError unless the map contracts the ball of this radius into itself.

        The bounds hold up to ``radius_bound``, if it is given.
        """
        if not radius > 0 or not (radius_bound is None or radius <= radius_bound):
            raise CertificateError("0 < radius <= radius_bound must hold")
        linear = self.z0 + self.z1
        image = self.y0 + linear * radius + self.z2 * radius * radius / 2
        if not image < radius:
            raise CertificateError(
                f"Y0 + Z r + Z2 r^2/2 < r fails: {_shown(image)} for r = {_shown(radius)}"
            )
        if not linear + self.z2 * radius < 1:
            raise CertificateError(f"Z + Z2 r < 1 fails: {_shown(linear + self.z2 * radius)}")


def _shown(value: arb) -> str:
    return str(value.str(6, radius=False))


def contraction(centre: PeriodicCentre) -> Contraction:
    """Return the bounds of the map x - A F(x) about a centre. Raises CertificateError."""
    top, nu, omega = centre.top, centre.nu, centre.speed_squared
    if not (nu >= 1 and centre.weight > 0 and omega > 0 and centre.period > 0 and top >= 2):
        raise CertificateError("nu >= 1, weight > 0, speed squared > 0, period > 0 must hold")
    require_size(top * (top + centre.bandwidth))
    jacobian = _jacobian(centre)
    inverse = approximate_inverse(jacobian)
    rows = [centre.weight, *(2 * nu**j for j in range(2, top + 1))]
    columns = [2 * nu**j for j in range(1, top + 1)]
    size_of_inverse = largest([*column_norms(inverse, rows, columns), upper(1 / omega)])
    rest_force = sum((m * law.force_rest for m, law in centre.laws), arb(0))
    rest_stiffness = sum((m * m * rest for m, _, rest in centre.coarse_stiffness), arb(0))
    third = sum((m**3 * law.third for m, law in centre.laws), arb(0))
    z1 = _tail_norm(centre, inverse, rows) + size_of_inverse * rest_stiffness
    return Contraction(
        upper(_defect(centre, inverse, rows) + size_of_inverse * rest_force),
        largest(column_norms(identity(top) - inverse * jacobian, rows, rows)),
        upper(z1),
        upper(size_of_inverse * upper(1 / centre.weight).max(upper(third))),
    )


def energy(centre: PeriodicCentre, radius: arb) -> arb:
    """Return the energy of a period at zero mean momentum; nearest neighbours, polynomial force.

    The momenta have the modes p_j = mu_j^(1/2) [V'(f)]_j/v, j >= 1.
    """
    (_, law), (spring,) = centre.laws[0], centre.springs
    speed = (centre.speed_squared + arb(0, upper(radius / centre.weight))).sqrt()
    momenta = [arb(0)]
    for j in range(1, len(law.force)):
        momenta.append(centre.phase(j).sin() / centre.phase(j) * law.force[j] / speed)
    size, slope = norm(centre.modes, centre.nu) + radius, arb(0)
    for coefficient in reversed(spring.force.derivative(1)):
        slope = slope * size + abs(coefficient)
    change = (slope * radius + law.force_rest) / speed
    potential = [arb(0), *(c / (i + 1) for i, c in enumerate(spring.force.derivative(0)))]
    total = sum((p * p for p in momenta), arb(0)) + polynomial_of(potential, centre.modes)[0]
    error = (norm(momenta, centre.nu) + change) * change + size * slope * radius
    return centre.period * (total + arb(0, upper(error)))


def _jacobian(centre: PeriodicCentre) -> arb_mat:
    """Return dF_j/d(v^2, f_2, ..., f_N), j = 1 ... N."""
    top = centre.top
    entries = []
    for j in range(1, top + 1):
        entries.append(centre.modes[j])
        for k in range(2, top + 1):
            diagonal = centre.speed_squared if j == k else arb(0)
            entries.append(diagonal - centre.coupling(j, k))
    return arb_mat(top, top, entries)


def approximate_inverse(matrix: arb_mat) -> arb_mat:
    """Return the approximate inverse of a matrix's midpoint. Raises CertificateError."""
    try:
        return matrix.mid().inv().mid()
    except ZeroDivisionError:
        raise CertificateError("the linear problem has no inverse here") from None


def identity(size: int) -> arb_mat:
    """Return the unit matrix."""
    return arb_mat(size, size, [arb(i == j) for i in range(size) for j in range(size)])


def column_norms(matrix: arb_mat, rows: Sequence[arb], columns: Sequence[arb]) -> list[arb]:
    """Return each column's norm: sum of |entry| times row weight, over the column's weight."""
    norms = []
    for k, weight in enumerate(columns):
        total = sum((w * abs(matrix[i, k]) for i, w in enumerate(rows)), arb(0))
        norms.append(upper(total / weight))
    return norms


def _defect(centre: PeriodicCentre, inverse: arb_mat, rows: Sequence[arb]) -> arb:
    """Return the norm of A F at the centre, over all j up to its bandwidth; A is ``inverse``."""
    top = centre.top
    residual = arb_mat(top, 1, [centre.residual(j) for j in range(1, top + 1)])
    total = column_norms(inverse * residual, rows, [arb(1)])[0]
    for j in range(top + 1, centre.bandwidth + 1):
        total += 2 * centre.nu**j * abs(centre.residual(j)) / centre.speed_squared
    return upper(total)


def _tail_norm(centre: PeriodicCentre, inverse: arb_mat, rows: Sequence[arb]) -> arb:
    """Return the norm of I - A DF outside the block of the first N rows and columns."""
    top, nu, omega, width = centre.top, centre.nu, centre.speed_squared, centre.bandwidth
    worst = arb(0)
    for k in range(2, top + 1):
        below = range(max(top + 1, k - width), top + width + 1)
        total = sum((nu**i * abs(centre.coupling(i, k)) for i in below if i - k <= width), arb(0))
        worst = worst.max(upper(total / nu**k / omega))
    outside = list(range(top + 1, top + max(width, 1) + 1))  # one at least: beyond, only the tail
    if outside:
        entries = [centre.coupling(j, k) for j in range(1, top + 1) for k in outside]
        image = inverse * arb_mat(top, len(outside), entries)
        stiffness = sum(
            (m * m * norm(known, nu) for m, known, _ in centre.coarse_stiffness), arb(0)
        )
        mobility = upper(1 / centre.phase(top + 1) ** 2).min(arb(1))
        tail = mobility * stiffness / omega
        weights = [2 * nu**k for k in outside]
        for column in column_norms(image, rows, weights):
            worst = worst.max(upper(column + tail))
    return upper(worst)
