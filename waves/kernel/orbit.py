r"""Time-periodic orbits of a chain: the contraction that proves one.

The sites q_n = a_n0 + 2 (a_n1 cos Omega t + a_n2 cos 2 Omega t + ...) of unit mass move by
q_n'' = -G_n, G_n = dH/dq_n, if for all n and k

    F_nk = k^2 Omega^2 a_nk - [G_n]_k = 0.

Finite chain: q = 0 beyond its ends; Omega^2 is unknown, and H = E at t = 0 is one more equation.
Infinite chain: Omega is given. If all forces are odd, only odd k occur. The norm is
weight |Omega^2| + sum_n (|a_n0| + 2 sum_k |a_nk| nu^k). In a block of sites and harmonics, A is an
approximate inverse; outside it divides F_nk by k^2 Omega^2 - rest, where rest is 0 in a finite
chain, and the slope of G_n at rest in an infinite one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from flint import acb, arb, arb_mat

from .composition import Composed, Strip, composed, trimmed
from .cosine_series import (
    Series,
    entry,
    largest,
    norm,
    polynomial_of,
    shifted_sum,
    upper,
    value_at_zero,
)
from .force_text import Force
from .limits import MAX_MODES, CertificateError, require_size
from .periodic import (
    STIFFNESS_CUT,
    Contraction,
    Spring,
    approximate_inverse,
    column_norms,
    identity,
)

Index = tuple[int, int]
"""Site and harmonic of an unknown or an equation, or two sites."""


@dataclass(frozen=True)
class OrbitBond:
    """A force V'(x) with the stretch x = sum of sign times q over the ends (site, sign).

    It pulls each end by -sign V'(x). A bond to a wall, or the force on a site, has one end.
    """

    force: Force
    ends: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class OrbitCentre:
    """Approximate modes of each site, weights of the norm, and the largest radius.

    Springs between 0-th neighbours are forces on each site. ``energy`` is None for an infinite
    chain, in which the sites beyond those with modes are at rest at the centre. The block may be
    smaller than the centre: ``margin`` sites less at each end of an infinite chain, and
    ``block_top`` as its largest harmonic.
    """

    springs: tuple[Spring, ...]
    modes: Sequence[Series]
    frequency_squared: arb
    energy: arb | None
    nu: arb
    weight: arb
    radius_bound: arb
    strip: Strip | None = None
    margin: int = 0
    block_top: int = MAX_MODES

    def frequency_squared_within(self, radius: arb) -> arb:
        """Return the squared frequency of an orbit within ``radius`` of the centre, as a ball."""
        return self.frequency_squared + arb(0, upper(radius / self.weight))

    @cached_property
    def top(self) -> int:
        """K, the largest harmonic of the centre."""
        return len(self.modes[0]) - 1

    @cached_property
    def sites(self) -> range:
        """Sites with modes."""
        return range(len(self.modes))

    @cached_property
    def around(self) -> range:
        """All sites of a finite chain; of an infinite one, up to a site with all bonds at rest.

        What is bounded at this site is bounded at all sites beyond.
        """
        return self._widened(2)

    def _widened(self, times: int) -> range:
        """Return the sites with modes; in an infinite chain also those ``times`` bonds away."""
        infinite = self.energy is None
        reach = infinite * times * max(spring.neighbour for spring in self.springs)
        return range(-reach, len(self.modes) + reach)

    @cached_property
    def bonds(self) -> list[OrbitBond]:
        """Bonds of the sites `around`."""
        sites = self._widened(3)
        bonds = []
        for spring in self.springs:
            m = spring.neighbour
            for n in range(sites.start - m, sites.stop):
                ends = ((n, 1),) if m == 0 else ((n + m, 1), (n, -1))
                bonds.append(OrbitBond(spring.force, tuple(e for e in ends if e[0] in sites)))
        return bonds

    @cached_property
    def is_odd(self) -> bool:
        """Whether all forces are odd polynomials, so that q(t + T/2) = -q(t) is required."""
        return all(spring.force.is_odd for spring in self.springs)

    def harmonics(self, first: int, last: int) -> range:
        """Return the harmonics from ``first`` to ``last`` that occur."""
        return range(first | 1, last + 1, 2) if self.is_odd else range(first, last + 1)

    @cached_property
    def index(self) -> list[Index]:
        """Sites and harmonics of the block."""
        return [(n, k) for n in self.inside for k in self.harmonics(0, self.last)]

    @cached_property
    def inside(self) -> range:
        """Sites of the block."""
        return self.sites[self.margin : len(self.sites) - self.margin]

    @cached_property
    def last(self) -> int:
        """Largest harmonic of the block."""
        return min(self.top, self.block_top)

    def outside(self, n: int, last: int) -> range:
        """Return the harmonics at site n that are not in the block, up to ``last``."""
        return self.harmonics(self.last + 1 if n in self.inside else 0, last)

    def stretch(self, bond: OrbitBond) -> Series:
        """Return the series of a bond's stretch."""
        total = [arb(0)] * (self.top + 1)
        for n, sign in bond.ends:
            if n in self.sites:
                total = [a + sign * b for a, b in zip(total, self.modes[n], strict=True)]
        return total

    @cached_property
    def laws(self) -> list[tuple[OrbitBond, Composed]]:
        """Each bond, and its force composed with its stretch."""
        return [
            (b, composed(b.force, self.stretch(b), self.nu, self.radius_bound, self.strip))
            for b in self.bonds
        ]

    @cached_property
    def forces(self) -> dict[int, Series]:
        """Known modes of G_n, by site."""
        sums: dict[int, Series] = {}
        for bond, law in self.laws:
            for n, sign in bond.ends:
                sums[n] = _added(sums.get(n, []), sign, law.force)
        return sums

    @cached_property
    def stiffness(self) -> dict[Index, Series]:
        """Largest modes of dG_n/dq_m, by the sites n and m."""
        return self.stiffness_of(lambda law: trimmed(law.stiffness, self.nu, STIFFNESS_CUT)[0])

    def stiffness_of(self, series: Callable[[Composed], Series]) -> dict[Index, Series]:
        """Return the modes of dG_n/dq_m, by the sites n and m, from those of V'' in each bond."""
        sums: dict[Index, Series] = {}
        for bond, law in self.laws:
            known = series(law)
            for n, sign in bond.ends:
                for m, other in bond.ends:
                    sums[n, m] = _added(sums.get((n, m), []), sign * other, known)
        return sums

    @cached_property
    def width(self) -> int:
        """Largest index of a known coefficient of a stiffness."""
        return max(len(known) for known in self.stiffness.values()) - 1

    @cached_property
    def rest(self) -> arb:
        """Slope of G_n at rest in an infinite chain; 0 in a finite one."""
        total = arb(0)
        for spring in self.springs if self.energy is None else ():
            total += spring.force.at_rest[1] * (2 if spring.neighbour else 1)
        return total

    def diagonal(self, k: int) -> arb:
        """Return k^2 Omega^2 - rest."""
        return k * k * self.frequency_squared - self.rest

    def weight_of(self, k: int) -> arb:
        """Return the weight of harmonic k in the norm."""
        return 2 * self.nu**k if k else arb(1)

    def residual(self, n: int, k: int) -> arb:
        """Return F_nk at the centre."""
        own = entry(self.modes[n], k) if n in self.sites else arb(0)
        return k * k * self.frequency_squared * own - entry(self.forces[n], k)

    def coupling(self, row: Index, column: Index) -> arb:
        """Return d[G_n]_j/da_mk for the ``row`` n, j and the ``column`` m, k."""
        known = self.stiffness.get((row[0], column[0]), [])
        return shifted_sum(known, row[1], column[1]) / (1 if column[1] else 2)

    def at_start(self, bond: OrbitBond, error: arb) -> arb:
        """Return a bond's stretch at t = 0, with an ``error``."""
        return value_at_zero(self.stretch(bond)) + arb(0, upper(error))

    def pulls(self, error: arb) -> dict[int, arb]:
        """Return G_n at t = 0 by site, if each stretch has an ``error``."""
        pulls: dict[int, arb] = {}
        for bond in self.bonds:
            force = bond.force.taylor(acb(self.at_start(bond, error)), 1)[0].real
            for n, sign in bond.ends:
                pulls[n] = pulls.get(n, arb(0)) + sign * force
        return pulls

    def over_bonds(self, values: Iterable[arb]) -> arb:
        """Return the largest sum over the bonds of a site; ``values`` has one value a bond."""
        sums: dict[int, arb] = {}
        for bond, value in zip(self.bonds, values, strict=True):
            for n, _ in bond.ends:
                sums[n] = sums.get(n, arb(0)) + value
        return largest(sums.values())


