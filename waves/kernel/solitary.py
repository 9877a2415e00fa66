r"""Solitary waves on the whole line: the contraction that proves one (Theorem 3).

For V'(r) = c^2 r + N(r) and a speed v > c the strain f(n - v t) is f = K*g with g = N(f), where K
has the transform s^2/(v^2 - c^2 s^2), s = sin(k/2)/(k/2); so F(g) = g - N(K*g) = 0 in even
functions of L^2. The centre is a cosine polynomial on (-d, d) and 0 outside:

    0 <= K(x) <= C exp(-kappa |x|),   C = max(1, exp(kappa - 1)/kappa if kappa > 1)/(v^2 - c^2 S),
    S = (sinh(kappa/2)/(kappa/2))^2,  |K*h| <= L ||h||,  ||K*h|| <= ||h||/D,  D = v^2 - c^2,
    L = min(1/D, (sqrt(3)/(2 v))^(1/2) D^(-3/4)).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from flint import acb, arb

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
    upper,
)
from .force_text import Force
from .limits import CertificateError
from .line_block import LineBlock, exponential_integral, line_block
from .periodic import Contraction

TAYLOR_PIECES = 32
"""Number of pieces of the range of strains on which a Taylor remainder is bounded."""


@dataclass(frozen=True)
class SolitaryCentre:
    """Modes a_0 ... a_N of g on (-d, d), the decay kappa of the kernel, the largest radius.

    An analytic force is replaced by its Taylor polynomial of ``degree`` for strains up to
    ``range_bound``; the rest is bounded.
    """

    force: Force
    speed_squared: arb
    half_length: arb
    kappa: arb
    modes: Series
    radius_bound: arb
    degree: int
    range_bound: arb

    @property
    def top(self) -> int:
        """N, the index of the highest mode."""
        return len(self.modes) - 1

    @cached_property
    def taylor(self) -> Series:
        """Taylor coefficients of the force at rest."""
        if self.force.polynomial is not None:
            return [*map(arb, self.force.polynomial), arb(0), arb(0)]
        return [c.real for c in self.force.taylor(acb(0), self.degree + 1)]

    @property
    def sound_squared(self) -> arb:
        """Squared speed of sound c^2."""
        return self.taylor[1]

    @cached_property
    def nonlinear(self) -> Series:
        """Taylor coefficients of the nonlinear part N of the force."""
        return [arb(0), arb(0), *self.taylor[2:]]

    @cached_property
    def taylor_rest(self) -> arb:
        """Bound e of |N^(p)|/p! on the range, p = degree + 1: |rest of N| <= e |y|^p."""
        if self.force.polynomial is not None:
            return arb(0)
        step = self.range_bound / TAYLOR_PIECES
        sizes = []
        for i in range(-TAYLOR_PIECES, TAYLOR_PIECES):
            piece = acb((i * step).union((i + 1) * step))
            sizes.append(abs(self.force.taylor(piece, self.degree + 2)[self.degree + 1]).upper())
        return largest(sizes)

    @cached_property
    def gap(self) -> arb:
        """Gap D = v^2 - c^2."""
        return self.speed_squared - self.sound_squared

    @cached_property
    def decay_constant(self) -> arb:
        """Constant C in K(x) <= C exp(-kappa |x|). Raises CertificateError for a large kappa."""
        half = self.kappa / 2
        ratio = half.sinh() / half
        below = self.speed_squared - self.sound_squared * ratio * ratio
        if not below > 0:
            raise CertificateError("kappa must satisfy c^2 (sinh(kappa/2)/(kappa/2))^2 < v^2")
        peak = ((self.kappa - 1).exp() / self.kappa).max(arb(1))
        return upper(peak / below)

    @cached_property
    def embedding(self) -> arb:
        """Constant L in |K*h| <= L ||h||."""
        root = (arb(3).sqrt() / (2 * self.speed_squared.sqrt())).sqrt()
        return upper((1 / self.gap).min(root / self.gap.sqrt() / self.gap.sqrt().sqrt()))

    def multiplier(self, n: int) -> arb:
        """Return the transform of K at k = pi n/d."""
        half = arb.pi() * n / self.half_length / 2
        square = (half.sin() / half) ** 2 if n else arb(1)
        return square / (self.speed_squared - self.sound_squared * square)

    @cached_property
    def strain(self) -> Series:
        """Modes of the periodic strain f_p, the sum of the translates of K*g by 2 d."""
        return [self.multiplier(n) * a for n, a in enumerate(self.modes)]

    @property
    def size_below(self) -> arb:
        """Lower bound of the centre's norm in L^2."""
        total = product(self.modes, self.modes)[0] * 2 * self.half_length
        return total.max(arb(0)).sqrt().lower()

    @cached_property
    def weighted_size(self) -> arb:
        """Weighted norm G = (2 d times the integral of g^2 exp(2 kappa |x|))^(1/2)."""
        square = product(self.modes, self.modes)
        total = exponential_integral(square, 2 * self.kappa, self.half_length)
        return upper((2 * self.half_length * total).abs_upper().sqrt())

    @cached_property
    def edge(self) -> arb:
        """Decay exp(-kappa d) from the middle to the edge of the interval."""
        return upper((-self.kappa * self.half_length).exp())

    @cached_property
    def images(self) -> arb:
        """Sum Q = 1/(1 - exp(-2 kappa d)) of the decay over all periodic images."""
        return upper(1 / (1 - self.edge * self.edge))

    @cached_property
    def periodic_error(self) -> arb:
        """Bound delta of |f_p - K*g| on (-d, d); at x = 0 it is delta exp(-kappa d)."""
        return upper(2 * self.decay_constant * self.weighted_size * self.images * self.edge)

    @cached_property
    def outer_strain(self) -> arb:
        """Bound of |K*g| outside (-d, d)."""
        return upper(self.decay_constant * self.weighted_size * self.edge)


