"""Range, sign and possible singularities of a formula, derived from the domains of its symbols.

A range contains every value that the formula takes on the domains; it may be wider.  None means
that the formula is not known to be real.

A verdict is about the points at which a formula is smooth.  `singularities` names the places that
are not shown to be smooth: a denominator, absolute value or sign whose argument is not shown to be
nonzero, a root or logarithm whose argument is not shown to be positive, and an inverse function at
an end of its cuts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import reduce
from itertools import product
from operator import add, and_, mul

import sympy as sp
from flint import fmpq
from sympy.functions.special.bessel import BesselBase

from longwave.solutions.functions import (
    jacobi_cn,
    jacobi_dn,
    jacobi_epsilon,
    jacobi_sn,
    jacobi_zeta,
)
from longwave.solutions.functions.jet_functions import JetFunction
from longwave.solutions.functions.weierstrass import WeierstrassFunction
from longwave.verify.kernel.axioms import FUNCTIONS, HALF_PI
from longwave.verify.kernel.bounds import POSITIVE, UNIT, Interval
from longwave.verify.subexpressions import abbreviated, distinct_nodes

from .certificate_writer import NAMES
from .domains import Domain, Domains
from .factors import exact, rational

FACTORABLE_NODES = 20
"""Most distinct subexpressions of a polynomial that is factored."""

FACTORABLE_POWER = 8
"""Highest power in a polynomial that is factored."""

FACTORABLE_SYMBOLS = 2
"""Most symbols of a polynomial that is factored to find its sign."""

LARGEST_POWER = 64
"""Highest power whose range is computed; above it only the sign is."""

REAL, NONNEGATIVE = Interval(), Interval(fmpq(0))
ZERO, ONE = Interval(fmpq(0), fmpq(0)), Interval(fmpq(1), fmpq(1))
BELOW_PI = 2 * HALF_PI


def is_small_polynomial(expression: sp.Expr) -> bool:
    """Return whether ``expression`` is a polynomial in symbols, short enough to factor."""
    if not expression.free_symbols:
        return False
    nodes = distinct_nodes(expression)
    return len(nodes) <= FACTORABLE_NODES and all(map(_is_polynomial_node, nodes))


def _is_polynomial_node(node: sp.Expr) -> bool:
    if node.is_Pow:
        return bool(node.exp.is_Integer and 0 < node.exp <= FACTORABLE_POWER)
    return bool(node.is_Add or node.is_Mul or node.is_Symbol or node.is_Rational)


def point_range(value: sp.Rational) -> Interval:
    """Return the interval that contains just a rational number."""
    return Interval(exact(value), exact(value))


class DomainSigns:
    """Ranges of formulas on ``domains``; a symbol without a domain is real."""

    def __init__(self, domains: Domains) -> None:
        self._domains = domains
        self._gaps = dict(_gaps(domains))
        self._found: dict[sp.Expr, Interval | None] = {}

    def range(self, expression: sp.Expr) -> Interval | None:
        """Return an interval that contains all values; None if they are not known to be real."""
        if expression not in self._found:
            self._found[expression] = None  # ends a recursion into the same node
            self._found[expression] = self._range(expression)
        return self._found[expression]

    def is_real(self, expression: sp.Expr) -> bool:
        """Return whether ``expression`` is shown to be real wherever it is smooth."""
        return self.range(expression) is not None

    def is_positive(self, expression: sp.Expr) -> bool:
        """Return whether ``expression`` is shown to be positive."""
        return (self.range(expression) or REAL).is_positive

    def is_nonnegative(self, expression: sp.Expr) -> bool:
        """Return whether ``expression`` is shown to be at least 0."""
        return (self.range(expression) or REAL).is_not_negative

    def is_nonpositive(self, expression: sp.Expr) -> bool:
        """Return whether ``expression`` is shown to be at most 0."""
        return (-(self.range(expression) or REAL)).is_not_negative

    def is_nonzero(self, expression: sp.Expr) -> bool:
        """Return whether ``expression``, real or not, is shown to be nowhere 0."""
        if expression in self._domains and self._domains[expression].nonzero:
            return True
        if expression.is_Mul:
            return all(map(self.is_nonzero, expression.args))
        if expression.is_Pow and expression.exp.is_Rational:
            return self.is_nonzero(expression.base)
        if isinstance(expression, sp.exp) or expression is sp.I:
            return True
        if isinstance(expression, sp.Abs | sp.conjugate):
            return self.is_nonzero(expression.args[0])
        return (self.range(expression) or REAL).is_not_zero

    def _range(self, node: sp.Expr) -> Interval | None:
        if node.is_Rational:
            return point_range(node)
        if node.is_Symbol:
            return self._symbol(self._domains.get(node, Domain()))
        if isinstance(node, sp.re | sp.im):
            return REAL
        ranges = [self.range(inner) for inner in node.args]
        known = [inner for inner in ranges if inner is not None]
        if isinstance(node, sp.Abs):
            return known[0].absolute() if known else NONNEGATIVE
        if len(known) < len(ranges):
            return None
        if node in CONSTANTS:
            return CONSTANTS[node]
        if node.is_Add:
            return self._sum(node, reduce(add, known))
        if node.is_Mul:
            return reduce(_times, known)
        if node.is_Pow:
            return _power(known[0], node.exp)
        return known[0] if isinstance(node, sp.conjugate) else _function(node, known)

    def _symbol(self, domain: Domain) -> Interval:
        lower, upper = (self.range(end) or REAL for end in (domain.lower, domain.upper))
        opens = domain.lower_open or lower.low_open, domain.upper_open or upper.high_open
        return Interval(lower.low, upper.high, *opens)

    def _sum(self, node: sp.Expr, total: Interval) -> Interval:
        if node in self._gaps and not total.is_not_zero:
            return self._gaps[node]
        if not total.is_not_zero:
            total = reduce(and_, self._beside_ends(node), total)
        small = len(node.free_symbols) <= FACTORABLE_SYMBOLS and is_small_polynomial(node)
        if total.is_not_zero or not small:
            return total
        return self._factored(node) or total

    def _beside_ends(self, node: sp.Expr) -> Iterator[Interval]:
        """Yield ranges of r*(symbol - bound) + c, or of r*(exp(z) - 1) with z > 0, for r > 0.

        None is yielded if ``node`` is of neither form."""
        excess = excess_of_exponential(node)
        if excess is not None and self.is_positive(excess[1].args[0]):
            yield POSITIVE
        for gap, gap_range in self._gaps.items():
            symbol = next(iter(gap.free_symbols), None)
            slope = gap.coeff(symbol, 1) if gap.free_symbols <= node.free_symbols else 0
            ratio = node.coeff(symbol, 1) / slope if slope else sp.S.Zero
            if ratio.is_Rational and ratio > 0:
                rest = sp.expand(node - ratio * gap)
                if rest.is_Rational:
                    yield gap_range * point_range(ratio) + point_range(rest)

    def _factored(self, node: sp.Expr) -> Interval | None:
        """Return the range of a polynomial from its factors, or its sign if it has no root."""
        factored = sp.factor(node)
        if not factored.is_Add and factored != node:
            return self.range(factored)
        symbols = node.free_symbols
        return self._without_root(node, symbols.pop()) if len(symbols) == 1 else None

    def _without_root(self, node: sp.Expr, symbol: sp.Symbol) -> Interval | None:
        polynomial = sp.Poly(node, symbol, domain="QQ")
        values = self.range(symbol)
        if values is None:
            return None
        low, high = domain_of(values).ends({})
        limits = None if low == -sp.oo else low, None if high == sp.oo else high
        inner = polynomial.count_roots(*limits)
        for end, is_open in ((low, values.low_open), (high, values.high_open)):
            if is_open and end.is_finite and polynomial(end) == 0:
                inner -= 1
        if inner:
            return None
        return POSITIVE if polynomial(_between(low, high)) > 0 else -POSITIVE


def excess_of_exponential(node: sp.Expr) -> tuple[sp.Rational, sp.exp] | None:
    """Return r and exp(z) of a sum r*(exp(z) - 1) with r > 0; None for any other node.

    >>> excess_of_exponential(sp.exp(sp.Symbol("x")) - 2)
    (2, exp(x - log(2)))
    """
    number, rest = node.as_coeff_Add(rational=True)
    times, power = rest.as_coeff_Mul(rational=True)
    if not (isinstance(power, sp.exp) and number < 0 < times):
        return None
    z = sp.expand(power.args[0] - sp.log(-number / times, evaluate=False))
    return -number, sp.exp(z, evaluate=False)


def is_entire(node: sp.Expr) -> bool:
    """Return whether a node is a Bessel function J or I of integer order."""
    return isinstance(node, sp.besselj | sp.besseli) and bool(node.order.is_Integer)


def _gaps(domains: Domains) -> Iterator[tuple[sp.Expr, Interval]]:
    """Yield differences between a symbol and its bound that is not rational, with their ranges."""
    for symbol, domain in domains.items():
        ends = (domain.lower, domain.lower_open, 1), (domain.upper, domain.upper_open, -1)
        for end, is_open, side in ends:
            if end.is_finite and not end.is_Rational:
                sign_range = POSITIVE if is_open else NONNEGATIVE
                yield side * (symbol - end), sign_range
                yield side * (end - symbol), -sign_range


def lies_between(values: Interval | None, low: fmpq | None, high: fmpq | None) -> bool:
    """Return whether a range is real and within two numbers (None: unbounded)."""
    return values is not None and values & Interval(low, high) == values & REAL


def _is_below_one(inner: Interval) -> bool:
    return (ONE + -inner).is_positive


def _halves(inner: Interval) -> list[Interval]:
    """Split an interval at 0, so that products of the parts have the narrowest ranges."""
    if inner.is_not_negative or inner.is_below:
        return [inner]
    return [inner & NONNEGATIVE, inner & -NONNEGATIVE]


def _hull(parts: Sequence[Interval]) -> Interval:
    """Return the smallest interval that contains the given ones."""
    return _from_least(parts) & -_from_least([-part for part in parts])


def _from_least(parts: Sequence[Interval]) -> Interval:
    """Return the half-line upwards from the smallest lower end of the intervals ``parts``."""
    low, is_open = min((part.ends[0] for part in parts), key=lambda end: (end[0] is not None, *end))
    return Interval(low, None, is_open)


def _times(left: Interval, right: Interval) -> Interval:
    return _hull([a * b for a, b in product(_halves(left), _halves(right))])


def _power(base: Interval, exponent: sp.Expr) -> Interval | None:
    """Return the range of a power where it is smooth, without base 0 for a negative exponent."""
    if not (exponent.is_Integer or base.is_not_negative):
        return None
    if not exponent.is_Rational:
        return NONNEGATIVE
    if exponent < 0 and base == ZERO:
        return None
    halves, times = _halves(base if exponent.is_Integer else base.root()), abs(int(exponent.p))
    if exponent < 0:
        halves = [half & (-POSITIVE if half.is_below else POSITIVE) for half in halves]
    long = times > LARGEST_POWER
    result = _hull([h.power(times) if long else reduce(mul, [h] * times) for h in halves])
    return result if exponent > 0 else result.inverse()


def _function(node: sp.Expr, arguments: Sequence[Interval]) -> Interval | None:
    """Return the range of a function at real arguments, from the checker's table."""
    name = NAMES.get(node.func)
    if isinstance(node, JetFunction):
        name = "theta" if len(arguments) > 1 else "jet"
    own = FUNCTIONS.get(name or "")
    if own is None or own.values is None or len(arguments) != len(own.letters):
        return None
    z = arguments[own.letters.find("z")]
    parameters = [arguments[place] for place in own.parameters(*range(len(arguments)))]
    if not (is_entire(node) or lies_between(z, *own.between)):
        return None
    if own.below_one and not all(map(_is_below_one, parameters)):
        return None
    if own.above_zero and not all(m.is_positive for m in parameters):
        return None
    values = own.values & z.side() if own.symmetry == "same" else own.values
    if isinstance(node, jacobi_dn) and _is_below_one(parameters[0]):
        return POSITIVE
    return values & SHARPER[node.func](z) if node.func in SHARPER else values


