r"""The tie of a chain's elliptic waves to the modified KdV equation, for all small eps (Theorem 2).

For V'(r) = K2 r + K4 r^3, f = eps Y, v^2 = K2 + eps^2 sigma and the period P_X/eps,

    (sigma + K2 m_j) Y_j - mu_j K4 (Y^3)_j = 0,   1 - mu_j = eps^2 m_j,   xi_j = 2 pi j/P_X,
    m_j = xi_j^2 h(u),  h(u) = 2 sum (-u)^n/(2 n + 4)!,  u = (eps xi_j)^2,

where the wave of the modified KdV equation has the defect eps^2 R_j,
R_j = Y_j (sigma_0 m_j + K2 (xi_j^4 h_2 + m_j xi_j^2/12)), h_2 = (h - 1/12)/u.
For all u >= 0: 0 <= h <= 1/12, |h'| <= 1/360, -1/360 <= h_2 <= 0, |h_2'| <= 1/20160.
On each piece of eps^2 the centre is (sigma_0, Y) + eps^2 (sigma_1, y_1), the radius c eps^2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import factorial

from flint import arb, arb_mat, fmpq

from .composition import trimmed
from .cosine_series import Series, entry, largest, norm, product, shifted_sum, supremum, upper
from .elliptic_pins import NearWave
from .limits import MAX_MODES, CertificateError, require_size
from .periodic import Contraction, approximate_inverse, column_norms, identity

SPEEDS: dict[str, Callable[[fmpq], fmpq]] = {
    "dn": lambda square: 2 - square,
    "cn": lambda square: 2 * square - 1,
    "sn": lambda square: -(1 + square),
}
"""Function of the squared modulus that gives 2 sigma_0/|K4|, for each form of Y."""

TERMS = 30
"""Number of terms of the power series of h used near 0."""

CUT = 1e-20


@dataclass(frozen=True)
class TiePiece:
    """A piece of the values of eps^2, as a ball, with the correction of the wave there.

    ``correction`` has sigma_1 and the modes 2 ... N of y_1; ``weight`` is that of sigma in the
    norm weight |sigma| + 2 sum |Y_j|; ``radius_bound`` bounds c eps^2.
    """

    wave: NearWave
    square: arb
    correction: Sequence[arb]
    weight: arb
    radius_bound: arb

    @property
    def top(self) -> int:
        """N, the index of the highest mode of the correction y_1."""
        return len(self.correction)

    @cached_property
    def constants(self) -> tuple[arb, arb]:
        """Constants K2 and K4 of the force."""
        jet = self.wave.force.at_rest
        return jet[1], jet[3]

    @cached_property
    def sigma(self) -> arb:
        """Speed sigma_0 of the wave of the modified KdV equation."""
        return abs(self.constants[1]) / 2 * arb(SPEEDS[self.wave.form](self.wave.k * self.wave.k))

    @cached_property
    def modes(self) -> Series:
        """Modes Y_0 ... Y_N of Y, and more until the sum of the others is below `CUT`."""
        top = self.top
        while not self.wave.rest(top) < CUT:
            if top > MAX_MODES:
                raise CertificateError("the modulus is too close to 1 for this many bits")
            top += 4
        return self.wave.modes(top)

    @cached_property
    def shift(self) -> Series:
        """Modes 0 ... N of the correction y_1; the first two are 0."""
        return [arb(0), arb(0), *self.correction[1:]]

    def wavenumber(self, j: int) -> arb:
        """Return xi_j = 2 pi j/P_X."""
        return 2 * arb.pi() * j / self.wave.period

    def dispersion(self, j: int) -> arb:
        """Return m_j = (1 - mu_j)/eps^2, as a ball for every eps of the piece."""
        xi = self.wavenumber(j)
        return xi * xi * _lipschitz(_h, self.square * xi * xi, 360)

    def mobility(self, j: int) -> arb:
        """Return mu_j = 1 - eps^2 m_j."""
        return 1 - self.square * self.dispersion(j)

    def linear(self, j: int) -> arb:
        """Return sigma_0 + K2 m_j."""
        return self.sigma + self.constants[0] * self.dispersion(j)

    def defect(self, j: int) -> arb:
        """Return R_j, the defect of the modified KdV equation's wave over eps^2."""
        xi2, m = self.wavenumber(j) ** 2, self.dispersion(j)
        second = _lipschitz(_h2, self.square * xi2, 20160)
        return self.modes[j] * (
            self.sigma * m + self.constants[0] * (xi2 * xi2 * second + m * xi2 / 12)
        )

    @cached_property
    def stiffness(self) -> tuple[Series, arb]:
        """Largest modes of 3 K4 Y^2, and a bound of the norm of the others."""
        rest = self.wave.rest(len(self.modes) - 1)
        known, cut = trimmed(product(self.modes, self.modes), arb(1), CUT)
        factor = 3 * self.constants[1]
        missing = 2 * norm(self.modes, arb(1)) * rest + rest * rest + cut
        return [factor * c for c in known], upper(abs(factor) * missing)

    @cached_property
    def least_tail(self) -> arb:
        """Lower bound of sigma_0 + K2 m_j over j > N and the piece. Raises CertificateError."""
        xi2 = self.wavenumber(self.top + 1) ** 2
        square = upper(self.square)
        below = xi2 / 12 - square * xi2 * xi2 / 360 if square * xi2 <= 15 else arb(5) / 8 / square
        least = (self.sigma + self.constants[0] * below).lower()
        if not least > 0:
            raise CertificateError("sigma_0 + K2 m > 0 fails in the tail (take more modes)")
        return least


