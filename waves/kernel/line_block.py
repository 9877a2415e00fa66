r"""Linear part I - W K_per of a wave on the line: its block in cosines of (-d, d), inverted.

The even functions of L^2(-d, d) have the orthonormal basis (2 d)^(-1/2), d^(-1/2) cos(pi n x/d).
W multiplies by a cosine polynomial; K_per multiplies mode n by a number, at most `tail` for n > N.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from flint import arb, arb_mat, ctx

from .cosine_series import Series, entry, largest, norm, shifted_sum, upper
from .limits import require_size
from .periodic import approximate_inverse, identity

BLOCK_BITS = 64


@dataclass(frozen=True)
class LineBlock:
    """Operator A: ``inverse`` on the modes up to N, else the identity.

    ``size`` is its norm. ``contraction`` bounds the norm of I - A (I - W K_per).
    """

    half_length: arb
    inverse: arb_mat
    size: arb
    contraction: arb

    def image_size(self, f: Sequence[arb]) -> arb:
        """Return a bound of ||A f|| for the cosine series f."""
        count, root = self.inverse.nrows(), self.half_length.sqrt()
        scaled = [c * root * (2 if n else arb(2).sqrt()) for n, c in enumerate(f)]
        image = self.inverse * arb_mat(count, 1, [entry(scaled, n) for n in range(count)])
        parts = [abs(value) for value in (*image.entries(), *scaled[count:])]
        return upper(sum((size * size for size in parts), arb(0)).abs_upper().sqrt())


def line_block(
    slope: Series, multiplier: Callable[[int], arb], tail: arb, top: int, half_length: arb
) -> LineBlock:
    """Invert the block of the modes 0 ... ``top``; W has the modes ``slope``.

    Raises CertificateError.
    """
    width = len(slope) - 1
    require_size((top + 1) * (top + 1 + width))
    inside, outside = range(top + 1), range(top + 1, top + width + 1)
    factors = [multiplier(n) for n in range(top + width + 1)]
    unit = identity(top + 1)
    block = unit - _coupling(slope, factors, inside, inside)
    precision, ctx.prec = ctx.prec, BLOCK_BITS
    try:
        inverse = approximate_inverse(block)
    finally:
        ctx.prec = precision
    norms = [spectral_norm(unit - inverse * block), norm(slope, arb(1)) * tail]
    if outside:
        norms.append(spectral_norm(inverse * _coupling(slope, factors, inside, outside)))
        norms.append(spectral_norm(_coupling(slope, factors, outside, inside)))
    contraction = upper(sum((n * n for n in norms), arb(0)).abs_upper().sqrt())
    size = largest([arb(1), spectral_norm(inverse)])
    return LineBlock(half_length, inverse, size, contraction)


def _coupling(
    slope: Series, factors: Series, rows: Sequence[int], columns: Sequence[int]
) -> arb_mat:
    """Return entries of W K_per; a constant's norm is sqrt(2) times that of 2 cos."""
    root, entries = arb(2).sqrt(), []
    for i in rows:
        for j in columns:
            if i and j:
                weight = shifted_sum(slope, i, j)
            else:
                weight = entry(slope, i + j) * (root if i + j else 1)
            entries.append(weight * factors[j])
    return arb_mat(len(rows), len(columns), entries)


def spectral_norm(matrix: arb_mat) -> arb:
    """Bound the spectral norm: root of the product of largest row sum and largest column sum."""
    sizes = [[abs(value) for value in row] for row in matrix.tolist()]
    rows = largest(sum(row, arb(0)).upper() for row in sizes)
    columns = largest(sum(column, arb(0)).upper() for column in zip(*sizes, strict=True))
    return upper((rows * columns).sqrt())


def exponential_integral(f: Series, rate: arb, half_length: arb) -> arb:
    """Return the integral of f(x) exp(rate |x|) over (-d, d), f in cosines of pi n x/d."""
    grown, total = (rate * half_length).exp(), arb(0)
    for n, coefficient in enumerate(f):
        wave = arb.pi() * n / half_length
        value = 2 * rate * ((-1) ** n * grown - 1) / (rate * rate + wave * wave)
        total += (2 if n else 1) * coefficient * value
    return total
