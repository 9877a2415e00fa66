r"""Floquet exponents of a periodic wave: the contraction that encloses one.

A perturbation exp(lambda t + i kappa x) sum W_j exp(2 pi i j x/P), x = n - v t, grows as

    G_j = (lambda - i v q_j)^2 W_j + 4 sin^2(q_j/2) sum_k g_{j-k} W_k = 0,  q_j = kappa + 2 pi j/P,

g the modes of V''(f). One W_j is 1; lambda and the others, |j| <= N and beyond, are unknown, with
the norm |lambda| + sum |W_j|.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from flint import acb, acb_mat, arb, ctx, fmpq

from .cosine_series import Series, entry, largest, norm, upper
from .limits import CertificateError, require_size
from .periodic import Contraction


@dataclass(frozen=True)
class Stiffness:
    """V''(f) of a proved wave: known modes, a bound of what is missing; v and P as balls."""

    modes: Series
    rest: arb
    speed: arb
    period: arb


@dataclass(frozen=True)
class ExponentCentre:
    """An approximate exponent with its vector W_{-N} ... W_N; W is 1 at the index ``fixed``."""

    stiffness: Stiffness
    bloch: fmpq
    exponent: acb
    vector: Sequence[acb]
    fixed: int
    radius_bound: arb

    @property
    def top(self) -> int:
        """N, the largest index of a component W_j."""
        return len(self.vector) // 2

    def wavenumber(self, j: int) -> arb:
        """Return q_j = kappa + 2 pi j/P, where kappa = 2 pi ``bloch``/P."""
        return 2 * arb.pi() * (arb(self.bloch) + j) / self.stiffness.period

    def rate(self, j: int) -> acb:
        """Return lambda - i v q_j at the centre."""
        return self.exponent - acb(arb(0), self.stiffness.speed * self.wavenumber(j))

    @cached_property
    def couplings(self) -> dict[int, arb]:
        """4 sin^2(q_j/2) by j, for all G_j in which known modes and components meet."""
        reach = self.top + len(self.stiffness.modes) - 1
        halves = {j: (self.wavenumber(j) / 2).sin() for j in range(-reach, reach + 1)}
        return {j: 4 * half * half for j, half in halves.items()}

    def known(self, j: int) -> acb:
        """Return the component W_j of the approximate vector; 0 beyond N."""
        return self.vector[j + self.top] if abs(j) <= self.top else acb(0)

    def residual(self, j: int) -> acb:
        """Return G_j at the approximate exponent and vector, without the error of the wave."""
        width = len(self.stiffness.modes) - 1
        total = acb(0)
        for k in range(max(-self.top, j - width), min(self.top, j + width) + 1):
            total += entry(self.stiffness.modes, j - k) * self.known(k)
        return self.rate(j) * self.rate(j) * self.known(j) + self.couplings[j] * total


def exponent_contraction(centre: ExponentCentre) -> Contraction:
    """Return the bounds of the map x - A G(x) about a centre. Raises CertificateError."""
    top, modes = centre.top, centre.stiffness.modes
    rows, width = range(-top, top + 1), len(centre.stiffness.modes) - 1
    if not abs(centre.fixed) <= top or centre.known(centre.fixed) != 1:
        raise CertificateError("the fixed component of the vector must be 1")
    require_size(4 * (2 * top + 1) * (2 * (top + width) + 1))
    jacobian = _jacobian(centre)
    inverse = _inverse(jacobian)
    tail_rate = _least_rate(centre)
    size = largest([*_column_sums(inverse), upper(1 / (tail_rate * tail_rate))])
    rates = [centre.rate(j) for j in rows]
    scaled = acb_mat(
        [[inverse[i, j] * rates[j] for j in range(2 * top + 1)] for i in range(2 * top + 1)]
    )
    with_rates = largest([*_column_sums(scaled), upper(1 / tail_rate)])
    length = upper(sum((abs(w) for w in centre.vector), arb(0)))
    defect = _column_sums(inverse * acb_mat([[centre.residual(j)] for j in rows]))[0]
    outside = [j for j in range(-top - width, top + width + 1) if abs(j) > top]
    for j in outside:
        defect += abs(centre.residual(j)) / abs(centre.rate(j)) ** 2
    wave_error = 4 * size * centre.stiffness.rest
    return Contraction(
        upper(defect + wave_error * length),
        largest(_column_sums(_identity(2 * top + 1) - inverse * jacobian)),
        upper(_tail(centre, inverse, outside, norm(modes, arb(1))) + wave_error),
        upper(
            2 * with_rates + 2 * size * (length + centre.radius_bound) + size * centre.radius_bound
        ),
    )


def _jacobian(centre: ExponentCentre) -> acb_mat:
    """Return dG_j/d(W_-N, ..., lambda, ..., W_N), lambda in the place of the fixed component."""
    top, table = centre.top, []
    for j in range(-top, top + 1):
        rate, row = centre.rate(j), []
        for k in range(-top, top + 1):
            if k == centre.fixed:
                row.append(2 * rate * centre.known(j))
            else:
                value = acb(centre.couplings[j] * entry(centre.stiffness.modes, j - k))
                row.append(value + rate * rate if j == k else value)
        table.append(row)
    return acb_mat(table)


def _inverse(matrix: acb_mat) -> acb_mat:
    try:
        with ctx.workprec(64):
            return matrix.mid().inv().mid()
    except ZeroDivisionError:
        raise CertificateError("the exponent is not simple here") from None


def _identity(size: int) -> acb_mat:
    return acb_mat(size, size, [acb(i == j) for i in range(size) for j in range(size)])


def _column_sums(matrix: acb_mat) -> list[arb]:
    return [upper(sum(map(abs, column), arb(0))) for column in zip(*matrix.tolist(), strict=True)]


def _least_rate(centre: ExponentCentre) -> arb:
    """Return a lower bound of |lambda - i v q_j| over |j| > N."""
    speed, imaginary = centre.stiffness.speed, centre.exponent.imag
    above = speed * centre.wavenumber(centre.top + 1) - imaginary
    below = imaginary - speed * centre.wavenumber(-centre.top - 1)
    if not (above > 0 and below > 0):
        raise CertificateError("more components are needed: a rate may vanish in the tail")
    return above.min(below).lower()


def _tail(centre: ExponentCentre, inverse: acb_mat, outside: Sequence[int], stiffness: arb) -> arb:
    """Return the norm of I - A DG outside the block |j|, |k| <= N, where A is ``inverse``."""
    top, modes = centre.top, centre.stiffness.modes
    rows = range(-top, top + 1)
    weights = {j: 1 / abs(centre.rate(j)) ** 2 for j in outside}
    worst = arb(0)
    for k in rows:
        if k == centre.fixed:
            continue
        total = sum(
            (weights[j] * centre.couplings[j] * abs(entry(modes, j - k)) for j in outside), arb(0)
        )
        worst = worst.max(upper(total))
    least = _least_rate(centre)
    beyond = upper(4 * stiffness / (least * least))
    worst = worst.max(beyond)
    if outside:
        image = inverse * acb_mat(
            [[acb(centre.couplings[j] * entry(modes, j - k)) for k in outside] for j in rows]
        )
        worst = worst.max(largest(_column_sums(image)) + beyond)
    return upper(worst)
