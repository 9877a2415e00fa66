r"""Numbers of a proved solitary wave: crest, stretch, momentum, energy, and its change with v.

The displacements move with the velocities p = -v Q*g, Q = (T_m/Delta), so with the kernels B_j of
the transforms T_m T_n/Delta^j, the potential V_m = K_m r^2/2 + M_m and M_m' = N_m,

    momentum  integral of p = -v integral of f,    integral of p^2 = v^2 <g, B_2 g>,
    energy    H = v^2 <g, B_2 g> - <g, B_1 g>/2 + sum_m integral of M_m(y_m).

With the action A = v <g, B_2 g> (p^2 over v), H - v A is stationary at a wave, and its derivative
by v alone is -A. Therefore dH/dv = v dA/dv, with dg/dv = -2 v w, w = N'(y) (B_1 w + B_2 g):

    dH/dv = v (<g, B_2 g> - 4 v^2 <g, B_3 g> - 4 v^2 <B_2 g, w>).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_poly

from .cosine_series import Series, entry, largest, norm, product, upper, value_at_zero
from .limits import CertificateError
from .periodic import Contraction
from .solitary import Law, SolitaryCentre


@dataclass(frozen=True)
class SolitaryNumbers:
    """Numbers of the wave within ``radius`` of a centre; ``bounds`` prove that it exists."""

    centre: SolitaryCentre
    bounds: Contraction
    radius: arb

    @property
    def speed(self) -> arb:
        """Speed v."""
        return self.centre.speed_squared.sqrt()

    @property
    def crest(self) -> arb:
        """Strain f(0)."""
        centre = self.centre
        error = centre.embedding * self.radius + centre.delta * centre.edge
        return value_at_zero(centre.strain) + _around_zero(error)

    @property
    def profile_error(self) -> arb:
        """Bound of |f - periodic strain| on (-d, d) and of |f| outside."""
        return largest([self.reach, self.outer])

    @property
    def reach(self) -> arb:
        """Bound of |stretches - periodic stretches| on (-d, d)."""
        return upper(self.centre.delta + self.centre.embedding * self.radius)

    @property
    def outer(self) -> arb:
        """Bound of the stretches outside (-d, d)."""
        return upper(self.centre.outer + self.centre.embedding * self.radius)

    @property
    def outer_size(self) -> arb:
        """Bound of the norm of the stretches outside (-d, d)."""
        centre = self.centre
        return centre.outer / centre.kappa.sqrt() + centre.norm_of_kernel(1) * self.radius

    @property
    def stretch(self) -> arb:
        """Integral of the strain f; outside (-d, d), |N(y)| <= sup |V'''| y^2/2."""
        centre, total = self.centre, arb(0)
        rest = (2 * centre.half_length).sqrt() * self.radius
        rest += centre.outer_third * self.outer_size * self.outer_size / 2
        for spring, modes in zip(centre.nonlinear, centre.modes, strict=True):
            integral = 2 * centre.half_length * modes[0] + _around_zero(rest)
            total += spring.neighbour * integral
        return total / centre.line.gap

    def form(self, power: int) -> arb:
        """Return <g, B g> for the kernel B with this ``power`` of 1/Delta."""
        centre, modes = self.centre, self.centre.modes
        size = centre.size(modes)
        error = centre.periodic_error(power, centre.weight) * centre.weight * centre.edge
        error += centre.norm_of_kernel(power) * (2 * size + self.radius) * self.radius
        return self._inner(modes, power, modes) + _around_zero(error)

    def _inner(self, f: Sequence[Series], power: int, g: Sequence[Series]) -> arb:
        """Return the integral of f times the periodic kernel*g over (-d, d)."""
        potential, total = self.centre.potential(g, power), arb(0)
        for spring, modes in zip(self.centre.nonlinear, f, strict=True):
            total += product(modes, self.centre.boxed(potential, spring.neighbour))[0]
        return 2 * self.centre.half_length * total

    @property
    def energy(self) -> arb:
        """Energy H; the errors of M(y) are those of y times N(y) and half of N'(y)."""
        centre = self.centre
        change = centre.norm_of_kernel(1) * self.radius
        size = centre.delta / centre.kappa.sqrt() + change
        error = centre.outer_third * self.outer * self.outer_size * self.outer_size / 6
        total = centre.speed_squared * self.form(2) - self.form(1) / 2
        for law in centre.laws:
            total += self._potential_energy(law)
            error += centre.delta * centre.edge * centre.weighted_size([law.values])
            error += centre.size([law.values]) * change
            error += law.values_rest * (2 * centre.half_length).sqrt() * size
            error += self._largest_slope(law) * size * size / 2
        return total + _around_zero(error)

    def _largest_slope(self, law: Law) -> arb:
        return norm(law.slope, arb(1)) + law.slope_rest + law.third * self.reach

    def _potential_energy(self, law: Law) -> arb:
        """Return the integral of M(y) over (-d, d), y the periodic stretch.

        M(y) has the derivative N(y) y', and its value at d is at most sup |V'''| y(d)^3/6.
        """
        half_length = self.centre.half_length
        top = len(law.stretch) - 1
        slopes = [j * c for j, c in enumerate(law.stretch)]
        sines = arb_poly([*(-c for c in reversed(slopes[1:])), *slopes]) * arb_poly(
            [*reversed(law.values[1:]), *law.values]
        )
        middle = top + len(law.values) - 1
        total = arb(0)
        for n in range(1, middle + 1):
            total -= 2 * (-1) ** n * sines[middle + n] / n
        edge = self.centre.outer + self.centre.delta
        steepness = 2 * sum((abs(c) for c in slopes), arb(0)) * arb.pi() / half_length
        error = law.outer_third * edge * edge * edge / 6
        error += law.values_rest * half_length * steepness / 2
        return 2 * half_length * (total + _around_zero(error))

    def energy_slope(self, modes: Sequence[Series]) -> arb:
        """Return dH/dv along the waves through this one; ``modes`` are those of w, about."""
        centre = self.centre
        error = self._slope_error(modes)
        second = centre.norm_of_kernel(2)
        size = centre.size(modes)
        error = second * (centre.size(centre.modes) + self.radius) * error
        error += second * self.radius * size
        error += centre.periodic_error(2, centre.weight) * centre.weighted_size(modes) * centre.edge
        change = self._inner(centre.modes, 2, modes) + _around_zero(error)
        square = 4 * centre.speed_squared
        return self.speed * (self.form(2) - square * (self.form(3) + change))

    def _slope_error(self, modes: Sequence[Series]) -> arb:
        """Bound the distance of w from ``modes`` by A DF w, whose inverse is within 1/(1 - Z)."""
        centre = self.centre
        contraction = self.bounds.z0 + self.bounds.z1 + self.bounds.z2 * self.radius
        if not contraction < 1:
            raise CertificateError("the derivative by the speed is not proved to exist")
        first, second = (centre.norm_of_kernel(power) for power in (1, 2))
        potentials = centre.potential(modes, 1), centre.potential(centre.modes, 2)
        potential = [a + b for a, b in zip(*potentials, strict=True)]
        images = [centre.boxed(potential, spring.neighbour) for spring in centre.nonlinear]
        defects, slope, rest = [], arb(0), arb(0)
        for law, f, image in zip(centre.laws, modes, images, strict=True):
            values = product(law.slope, image)
            defects.append([entry(f, n) - value for n, value in enumerate(values)])
            slope = slope.max(norm(law.slope, arb(1)) + law.slope_rest)
            rest = rest.max(law.slope_rest)
        edge = centre.periodic_error(1, centre.weighted_size(modes))
        edge += centre.periodic_error(2, centre.weight)
        far = edge / centre.kappa.sqrt() + second * self.radius
        size = first * centre.size(modes) + second * (centre.size(centre.modes) + self.radius)
        total = edge * centre.edge_slope + slope * second * self.radius
        total += (rest + centre.third * centre.embedding * self.radius) * size
        total += centre.third * centre.delta * (centre.edge_size(images) + far)
        total += centre.outer_third * self.outer * far
        defect = centre.linear.image_size(defects) + centre.linear.size * total
        return upper(defect / (1 - contraction))


def _around_zero(size: arb) -> arb:
    return arb(0, upper(abs(size)))
