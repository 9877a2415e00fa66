"""Evaluate typed statements at points of the domain, first integers and a few complex values.

SymPy simplifies while it builds formulas: `sign(z)**2` becomes 1, and `abs(n)` becomes n for n > 0
before it is shifted.  So a refutation is a point at which a ball around the residual of the typed
tree excludes 0, and SymPy's residual is compared with such balls before it is solved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import islice, product

import sympy as sp
from flint import acb, arb, ctx

from longwave.derive.algebra.formula_tree import Call, FormulaTree, Power, rational
from longwave.solutions import functions

from .balls import ball_value
from .domain_signs import DomainSigns
from .domains import Domain, Domains, Point
from .samples import sample
from .statement_problem import typed_domains
from .typed_balls import TextPoint, TypedBalls
from .typed_statement import Statement, StatementTrees

POINTS_WITH_INTEGERS = 4
"""Sampled points that are repeated with small integers for the integer symbols."""

BITS = (128, 512, 2048, 8192)
"""Precisions in bits; the last two detect changes by 10**-40 and tails such as 1 - tanh(1000)."""

QUICK = ((BITS[0], 8), (BITS[2], 1))
"""Bits and number of points in each pass of the search for a failure before a proof."""

THOROUGH = ((BITS[0], 48), (BITS[1], 48), (BITS[2], 8), (BITS[3], 8))
"""Bits and number of points in each pass of the search for a failure if no proof is found."""

FIRST_INTEGERS, MOST_COMBINATIONS = 4, 16
"""Width of the integer range tried at a domain's end or around 0; most combinations of integers."""

COMPLEX = ("2/3 + 5/7*I", "-3/5 + 4/9*I", "-7/8 - 3/4*I", "5/4*I", "11/7")
"""Values in several quadrants of the complex plane, and on its axes."""

MOST_COMPLEX_CHOICES = 25
"""Most choices of complex values."""

PLAIN = {
    *("exp", "sin", "cos", "tan", "cot", "sec", "csc", "erf"),
    *("sinh", "cosh", "tanh", "coth", "sech", "csch"),
    *functions.__all__,
}
"""Functions without branches: agreement at a few points is agreement everywhere."""

PLAIN_POINTS, SIGNED_POINTS = 6, 36
"""Points at which residuals are compared, for `PLAIN` and for other functions."""

SMALL_VALUES = (*map(Fraction, (0, 1, -1, 2, -2)), Fraction(1, 2))
"""Parameter values at which SymPy's form may differ from that at other values."""

LEAST_AGREEING = 3
"""Fewest points at which residuals must be shown to agree."""

COMPARED_BITS = (128, 512)
RELATIVE_AGREEMENT = arb(2) ** -40

OTHER_RESIDUAL = "what was typed has another residual than what was solved"
NOT_SEEN = "what was typed was not seen to have the residual that was solved"


def failing_values(statement: Statement, thorough: bool = False) -> dict[str, str] | None:
    """Return values at which an equation fails, also complex ones if ``thorough``, or None."""
    typed = typed_values(statement)
    failing = typed.failure(thorough)
    names = statement.complexes if thorough and failing is None else ()
    for values in islice(product(COMPLEX, repeat=len(names)), MOST_COMPLEX_CHOICES if names else 0):
        chosen = dict(zip(names, values, strict=True))
        trees = typed.trees.with_values(chosen)
        failing = TypedValues(trees, typed_domains(statement)).failure()
        if failing is not None:
            return {k: str(v) for k, v in failing.items() if k not in chosen} | chosen
    return None if failing is None else {name: str(value) for name, value in failing.items()}


def typed_values(statement: Statement) -> TypedValues:
    """Return the evaluator of a statement's typed residuals."""
    return TypedValues(statement.trees, typed_domains(statement))