CONSTANTS = {sp.pi: Interval(fmpq(3), fmpq(4)), sp.E: Interval(fmpq(2), fmpq(3))}

SHARPER: dict[type, Callable[[Interval], Interval]] = {
    sp.exp: Interval.exponential,
    sp.log: lambda z: (z + -ONE).side(),
    sp.sign: lambda z: ONE if z.is_positive else -ONE if (-z).is_positive else UNIT,
    sp.sin: lambda z: z.side() if lies_between(z, fmpq(0), BELOW_PI) else UNIT,
    sp.cos: lambda z: POSITIVE if lies_between(z, -HALF_PI, HALF_PI) else UNIT,
    **dict.fromkeys((sp.atan, sp.asin), lambda z: Interval(fmpq(-2), fmpq(2), True, True)),
    sp.acos: lambda z: Interval(fmpq(0), fmpq(4)),
    sp.LambertW: lambda z: z.side(),
}
"""Functions that map the range of z to a range narrower than that in the checker's table."""


def domain_of(values: Interval) -> Domain:
    """Return an interval as the domain of a symbol."""
    low = -sp.oo if values.low is None else rational(values.low)
    high = sp.oo if values.high is None else rational(values.high)
    return Domain(low, high, values.low_open, values.high_open)


def _between(low: sp.Expr, high: sp.Expr) -> sp.Rational:
    if low == -sp.oo:
        return sp.S.Zero if high == sp.oo else high - 1
    return low + 1 if high == sp.oo else (low + high) / 2