def _added(f: Series, sign: int, g: Series) -> Series:
    """Return f + sign g."""
    return [entry(f, k) + sign * entry(g, k) for k in range(max(len(f), len(g)))]


def orbit_contraction(centre: OrbitCentre) -> Contraction:
    """Return the bounds of the map x - A F(x) about a centre. Raises CertificateError."""
    _require_fit(centre)
    block = _Block(centre)
    unit = identity(len(block.rows))
    missing, force_rest, third = [], arb(0), []
    for bond, law in centre.laws:
        cut = trimmed(law.stiffness, centre.nu, STIFFNESS_CUT)[1]
        missing.append(len(bond.ends) * (cut + law.stiffness_rest))
        force_rest += len(bond.ends) * law.force_rest
        third.append(len(bond.ends) * law.third)
    second = block.size * centre.over_bonds(third)
    if centre.energy is not None:
        second = largest([second, block.size_of_squares / centre.weight])
        second += block.size_of_energy * centre.over_bonds(
            abs(bond.force.taylor(acb(centre.at_start(bond, centre.radius_bound)), 2)[1])
            for bond in centre.bonds
        )
    return Contraction(
        upper(block.defect() + block.size * force_rest),
        largest(column_norms(unit - block.inverse * block.jacobian, block.rows, block.rows)),
        upper(block.tail_norm() + block.size * centre.over_bonds(missing)),
        upper(second),
    )