def _lipschitz(function: Callable[[arb], arb], u: arb, inverse_slope: int) -> arb:
    """Return a function on the ball ``u``; its slope is at most 1/``inverse_slope``."""
    return function(u.mid()) + arb(0, upper(u.rad() / inverse_slope))


def _h(u: arb) -> arb:
    if u > 1:
        half = u.sqrt() / 2
        ratio = half.sin() / half
        return (1 - ratio * ratio) / u
    return _series(u, 0)


def _h2(u: arb) -> arb:
    return (_h(u) - arb(1) / 12) / u if u > 1 else _series(u, 1)


def _series(u: arb, first: int) -> arb:
    """Return 2 sum over n >= first of (-1)^n u^(n - first)/(2 n + 4)! for |u| <= 1."""
    total = arb(0, arb(4) / factorial(2 * (first + TERMS) + 4))
    for n in reversed(range(TERMS)):
        total = total * u if n < TERMS - 1 else total
        total += arb(2 * (-1) ** (n + first)) / factorial(2 * (n + first) + 4)
    return total


def tie_contraction(piece: TiePiece) -> Contraction:
    """Return bounds in units of eps^2: y, Z0, Z1, and Z2 eps^2. Raises CertificateError."""
    top, (_, k4) = piece.top, piece.constants
    require_size(top * (top + len(piece.stiffness[0])))
    jacobian = _jacobian(piece)
    inverse = approximate_inverse(jacobian)
    rows = [piece.weight, *(arb(2) for _ in range(2, top + 1))]
    columns = [arb(2)] * top
    tail = upper(1 / piece.least_tail)
    size = largest([*column_norms(inverse, rows, columns), tail])
    square = upper(piece.square)
    length = upper(piece.weight * abs(piece.correction[0]) + norm(piece.shift, arb(1)))
    everything = norm(piece.modes, arb(1)) + piece.wave.rest(len(piece.modes) - 1)
    third = 6 * abs(k4) * (everything + square * length + piece.radius_bound)
    second = upper(size * upper(1 / piece.weight).max(upper(third)) * square)
    stiff_rest = size * piece.stiffness[1]
    defect = _defect(piece, inverse, rows, tail) + stiff_rest * length
    return Contraction(
        upper(defect + second * length * length / 2),
        largest(column_norms(identity(top) - inverse * jacobian, rows, rows)),
        upper(_tail_norm(piece, inverse, rows, tail) + stiff_rest + second * length),
        second,
    )


