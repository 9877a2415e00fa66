r"""The tie of a chain's elliptic waves to KdV or modified KdV, for all small eps (Theorem 2).

For V'(r) = K2 r + sum c_n r^n, f = eps^p Y, v^2 = K2 + eps^2 sigma and the period P_X/eps,

    (sigma + K2 m_j) Y_j - mu_j G(Y)_j = 0,   1 - mu_j = eps^2 m_j,   xi_j = 2 pi j/P_X,
    G(Y) = sum c_n eps^(p n - p - 2) Y^n = G_0(Y) + eps^2 G_1(Y),  G_0 = K3 Y^2 or K4 Y^3,
    m_j = xi_j^2 h(u),  u = (eps xi_j)^2,  h and h_2 as in `long_waves`,

where the wave of the reduced equation has the defect eps^2 R_j,
R_j = Y_j (sigma_0 m_j + K2 (xi_j^4 h_2 + m_j xi_j^2/12)) - mu_j G_1(Y)_j.
On each piece of eps^2 the centre is (sigma_0, Y) + eps^2 (sigma_1, y_1), the radius c eps^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from flint import arb, arb_mat

from .composition import trimmed
from .cosine_series import (
    Series,
    derivative,
    entry,
    largest,
    norm,
    polynomial_bound,
    polynomial_of,
    product,
    shifted_sum,
    supremum,
    upper,
)
from .elliptic_pins import NearWave
from .limits import MAX_MODES, CertificateError, require_size
from .long_waves import h, h2
from .periodic import Contraction, approximate_inverse, column_norms, identity

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
    def k2(self) -> arb:
        """Linear constant K2 of the force."""
        return self.wave.force.at_rest[1]

    @cached_property
    def sigma(self) -> arb:
        """Speed sigma_0 of the wave of the reduced equation."""
        return self.wave.sigma

    @cached_property
    def nonlinear(self) -> tuple[Series, Series]:
        """Coefficients of the polynomials G and G_1. Raises CertificateError for odd eps powers."""
        order, power = self.wave.form.order, self.wave.form.power
        full, higher = [arb(0)] * power, [arb(0)] * power
        for n, coefficient in enumerate((self.wave.force.polynomial or ())[power:]):
            if coefficient == 0:
                full.append(arb(0))
                higher.append(arb(0))
                continue
            if order * n % 2:
                raise CertificateError("the force must have odd powers of r only")
            full.append(arb(coefficient) * self.square ** (order * n // 2))
            higher.append(arb(coefficient) * self.square ** (order * n // 2 - 1) if n else arb(0))
        return full, higher

    @cached_property
    def higher(self) -> tuple[Series, arb]:
        """Largest modes of G_1(Y), and a bound of the norm of the others."""
        return self._composed(self.nonlinear[1])

    @cached_property
    def stiffness(self) -> tuple[Series, arb]:
        """Largest modes of G'(Y), and a bound of the norm of the others."""
        return self._composed(derivative(self.nonlinear[0], 1))

    def _composed(self, polynomial: Series) -> tuple[Series, arb]:
        rest = self.wave.rest(len(self.modes) - 1)
        known, cut = trimmed(polynomial_of(polynomial, self.modes), arb(1), CUT)
        slope = polynomial_bound(derivative(polynomial, 1), norm(self.modes, arb(1)) + rest)
        return known, upper(slope * rest + cut)

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
        return xi * xi * h(self.square * xi * xi)

    def mobility(self, j: int) -> arb:
        """Return mu_j = 1 - eps^2 m_j."""
        return 1 - self.square * self.dispersion(j)

    def linear(self, j: int) -> arb:
        """Return sigma_0 + K2 m_j."""
        return self.sigma + self.k2 * self.dispersion(j)

    def defect(self, j: int) -> arb:
        """Return R_j without G_1: the defect of the reduced equation's wave over eps^2."""
        xi2, m = self.wavenumber(j) ** 2, self.dispersion(j)
        second = h2(self.square * xi2)
        return self.modes[j] * (self.sigma * m + self.k2 * (xi2 * xi2 * second + m * xi2 / 12))

    @cached_property
    def least_tail(self) -> arb:
        """Lower bound of sigma_0 + K2 m_j over j > N and the piece. Raises CertificateError."""
        xi2 = self.wavenumber(self.top + 1) ** 2
        square = upper(self.square)
        below = xi2 / 12 - square * xi2 * xi2 / 360 if square * xi2 <= 15 else arb(5) / 8 / square
        least = (self.sigma + self.k2 * below).lower()
        if not least > 0:
            raise CertificateError("sigma_0 + K2 m > 0 fails in the tail (take more modes)")
        return least


def tie_contraction(piece: TiePiece) -> Contraction:
    """Return bounds in units of eps^2: y, Z0, Z1, and Z2 eps^2. Raises CertificateError."""
    top = piece.top
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
    reach = everything + square * length + piece.radius_bound
    third = polynomial_bound(derivative(piece.nonlinear[0], 2), reach)
    second = upper(size * upper(1 / piece.weight).max(upper(third)) * square)
    stiff_rest = size * piece.stiffness[1]
    defect = _defect(piece, inverse, rows, tail) + stiff_rest * length + size * piece.higher[1]
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
    """Return the norm of A (R + J y_1), without the modes of G' and G_1 that are only bounded."""
    top, known, higher = piece.top, piece.stiffness[0], piece.higher[0]
    sigma1 = piece.correction[0]
    force = product(known, piece.shift)
    block = []
    for j in range(1, top + 1):
        value = piece.defect(j) + sigma1 * piece.modes[j]
        value -= piece.mobility(j) * (entry(force, j) + entry(higher, j))
        block.append(value + piece.linear(j) * entry(piece.shift, j))
    total = column_norms(inverse * arb_mat(top, 1, block), rows, [arb(1)])[0]
    beyond = arb(0)
    for j in range(top + 1, max(len(force), len(higher))):
        beyond += 2 * (abs(entry(force, j)) + abs(entry(higher, j)))
    for j in range(top + 1, len(piece.modes)):
        beyond += 2 * abs(piece.defect(j)) + 2 * abs(sigma1 * piece.modes[j])
    last = len(piece.modes) - 1
    beyond += abs(sigma1) * piece.wave.rest(last) + _defect_rest(piece, last)
    return upper(total + tail * beyond)


def _defect_rest(piece: TiePiece, last: int) -> arb:
    """Return a bound of the sum of 2 |R_j| over j > last: |R_j| <= |Y_j| (a xi^4 + b xi^2)."""
    xi2 = piece.wavenumber(piece.wave.first_after(last)) ** 2
    fourth = piece.k2 * xi2 * xi2 * (arb(1) / 360 + arb(1) / 144)
    return upper(piece.wave.rest(last, 4) * (fourth + abs(piece.sigma) * xi2 / 12))


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


def scaled_distance(piece: TiePiece, bound: arb) -> tuple[arb, arb]:
    """Return lower and upper bounds of sup |f - eps^p Y|/eps^(p + 2); ``bound`` is c."""
    low, high = supremum(piece.shift)
    return (low - bound).lower(), upper(high + bound)