def _require_fit(centre: OrbitCentre) -> None:
    last, pinned = centre.last, centre.energy is not None
    length = max(len(spring.force.polynomial or spring.force.text) for spring in centre.springs)
    require_size(len(centre.bonds) * (centre.top + 1) * length)
    if not (centre.nu >= 1 and centre.weight > 0 and centre.frequency_squared > 0 and last >= 1):
        raise CertificateError("nu >= 1, weight > 0, frequency > 0, one harmonic must hold")
    if not centre.inside or (pinned and centre.margin):
        raise CertificateError("the block must have a site, and in a finite chain all sites")
    if not pinned:
        if not all(spring.force.at_rest[0].is_zero() for spring in centre.springs):
            raise CertificateError("the forces of an infinite chain must be 0 at rest")
        for k in centre.harmonics(0, last + 1):
            if not abs(centre.diagonal(k)) > 0:
                raise CertificateError(f"harmonic {k} is resonant with waves of the chain")
    if not centre.diagonal(last + 1) > 0:
        raise CertificateError("more harmonics are needed: k^2 Omega^2 - rest > 0 fails")


class _Block:
    """The equations and unknowns of the block, and the approximate inverse A of their matrix."""

    def __init__(self, centre: OrbitCentre) -> None:
        self.centre = centre
        weights = [centre.weight_of(k) for _, k in centre.index]
        pinned = centre.energy is not None
        self.pulls = centre.pulls(arb(0)) if pinned else {}
        self.rows = [centre.weight, *weights] if pinned else weights
        self.outside = self._outside()
        require_size(len(self.rows) * (len(self.rows) + len(self.outside)))
        self.jacobian = self._jacobian()
        self.inverse = approximate_inverse(self.jacobian)
        norms = column_norms(self.inverse, self.rows, [arb(1), *weights] if pinned else weights)
        self.size_of_energy = norms.pop(0) if pinned else arb(0)
        self.inner = upper(1 / centre.diagonal(centre.last + 1))
        low = () if pinned else centre.harmonics(0, centre.last + 1)
        self.outer = largest([self.inner, *(1 / abs(centre.diagonal(k)) for k in low)])
        self.size = largest([*norms, self.outer])
        squares = (k * k * size for (_, k), size in zip(centre.index, norms, strict=True))
        self.size_of_squares = largest([*squares, 1 / centre.frequency_squared])

    def _jacobian(self) -> arb_mat:
        centre, entries = self.centre, []
        if self.pulls:
            row = [(2 if k else 1) * self.pulls[n] for n, k in centre.index]
            entries += [arb(0), *row]
        for n, j in centre.index:
            if self.pulls:
                entries.append(j * j * centre.modes[n][j])
            for m, k in centre.index:
                value = -centre.coupling((n, j), (m, k))
                square = j * j * centre.frequency_squared
                entries.append(value + square if (n, j) == (m, k) else value)
        return arb_mat(len(self.rows), len(self.rows), entries)

    def _outside(self) -> list[Index]:
        """Return the columns outside the block that its rows meet.

        The equation of the energy meets all; the factors of the last ones are the largest.
        """
        centre = self.centre
        met = {m for n, m in centre.stiffness if n in centre.inside}
        last = centre.last + centre.width + 2
        return [(m, k) for m in centre.around if m in met for k in centre.outside(m, last)]

    def defect(self) -> arb:
        """Return the norm of A F at the centre, with all known modes of the forces."""
        centre, block = self.centre, []
        if centre.energy is not None:
            block.append(energy_at_start(centre) - centre.energy)
        block += [centre.residual(n, k) for n, k in centre.index]
        image = self.inverse * arb_mat(len(block), 1, block)
        total = column_norms(image, self.rows, [arb(1)])[0]
        for n in centre.around:
            for k in centre.outside(n, max(centre.top, len(centre.forces[n]) - 1)):
                defect = abs(centre.residual(n, k) / centre.diagonal(k))
                total += centre.weight_of(k) * defect
        return upper(total)

    def tail_norm(self) -> arb:
        """Return the norm of I - A DF outside the block."""
        centre = self.centre
        beyond = {m: self._beyond(m) for m in centre.around}
        norms = [*beyond.values()]
        if centre.energy is not None:
            norms.append(self._below_square())
        entries = [2 * self.pulls[m] for m, _ in self.outside] if self.pulls else []
        for row in centre.index:
            entries += [-centre.coupling(row, column) for column in self.outside]
        image = self.inverse * arb_mat(len(self.rows), len(self.outside), entries)
        columns = column_norms(image, self.rows, [centre.weight_of(k) for _, k in self.outside])
        for (m, _), size in zip(self.outside, columns, strict=True):
            norms.append(size + beyond[m])
        return largest(norms)

    def _below_square(self) -> arb:
        """Return the norm of the rows outside the block, of the column of Omega^2."""
        centre, total = self.centre, arb(0)
        for n in centre.sites:
            for k in centre.outside(n, centre.top):
                size = abs(k * k * centre.modes[n][k] / centre.diagonal(k))
                total += centre.weight_of(k) * size
        return upper(total / centre.weight)

    def _beyond(self, m: int) -> arb:
        """Return a bound of the norm of the rows outside the block, of all columns at site m."""
        centre, total = self.centre, arb(0)
        for (n, column), series in centre.stiffness.items():
            if column == m:
                known = [*series]
                known[0] -= centre.rest if n == m else 0
                size = norm(known, centre.nu)
                total += size * (self.inner if n in centre.inside else self.outer)
        return upper(total)


def energy_at_start(centre: OrbitCentre, radius: arb | None = None) -> arb:
    """Return the energy at t = 0 of the centre, or of all sites within ``radius`` of it."""
    total = sum((_potential(b.force, centre.at_start(b, arb(0))) for b in centre.bonds), arb(0))
    if radius is None:
        return total
    return total + arb(0, upper(radius * largest(map(abs, centre.pulls(radius).values()))))


def _potential(force: Force, x: arb) -> arb:
    """Return V(x), the integral of a force from 0."""
    if force.polynomial is not None:
        powers = [arb(0), *(c / (i + 1) for i, c in enumerate(force.derivative(0)))]
        return polynomial_of(powers, [x])[0]

    def integrand(z: acb, _: bool) -> acb:
        try:
            return force.taylor(z, 1)[0]
        except CertificateError:
            return acb("nan")

    middle = acb.integral(integrand, 0, acb(x.mid()))
    return middle.real + force.taylor(acb(x), 1)[0].real * arb(0, x.rad())
