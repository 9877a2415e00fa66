r"""Solitary waves on the whole line: the contraction that proves one (Theorem 3).

With V_m'(r) = V_m'(0) + K_m r + N_m(r) between m-th neighbours, the stretches y_m of a wave of
speed v are y = K*g, where g_m = N_m(y_m) and K has the transforms T_m T_n/Delta (`line_kernel`);
so F(g) = g - N(K*g) = 0 in even functions of L^2. The unknowns are the g_m of the nonlinear
springs, the strain is y_1. The centre is a cosine polynomial on (-d, d) and 0 outside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from flint import acb, arb

from .composition import Composed, Strip, composed, trimmed
from .cosine_series import Series, entry, largest, product, upper
from .limits import CertificateError
from .line_block import LineBlock, LineInterval, line_block, square_integral
from .line_kernel import LineKernel, box
from .periodic import Contraction, Spring

SLOPE_CUT = 1e-9
"""Norm below which the highest coefficients of N'(y) are only bounded, not known."""


@dataclass(frozen=True)
class Law:
    """Series of N_m and N_m' at the periodic stretch y_m, norms of their remainders.

    ``third`` bounds V_m''' within the reach of the stretch, ``outer_third`` near rest.
    """

    stretch: Series
    values: Series
    values_rest: arb
    slope: Series
    slope_rest: arb
    third: arb
    outer_third: arb


@dataclass(frozen=True)
class SolitaryCentre(LineInterval):
    """Modes a_0 ... a_N of each g_m on (-d, d), decay kappa, size of the block, largest radius."""

    springs: tuple[Spring, ...]
    speed_squared: arb
    half_length: arb
    kappa: arb
    modes: tuple[Series, ...]
    block: int
    radius_bound: arb
    strip: Strip | None = None

    @cached_property
    def nonlinear(self) -> tuple[Spring, ...]:
        """Nonlinear springs, one for each unknown function."""
        return nonlinear_springs(self.springs)

    @cached_property
    def line(self) -> LineKernel:
        """Kernel of the linear chain; its functions are the strain and the unknowns' stretches."""
        boxes = sorted({1, *(spring.neighbour for spring in self.nonlinear)})
        stiffness = tuple((spring.neighbour, spring.force.at_rest[1]) for spring in self.springs)
        return LineKernel(stiffness, self.speed_squared, self.kappa, tuple(boxes))

    def boxes(self, n: int) -> list[arb]:
        """Return T_m(k_n) for each unknown."""
        return [box(spring.neighbour, self.wavenumber(n)) for spring in self.nonlinear]

    def potential(self, modes: Sequence[Series], power: int) -> Series:
        """Return the modes of sum_m T_m a_m/Delta^power, of which a kernel's parts are T_n."""
        result = []
        for n in range(len(modes[0])):
            pull = sum((t * a[n] for t, a in zip(self.boxes(n), modes, strict=True)), arb(0))
            result.append(pull / self.line.symbol(self.wavenumber(n)) ** power)
        return result

    def boxed(self, potential: Series, m: int) -> Series:
        """Return the modes of T_m times a ``potential``."""
        return [box(m, self.wavenumber(n)) * c for n, c in enumerate(potential)]

    @cached_property
    def strain(self) -> Series:
        """Modes of the periodic strain, the sum of the translates of K*g by 2 d."""
        return self.boxed(self.potential(self.modes, 1), 1)

    def size(self, functions: Sequence[Series]) -> arb:
        """Return a ball with the norm in L^2(-d, d) of ``functions``."""
        total = sum((product(f, f)[0] for f in functions), arb(0)) * 2 * self.half_length
        return total.max(arb(0)).sqrt()

    def weighted_size(self, functions: Sequence[Series]) -> arb:
        """Bound (2 d times the integral of sum f^2 exp(2 kappa |x|))^(1/2)."""
        total = square_integral(functions, 2 * self.kappa, self.half_length)
        return upper((2 * self.half_length * total).abs_upper().sqrt())

    def edge_size(self, functions: Sequence[Series]) -> arb:
        """Bound (integral of sum f^2 exp(-2 kappa (d - |x|)))^(1/2)."""
        total = square_integral(functions, 2 * self.kappa, self.half_length)
        return upper(total.abs_upper().sqrt() * self.edge)

    @cached_property
    def weight(self) -> arb:
        """Weighted norm G of the centre."""
        return self.weighted_size(self.modes)

    def periodic_error(self, power: int, weight: arb) -> arb:
        """Bound exp(kappa (d - |x|)) |periodic kernel*g - kernel*g| on (-d, d).

        ``weight`` is the weighted norm of g.
        """
        return upper(2 * self.line.constants[power - 1] * weight * self.images * self.edge)

    @cached_property
    def delta(self) -> arb:
        """Bound of |periodic stretches - stretches| on (-d, d)."""
        return self.periodic_error(1, self.weight)

    @cached_property
    def outer(self) -> arb:
        """Bound of the stretches exp(kappa (|x| - d)) outside (-d, d)."""
        return upper(self.line.constants[0] * self.weight * self.edge)

    @cached_property
    def embedding(self) -> arb:
        """Constant L in |K*h| <= L ||h||."""
        return upper(self.line.constants[0] / self.kappa.sqrt())

    def norm_of_kernel(self, power: int) -> arb:
        """Bound ||kernel*h||/||h||."""
        return upper(2 * self.line.constants[power - 1] / self.kappa)

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """Forces of the nonlinear springs at the centre."""
        potential = self.potential(self.modes, 1)
        return tuple(self.law(s, self.boxed(potential, s.neighbour)) for s in self.nonlinear)

    def law(self, spring: Spring, stretch: Series) -> Law:
        """Return the force of a spring at a periodic ``stretch``."""
        reach = upper(self.delta + self.embedding * self.radius_bound)
        law: Composed = composed(spring.force, stretch, arb(1), reach, self.strip)
        rest_force, stiffness = spring.force.at_rest[:2]
        values = [entry(law.force, n) for n in range(max(len(law.force), len(stretch)))]
        values = [value - stiffness * entry(stretch, n) for n, value in enumerate(values)]
        values[0] -= rest_force
        slope = [law.stiffness[0] - stiffness, *law.stiffness[1:]]
        near_rest = acb(arb(0, upper(self.outer + reach)))
        third = abs(2 * spring.force.taylor(near_rest, 3)[2]).upper()
        if not third.is_finite():
            raise CertificateError("force leaves its domain near rest")
        return Law(
            stretch, values, law.force_rest, slope, law.stiffness_rest, law.third, upper(third)
        )

    @cached_property
    def third(self) -> arb:
        """Largest bound of V_m''' on (-d, d)."""
        return largest(law.third for law in self.laws)

    @cached_property
    def outer_third(self) -> arb:
        """Largest bound of V_m''' outside (-d, d)."""
        return largest(law.outer_third for law in self.laws)

    @cached_property
    def edge_slope(self) -> arb:
        """Bound (integral of sum N'(y)^2 exp(-2 kappa (d - |x|)))^(1/2)."""
        rest = sum((law.slope_rest for law in self.laws), arb(0)) / self.kappa.sqrt()
        return upper(self.edge_size([law.slope for law in self.laws]) + rest)

    @cached_property
    def linear(self) -> LineBlock:
        """Approximate inverse of DF on the modes up to `block`."""
        slopes, rests = zip(
            *(trimmed(law.slope, arb(1), SLOPE_CUT) for law in self.laws), strict=True
        )
        count = self.block + 1
        tail = self.line.largest_beyond(self.wavenumber(count))
        part = line_block(slopes, self.kernel, tail, count, self.half_length)
        rest = largest([*rests, *(law.slope_rest for law in self.laws)]) * 2
        missing = part.size * rest * self.norm_of_kernel(1)
        return replace(part, contraction=upper(part.contraction + missing))

    def kernel(self, n: int) -> list[list[arb]]:
        """Return the matrix T_m T_m'/Delta of the unknowns at k_n."""
        boxes, pull = self.boxes(n), self.line.symbol(self.wavenumber(n))
        return [[s * t / pull for t in boxes] for s in boxes]