def _jacobian(piece: TiePiece) -> arb_mat:
    top, known = piece.top, piece.stiffness[0]
    entries = []
    for j in range(1, top + 1):
        entries.append(piece.modes[j])
        linear, mobility = piece.linear(j), piece.mobility(j)
        for k in range(2, top + 1):
            value = -mobility * shifted_sum(known, j, k)
            entries.append(value + linear if j == k else value)
    return arb_mat(top, top, entries)


def _defect(piece: TiePiece, inverse: arb_mat, rows: Sequence[arb], tail: arb) -> arb:
    """Return the norm of A (R + J y_1), without the modes that ``stiffness`` only bounds."""
    top, known = piece.top, piece.stiffness[0]
    sigma1 = piece.correction[0]
    force = product(known, piece.shift)
    block = []
    for j in range(1, top + 1):
        value = piece.defect(j) + sigma1 * piece.modes[j] - piece.mobility(j) * entry(force, j)
        block.append(value + piece.linear(j) * entry(piece.shift, j))
    total = column_norms(inverse * arb_mat(top, 1, block), rows, [arb(1)])[0]
    beyond = arb(0)
    for j in range(top + 1, len(force)):
        beyond += 2 * abs(force[j])
    for j in range(top + 1, len(piece.modes)):
        beyond += 2 * abs(piece.defect(j)) + 2 * abs(sigma1 * piece.modes[j])
    last = len(piece.modes) - 1
    beyond += abs(sigma1) * piece.wave.rest(last) + _defect_rest(piece, last)
    return upper(total + tail * beyond)


def _defect_rest(piece: TiePiece, last: int) -> arb:
    """Return a bound of the sum of 2 |R_j| over j > last: |R_j| <= |Y_j| (a xi^4 + b xi^2)."""
    wave, k2 = piece.wave, piece.constants[0]
    stride = 1 if wave.form == "dn" else 2
    first = last + 1
    while stride == 2 and first % 2 == 0:
        first += 1
    nome = wave.nome
    theta = nome * (1 + arb(stride) / first) ** 4
    if not theta < 1:
        raise CertificateError("the tail of the wave is not bounded (take more modes)")
    xi2 = piece.wavenumber(first) ** 2
    size = 2 * abs(wave.mode(first)) * (1 + nome**first) / (1 - theta)
    return upper(
        size * (k2 * xi2 * xi2 * (arb(1) / 360 + arb(1) / 144) + abs(piece.sigma) * xi2 / 12)
    )


def _tail_norm(piece: TiePiece, inverse: arb_mat, rows: Sequence[arb], tail: arb) -> arb:
    """Return the norm of I - A J outside the block of the first N rows and columns."""
    top, (known, _) = piece.top, piece.stiffness
    width = len(known) - 1
    missing = sum((2 * abs(c) for c in piece.modes[top + 1 :]), arb(0))
    missing += piece.wave.rest(len(piece.modes) - 1)
    worst = upper(missing * tail / piece.weight)
    for k in range(2, top + 1):
        total = sum((abs(shifted_sum(known, i, k)) for i in range(top + 1, k + width + 1)), arb(0))
        worst = worst.max(upper(total * tail))
    outside = range(top + 1, top + max(width, 1) + 1)  # one at least: beyond, only the tail
    if outside:
        entries = []
        for j in range(1, top + 1):
            mobility = piece.mobility(j)
            entries += [mobility * shifted_sum(known, j, k) for k in outside]
        image = inverse * arb_mat(top, len(outside), entries)
        beyond = norm(known, arb(1)) * tail
        for column in column_norms(image, rows, [arb(2)] * len(outside)):
            worst = worst.max(upper(column + beyond))
    return upper(worst)


def distance_over_cube(piece: TiePiece, bound: arb) -> tuple[arb, arb]:
    """Return lower and upper bounds of sup |f - eps Y|/eps^3; ``bound`` is c."""
    low, high = supremum(piece.shift)
    return (low - bound).lower(), upper(high + bound)