POLES = {sp.tan: sp.cos, sp.sec: sp.cos, sp.cot: sp.sin, sp.csc: sp.sin}
HYPERBOLIC_POLES = (sp.coth, sp.csch)
COMPLEX_POLES = (sp.tanh, sp.sech, jacobi_sn, jacobi_cn, jacobi_dn, jacobi_epsilon, jacobi_zeta)
"""Functions whose poles are all off the real axis."""
DEPTH = 3
"""Nesting depth to which a printed line shows a subexpression."""


def singularities(expressions: Iterable[sp.Expr], domains: Domains) -> tuple[str, ...]:
    """Return one line for each place where ``expressions`` may not be smooth on ``domains``.

    >>> x = sp.Symbol("x", real=True)
    >>> singularities([sp.sqrt(x) / (1 + x**2)], {})
    ('branch point where x is not positive',)
    """
    signs = DomainSigns(domains)
    places = (
        words.format(abbreviated(node if argument is None else node.args[argument], DEPTH))
        for expression in expressions
        for node in distinct_nodes(expression)
        for words, argument in rough_places(node, signs)
    )
    return tuple(dict.fromkeys(places))


def corners(
    expressions: Iterable[sp.Expr], domains: Domains, variables: Sequence[sp.Symbol]
) -> tuple[str, ...]:
    """Return conditions under which arguments of abs, sign and roots with a variable may be 0.

    >>> x, c = sp.symbols("x c", real=True)
    >>> corners([sp.sign(x - 1) * sp.Abs(c)], {}, [x])
    ('x - 1 = 0',)
    """
    signs = DomainSigns(domains)
    nodes = (node for expression in expressions for node in distinct_nodes(expression))
    inner = (
        node.args[0]
        for node in nodes
        if isinstance(node, sp.Abs | sp.sign)
        or (node.is_Pow and node.base is not sp.E and not node.exp.is_Integer)
    )
    may_be_zero = (f for f in inner if f.has(*variables) and not signs.is_nonzero(f))
    return tuple(dict.fromkeys(f"{abbreviated(f, DEPTH)} = 0" for f in may_be_zero))


