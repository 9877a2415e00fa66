"""What is to be decided, and rational points of its domains at which it is looked at.

Sampled points cover the whole of the domains: both signs, every size, near the ends; the same for a
seed.
"""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, product
from typing import ClassVar

import sympy as sp
from flint import acb
from sympy.core.function import AppliedUndef

from solutions.exact import shown
from verify.subexpressions import abbreviated
from verify.terms import FieldEquation

from .balls import ball_value, residual_ball
from .checker.limits import JETS
from .domain_signs import Signs
from .domains import Domain, Domains, Point, in_order, settled_domains

POINTS = 8
"""Points at which a formula is looked at before anything is proved."""

MORE_POINTS = 40
"""Further points at which a formula is looked at that could not be proved."""

LARGEST_POWER = 13
"""Of a sum with the unknown; from this on it is not multiplied out."""

DENOMINATORS = (1009, 2147483647, 65537, 1009)
"""Primes, so that no drawn value is a common fraction, and no one multiple of all is whole."""

SIZES = (1, 1, 1, 4, 4, sp.Rational(1, 30), 30, sp.Rational(1, 1000), 1000)
"""Scales of what is drawn from a domain without end; most are moderate, where balls stay narrow."""

MARGINS = (sp.Rational(1, 20),) * 3 + (sp.Rational(1, 1000), sp.Rational(1, 10**6))
"""Shares of a bounded domain that are left out at its ends."""

SLIVER, EVERY = sp.Rational(1, 10**31), 4
"""Every so manieth point lies that near to an end of one symbol's domain."""

REJECTIONS = 1000
"""Points in a row outside the domains, after which these are taken to be empty."""

SIGN_PATTERNS = 5
"""Symbols whose signs are combined in all ways before they are drawn."""

Stated = Mapping[sp.Symbol, Domain | sp.Interval]

Term = tuple[sp.Rational, list[sp.Expr], list[list[int]]]
"""A number, known factors, and derivatives of the unknown by their orders in the variables."""


@dataclass(frozen=True, repr=False)
class Problem(ABC):
    """Does ``formula`` satisfy an equation of that name on the domains?

    ``domains`` has every variable and parameter.  ``points`` are rational points of them, for
    witnesses and for denominators: sampled ones, then those that the caller added.
    """

    name: str
    equation_name: str
    formula: sp.Expr
    variables: tuple[sp.Symbol, ...]
    domains: Domains
    points: tuple[Point, ...]

    has_derivatives: ClassVar[bool]

    @property
    @abstractmethod
    def unknown_name(self) -> str:
        """What the equation calls the formula."""

    @abstractmethod
    def terms(self) -> list[Term]:
        """The equation's terms; raises ValueError if it is no polynomial in its jets."""

    @abstractmethod
    def residual(self, point: Point, bits: int, signs: Signs) -> acb:
        """A ball around the residual at ``point``; raises ValueError where it is not smooth."""

    @property
    def expressions(self) -> list[sp.Expr]:
        """The formula, and the known factors in the equation."""
        return [self.formula, *dict.fromkeys(f for _, known, _ in self.terms() for f in known)]

    def more_points(self) -> tuple[Point, ...]:
        """Further points of the domains, of all sizes and near the ends."""
        return sample(self.domains, POINTS + MORE_POINTS)[POINTS:]

    def __repr__(self) -> str:
        where = ", ".join(domain.text(symbol) for symbol, domain in self.domains.items())
        formula = f"{self.unknown_name} = {abbreviated(self.formula)}"
        return f"<{type(self).__name__} {self.name}: {formula} in {self.equation_name}; {where}>"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.unknown_name} = {sp.latex(self.formula)}$"