class TypedValues:
    """Evaluator of the residuals of a statement's trees at points of the domains."""

    def __init__(self, trees: StatementTrees, domains: Domains) -> None:
        self._domains, self._names, self.trees = domains, trees.names, trees
        self._signs = DomainSigns(domains)
        self._balls = TypedBalls(trees, {str(s) for s, d in domains.items() if d.integer})

    def fails_at(self, point: TextPoint, bits: Sequence[int] = BITS) -> bool | None:
        """Return whether an equation fails at a point; None if it cannot be decided."""
        is_small = False
        for size, balls in self._residuals(point, bits):
            if any(not residual.contains(0) for residual in balls):
                return True
            least = arb(2) ** (-size // 4)
            is_small = bool(balls) and all(residual.abs_upper() < least for residual in balls)
        return False if is_small else None

    def failing(self, point: TextPoint) -> tuple[int, acb] | None:
        """Return the number of an equation that fails at a point, and its ball, or None."""
        rows = (enumerate(balls, 1) for _, balls in self._residuals(point, BITS))
        return next((pair for row in rows for pair in row if not pair[1].contains(0)), None)

    def _residuals(self, point: TextPoint, bits: Sequence[int]) -> Iterator[tuple[int, list[acb]]]:
        """Yield precision and balls of the residuals at a point; [] if they have no value."""
        for size in bits if self._names <= point.keys() else ():
            try:
                yield size, list(self._balls.residuals(point, size))
            except (ArithmeticError, ValueError, RuntimeError):
                yield size, []

    def failure(self, thorough: bool = False) -> TextPoint | None:
        """Return a point of the domain at which an equation fails; None if none is found."""
        for size, count in THOROUGH if thorough else QUICK:
            for point in self._points(count):
                if self.fails_at(point, (size,)):
                    return point
        return None

    def difference(self, residuals: Sequence[sp.Expr]) -> str:
        """Return why residuals are not shown to equal those of the typed trees; "" if they are."""
        agreed = 0
        for point in self._compared():
            agrees = self._agree_at(point, residuals)
            if agrees is False:
                where = ", ".join(f"{name} = {value}" for name, value in point.items())
                return f"{OTHER_RESIDUAL} at {where}"
            agreed += bool(agrees)
        return "" if agreed >= LEAST_AGREEING else NOT_SEEN

    def _agree_at(self, point: TextPoint, residuals: Sequence[sp.Expr]) -> bool | None:
        """Return whether residuals have the values of the typed trees; None if undecided."""
        values = {s: sp.Rational(point[s.name]) for r in residuals for s in r.free_symbols}
        for bits in COMPARED_BITS:
            with ctx.workprec(bits), suppress(ArithmeticError, ValueError, RuntimeError):
                typed = list(self._balls.residuals(point, bits))
                other = (ball_value(r, values, bits, self._signs) for r in residuals)
                gaps = [(a - b, a.abs_upper() + 1) for a, b in zip(typed, other, strict=True)]
                if any(not gap.contains(0) for gap, _ in gaps):
                    return False
                if all(gap.abs_upper() < scale * RELATIVE_AGREEMENT for gap, scale in gaps):
                    return True
        return None

    def _compared(self) -> Iterator[TextPoint]:
        """Yield points at which residuals are compared."""
        nodes = [node for formula in self.trees.formulas for node in formula.nodes()]
        drawn = list(self._points(PLAIN_POINTS if all(map(_is_plain, nodes)) else SIGNED_POINTS, 1))
        yield from drawn
        parameters = [s for s in self._domains if s.name not in self.trees.variables]
        for number, (symbol, value) in enumerate(product(parameters, SMALL_VALUES)):
            point = {**drawn[number % len(drawn)], symbol.name: value}
            exact = {s: sp.Rational(point[s.name]) for s in self._domains}
            if all(d.contains(exact[s], exact) for s, d in self._domains.items()):
                yield point

    def _points(self, count: int, most: int = POINTS_WITH_INTEGERS) -> Iterator[TextPoint]:
        """Yield sampled points, and the first ``most`` of them again with small integers."""
        known = {str(symbol): symbol for symbol in self._domains}
        added = {sp.Symbol(name, real=True): Domain() for name in self._names - known.keys()}
        integers = [s for s in self._domains if self._domains[s].integer]
        integers.sort(key=lambda symbol: len(self._domains[symbol].symbols))
        for place, drawn in enumerate(sample({**self._domains, **added}, count)):
            yield {str(symbol): Fraction(int(v.p), int(v.q)) for symbol, v in drawn.items()}
            if not integers or place >= most:
                continue
            for whole in islice(self._with_first(drawn, integers), MOST_COMBINATIONS):
                if all(d.contains(whole[s], whole) for s, d in self._domains.items()):
                    yield {str(s): Fraction(int(v.p), int(v.q)) for s, v in whole.items()}

    def _with_first(self, point: Point, integers: Sequence[sp.Symbol]) -> Iterator[Point]:
        """Yield the point with every choice of small values of the symbols ``integers``."""
        if not integers:
            yield point
            return
        symbol, *others = integers
        for value in self._first(self._domains[symbol], point):
            yield from self._with_first({**point, symbol: value}, others)

    def _first(self, domain: Domain, point: Point) -> list[sp.Integer]:
        lower, upper = domain.lower.xreplace(point), domain.upper.xreplace(point)
        if lower.is_Rational:
            return [sp.floor(lower) + step for step in range(FIRST_INTEGERS + 1)]
        if upper.is_Rational:
            return [sp.ceiling(upper) - step for step in range(FIRST_INTEGERS + 1)]
        return [sp.Integer(step) for step in range(-FIRST_INTEGERS // 2, FIRST_INTEGERS // 2 + 1)]


def _is_plain(node: FormulaTree) -> bool:
    """Return whether a node has no branches: no fractional power and no function with branches."""
    if isinstance(node, Power):
        exponent = rational(node.parts[1])
        return exponent is not None and exponent.denominator == 1
    return not isinstance(node, Call) or node.name in PLAIN
