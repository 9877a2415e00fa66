r"""Linear part I - W K_per of waves on the line: its block in cosines of (-d, d), inverted.

The even functions of L^2(-d, d) have the orthonormal basis (2 d)^(-1/2), d^(-1/2) cos(pi n x/d).
There are one or more unknown functions; W multiplies each by a cosine polynomial, and K_per
multiplies their modes n by a matrix.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from flint import arb, arb_mat, ctx

from .cosine_series import Series, entry, largest, norm, product, shifted_sum, upper
from .limits import require_size
from .periodic import approximate_inverse, identity

BLOCK_BITS = 64

Kernels = Sequence[Sequence[Sequence[arb]]]
"""Matrices by which K_per multiplies the unknowns' modes, by the index of the mode."""

Index = tuple[int, int]
"""Index of an unknown and of its mode."""


class LineInterval:
    """Interval (-d, d) for a wave on the line, whose kernel decays as exp(-kappa |x|)."""

    half_length: arb
    kappa: arb

    def wavenumber(self, n: int) -> arb:
        """Return k_n = pi n/d."""
        return arb.pi() * n / self.half_length

    @cached_property
    def edge(self) -> arb:
        """Decay exp(-kappa d) from the middle to the edge of the interval."""
        return upper((-self.kappa * self.half_length).exp())

    @cached_property
    def images(self) -> arb:
        """Sum Q = 1/(1 - exp(-2 kappa d)) of the decay over all periodic images."""
        return upper(1 / (1 - self.edge * self.edge))


@dataclass(frozen=True)
class LineBlock:
    """Operator A: ``inverse`` on the modes below ``count``, else the identity.

    ``size`` is its norm. ``contraction`` bounds the norm of I - A (I - W K_per).
    """

    half_length: arb
    count: int
    inverse: arb_mat
    size: arb
    contraction: arb

    def image_size(self, functions: Sequence[Series]) -> arb:
        """Bound the norm of A applied to ``functions``, one for each unknown."""
        first, other = (2 * self.half_length).sqrt(), 2 * self.half_length.sqrt()
        inside, total = [], arb(0)
        for f in functions:
            scaled = [c * (other if n else first) for n, c in enumerate(f)]
            inside += [entry(scaled, n) for n in range(self.count)]
            total += sum((abs(c) * abs(c) for c in scaled[self.count :]), arb(0))
        image = self.inverse * arb_mat(len(inside), 1, inside)
        total += sum((abs(c) * abs(c) for c in image.entries()), arb(0))
        return upper(total.abs_upper().sqrt())


def line_block(
    slopes: Sequence[Series],
    kernel: Callable[[int], Sequence[Sequence[arb]]],
    tail: arb,
    count: int,
    half_length: arb,
) -> LineBlock:
    """Invert the block of the modes below ``count``; W has the modes ``slopes``.

    ``kernel`` returns the matrix of K_per for a mode; ``tail`` bounds its norm from ``count`` on.

    Raises CertificateError.
    """
    unknowns, width = range(len(slopes)), max(map(len, slopes)) - 1
    require_size(len(slopes) ** 2 * count * (count + width))
    kernels = [kernel(n) for n in range(count + width)]
    inside = [(m, n) for m in unknowns for n in range(count)]
    outside = [(m, n) for m in unknowns for n in range(count, count + width)]
    unit = identity(len(inside))
    block = unit - _coupling(slopes, kernels, inside, inside)
    with ctx.workprec(BLOCK_BITS):
        inverse = approximate_inverse(block)
    sizes = largest(norm(slope, arb(1)) for slope in slopes)
    norms = [_spectral_norm(unit - inverse * block), sizes * tail]
    if outside:
        norms.append(_spectral_norm(inverse * _coupling(slopes, kernels, inside, outside)))
        norms.append(_spectral_norm(_coupling(slopes, kernels, outside, inside)))
    contraction = upper(sum((n * n for n in norms), arb(0)).abs_upper().sqrt())
    size = largest([arb(1), _spectral_norm(inverse)])
    return LineBlock(half_length, count, inverse, size, contraction)


def _coupling(
    slopes: Sequence[Series], kernels: Kernels, rows: Sequence[Index], columns: Sequence[Index]
) -> arb_mat:
    """Return entries of W K_per in the orthonormal cosine basis."""
    root, entries = arb(2).sqrt(), []
    for m, i in rows:
        slope = slopes[m]
        for n, j in columns:
            if i and j:
                weight = shifted_sum(slope, i, j)
            else:
                weight = entry(slope, i + j) * (root if i + j else 1)
            entries.append(weight * kernels[j][m][n])
    return arb_mat(len(rows), len(columns), entries)


def _spectral_norm(matrix: arb_mat) -> arb:
    """Bound the spectral norm: root of the product of largest row sum and largest column sum."""
    sizes = [[abs(value) for value in row] for row in matrix.tolist()]
    rows = largest(sum(row, arb(0)).upper() for row in sizes)
    columns = largest(sum(column, arb(0)).upper() for column in zip(*sizes, strict=True))
    return upper((rows * columns).sqrt())


def square_integral(functions: Sequence[Sequence[arb]], rate: arb, half_length: arb) -> arb:
    """Return the integral of sum f(x)^2 exp(rate |x|) over (-d, d), f in cosines of pi n x/d."""
    grown, total = (rate * half_length).exp(), arb(0)
    for f in functions:
        for n, coefficient in enumerate(product(f, f)):
            wave = arb.pi() * n / half_length
            value = 2 * rate * ((-1) ** n * grown - 1) / (rate * rate + wave * wave)
            total += (2 if n else 1) * coefficient * value
    return total
