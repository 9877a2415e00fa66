"""What is to be decided: an equation, its unknown, and the formula put in its place."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import sympy as sp
from sympy.core.function import AppliedUndef

from solutions.exact import shown
from verify.terms import FieldEquation

from .domains import Domain, Domains, Point, sample, settled_domains

POINTS = 8
"""Points at which a formula is looked at before anything is proved."""

MORE_POINTS = 40
"""Further points at which a formula is looked at that could not be proved."""

LARGEST_POWER = 13
"""Of a sum with the unknown; from this on it is not multiplied out."""

Stated = Mapping[sp.Symbol, Domain | sp.Interval]


@dataclass(frozen=True)
class Problem:
    """Does ``expression`` for ``unknown`` make ``left`` vanish on the domains?

    ``domains`` has every variable and parameter.  ``points`` are rational points of them, for
    witnesses and for denominators: sampled ones, then those that the caller added.
    """

    left: sp.Expr
    unknown: sp.Expr
    expression: sp.Expr
    points: tuple[Point, ...]
    name: str
    equation_name: str
    domains: Domains

    @property
    def variables(self) -> tuple[sp.Symbol, ...]:
        """The arguments of the unknown function."""
        return tuple(self.unknown.args)


def make_problem(
    equation: FieldEquation | sp.Expr,
    expression: sp.Expr,
    points: Sequence[Point],
    name: str,
    stated: Stated,
) -> Problem:
    """The problem that `prove` is called with.

    Raises ValueError without a single unknown, and as `domain.settled_domains` does.
    """
    expression = formula("expression", expression)
    if isinstance(equation, sp.Expr):
        left, label = equation, f"{equation} = 0"
    elif not hasattr(equation, "residual"):
        raise TypeError(
            f"equation must be a SymPy expression, got {shown(equation)} (its left-hand "
            "side, '= 0' understood)"
        )
    else:
        left, label = equation.residual(sp.Function("U")(equation.xi, equation.tau)), equation.name
    unknowns = left.atoms(AppliedUndef)
    if len(unknowns) != 1:
        raise ValueError(
            f"equation must contain one unknown function, got {len(unknowns)} "
            "(write it with sympy.Function('u')(x, t))"
        )
    (unknown,) = unknowns
    if len(set(unknown.args)) < len(unknown.args) or not all(a.is_Symbol for a in unknown.args):
        raise ValueError(
            f"the unknown must be a function of different symbols, got {unknown} "
            "(write it with sympy.Function('u')(x, t))"
        )
    real = real_symbols(left.free_symbols | expression.free_symbols)
    left, expression = left.xreplace(real), expression.xreplace(real)
    (unknown,) = left.atoms(AppliedUndef)
    left = _written_out(left, unknown)
    steps = {symbol for d in left.atoms(sp.Derivative) for symbol in d.variables}
    if not steps <= set(unknown.args):
        raise ValueError(
            f"derivatives must be in the arguments of {unknown}, got one in "
            f"{(steps - set(unknown.args)).pop()} (make it an argument, or work it out)"
        )
    domains = settled_domains(left.free_symbols | expression.free_symbols, stated)
    found = problem_points(domains, points)
    return Problem(left, unknown, expression, found, name, label, domains)


def _written_out(left: sp.Expr, unknown: sp.Expr) -> sp.Expr:
    """The equation with the derivatives of products and powers of the unknown in jets."""
    whole = [d for d in left.atoms(sp.Derivative) if d.expr != unknown and d.has(unknown)]
    return left.xreplace({derivative: derivative.doit() for derivative in whole})


def formula(name: str, given: object) -> sp.Expr:
    """A formula as a SymPy expression; raises TypeError for what is none."""
    if isinstance(given, sp.Expr):
        return given
    if isinstance(given, int) and not isinstance(given, bool):
        return sp.Integer(given)
    raise TypeError(
        f"{name} must be a SymPy expression, got {shown(given)} (make it from sympy.Symbol)"
    )


def real_symbols(symbols: Iterable[sp.Symbol]) -> dict[sp.Symbol, sp.Symbol]:
    """Real symbols in place of those of which SymPy knows nothing.

    Raises ValueError as `domain.settled_domains` does.
    """
    return {
        symbol: sp.Symbol(symbol.name, real=True)
        for symbol in settled_domains(symbols, {})
        if symbol.is_real is None
    }


def make_equality(
    left: sp.Expr,
    right: sp.Expr,
    points: Sequence[Point],
    names: tuple[str, str],
    stated: Stated,
) -> Problem:
    """The problem that `prove_equal` is called with; ``names`` of the formulas and the equation."""
    domains = settled_domains(left.free_symbols | right.free_symbols, stated)
    found = problem_points(domains, points)
    return Problem(sp.S.Zero, sp.S.Zero, left - right, found, *names, domains)


def problem_points(domains: Domains, added: Iterable[Point]) -> tuple[Point, ...]:
    """Sampled points, and the added ones with sampled values where they leave a symbol out.

    Raises ValueError for an added point outside the domains.
    """
    found = sample(domains, POINTS)
    by_name = {symbol.name: symbol for symbol in domains}
    extra = [
        {**found[0], **{by_name[str(s)]: _exact(s, v) for s, v in p.items() if str(s) in by_name}}
        for p in added
    ]
    for point in extra:
        for symbol, value in point.items():
            if not domains[symbol].contains(value, point):
                raise ValueError(
                    f"points must lie in the domains, got {symbol} = {value} "
                    f"({domains[symbol].text(symbol)})"
                )
    return (*found, *extra)


def more_points(problem: Problem) -> tuple[Point, ...]:
    """Further points of a problem's domains, of all sizes and near the ends."""
    return sample(problem.domains, POINTS + MORE_POINTS)[POINTS:]


def _exact(symbol: sp.Symbol, value: object) -> sp.Rational:
    found = sp.Integer(value) if isinstance(value, int) else value
    if not (isinstance(found, sp.Expr) and found.is_Rational):
        raise ValueError(
            f"points must have rational numbers, got {symbol} = {shown(value)} "
            "(sympy.Rational(1, 2))"
        )
    return found


def coefficients(equation: sp.Expr, unknown: sp.Expr) -> list[sp.Expr]:
    """The factors of the terms of ``equation`` that are free of ``unknown``."""
    factors = (f for term in terms_in(equation, unknown) for f in sp.Mul.make_args(term))
    return [factor for factor in dict.fromkeys(factors) if not factor.has(unknown)]


def terms_in(equation: sp.Expr, unknown: sp.Expr) -> list[sp.Expr]:
    """The terms of a polynomial in ``unknown``; sums that are free of it are not multiplied out.

    >>> x = sp.Symbol("x")
    >>> u = sp.Function("u")(x)
    >>> set(terms_in((1 + x) * (u + 2), u)) == {(1 + x) * u, 2 + 2 * x}
    True
    """
    if not equation.has(unknown):
        return [equation]
    if equation.is_Add:
        return [term for part in equation.args for term in terms_in(part, unknown)]
    if equation.is_Mul:
        parts = [terms_in(factor, unknown) for factor in equation.args]
    elif equation.is_Pow and equation.base.is_Add and equation.exp in range(2, LARGEST_POWER):
        parts = [terms_in(equation.base, unknown)] * int(equation.exp)
    else:
        return [equation]
    return [sp.Mul(*factors) for factors in product(*parts)]