JUMP = "jump or corner"

CORNER = f"{JUMP} where {{}} = 0"
"""Template for the jumps and corners of abs and sign; the argument goes into the braces."""

Place = tuple[str, int | None]
"""Template of a line, and the index of the argument that fills it (None: the whole node)."""


def rough_places(node: sp.Expr, signs: DomainSigns) -> Iterator[Place]:
    """Yield the places at which a node may not be smooth although its arguments are."""
    if (node.is_Pow or node.is_Function) and node.free_symbols:
        yield from _of_power(node, signs) if node.is_Pow else _of_function(node, signs)


def _of_power(node: sp.Expr, signs: DomainSigns) -> Iterator[Place]:
    base, exponent = node.args
    if not base.free_symbols:
        return
    falls = exponent.could_extract_minus_sign() or not (exponent.is_Rational or exponent.is_real)
    if exponent.is_integer and not exponent.is_Integer:
        falls = not exponent.is_nonnegative
    if falls and not signs.is_nonzero(base):
        yield "pole where {} = 0", 0
    if not (exponent.is_integer or signs.is_positive(base)):
        yield "branch point where {} is not positive", 0


def _of_function(node: sp.Expr, signs: DomainSigns) -> Iterator[Place]:
    argument = node.args[0]
    if isinstance(node, sp.log) and not signs.is_positive(argument):
        yield "branch point where {} is not positive", 0
    if isinstance(node, sp.Abs | sp.sign) and not signs.is_nonzero(argument):
        yield CORNER, 0
    if node.func in POLES:
        yield f"pole where {POLES[node.func].__name__}({{}}) = 0", 0
    if isinstance(node, HYPERBOLIC_POLES) and not signs.is_nonzero(argument):
        yield "pole where sinh({}) = 0", 0
    if isinstance(node, sp.asin | sp.acos | sp.atanh | sp.acosh) and not _is_off_cuts(node, signs):
        yield "branch point of {}", None
    if isinstance(node, sp.LambertW) and not signs.is_nonnegative(argument):
        yield "branch point of {}", None
    if isinstance(node, BesselBase) and not (is_entire(node) or signs.is_positive(node.args[1])):
        yield "branch point where {} is not positive", 1
    if isinstance(node, COMPLEX_POLES) and not all(map(signs.is_real, node.args)):
        yield "poles of {}", None
    if isinstance(node, WeierstrassFunction):
        yield "poles of {}", None
    if isinstance(node, sp.atan | sp.asinh) and not signs.is_real(argument):
        yield "branch point of {}", None


def _is_off_cuts(node: sp.Expr, signs: DomainSigns) -> bool:
    """Return whether an inverse function's argument is shown to avoid the ends of its cuts."""
    inner = signs.range(node.args[0])
    if inner is None:
        return False
    if isinstance(node, sp.acosh):
        return (inner + -ONE).is_positive
    return _is_below_one(inner.absolute())