def nonlinear_springs(springs: Sequence[Spring]) -> tuple[Spring, ...]:
    """Return the springs whose force is not proved to be linear."""
    return tuple(s for s in springs if s.force.polynomial is None or len(s.force.polynomial) > 2)


def solitary_contraction(centre: SolitaryCentre) -> Contraction:
    """Return the bounds of the map g - A F(g) about a centre. Raises CertificateError."""
    if not centre.half_length > 0:
        raise CertificateError("half_length > 0 must hold")
    delta, outer, kappa, linear = centre.delta, centre.outer, centre.kappa, centre.linear
    constant, operator = centre.line.constants[0], centre.norm_of_kernel(1)
    curvature = centre.third * delta * delta + centre.outer_third * outer * outer
    rest = sum((law.values_rest for law in centre.laws), arb(0)) * (2 * centre.half_length).sqrt()
    defect = delta * centre.edge_slope + curvature / (2 * (2 * kappa).sqrt()) + rest
    coupling = (2 * centre.images + 1) * constant * centre.edge_slope / kappa.sqrt()
    variation = largest([upper(delta * centre.third), upper(outer * centre.outer_third)])
    differences = [
        [entry(a, n) - entry(law.values, n) for n in range(max(len(a), len(law.values)))]
        for a, law in zip(centre.modes, centre.laws, strict=True)
    ]
    second = largest([centre.third, centre.outer_third])
    return Contraction(
        upper(linear.image_size(differences) + linear.size * defect),
        linear.contraction,
        upper(linear.size * (coupling + variation * operator)),
        upper(linear.size * second * centre.embedding * operator),
    )