@dataclass(frozen=True, repr=False)
class SolutionProblem(Problem):
    """Does ``formula`` for ``unknown`` make ``left`` vanish?"""

    left: sp.Expr
    unknown: sp.Expr

    has_derivatives = True

    @property
    def unknown_name(self) -> str:
        """The name of the undefined function."""
        return str(self.unknown.func.__name__)

    def terms(self) -> list[Term]:
        """The terms of ``left``."""
        return [self._term(term) for term in terms_in(self.left, self.unknown)]

    def residual(self, point: Point, bits: int, signs: Signs) -> acb:
        """A ball around the residual of ``left``."""
        return residual_ball(self.left, self.unknown, self.formula, point, bits, signs)

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
        """A power of the unknown or of one of its derivatives, as that many orders."""
        base, power = factor.as_base_exp()
        inner = base.expr if isinstance(base, sp.Derivative) else base
        pairs = base.variable_count if isinstance(base, sp.Derivative) else ()
        counts = {symbol: int(count) for symbol, count in pairs}
        whole = power.is_Integer and 0 < power <= JETS
        if inner != self.unknown or not whole or counts.keys() - set(self.variables):
            raise ValueError(
                f"equations must be polynomials in {self.unknown} and its derivatives in its own "
                f"variables, got {factor} (multiply it out)"
            )
        return [[counts.get(variable, 0) for variable in self.variables]] * int(power)


@dataclass(frozen=True, repr=False)
class EqualityProblem(Problem):
    """Is ``formula`` the same function as ``right``?"""

    right: sp.Expr

    has_derivatives = False
    unknown_name = "u"

    def terms(self) -> list[Term]:
        """The terms of u - ``right``."""
        return [(sp.S.One, [], [[0] * len(self.variables)]), (-sp.S.One, [self.right], [])]

    def residual(self, point: Point, bits: int, signs: Signs) -> acb:
        """A ball around the difference."""
        return ball_value(self.formula - self.right, point, bits, signs)


def solution_problem(
    equation: FieldEquation | sp.Expr,
    expression: sp.Expr,
    points: Sequence[Point] = (),
    name: str = "expression",
    stated: Stated | None = None,
) -> SolutionProblem:
    """The problem that `prove` is called with.

    Raises ValueError without a single unknown, and as `domains.settled_domains` does.
    """
    expression = formula("expression", expression)
    left, label = _left_side(equation)
    unknown = _single_unknown(left)
    real = real_symbols(left.free_symbols | expression.free_symbols)
    left, expression, unknown = (part.xreplace(real) for part in (left, expression, unknown))
    left = _written_out(left, unknown)
    steps = {symbol for d in left.atoms(sp.Derivative) for symbol in d.variables}
    if not steps <= set(unknown.args):
        raise ValueError(
            f"derivatives must be in the arguments of {unknown}, got one in "
            f"{(steps - set(unknown.args)).pop()} (make it an argument, or work it out)"
        )
    domains = settled_domains(left.free_symbols | expression.free_symbols, stated or {})
    found = problem_points(domains, points)
    return SolutionProblem(name, label, expression, unknown.args, domains, found, left, unknown)


def _left_side(equation: FieldEquation | sp.Expr) -> tuple[sp.Expr, str]:
    """The left-hand side of an equation, and its name."""
    if isinstance(equation, sp.Expr):
        return equation, f"{equation} = 0"
    if hasattr(equation, "residual"):
        return equation.residual(sp.Function("U")(equation.xi, equation.tau)), equation.name
    raise TypeError(
        f"equation must be a SymPy expression, got {shown(equation)} (its left-hand "
        "side, '= 0' understood)"
    )


def _single_unknown(left: sp.Expr) -> sp.Expr:
    """The one undefined function, of different symbols; raises ValueError for anything else."""
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
    return unknown


def _written_out(left: sp.Expr, unknown: sp.Expr) -> sp.Expr:
    """The equation with the derivatives of products and powers of the unknown in jets."""
    whole = [d for d in left.atoms(sp.Derivative) if d.expr != unknown and d.has(unknown)]
    return left.xreplace({derivative: derivative.doit() for derivative in whole})


def equality_problem(
    left: sp.Expr,
    right: sp.Expr,
    variables: Sequence[sp.Symbol],
    points: Sequence[Point] = (),
    name: str = "expressions",
    equation_name: str = "equality",
    stated: Stated | None = None,
) -> EqualityProblem:
    """The problem that `prove_equal` is called with; raises as `domains.settled_domains` does."""
    left, right = formula("left", left), formula("right", right)
    real = real_symbols(left.free_symbols | right.free_symbols | set(variables))
    left, right = left.xreplace(real), right.xreplace(real)
    domains = settled_domains(left.free_symbols | right.free_symbols, stated or {})
    own = tuple(real.get(variable, variable) for variable in variables)
    found = problem_points(domains, points)
    return EqualityProblem(name, equation_name, left, own, domains, found, right)


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


