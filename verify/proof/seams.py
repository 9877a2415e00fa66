"""Seams: places at which the typed formulas of a statement may jump or have corners.

A proof holds where the formulas are smooth: on each side of a seam, not across it.  A travelling
corner is not a solution just because both of its sides are.

A seam is where the argument of abs, sign, a root or a logarithm is 0 or may cross a cut, where an
inverse function is at an end of its cuts, and where a function's argument has a pole (atan(1/x)).
A pole outside of all functions is not a seam: nobody takes it as part of the solution.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain

import sympy as sp

from longwave.derive.algebra.formula_expression import ExpressionBuilder
from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.derive.algebra.formula_tree import (
    Call,
    FormulaTree,
    Name,
    Number,
    Power,
    Product,
    Sum,
    plain_text,
    rational,
)
from longwave.verify.subexpressions import abbreviated
from longwave.verify.verdict import on_each_side

from .domain_signs import DEPTH, DomainSigns
from .domains import REAL
from .simplification import Rewriting
from .statement_problem import all_domains
from .typed_hints import put_in, vocabulary
from .typed_places import DOTS, corner_line, typed_places
from .typed_statement import Statement, names_in

BRANCH_AT_ONE = ("asin", "acos", "atanh", "acosh")
"""Inverse functions with branch points where the argument is 1 or -1."""

POLES = {"tan": "cos", "sec": "cos", "cot": "sin", "csc": "sin", "coth": "sinh", "csch": "sinh"}
"""Functions with poles on the real axis, each with the function that is 0 at these poles."""

SAFE = ("exp", "sin", "cos", "sinh", "cosh", "tanh", "sech", "erf")
"""Functions that SymPy does not rewrite: it prints them as typed, up to notation."""

LONGEST_PLACE = 60
"""Most characters of a place that is not abbreviated."""

ONE = Fraction(1)


@dataclass(frozen=True)
class Seam:
    """Seam at ``place``, an equation as text; ``line`` is its line in `typed_places`.

    ``at_sites``: the equation contains no variable other than sites.  With an empty ``place`` the
    line is for a formula that is never 0 or has no variable; ``own_line`` is then the line for a
    factor without variables.
    """

    place: str
    at_sites: bool
    line: str = ""
    own_line: str = ""


def seams(statement: Statement) -> tuple[Seam, ...]:
    """Return the places where the typed formulas may not be smooth, without repeats.

    >>> from longwave.verify.proof.statement_text import read_statement
    >>> [seam.place for seam in seams(read_statement("u_x", "u = sign(x - c*t)"))]
    ['x = c*t']
    """
    return _places(_all_seams(statement))


def _places(all_seams: Sequence[Seam]) -> tuple[Seam, ...]:
    """Return the seams that have places, without repeats."""
    return tuple({seam.place: seam for seam in all_seams if seam.place}.values())


def left_open(statement: Statement) -> tuple[tuple[Seam, ...], tuple[str, ...]]:
    """Return where a proof makes no claim: the seams, and lines for all other places.

    >>> from longwave.verify.proof.statement_text import read_statement
    >>> found, lines = left_open(read_statement("u_x", "u = sign(m*(x - t))"))
    >>> [seam.place for seam in found], lines
    (['x = t'], ('jump or corner where m = 0',))
    """
    all_seams = _all_seams(statement)
    covered = {seam.line for seam in all_seams}
    lines = (line for line in typed_places(statement) if line not in covered)
    own = (seam.own_line for seam in all_seams if seam.own_line)
    return _places(all_seams), tuple(dict.fromkeys((*lines, *own)))


def _all_seams(statement: Statement) -> tuple[Seam, ...]:
    """Return the seams of all formulas and equations, also those without a place."""
    finder, trees = _Finder(statement), statement.trees
    own = (finder.seams(put_in(trees, tree)) for tree in trees.solutions.values())
    of_equations = (finder.seams(put_in(trees, tree), None) for tree in trees.equations)
    return tuple(chain.from_iterable((*own, *of_equations)))


def sides(jumps: Sequence[Seam]) -> str:
    """Return in words what a proof claims and leaves open at seams."""
    return on_each_side(
        [seam.place for seam in jumps if not seam.at_sites],
        [seam.place for seam in jumps if seam.at_sites],
    )


class _Finder:
    """Finder of the seams of one statement's formulas, without unknowns and defined names."""

    def __init__(self, statement: Statement) -> None:
        self._build = ExpressionBuilder(vocabulary(statement)).expression
        self._domains = all_domains(statement, *statement.equations)
        self._signs = DomainSigns(self._domains)
        self._has_complexes = bool(statement.complexes)
        self._variables = {str(v): v for v in statement.variables}

    def seams(self, formula: FormulaTree, inside: bool | None = False) -> Iterator[Seam]:
        """Yield the seams of a formula.

        Poles and zeros of logarithms' arguments are seams only if ``inside`` is True: within
        functions.  None, for equations, excludes them within functions too.
        """
        match formula:
            case Power(parts=(Call(name="abs", parts=parts), exponent)) if _is_even(exponent):
                pass  # f times its conjugate
            case Call(name="abs" | "sign", parts=(argument,) as parts):
                yield from self._zero(argument, jumps=True)
            case Call(name="sqrt", parts=(argument,) as parts):
                yield from self._branch(argument)
            case Call(name="log", parts=(argument,) as parts):
                yield from self._branch(argument, bool(inside))
            case Call(name="lambert_w", parts=(argument,) as parts):
                yield from self._zero(Sum((argument, Call((Number(-ONE),), "exp"))))
            case Call(name="bessel_j" | "bessel_y" | "bessel_i" | "bessel_k", parts=parts):
                is_entire = formula.name in ("bessel_j", "bessel_i") and _is_whole(parts[0])
                yield from () if is_entire else self._branch(parts[1])
            case Call(name=name, parts=parts) if name in BRANCH_AT_ONE:
                for end in (ONE, -ONE):
                    yield from self._zero(Sum((parts[0], Number(-end))))
            case Call(name="atan" | "asinh", parts=(argument,) as parts):
                yield from () if self._is_real(argument) else self._cut("re", argument)
            case Call(name=name, parts=parts) if inside and name in POLES:
                yield from self._zero(Call(parts, POLES[name]))
            case Power(parts=(base, exponent) as parts):
                power = rational(exponent)
                if power is None or power.denominator != 1:
                    yield from self._branch(base, bool(inside) or power is None or power > 0)
                elif inside and power < 0:
                    yield from self._zero(base)
            case _:
                parts = formula.inner()
        if inside is not None and isinstance(formula, Call) and formula.name != "log":
            inside = True
        for part in parts:
            yield from self.seams(part, inside)

    def _branch(self, argument: FormulaTree, finite: bool = True) -> Iterator[Seam]:
        """Yield the cut of a root or logarithm; for a real argument its zero, if ``finite``."""
        if not self._is_real(argument):
            yield from self._cut("im", argument)
        elif finite:
            yield from self._zero(argument)

    def _cut(self, part: str, argument: FormulaTree) -> Iterator[Seam]:
        value = self._value(argument)
        right = value is not None and self._signs.is_positive(sp.re(value))
        if self._moves(argument) and not right:
            yield Seam(f"{part}({self._text(argument)}) = 0", False)

    def _zero(self, argument: FormulaTree, line: str = "", jumps: bool = False) -> Iterator[Seam]:
        """Yield the seams where a formula with a variable may be 0; for a product, by factors.

        ``line`` is that of the product; if it ``jumps``, constant factors have lines of their own.
        """
        if not (line or self._moves(argument)):
            return
        line = line or corner_line(argument)
        never = Seam("", False, "" if DOTS in line or self._has_complexes else line)
        match argument:
            case Product(parts=factors) | Call(name="abs" | "sign", parts=factors):
                for factor in factors:
                    yield from self._zero(factor, line, jumps)
                return
        value = self._value(argument)
        inverse = isinstance(argument, Power) and (rational(argument.parts[1]) or 0) < 0
        if inverse or (value is not None and self._is_nonzero(value)):
            yield never
            return
        if not self._moves(argument):
            own_line = corner_line(argument) if jumps and names_in(argument) else ""
            yield Seam("", False, line, own_line)
            return
        at_sites = all(map(self._is_site, names_in(argument) & {*self._variables}))
        solved = self._solved(argument)
        place = f"{self._text(argument)} = 0" if solved is None else solved
        if value is not None and len(place) > LONGEST_PLACE:
            place = f"{abbreviated(value, DEPTH)} = 0"
        yield Seam(place, at_sites, line) if place else never

    def _solved(self, argument: FormulaTree) -> str | None:
        """Return ``x = ...`` for a polynomial of degree 1 in x; "" without a real x or site."""
        match argument:
            case Power(parts=(base, Number(value=power))) if power.denominator == 1 and power > 0:
                return self._solved(base) or f"{self._text(base)} = 0"
        value = self._value(argument)
        if value is None or not all(map(_is_polynomial, argument.nodes())):
            return None
        value = sp.expand(value)
        for name, variable in self._variables.items():
            slope = value.coeff(variable, 1)
            rest = value - slope * variable
            if rest.has(variable) or slope.has(*self._variables.values()):
                continue
            if self._signs.is_nonzero(slope):
                end = sp.expand(-rest / slope)
                missed = self._is_site(name) and end.is_Rational and not end.is_Integer
                if missed or (end.is_real is False and not self._has_complexes):
                    return ""
                return f"{name} = {formula_as_text(end)}"
        return None

    def _text(self, argument: FormulaTree) -> str:
        """Return a formula as text, in SymPy's notation if that means the same everywhere."""
        value = self._value(argument)
        safe = (isinstance(n, Call) and n.name in SAFE for n in argument.nodes())
        plain = map(_is_polynomial, argument.nodes())
        if value is not None and all(a or b for a, b in zip(safe, plain, strict=True)):
            return formula_as_text(value)
        return plain_text(argument)

    def _is_site(self, name: str) -> bool:
        return self._domains.get(self._variables[name], REAL).integer

    def _is_real(self, argument: FormulaTree) -> bool:
        value = self._value(argument)
        return value is not None and (bool(value.is_real) or self._signs.is_real(value))

    def _is_nonzero(self, value: sp.Expr) -> bool:
        """Return whether a value is shown to be nowhere 0, such as a power of a positive base."""
        if value.is_Mul or isinstance(value, sp.Abs):
            return all(map(self._is_nonzero, value.args))
        if value.is_Pow and self._signs.is_positive(value.base):
            return self._signs.is_real(value.exp)
        return self._signs.is_nonzero(value) or Rewriting(self._signs).is_nonzero(value)

    def _moves(self, argument: FormulaTree) -> bool:
        return not names_in(argument).isdisjoint(self._variables)

    def _value(self, argument: FormulaTree) -> sp.Expr | None:
        with suppress(ValueError, TypeError, NotImplementedError, RecursionError):
            return self._build(argument)
        return None


def _is_whole(exponent: FormulaTree) -> bool:
    power = rational(exponent)
    return power is not None and power.denominator == 1


def _is_even(exponent: FormulaTree) -> bool:
    power = rational(exponent)
    return power is not None and power > 0 and power % 2 == 0


def _is_polynomial(node: FormulaTree) -> bool:
    if isinstance(node, Power) and rational(node) is None:
        return _is_whole(node.parts[1]) and (rational(node.parts[1]) or 0) > 0
    return rational(node) is not None or isinstance(node, Name | Number | Sum | Product)
