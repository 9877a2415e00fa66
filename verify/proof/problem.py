"""Problems to decide: an equation, its unknown, and the formula to substitute for it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import sympy as sp
from flint import acb
from sympy.core.function import AppliedUndef

from longwave.solutions.equation import Equation
from longwave.support.user_files import shown

from .balls import ball_value, residual_ball
from .domain_signs import DomainSigns
from .domains import Domain, Domains, Point, settled_domains
from .samples import sample
from .typed_statement import StatementTexts

POINTS = 8
"""Number of points at which a formula is evaluated before a proof is tried."""

MORE_POINTS = 40
"""Number of further points at which an unproved formula is evaluated."""

LARGEST_JET_POWER = 64
"""Highest power of the unknown or a derivative that is written as a list of factors."""

LARGEST_POWER = 13
"""A power of a sum with the unknown is expanded if its exponent is lower than this."""

NO_POLYNOMIAL = "equations must be polynomials"
"""Beginning of the reason that an equation is not a polynomial."""

Stated = Mapping[sp.Symbol, Domain | sp.Interval]

Term = tuple[sp.Rational, list[sp.Expr], list[list[int]]]
"""Term of an equation: number, known factors, and orders of each derivative of the unknown."""


@dataclass(frozen=True)
class Problem:
    """Question whether ``formula`` for ``unknown`` makes ``left`` vanish on the domains.

    With ``right`` it is whether ``formula`` and ``right`` are the same function, and ``left`` is
    the difference.  ``domains`` has all symbols; ``texts`` are those of a certificate, if known.
    """

    name: str
    equation_name: str
    unknown: sp.Expr
    formula: sp.Expr
    left: sp.Expr
    domains: Domains
    right: sp.Expr | None = None
    texts: StatementTexts | None = None

    @property
    def variables(self) -> tuple[sp.Symbol, ...]:
        """Arguments of the unknown."""
        return tuple(self.unknown.args)

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """Rational points of the domains, used for witnesses and denominators."""
        return sample(self.domains, POINTS)

    @property
    def solutions(self) -> dict[AppliedUndef, sp.Expr]:
        """Dictionary that maps the unknown to its formula."""
        return {self.unknown: self.formula}

    @property
    def expressions(self) -> list[sp.Expr]:
        """The formula, and the known factors of the equation."""
        return [self.formula, *dict.fromkeys(f for _, known, _ in self.terms() for f in known)]

    def terms(self) -> list[Term]:
        """Return the equation's terms; raises ValueError if it is not a polynomial in its jets."""
        if self.right is not None:
            return [(sp.S.One, [], [[0] * len(self.variables)]), (-sp.S.One, [self.right], [])]
        return [self._term(term) for term in terms_in(self.left, self.unknown)]

    def residual(self, point: Point, bits: int, signs: DomainSigns) -> acb:
        """Return a ball with the residual at ``point``; raises ValueError if it is not smooth."""
        if self.right is not None:
            return ball_value(self.left, point, bits, signs)
        return residual_ball(self.left, self.unknown, self.formula, point, bits, signs)

    def more_points(self) -> tuple[Point, ...]:
        """Return further points of the domains, of all sizes and near the ends."""
        return sample(self.domains, POINTS + MORE_POINTS)[POINTS:]

    def _term(self, term: sp.Expr) -> Term:
        number, known, jets = sp.S.One, [], []
        for factor in sp.Mul.make_args(term):
            if factor.is_Rational:
                number *= factor
            elif not factor.has(self.unknown):
                known.append(factor)
            else:
                jets += self._jets(factor)
        return number, known, jets

    def _jets(self, factor: sp.Expr) -> list[list[int]]:
        """Return a power of a derivative as one entry per factor: its orders in the variables."""
        base, power = factor.as_base_exp()
        inner = base.expr if isinstance(base, sp.Derivative) else base
        pairs = base.variable_count if isinstance(base, sp.Derivative) else ()
        counts = {symbol: int(count) for symbol, count in pairs}
        whole = power.is_Integer and 0 < power <= LARGEST_JET_POWER
        if inner != self.unknown or not whole or counts.keys() - set(self.variables):
            words = f"{self.unknown} and its derivatives in its own variables"
            raise ValueError(f"{NO_POLYNOMIAL} in {words}, got {factor} (multiply it out)")
        return [[counts.get(variable, 0) for variable in self.variables]] * int(power)