def _exact(symbol: sp.Symbol, value: object) -> sp.Rational:
    found = sp.Integer(value) if isinstance(value, int) else value
    if not (isinstance(found, sp.Expr) and found.is_Rational):
        raise ValueError(
            f"points must have rational numbers, got {symbol} = {shown(value)} "
            "(sympy.Rational(1, 2))"
        )
    return found


def sample(domains: Domains, count: int, seed: int = 0) -> tuple[Point, ...]:
    """``count`` points of the domains; the first ones combine the signs that the symbols can have.

    The first point has moderate values; the signs come before the sizes.
    """
    return tuple(islice(points(domains, seed), count))


def points(domains: Domains, seed: int = 0) -> Iterator[Point]:
    """Points of the domains without end; raises ValueError if none is found in them."""
    draw = random.Random(seed)
    ordered = in_order(domains)
    signed = [s for s in ordered if _has_both_signs(domains[s])][:SIGN_PATTERNS]
    number = rejected = 0
    while rejected < REJECTIONS:
        signs = {s: -1 if number >> place & 1 else 1 for place, s in enumerate(signed)}
        early = number < 2 ** len(signed)
        point: dict[sp.Symbol, sp.Rational] = {}
        edges = ordered if not early and number % EVERY == 0 else []
        edge = edges[number // EVERY % len(edges)] if edges else None
        for symbol in ordered:
            size = sp.S.One if early else draw.choice(SIZES)
            margin = MARGINS[0] if early else draw.choice(MARGINS)
            sign = signs.get(symbol, 1) if early else draw.choice((1, -1))
            if symbol == edge:
                size, margin, sign = SLIVER, SLIVER, 1
            point[symbol] = _value(domains[symbol], point, size * sign, margin, draw)
        number += 1
        if all(domains[s].contains(value, point) for s, value in point.items()):
            rejected = 0
            yield point
        else:
            rejected += 1
    words = ", ".join(domain.text(symbol) for symbol, domain in domains.items())
    raise ValueError(f"domains must hold rational points, got {words} (none was found)")


def _has_both_signs(domain: Domain) -> bool:
    return bool(domain.lower == -sp.oo and (domain.upper == sp.oo or domain.upper.is_positive)) or (
        bool(domain.upper == sp.oo and domain.lower.is_negative)
    )


def _value(
    domain: Domain,
    known: Mapping[sp.Symbol, sp.Rational],
    size: sp.Rational,
    margin: sp.Rational,
    draw: random.Random,
) -> sp.Rational:
    """A value of the domain: a share of a bounded one, a length from the end of another."""
    lower, upper = (_rational(end) for end in domain.ends(known))
    prime = draw.choice(DENOMINATORS)
    share = sp.Rational(draw.randint(1, prime - 1), prime)
    if lower is None:
        value = size * share if upper is None else upper - _length(-upper, size) * share
    elif upper is None:
        value = lower + _length(lower, size) * share
    else:
        edge = margin * (upper - lower)
        value = lower + edge + (upper - lower - 2 * edge) * share
        if margin < MARGINS[0]:
            near = edge * (1 + share)
            value = draw.choice((value, lower + near, upper - near))
    if not domain.integer:
        return sp.Rational(value)
    return sp.Integer(draw.randint(-9, 9) + int(value) if abs(value) <= 9 else int(value))


def _length(end: sp.Rational, size: sp.Rational) -> sp.Rational:
    """How far to go from an end; twice as far as 0 where that is inside and for both signs."""
    return abs(size) if size > 0 or end >= 0 else -2 * end


def _rational(end: sp.Expr) -> sp.Rational | None:
    """A rational number close to a finite end; the margin covers the difference.

    Raises ValueError for an end that is not real.
    """
    if end in (sp.oo, -sp.oo):
        return None
    if end.is_Rational:
        return end
    number = sp.N(end, 20)
    if not number.is_Float:
        raise ValueError(
            f"ends of domains must be real, got {end} (state where what it contains makes it so)"
        )
    return sp.Rational(str(number))
