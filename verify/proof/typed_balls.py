"""Balls around the residuals of typed statements: trees evaluated in Taylor coefficients.

SymPy does not simplify anything here.  ValueError is raised for a formula without a certain value
at a point or where it is not smooth: on a branch cut, at a pole, or where a modulus is 0.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, reduce
from math import factorial, prod
from operator import add, mul

import sympy as sp
from flint import acb, ctx

from longwave.derive.algebra import formula_tree as syntax
from longwave.derive.algebra.formula_text import CONSTANTS
from longwave.derive.algebra.formula_tree import FormulaTree
from longwave.solutions.functions.jacobi import JacobiFunction

from . import balls as ball_jets
from .taylor import Elliptic
from .text_names import SITE, function_named
from .typed_statement import StatementTrees, names_in

TextPoint = Mapping[str, Fraction]

LARGEST_ROOT = 1000
"""Largest degree of a root; other powers are computed by the logarithm."""

MEAN = ("elliptic_k", "elliptic_e")
SIZES = ("abs", "sign", "re", "im", "conjugate")


@dataclass(frozen=True)
class TypedBall:
    """Jet of a formula, and whether the formula's structure makes it real."""

    jet: ball_jets.Jet
    is_real: bool

    @classmethod
    def of(cls, jet: ball_jets.Jet, is_real: bool) -> TypedBall:
        """Return a `TypedBall`; for a real formula, drop the imaginary parts left by rounding."""
        parts = tuple(acb(c.real) for c in jet.coefficients) if is_real else jet.coefficients
        return cls(ball_jets.Jet(jet.shape, parts), is_real)


class TypedBalls:
    """Evaluator of the residuals of a statement's trees; ``integers`` names the integer symbols."""

    def __init__(self, trees: StatementTrees, integers: Collection[str]) -> None:
        self.trees = trees
        self.integers = {*integers, SITE}
        self.letters = tuple(name for name in trees.variables if name != SITE)
        self._needed: dict[tuple[str, int], set[ball_jets.Index]] = {}
        for equation in trees.equations:
            self._need(equation, {(0,) * len(self.letters)})

    def residuals(self, point: TextPoint, bits: int) -> Iterator[acb]:
        """Yield the ball of each equation's residual; raises ValueError if it has no value."""
        with ctx.workprec(bits):
            shapes = {key: shape_of(frozenset(tops)) for key, tops in self._needed.items()}
            top = TypedPlace(self, point, ball_jets.JetShape([(0,) * len(self.letters)]))
            for (name, shift), shape in shapes.items():
                moved = {**point, SITE: point[SITE] + shift} if shift else point
                place = TypedPlace(self, moved, shape)
                top.unknowns[name, shift] = place.value(self.trees.solutions[name])
            for equation in self.trees.equations:
                ball = top.value(equation).jet.value
                if not ball.is_finite():
                    raise ValueError("a residual must have a finite value")
                yield ball

    def steps_of(self, steps: Collection[str]) -> ball_jets.Index:
        """Return the order in each variable of a derivative along ``steps``, such as x, x, t."""
        return tuple([*steps].count(letter) for letter in self.letters)

    def _need(self, formula: FormulaTree, tops: set[ball_jets.Index]) -> None:
        """Record which derivatives of unknowns the derivatives ``tops`` of a formula contain."""
        if isinstance(formula, syntax.Unknown | syntax.Derivative):
            tops = {_sum(top, self.steps_of(formula.steps)) for top in tops}
        if isinstance(formula, syntax.Unknown):
            self._needed.setdefault((formula.name, formula.shift), set()).update(tops)
        for part in formula.inner():
            self._need(part, tops)


def _sum(left: ball_jets.Index, right: ball_jets.Index) -> ball_jets.Index:
    return tuple(map(add, left, right))


@lru_cache(maxsize=64)
def shape_of(tops: frozenset[ball_jets.Index]) -> ball_jets.JetShape:
    """Return the cached shape of all multi-indices below the given ones."""
    return ball_jets.JetShape(sorted(tops))


