"""From the eps-series of the lattice equation to the reduced equation, order by order.

The lowest order is the sound condition ``P(c) Y_XX = 0``.  Every order below the one with Y_XT
must vanish by a condition on the constants.  The order with Y_XT, integrated in X, is the reduced
equation, except for a transverse term that stays outside the X-derivative. The later orders, with
time derivatives removed, give its corrections.  For the strain FPUT lattice these are the steps to
the paper's eq. (8).  For displacements the wave is W, and the steps use Y = W_X and the
X-derivative of the equation.
"""

from collections.abc import Mapping, Sequence

from sympy import Expr, Symbol

from longwave.derive.algebra.elimination import (
    Elimination,
    TimeElimination,
    solve_linear,
    vanishing_factors,
)
from longwave.derive.algebra.exact_numbers import instance, integer
from longwave.derive.algebra.formula_printing import text_of
from longwave.derive.algebra.jets import DifferentialPolynomial, EpsSeries, Jet, raised
from longwave.derive.algebra.rational_functions import RationalFunction
from longwave.derive.equations import Condition, EvolutionEquation, OrderEquation
from longwave.derive.expansion import Expansion, expand
from longwave.derive.lattice import Lattice
from longwave.derive.output.notation import Notation
from longwave.derive.output.own_names import unused
from longwave.derive.reduction import Reduction
from longwave.derive.scaling import Scaling

FURTHER_ORDERS = 2
"""Default number of orders beyond the evolution equation: usually includes the first correction."""


class ReductionError(ValueError):
    """Error for an ansatz that does not reduce the lattice; it names the order and its terms."""