def solitary_contraction(centre: SolitaryCentre) -> Contraction:
    """Return the bounds of the map g - A F(g) about a centre. Raises CertificateError."""
    if not (centre.gap > 0 and centre.sound_squared > 0):
        raise CertificateError("speed must be above the speed of sound")
    if not (centre.kappa > 0 and centre.half_length > 0):
        raise CertificateError("kappa > 0 and half_length > 0 must hold")
    slope, rest = trimmed(
        polynomial_of(derivative(centre.nonlinear, 1), centre.strain), arb(1), 1e-9
    )
    block = _block(centre, slope)
    size = block.size
    delta, d, gap, kappa = centre.periodic_error, centre.half_length, centre.gap, centre.kappa
    inner = upper(norm(centre.strain, arb(1)) + delta)
    reach = largest([inner, centre.outer_strain])
    widest = upper(reach + centre.embedding * centre.radius_bound)
    if not centre.range_bound >= widest and centre.force.polynomial is None:
        least = widest.str(6, radius=False)
        raise CertificateError(f"range_bound must be at least {least}, got {centre.range_bound}")
    p, e = centre.degree + 1, centre.taylor_rest
    curvature = polynomial_bound(derivative(centre.nonlinear, 2), inner)
    edge_slope = _edge_slope(centre, slope) + rest / kappa.sqrt()
    outer = polynomial_bound(centre.nonlinear[2:], centre.outer_strain)
    defect = (
        delta * edge_slope
        + curvature * delta * delta / (2 * (2 * kappa).sqrt())
        + outer * centre.outer_strain**2 / (2 * kappa).sqrt()
        + e * (reach**p * (2 * d).sqrt() + centre.outer_strain**p / (p * kappa).sqrt())
    )
    coupling = (2 * centre.images + 1) * centre.decay_constant * edge_slope / kappa.sqrt()
    variation = largest(
        [delta * curvature, polynomial_bound(derivative(centre.nonlinear, 1), centre.outer_strain)]
    )
    linear = coupling + (variation + rest + e * p * reach ** (p - 1)) / gap
    second = polynomial_bound(derivative(centre.nonlinear, 2), widest) + e * p * (
        p - 1
    ) * widest ** (p - 2)
    return Contraction(
        upper(block.image_size(_periodic_defect(centre)) + size * defect),
        block.contraction,
        upper(size * linear),
        upper(size * second * centre.embedding / gap),
    )


def _block(centre: SolitaryCentre, slope: Series) -> LineBlock:
    """Return the inverted linear part; W has the modes ``slope``."""
    wave = arb.pi() * (centre.top + 1) / centre.half_length
    tail = 1 / (centre.gap + centre.speed_squared * wave * wave / 12)
    return line_block(slope, centre.multiplier, tail, centre.top, centre.half_length)


def _periodic_defect(centre: SolitaryCentre) -> Series:
    """Return the modes of g - N(f_p)."""
    values = polynomial_of(centre.nonlinear, centre.strain)
    count = max(len(values), centre.top + 1)
    return [entry(centre.modes, n) - entry(values, n) for n in range(count)]


def _edge_slope(centre: SolitaryCentre, slope: Series) -> arb:
    """Return the root of the integral of W^2 exp(-2 kappa (d - |x|)); W is ``slope``."""
    square = product(slope, slope)
    total = exponential_integral(square, 2 * centre.kappa, centre.half_length)
    return upper((total * (-2 * centre.kappa * centre.half_length).exp()).abs_upper().sqrt())
