"""The linear dispersion relation of a lattice about a uniform strain.

For a plane wave ``y = ybar + delta exp(i (k n - omega t))`` a shift by j cells is ``exp(i j k)``;
the force enters by its slope at ybar.  Opposite shifts have equal weights, so ``omega^2`` is a sum
of ``sin^2(j k/2)``, each a polynomial in ``sin^2(k/2)`` (Chebyshev's), plus the sum of the weights
if on-site forces act.  For the strain FPUT lattice: the paper's eqs. (5) and (6).

With losses it is ``omega^2 + i Gamma omega``: Gamma is a sum of the same kind over dashpots and
sites.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

from sympy import Expr, I, Integer, S, Symbol, chebyshevt, expand, factor, series, sin, sqrt

from longwave.derive.algebra.formula_printing import latex_of
from longwave.derive.lattice import Bond, Lattice
from longwave.derive.models.lattices import FPUT_STRAIN
from longwave.derive.reduction import Reduction
from longwave.derive.scaling import Scaling
from longwave.derive.symbols import eps, k, powers_of_eps, ybar

HALF_SINE = Symbol("sin(k/2)")


@dataclass(frozen=True)
class Dispersion:
    """``omega_squared`` and the right-going branch ``omega_plus`` for 0 < k < 2 pi.

    For the strain FPUT lattice ``omega_squared`` is the right-hand side of the paper's eq. (5).
    Both are expressions in the wavenumber ``derive.symbols.k`` (radians a site), the uniform
    strain ``derive.symbols.ybar`` and the lattice's constants.  With losses the frequency solves
    ``omega^2 + i damping omega = omega_squared``; the right-going branch is then ``omega``.
    """

    omega_squared: Expr
    omega_plus: Expr
    damping: Expr = S.Zero

    @property
    def omega(self) -> Expr:
        """The frequency with losses; minus its imaginary part is the decay rate."""
        return sqrt(self.omega_squared - self.damping**2 / 4) - I * self.damping / 2

    def long_wave(self, order: int = 5) -> Expr:
        """Return the expansion of omega_plus in k up to, but without, ``k^order``.

        It is the sound speed times a series that begins with k, the paper's eq. (6); for a pinned
        lattice, its lowest frequency times a series that begins with 1.

        >>> dispersion_relation().at(Integer(0)).long_wave()
        sqrt(K2)*(-k**3/24 + k)
        """
        unit = self.omega_plus.subs(k, 0) or self.omega_plus.diff(k).subs(k, 0)
        return unit * expand(series(self.omega_plus / unit, k, 0, order).removeO())

    def is_solved_by(self, omega: Expr, power: int) -> bool:
        """Return whether a polynomial omega(k) solves the relation to ``eps^power``, k = O(eps)."""
        difference = omega**2 + I * self.damping * omega - self.omega_squared
        scaled = difference.subs({sin(k / 2): k / 2 - k**3 / 48 + k**5 / 3840}).subs(k, eps * k)
        orders = powers_of_eps(expand(scaled))
        return all(value.equals(0) for order, value in orders.items() if order <= power + 1)

    def at(self, strain: Expr) -> Dispersion:
        """Return the relation about the uniform strain ``strain``."""
        parts = (self.omega_squared, self.omega_plus, self.damping)
        return Dispersion(*(part.subs(ybar, strain) for part in parts))

    def latex(self) -> tuple[str, str, str]:
        """Return omega^2, omega_+ and its long-wave expansion as LaTeX equations."""
        return (
            rf"\omega^{{2}} = {latex_of(self.omega_squared)}",
            rf"\omega_{{+}} = {latex_of(self.omega_plus)}",
            rf"\omega_{{+}} = {latex_of(self.long_wave())} + \mathcal{{O}}(k^{{5}})",
        )


@lru_cache
def dispersion_relation(lattice: Lattice = FPUT_STRAIN) -> Dispersion:
    """Return the relation of a one-field lattice on a line, about the uniform strain ybar.

    A pinned lattice has no uniform strain: its relation is about the state at rest.

    >>> from longwave.derive import LATTICES
    >>> dispersion_relation(LATTICES["klein_gordon"]).omega_squared
    4*K2*sin(k/2)**2 + g1

    Raises ValueError for several fields or axes, for a lattice with a constant called ybar, and if
    opposite shifts carry different weights (omega^2 is then not real).
    """
    if len(lattice.fields) != 1 or lattice.dimension != 1:
        raise ValueError(
            f"lattice must have one field and one axis, got {len(lattice.fields)} fields and "
            f"{lattice.dimension} axes (the branches of several are roots of a determinant)"
        )
    if str(ybar) in map(str, lattice.constants):
        raise ValueError(
            f"constants must have names other than ybar, got {lattice.constants} (it is the "
            "uniform strain)"
        )
    actual = {HALF_SINE: sin(k / 2)}
    uniform_part, squared = _in_half_sines(_weights(lattice, Bond.stiffness))
    constant_loss, dashpot_loss = _in_half_sines(_weights(lattice, lambda bond, _: bond.loss))
    rates = lattice.site_losses[0] + constant_loss + dashpot_loss
    damping = (expand(rates) / lattice.masses[0]).subs(actual)
    if uniform_part != 0:
        over_mass = expand(uniform_part + squared) / lattice.masses[0]
        squared_frequency = over_mass.subs({**actual, ybar: 0})
        return Dispersion(squared_frequency, sqrt(squared_frequency), damping)
    over_mass = squared / lattice.masses[0]
    stiffness = factor(expand(over_mass / HALF_SINE**2))
    root = sqrt(stiffness) * HALF_SINE
    return Dispersion((stiffness * HALF_SINE**2).subs(actual), root.subs(actual), damping)


def _in_half_sines(weights: Mapping[int, Expr]) -> tuple[Expr, Expr]:
    """Return ``-sum weights[shift] exp(i shift k)`` as its value at k = 0 and the remainder.

    The remainder is a polynomial in `HALF_SINE`.
    """
    squared: Expr = Integer(0)
    for shift in sorted(weights):
        if weights[shift] != weights[-shift]:
            raise ValueError(
                f"shifts by {shift} and {-shift} must carry equal weights, got "
                f"{weights[shift]} and {weights[-shift]} (the force must be reciprocal)"
            )
        if shift > 0:
            squared_sine = (1 - chebyshevt(shift, 1 - 2 * HALF_SINE**2)) / 2  # of shift k/2
            squared += 4 * weights[shift] * expand(squared_sine)
    return -expand(sum(weights.values())), squared


def _weights(lattice: Lattice, slope_of: Callable[[Bond, Expr], Expr]) -> dict[int, Expr]:
    """Return the linear force: shift -> factor of ``exp(i shift k)``.

    ``slope_of(bond, stretch)`` is the factor of a small stretch in a bond's force.
    """
    weights: dict[int, Expr] = defaultdict(lambda: Integer(0))
    definitions = dict(lattice.definitions)
    for bond in lattice.bonds:
        uniform = sum(entry.weight for entry in bond.stretch) * ybar
        slope = slope_of(bond, uniform).xreplace(definitions)
        for entry in bond.action:
            for part in bond.stretch:
                [shift] = (i + j for i, j in zip(entry.shift, part.shift, strict=True))
                weights[shift] += entry.weight * part.weight * slope
    return weights


def long_wave_of_reduction(reduction: Reduction) -> Expr:
    """Return omega of a long wave by the reduced equation's linear part, to k^3, with losses.

    A wave ``exp(i (kappa X - Omega T))`` of the linear part has ``Omega = -delta kappa^3``; on the
    lattice ``k = eps kappa`` and ``omega = c k + eps^3 Omega``.  Raises ValueError for another
    scaling, or if the linear part has terms other than Y_XXX and, from losses, Y and Y_XX.
    """
    scaling, values = reduction.scaling, reduction.coefficients()
    time = scaling.time if reduction.lattice.has_losses else Scaling().time
    paper = Scaling(scaling.amplitude, time=time, background=scaling.background)
    linear = {n: m[0][0] for n, m in values.monomials.items() if len(m) == 1}
    if scaling != paper or not linear.keys() <= {"Y_XXX", "Y", "Y_XX"}:
        raise ValueError(
            "reduction must have X = eps (n - c t), T = eps^3 t and no linear term except Y_XXX, "
            f"got {reduction.pde.text()} (compare the terms of .pde by hand)"
        )
    omega = values.c * k - values.dispersive * k**3
    losses = [(values.terms[name], count) for name, count in linear.items() if count % 2 == 0]
    decay = sum(size * (I * k) ** count * eps ** (time - count) for size, count in losses)
    return expand(omega - I * decay)


def agrees_with_reduction(lattice: Lattice, reduction: Reduction) -> bool:
    """Return whether lattice and reduced equation give the same omega to k^3.

    The lattice is taken about the background. With losses, the comparison is to the reduced
    equation's order in eps.

    Raises ValueError as `long_wave_of_reduction` does, and for a background multiplied by eps.
    """
    background = reduction.scaling.background
    if any(power or value.has(eps) for power, value in background):
        raise ValueError(
            f"background must be of order one, got {background} (compare the terms by hand)"
        )
    mean = sum((value for _, value in background), start=Integer(0))
    relation, omega = dispersion_relation(lattice).at(mean), long_wave_of_reduction(reduction)
    if lattice.has_losses:
        return relation.is_solved_by(omega, reduction.scaling.time)
    return bool(expand(relation.long_wave() - omega) == 0)