class TypedPlace:
    """Evaluator of the trees at one point, up to the derivatives of one shape."""

    def __init__(self, balls: TypedBalls, point: TextPoint, shape: ball_jets.JetShape) -> None:
        self._balls, self._point, self._shape = balls, point, shape
        self.unknowns: dict[tuple[str, int], TypedBall] = {}
        self._found: dict[FormulaTree, TypedBall] = {}

    def value(self, formula: FormulaTree) -> TypedBall:
        """Return the jet of a formula at the point, and whether it is real."""
        if formula not in self._found:
            ball = self._value(formula)
            fixed = ball.jet.value.imag == 0 and names_in(formula) <= CONSTANTS.keys()
            self._found[formula] = TypedBall(ball.jet, ball.is_real or fixed)
        return self._found[formula]

    def _value(self, formula: FormulaTree) -> TypedBall:
        match formula:
            case syntax.Number(value=number):
                return self._constant(ball_jets.exact(number), True)
            case syntax.Name(name=name):
                return self._named(name)
            case syntax.Sum(parts=parts) | syntax.Product(parts=parts):
                operation = add if isinstance(formula, syntax.Sum) else mul
                balls = [self.value(part) for part in parts]
                jet = reduce(operation, (ball.jet for ball in balls))
                return TypedBall.of(jet, all(ball.is_real for ball in balls))
            case syntax.Power(parts=(base, exponent)):
                return self._power(base, exponent)
            case syntax.Unknown(name=name, steps=steps, shift=shift):
                return self._derived(self.unknowns[name, shift], steps)
            case syntax.Derivative(parts=(inner,), steps=steps):
                further = self._balls.steps_of(steps)
                shape = shape_of(frozenset(_sum(i, further) for i in self._shape.indices))
                place = TypedPlace(self._balls, self._point, shape)
                place.unknowns = self.unknowns
                return self._derived(place.value(inner), steps)
            case syntax.Call(name=name, parts=parts):
                return self._call(name, parts)
        raise TypeError(f"formula must be a node of a tree, got {type(formula).__name__}")

    def _constant(self, value: acb, is_real: bool) -> TypedBall:
        return TypedBall(ball_jets.constant(self._shape, value), is_real)

    def _named(self, name: str) -> TypedBall:
        definitions, letters = self._balls.trees.definitions, self._balls.letters
        if name == "pi":
            return self._constant(acb.pi(), True)
        if name == "I":
            return self._constant(acb(0, 1), False)
        if name in definitions:
            return self.value(definitions[name])
        if name not in letters:
            return self._constant(ball_jets.exact(self._point[name]), True)
        place = letters.index(name)
        value = ball_jets.exact(self._point[name])
        return TypedBall(ball_jets.variable(self._shape, place, value), True)

    def _derived(self, ball: TypedBall, steps: Collection[str]) -> TypedBall:
        """Return a derivative's jet in this shape, from the jet of a larger shape."""
        known = dict(zip(ball.jet.shape.indices, ball.jet.coefficients, strict=True))
        further = self._balls.steps_of(steps)
        coefficients = []
        for index in self._shape.indices:
            above = _sum(index, further)
            weight = prod(map(factorial, above)) // prod(map(factorial, index))
            coefficients.append(known[above] * weight)
        return TypedBall(ball_jets.Jet(self._shape, tuple(coefficients)), ball.is_real)

    def _power(self, base: FormulaTree, exponent: FormulaTree) -> TypedBall:
        below, number = self.value(base), self._exact_value(exponent)
        if number is not None and number > 0 and self._is_zero(base, below):
            return below
        if number is not None and number.denominator == 1:
            names = {node.name for node in exponent.nodes() if isinstance(node, syntax.Name)}
            if names <= self._balls.integers or not below.jet.value.contains(0):
                return TypedBall.of(ball_jets.powered(below.jet, number), below.is_real)
        self._check_smooth(sp.log, below)
        is_real = below.is_real and below.jet.value.real > 0
        if number is not None and number.denominator <= LARGEST_ROOT:
            return TypedBall.of(ball_jets.powered(below.jet, number), is_real)
        above = self.value(exponent)
        logarithm = below.jet.composed(ball_jets.ELEMENTARY[sp.log])
        jet = (above.jet * logarithm).composed(ball_jets.ELEMENTARY[sp.exp])
        return TypedBall.of(jet, is_real and above.is_real)

    def _exact_value(self, exponent: FormulaTree) -> Fraction | None:
        """Return an exponent that is rational and constant at the point; None if it is not."""
        definitions = self._balls.trees.definitions

        def image(node: FormulaTree) -> FormulaTree | None:
            if not isinstance(node, syntax.Name) or node.name in self._balls.letters:
                return None
            if node.name in definitions:
                return syntax.mapped(definitions[node.name], image)
            return syntax.Number(self._point[node.name]) if node.name in self._point else None

        return syntax.rational(syntax.mapped(exponent, image))

    def _is_zero(self, formula: FormulaTree, ball: TypedBall) -> bool:
        """Return whether a formula is 0 and free of continuous variables: its roots are then 0."""
        return bool(ball.jet.value == 0) and not names_in(formula) & {*self._balls.letters}

    def _check_smooth(self, function: type, ball: TypedBall) -> None:
        """Raise ValueError on a cut, unless it is that of log and the argument stays real."""
        value = ball.jet.value
        along = function is sp.log and ball.is_real and not value.contains(0)
        if ball_jets.touches_cut(function, value) and not along:
            raise ValueError("points must lie off the cuts, got one on a cut (take another)")

    def _call(self, name: str, parts: tuple[FormulaTree, ...]) -> TypedBall:
        ball, *further = map(self.value, parts)
        function = function_named(name)
        if name == "sqrt":
            return self._power(parts[0], syntax.Number(Fraction(1, 2)))
        if name == "abs" and self._is_zero(parts[0], ball):
            return ball
        if name in SIZES:
            return self._size(name, ball)
        if name in MEAN:
            m = _parameter(ball)
            if not (m.real < 1 or (name == "elliptic_e" and m == 1)):
                raise ValueError(f"{name} needs m < 1, got {m.str(10)}")
            return self._constant(getattr(m, name)(), True)
        if issubclass(function, JacobiFunction):
            elliptic = Elliptic(_parameter(*further))
            taylor = getattr(elliptic, name.removeprefix("jacobi_"))
            return TypedBall.of(ball.jet.composed(taylor), ball.is_real)
        is_real = all(inner.is_real for inner in (ball, *further))
        if function in ball_jets.ELEMENTARY and function not in ball_jets.PERIODIC:
            self._check_smooth(function, ball)
            is_real = is_real and not ball_jets.touches_cut(function, ball.jet.value)
        jets = [inner.jet for inner in (ball, *further)]
        return TypedBall.of(ball_jets.function_jet(function, jets), is_real)

    def _size(self, name: str, ball: TypedBall) -> TypedBall:
        value = ball.jet.value
        if ball.is_real and name in ("abs", "sign") and not value.contains(0):
            sign = ball_jets.constant(self._shape, acb(1 if value.real > 0 else -1))
            return TypedBall.of(sign if name == "sign" else sign * ball.jet, True)
        is_real = ball.is_real or name not in ("sign", "conjugate")
        return TypedBall.of(ball_jets.size_jet(name, ball.jet), is_real)


def _parameter(ball: TypedBall) -> acb:
    """Return the value of an elliptic parameter; raises ValueError unless it is real."""
    value = ball_jets.constant_value(ball.jet)
    if not ball.is_real:
        raise ValueError(f"elliptic parameters must be real, got {value.str(10)}")
    return value