class _Solver:
    """Solver of ``residual = 0`` order by order in eps; solutions are put into the later orders."""

    def __init__(self, residual: EpsSeries, expansion: Expansion) -> None:
        self.lattice, self.scaling = expansion.lattice, expansion.scaling
        scaling = expansion.scaling
        self.series = _in_strain(residual) if expansion.is_displacement else residual
        self.frame = scaling.frame_symbol
        self.drifts = scaling.drifts
        self.constants = (*scaling.drifts, *expansion.lattice.constants)
        self.notation = Notation(scaling.axes)
        self.leading_order = scaling.leading_order
        self.lowest_order = scaling.amplitude + 2 * scaling.space[0].exponent
        self.conditions: list[Condition] = []
        self.solved: list[Elimination] = []
        self.factor = residual.field.one
        self.second = self._jet(2, 0)
        self.mixed = self._jet(1, 1)

    def _jet(self, space: int, time: int) -> Jet:
        return (space, *(0,) * (len(self.notation.axes) - 2), time)

    def check_losses(self) -> None:
        """Raise ReductionError if losses enter before the order of the reduced equation."""
        losses = self.lattice.leading_losses
        lower_orders = {o: part for o, part in self.series.parts.items() if o < self.leading_order}
        for order, part in lower_orders.items() if losses else ():
            for monomial in part.terms:
                if len(monomial) == 1 and sum(monomial[0]) % 2:
                    kind = "site" if sum(monomial[0]) == 1 else "bond"
                    kind = kind if kind in losses else next(iter(losses))
                    raise ReductionError(self._dominant(kind, *losses[kind], order))

    def _dominant(self, kind: str, given: Expr, power: int, order: int) -> str:
        shortfall = self.leading_order - order
        power_text = f"eps^{power + shortfall}" if power + shortfall > 1 else "eps"
        slow_time = self.scaling.time - shortfall
        other = f", or take T = eps^{slow_time} t" if slow_time > 1 else ""
        remedy = f"write {power_text} times a constant{other}"
        return (
            f"{kind} loss must enter at the order of the reduced equation, eps^"
            f"{self.leading_order}, got {text_of(given)}, which dominates at eps^{order} ({remedy})"
        )

    def sound_polynomial(self) -> RationalFunction:
        """Return P(c) of the lowest order; solve P(c) = 0 and substitute the result everywhere."""
        order = next(iter(self.series.parts), self.lowest_order)
        lowest = self.series.at(order)
        if set(lowest.terms) != {(self.second,)}:
            required = f"a multiple of {self.notation.monomial((self.second,))} alone"
            raise self._refusal(order, f"{required} (try a larger amplitude exponent)")
        polynomial = lowest.coefficient(self.second)
        if self.frame and not (polynomial.as_expr() / self.frame**2).expand().has(self.frame):
            equation_text = OrderEquation(order, lowest, self.notation).text()
            raise ReductionError(
                f"there is no sound: the linear stiffness at rest is 0 (order eps^{order} reads "
                f"{equation_text}; precompress the lattice, as by d - x for -x, or give springs a "
                "linear term)"
            )
        self._eliminate(order, polynomial)
        return polynomial

    def solve_conditions(self) -> None:
        """Turn every order below the evolution equation into conditions on the constants."""
        for order in [o for o in self.series.parts if o < self.leading_order]:
            if order in self.series.parts:
                self._solve_drifts(order)
            if order not in self.series.parts:
                continue
            equation = OrderEquation(order, self.series.parts[order], self.notation)
            factors = vanishing_factors(equation.polynomial.terms.values())
            if factors is None:
                needed = "solvable by a condition on the constants"
                has_mixed_term = any(m[0][0] and any(m[0][1:-1]) for m in equation.polynomial.terms)
                drift = " (let the transverse variable drift: give it a symbol for its speed)"
                raise self._refusal(order, needed + (drift if has_mixed_term else ""))
            for factor in factors:
                self._require(order, factor, equation)

    def _solve_drifts(self, order: int) -> None:
        """Remove the linear term Y_XZ by a condition on the transverse variable's drift speed."""
        part = self.series.parts[order]
        for monomial, value in part.terms.items():
            drifts = [s for s in self.drifts if value.diff(s)]
            if len(monomial) == 1 and drifts:
                mixed_part = DifferentialPolynomial(part.field, {monomial: value})
                [vanishing] = vanishing_factors([value]) or [value]
                crossing = OrderEquation(order, mixed_part, self.notation)
                self._require(order, vanishing, crossing, drifts)
                return

    def _require(
        self,
        order: int,
        vanishing: RationalFunction,
        equation: OrderEquation,
        drifts: Sequence[Symbol] = (),
    ) -> None:
        self.conditions.append(Condition(order, vanishing.numerator().as_expr(), equation))
        self._eliminate(order, vanishing, drifts)

    def _eliminate(
        self, order: int, vanishing: RationalFunction, drifts: Sequence[Symbol] = ()
    ) -> None:
        """Solve ``vanishing = 0`` for one of ``drifts``, else for a constant, and substitute it."""
        solved = solve_linear(vanishing, drifts) if drifts else None
        solved = solved or solve_linear(vanishing, self.constants, self.frame)
        if solved is None:
            raise self._refusal(
                order,
                "linear in one of the lattice's constants (write a symbol for a number or a power, "
                "and give its value to coefficients)",
            )
        self.solved.append(solved)
        self.series = self.substitute_conditions(self.series)

    def substitute_conditions(self, series: EpsSeries) -> EpsSeries:
        """Return a series without the constants that the conditions determine."""
        squares = [elimination for elimination in self.solved if elimination.power > 1]
        for elimination in (*self.solved, *squares):
            series = elimination.series(series)
        return series

    def flow(self) -> tuple[DifferentialPolynomial, DifferentialPolynomial]:
        """Return F and B of ``(Y_T - F)_X + B = 0``; B is linear, without X-derivatives."""
        part = self.series.parts.get(self.leading_order)
        time_terms = [m for m in part.terms if any(jet[-1] for jet in m)] if part else []
        mixed_name = self.notation.monomial((self.mixed,))
        if time_terms != [(self.mixed,)] or part is None:
            raise self._refusal(self.leading_order, f"linear in {mixed_name}")
        self.factor = part.coefficient(self.mixed)
        others = part.select(lambda monomial: monomial != (self.mixed,))
        known = others.map_coefficients(lambda value: value / self.factor)
        transverse = known.select(lambda m: len(m) == 1 and m[0][0] == 0)
        flow = (-(known - transverse)).antiderivative()
        if flow is None:
            raise self._refusal(self.leading_order, "an X-derivative")
        return flow, transverse

    def _refusal(self, order: int, needed: str) -> ReductionError:
        equation_text = OrderEquation(order, self.series.at(order), self.notation).text()
        return ReductionError(f"order eps^{order} must be {needed}, got {equation_text}")