def solution_problem(
    equation: Equation | sp.Expr,
    expression: sp.Expr,
    name: str = "expression",
    equation_name: str | None = None,
    stated: Stated | None = None,
) -> Problem:
    """Return the problem that `prove` decides; raises the same errors as `prove`."""
    expression = formula("expression", expression)
    left, label = _left_side(equation)
    unknown = _single_unknown(left)
    real = real_symbols(left.free_symbols | expression.free_symbols)
    left, expression, unknown = (part.xreplace(real) for part in (left, expression, unknown))
    products = [d for d in left.atoms(sp.Derivative) if d.expr != unknown and d.has(unknown)]
    left = left.xreplace({derivative: derivative.doit() for derivative in products})
    steps = {symbol for d in left.atoms(sp.Derivative) for symbol in d.variables}
    if not steps <= set(unknown.args):
        got = f"one in {(steps - set(unknown.args)).pop()} (make it an argument, or work it out)"
        raise ValueError(f"derivatives must be in the arguments of {unknown}, got {got}")
    domains = settled_domains(left.free_symbols | expression.free_symbols, stated or {})
    return Problem(_text(name), equation_name or label, unknown, expression, left, domains)


def _left_side(equation: Equation | sp.Expr) -> tuple[sp.Expr, str]:
    """Return the left-hand side of an equation, and its name."""
    if isinstance(equation, sp.Expr):
        return equation, f"{equation} = 0"
    if hasattr(equation, "residual"):
        return equation.residual(sp.Function("U")(equation.xi, equation.tau)), equation.name
    got = f"{shown(equation)} (its left-hand side, '= 0' understood)"
    raise TypeError(f"equation must be a SymPy expression, got {got}")


def _single_unknown(left: sp.Expr) -> sp.Expr:
    """Return the only undefined function in ``left``.

    Raises ValueError for none or several, and for arguments that are not different symbols."""
    unknowns = left.atoms(AppliedUndef)
    if len(unknowns) != 1:
        got = f"{len(unknowns)} (write it with sympy.Function('u')(x, t))"
        raise ValueError(f"equation must contain one unknown function, got {got}")
    (unknown,) = unknowns
    if len(set(unknown.args)) < len(unknown.args) or not all(a.is_Symbol for a in unknown.args):
        got = f"{unknown} (write it with sympy.Function('u')(x, t))"
        raise ValueError(f"the unknown must be a function of different symbols, got {got}")
    return unknown


def equality_problem(
    left: sp.Expr,
    right: sp.Expr,
    variables: Sequence[sp.Symbol],
    name: str = "expressions",
    equation_name: str = "equality",
    stated: Stated | None = None,
) -> Problem:
    """Return the problem that `prove_equal` decides; raises the same errors as `prove_equal`."""
    left, right = formula("left", left), formula("right", right)
    if not isinstance(variables, Iterable):
        raise TypeError(f"variables must be a list of symbols, got {shown(variables)} ([x, t])")
    real = real_symbols(left.free_symbols | right.free_symbols | set(variables))
    left, right = left.xreplace(real), right.xreplace(real)
    domains = settled_domains(left.free_symbols | right.free_symbols, stated or {})
    own = tuple(real.get(variable, variable) for variable in variables)
    unknown = sp.Function("u")(*own)
    return Problem(_text(name), equation_name, unknown, left, left - right, domains, right)


def formula(name: str, given: object) -> sp.Expr:
    """Return a formula as a SymPy expression; raises TypeError for other objects."""
    if isinstance(given, sp.Expr | int) and not isinstance(given, bool):
        return given if isinstance(given, sp.Expr) else sp.Integer(given)
    got = shown(given)
    raise TypeError(f"{name} must be a SymPy expression, got {got} (make it from sympy.Symbol)")


def _text(name: object) -> str:
    if isinstance(name, str):
        return name
    raise TypeError(f"name must be text, got {shown(name)} (such as 'kink')")


def real_symbols(symbols: Iterable[sp.Symbol]) -> dict[sp.Symbol, sp.Symbol]:
    """Map symbols without assumptions to real ones; raises as `domains.settled_domains` does."""
    unassumed = (symbol for symbol in settled_domains(symbols, {}) if symbol.is_real is None)
    return {symbol: sp.Symbol(symbol.name, real=True) for symbol in unassumed}


def terms_in(equation: sp.Expr, unknown: sp.Expr) -> list[sp.Expr]:
    """Return the terms of a polynomial in ``unknown``; sums without it are not expanded.

    >>> x = sp.Symbol("x")
    >>> u = sp.Function("u")(x)
    >>> set(terms_in((1 + x) * (u + 2), u)) == {(1 + x) * u, 2 + 2 * x}
    True
    """
    if not equation.has(unknown):
        return [equation]
    if equation.is_Add:
        return [term for part in equation.args for term in terms_in(part, unknown)]
    factors = equation.args if equation.is_Mul else ()
    if equation.is_Pow and equation.base.is_Add and equation.exp in range(2, LARGEST_POWER):
        factors = [equation.base] * int(equation.exp)
    parts = [terms_in(factor, unknown) for factor in factors]
    return [sp.Mul(*row) for row in product(*parts)] if parts else [equation]
