"""From the eps-series of the lattice equation to the reduced equation, order by order.

The lowest order is the sound condition ``P(c) Y_XX = 0``.  Every order below the one with Y_XT
must vanish by a condition on the constants.  The order with Y_XT is the reduced equation once
integrated in X; the later orders, with time derivatives removed, give its corrections.  For the
strain FPUT lattice these are the steps to the paper's eq. (8).
"""

from __future__ import annotations

from sympy.polys.fields import FracElement

from derive.algebra.elimination import TimeElimination, solve_linear, vanishing_factor
from derive.algebra.exact_numbers import integer
from derive.algebra.jets import DifferentialPolynomial, Jet
from derive.algebra.series import EpsSeries
from derive.equations import Condition, EvolutionEquation, OrderEquation
from derive.expansion import expand
from derive.lattice import Lattice
from derive.output.notation import Notation
from derive.reduction import Reduction
from derive.scaling import Scaling

DEFAULT_ORDERS = 7


class ReductionError(ValueError):
    """The ansatz does not reduce the lattice; the message names the order and its terms."""


class _Solver:
    """Walks up the orders of ``residual``, applying each condition to all that follow."""

    def __init__(self, residual: EpsSeries, lattice: Lattice, scaling: Scaling) -> None:
        self.series = residual
        self.constants = lattice.constants
        self.notation = Notation(scaling.axes)
        self.leading_order = scaling.leading_order
        self.lowest_order = scaling.amplitude + 2 * scaling.space[0].exponent
        self.conditions: list[Condition] = []
        self.second = self._jet(2, 0)
        self.mixed = self._jet(1, 1)

    def _jet(self, space: int, time: int) -> Jet:
        return (space, *(0,) * (len(self.notation.axes) - 2), time)

    def sound_polynomial(self) -> FracElement:
        """P(c) of the lowest order, eliminated from all orders on the way."""
        order, lowest = next(iter(self.series.parts.items()), (self.lowest_order, self._zero()))
        if set(lowest.terms) != {(self.second,)}:
            raise self._refusal(order, "a multiple of Y_XX alone (try a larger amplitude exponent)")
        polynomial = lowest.coefficient(self.second)
        self._eliminate(order, polynomial)
        return polynomial

    def solve_conditions(self) -> None:
        """Turn every order below the evolution equation into a condition."""
        for order in [o for o in self.series.parts if o < self.leading_order]:
            if order not in self.series.parts:
                continue
            equation = OrderEquation(order, self.series.parts[order], self.notation)
            factor = vanishing_factor(equation.polynomial.terms.values())
            if factor is None:
                raise self._refusal(order, "solvable by a condition on the constants")
            self.conditions.append(Condition(order, factor.as_expr(), equation))
            self._eliminate(order, factor)

    def _eliminate(self, order: int, vanishing: FracElement) -> None:
        solved = solve_linear(vanishing, self.constants)
        if solved is None:
            raise self._refusal(
                order,
                "linear in one of the lattice's constants (write a symbol for a number or a power, "
                "and give its value to coefficients)",
            )
        self.series = solved.series(self.series)

    def leading(self) -> FracElement:
        """The coefficient of Y_XT, the only time derivative allowed at its order."""
        part = self.series.parts.get(self.leading_order)
        timed = [m for m in part.terms if any(jet[-1] for jet in m)] if part else []
        if timed != [(self.mixed,)] or part is None:
            raise self._refusal(self.leading_order, "linear in Y_XT")
        return part.coefficient(self.mixed)

    def _zero(self) -> DifferentialPolynomial:
        return DifferentialPolynomial.zero(self.series.field)

    def _refusal(self, order: int, needed: str) -> ReductionError:
        part = self.series.parts.get(order, self._zero())
        found = OrderEquation(order, part, self.notation).text()
        return ReductionError(f"order eps^{order} must be {needed}, got {found}")


def reduce(
    lattice: Lattice, scaling: Scaling | None = None, orders: int = DEFAULT_ORDERS
) -> Reduction:
    """Reduce a one-field lattice under an ansatz, through order ``eps^orders``.

    Raises ReductionError (a ValueError) when the ansatz does not lead to an evolution equation,
    ValueError when ``orders`` stops below it.

    >>> from derive import LATTICES, reduce
    >>> print(reduce(LATTICES["fput_strain"]).pde.text())
    Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX = 0
    """
    chosen = Scaling() if scaling is None else scaling
    expansion = expand(lattice, chosen, orders)
    if integer("orders", orders, 0, "the highest power of eps") < chosen.leading_order:
        raise ValueError(
            f"orders must satisfy orders >= {chosen.leading_order}, got {orders} "
            f"(the evolution equation appears at eps^{chosen.leading_order})"
        )
    residual = expansion.residual()
    solver = _Solver(residual, lattice, chosen)
    sound = solver.sound_polynomial()
    solver.solve_conditions()
    mixed = solver.leading()
    flow = _leading_flow(solver, mixed)
    corrections, obstruction = _corrections(solver, mixed, flow)
    return Reduction(
        lattice=lattice,
        scaling=chosen,
        highest_order=orders,
        orders={
            order: OrderEquation(order, part, solver.notation)
            for order, part in residual.parts.items()
        },
        sound_polynomial=sound,
        conditions=tuple(solver.conditions),
        pde=EvolutionEquation(flow, solver.notation),
        remainders=_remainders(solver, flow),
        corrections=corrections,
        obstruction=obstruction,
    )


def _leading_flow(solver: _Solver, mixed: FracElement) -> DifferentialPolynomial:
    """F_0 in ``Y_T = F_0``: the evolution equation's order divided and integrated in X."""
    part = solver.series.parts[solver.leading_order]
    rest = part.select(lambda monomial: monomial != (solver.mixed,))
    flow = ((-1 / mixed) * rest).antiderivative()
    if flow is None:
        found = OrderEquation(solver.leading_order, part, solver.notation).text()
        raise ReductionError(
            f"order eps^{solver.leading_order} must be an X-derivative, got {found}"
        )
    return flow


def _on_solutions(solver: _Solver, flow: EpsSeries) -> EpsSeries:
    """The lattice residual on solutions of ``Y_T = flow``."""
    return TimeElimination(flow, len(solver.notation.axes)).series(solver.series)


def _remainders(solver: _Solver, flow: DifferentialPolynomial) -> dict[int, DifferentialPolynomial]:
    """What is left of each order on exact solutions of the leading equation."""
    leading = EpsSeries(flow.field, solver.series.limit, {0: flow})
    return dict(_on_solutions(solver, leading).parts)


def _corrections(
    solver: _Solver, mixed: FracElement, flow: DifferentialPolynomial
) -> tuple[dict[int, DifferentialPolynomial], tuple[int, DifferentialPolynomial] | None]:
    """F_k of ``Y_T = sum eps^k F_k``, and the first order whose X-integral does not exist."""
    limit = solver.series.limit
    flows = {0: flow}
    for power in range(1, limit - solver.leading_order + 1):
        series = _on_solutions(solver, EpsSeries(flow.field, limit, dict(flows)))
        rest = series.parts.get(solver.leading_order + power)
        if rest is None:
            continue
        correction = ((-1 / mixed) * rest).antiderivative()
        if correction is None:
            return _later(flows), (power, (-1 / mixed) * rest)
        flows[power] = correction
    return _later(flows), None


def _later(flows: dict[int, DifferentialPolynomial]) -> dict[int, DifferentialPolynomial]:
    return {power: flow for power, flow in flows.items() if power}