def reduce(
    lattice: Lattice, scaling: Scaling | None = None, orders: int | None = None
) -> Reduction:
    """Reduce a lattice under an ansatz, through order ``eps^orders``.

    By default two orders beyond the reduced equation are derived.  Raises ReductionError (a
    ValueError) if the ansatz does not lead to an evolution equation, ValueError if ``orders`` is
    below the order of that equation.

    >>> from longwave.derive import LATTICES, reduce
    >>> print(reduce(LATTICES["fput_strain"]).pde.text())
    Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX = 0
    """
    remedy = "Scaling() is the paper's"
    chosen = instance("scaling", Scaling() if scaling is None else scaling, Scaling, remedy)
    leading = chosen.leading_order
    highest = leading + FURTHER_ORDERS if orders is None else orders
    if integer("orders", highest, 0, "the highest power of eps") < leading:
        raise ValueError(
            f"orders must satisfy orders >= {leading}, got {orders} "
            f"(the evolution equation appears at eps^{leading})"
        )
    expansion = expand(lattice, chosen, highest)
    slaved = expansion.slaved_parts()
    residual = expansion.residual(slaved)
    solver = _Solver(residual, expansion)
    solver.check_losses()
    sound = solver.sound_polynomial()
    solver.solve_conditions()
    flow, transverse = solver.flow()
    corrections, obstruction = ({}, None) if transverse else _corrections(solver, flow)
    names = expansion.lattice.fields
    unknown = unused("W", lattice.names) if expansion.is_displacement else "Y"
    wave = Notation(chosen.axes, unknown)
    return Reduction(
        lattice=expansion.lattice,
        scaling=chosen,
        highest_order=highest,
        orders={order: OrderEquation(order, part, wave) for order, part in residual.parts.items()},
        sound_polynomial=sound,
        conditions=tuple(solver.conditions),
        pde=EvolutionEquation(flow, solver.notation, transverse),
        remainders={} if transverse else dict(_on_solutions(solver, {0: flow}).parts),
        corrections=corrections,
        obstruction=obstruction,
        slaved=dict(zip(names, zip(expansion.zero_mode[0], slaved, strict=True), strict=True)),
        left=tuple(expansion.zero_mode[1]),
    )


def _on_solutions(solver: _Solver, flows: Mapping[int, DifferentialPolynomial]) -> EpsSeries:
    """Return the lattice residual on solutions of ``Y_T = sum eps^k F_k``; ``flows``: k -> F_k."""
    flow = EpsSeries(solver.series.field, solver.series.limit, flows)
    residual = TimeElimination(flow, len(solver.notation.axes)).series(solver.series)
    return solver.substitute_conditions(residual)


def _corrections(
    solver: _Solver, flow: DifferentialPolynomial
) -> tuple[dict[int, DifferentialPolynomial], tuple[int, DifferentialPolynomial] | None]:
    """Return k -> F_k of ``Y_T = flow + sum eps^k F_k``; and the first k without F_k, with the part
    that is no X-derivative."""
    corrections: dict[int, DifferentialPolynomial] = {}
    for power in range(1, solver.series.limit - solver.leading_order + 1):
        series = _on_solutions(solver, {0: flow, **corrections})
        derivative = (-1 / solver.factor) * series.at(solver.leading_order + power)
        correction = derivative.antiderivative()
        if correction is None:
            return corrections, (power, derivative)
        if correction:
            corrections[power] = correction
    return corrections, None


def _in_strain(series: EpsSeries) -> EpsSeries:
    """Return the X-derivative of a series in W as a series in Y = W_X."""
    parts = {}
    for order, part in series.derivative(0).parts.items():
        items = ((tuple(sorted(raised(j, 0, -1) for j in m)), v) for m, v in part.terms.items())
        parts[order] = DifferentialPolynomial.collect(part.field, items)
    return EpsSeries(series.field, series.limit, parts)
