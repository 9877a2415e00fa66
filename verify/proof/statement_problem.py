"""Problems to prove for the equations of a statement.

The certificate states the equation with its unknowns, shifts, conjugates and derivatives, and the
checker substitutes the formulas.  SymPy's form of the equation is used only to find generators.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

import sympy as sp
from sympy.core.function import AppliedUndef

from longwave.derive.algebra.bounded_building import without_sizes
from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.verify.subexpressions import rebuilt

from . import typed_statement
from .balls import ball_value
from .domains import Domains, Point, settled_domains
from .problem import POINTS, Problem
from .samples import sample
from .typed_statement import Statement

DIVISOR_BITS = (160, 1280)

CONJUGATES = (sp.conjugate, sp.Abs, sp.re, sp.im)


@dataclass(frozen=True)
class StatementProblem(Problem):
    """Question whether the formulas of ``statement`` make ``left``, one of its equations, vanish.

    ``unknown`` is the first in ``left``; ``also`` has further expressions that need generators.
    """

    statement: typed_statement.Statement | None = None
    also: tuple[sp.Expr, ...] = ()

    @property
    def solutions(self) -> dict[AppliedUndef, sp.Expr]:
        """Unknowns in the equation, and their formulas."""
        assert self.statement is not None
        return {u: f for u, f in self.statement.solutions.items() if self.left.has(u.func)}

    @property
    def expressions(self) -> list[sp.Expr]:
        """Formulas and functions in the equation, at all shifts and with conjugates."""
        parts = (with_exponentials(part) for part in (*self._parts(self.left), *self.also))
        return list(dict.fromkeys(parts))

    def _parts(self, node: sp.Expr) -> Iterator[sp.Expr]:
        """Yield the formulas of unknowns in ``node``, their conjugates, and functions of them."""
        assert self.statement is not None
        if not node.atoms(AppliedUndef):
            yield node
            return
        if isinstance(node, AppliedUndef):
            yield residual_of(self.statement, node)
            return
        of_modulus = node.is_Pow and isinstance(node.base, sp.Abs) and node.exp.is_even
        inner = [node.expr] if isinstance(node, sp.Derivative) else node.args
        inner = node.base.args if of_modulus else inner
        for part in inner:
            yield from self._parts(part)
        if of_modulus or isinstance(node, CONJUGATES):
            for part in inner:
                yield from (formula.xreplace({sp.I: -sp.I}) for formula in self._parts(part))
        plain = node.is_Add or node.is_Mul or (node.is_Pow and node.exp.is_Integer)
        if not (plain or of_modulus or isinstance(node, (sp.Derivative, sp.conjugate))):
            arguments = (residual_of(self.statement, part) for part in node.args)
            yield node.func(*arguments, evaluate=False)


def statement_problem(statement: Statement, equation: sp.Expr) -> StatementProblem:
    """Return the problem of one equation; raises ValueError if it has no unknown."""
    used = ((u, f) for u, f in statement.solutions.items() if equation.has(u.func))
    unknown, formula = next(used, (None, None))
    if unknown is None:
        raise ValueError("equations must have an unknown, got one in which it cancels")
    domains = all_domains(statement, equation)
    known = f"{formula_as_text(equation)} = 0", unknown, formula, equation, domains
    return StatementProblem(statement.name, *known, statement=statement)


def all_domains(statement: Statement, *equations: sp.Expr) -> Domains:
    """Return the domains of all variables and of all symbols in the equations and formulas."""
    used = [f for u, f in statement.solutions.items() if any(e.has(u.func) for e in equations)]
    symbols = {s for formula in (*equations, *used) for s in formula.free_symbols}
    return settled_domains(symbols | set(statement.variables), statement.domains)


def typed_domains(statement: Statement) -> Domains:
    """Return the domains of all symbols in the typed texts, including those that SymPy cancels."""
    domains = all_domains(statement, *statement.equations)
    names = {str(symbol) for symbol in domains}
    others = {s: d for s, d in statement.domains.items() if str(s) not in names}
    return {**domains, **others}


def undefined(statement: Statement) -> sp.Expr | None:
    """Return a divisor that is not shown to be nonzero at any sampled point, else None."""
    points = sample(all_domains(statement, *statement.equations, *statement.divisors), POINTS)
    for divisor in statement.divisors:
        value = with_exponentials(residual_of(statement, divisor))
        if not any(_is_nonzero(value, point) for point in points):
            return divisor
    return None


def _is_nonzero(value: sp.Expr, point: Point) -> bool:
    for bits in DIVISOR_BITS:
        with suppress(ValueError, ZeroDivisionError):
            ball = ball_value(value, point, bits)
            if ball.is_finite() and not ball.contains(0):
                return True
    return False


def with_exponentials(expression: sp.Expr) -> sp.Expr:
    """Write x**k as exp(k*log(x)); for x < 0 and an integer k as (-1)**k*exp(k*log(-x))."""
    if not any(_is_symbolic(power) for power in expression.atoms(sp.Pow)):
        return expression

    def rebuild(node: sp.Expr, arguments: list[sp.Expr]) -> sp.Expr:
        if node.is_Pow and _is_symbolic(node):
            base, exponent = arguments
            turn = sp.S.One
            if exponent.is_integer and base.is_negative:
                turn, base = (-1) ** exponent, -base
            return turn * sp.exp(exponent * sp.log(base, evaluate=False), evaluate=False)
        if arguments == list(node.args):
            return node
        return node.func(*arguments, **{"evaluate": False} if node.is_Function else {})

    return rebuilt(expression, rebuild)


def _is_symbolic(power: sp.Pow) -> bool:
    """Return whether an exponent is symbolic, except for powers of e and integer powers of -1."""
    whole = power.base is sp.S.NegativeOne and power.exp.is_integer
    return not (power.exp.is_Rational or power.base is sp.E or whole)


def residual_of(statement: Statement, equation: sp.Expr) -> sp.Expr:
    """Return the left-hand side with the formulas substituted for the unknowns.

    >>> from longwave.verify.proof.statement_text import read_statement
    >>> statement = read_statement("diff(q[n], t) - q[n+1] + q[n]", "q = n + t")
    >>> residual_of(statement, statement.equations[0])
    0
    """
    formulas = {unknown.func: (unknown.args, f) for unknown, f in statement.solutions.items()}

    def substitute(node: sp.Expr, inner: list[sp.Expr]) -> sp.Expr:
        if isinstance(node, sp.Derivative):
            slope = sp.diff(without_sizes(inner[0]), *node.variables)
            if slope.has(sp.DiracDelta):  # at jumps, which are left out
                slope = slope.replace(sp.DiracDelta, lambda *_: sp.S.Zero)
            if slope.has(sp.Derivative, sp.Subs):
                raise ValueError(f"derivatives must be known, got {formula_as_text(slope)[:80]}")
            return slope
        if isinstance(node, AppliedUndef):
            arguments, formula = formulas[node.func]
            return formula.subs(dict(zip(arguments, node.args, strict=True)), simultaneous=True)
        return node.func(*inner) if inner else node

    return rebuilt(equation, substitute)
