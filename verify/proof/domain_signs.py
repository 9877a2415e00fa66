"""What the domains say of a formula: the range of its values, its sign, where it may not be smooth.

A range holds every value that the formula takes on the domains; it may be wider than that.  None
says that the formula is not known to be real.

A verdict speaks of the points at which a formula is smooth.  What `singularities` names is not
shown to be smooth everywhere: a denominator not shown to be different from 0, a root or logarithm
of what is not shown to be positive, an absolute value or a sign of what is not shown to be
different from 0, an inverse function at an end of its cuts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction

import sympy as sp
from sympy.functions.special.bessel import BesselBase

from longwave.solutions.functions import (
    jacobi_cn,
    jacobi_dn,
    jacobi_epsilon,
    jacobi_sn,
    jacobi_theta,
    jacobi_zeta,
)
from longwave.solutions.functions.jacobi import JacobiFunction
from longwave.solutions.functions.jet_functions import JetFunction
from longwave.solutions.functions.weierstrass import WeierstrassFunction
from longwave.verify.subexpressions import abbreviated, distinct_nodes

from .domains import INFINITY, Domain, Domains, Number, ValueRange

FACTORABLE_NODES = 20
FACTORABLE_POWER = 8
"""Polynomials with more subexpressions or higher powers are not factored."""

FACTORABLE_SYMBOLS = 2
"""Polynomials in more symbols are not factored to find their sign."""

BELOW_PI = Fraction(31415926, 10**7)

REAL = ValueRange()
ZERO, ONE = Fraction(0), Fraction(1)
POSITIVE = ValueRange(ZERO, INFINITY, True)
NONNEGATIVE = ValueRange(ZERO, INFINITY)
UNIT = ValueRange(-ONE, ONE)


def is_small_polynomial(expression: sp.Expr) -> bool:
    """Whether ``expression`` is a polynomial in symbols, short enough to factor."""
    if not expression.free_symbols:
        return False
    nodes = distinct_nodes(expression)
    return len(nodes) <= FACTORABLE_NODES and all(map(_is_polynomial_node, nodes))


def _is_polynomial_node(node: sp.Expr) -> bool:
    if node.is_Pow:
        return bool(node.exp.is_Integer and 0 < node.exp <= FACTORABLE_POWER)
    return bool(node.is_Add or node.is_Mul or node.is_Symbol or node.is_Rational)


class DomainSigns:
    """Ranges of formulas on ``domains``; a symbol without a domain is real."""

    def __init__(self, domains: Domains) -> None:
        self._domains = domains
        self._gaps = dict(_gaps(domains))
        self._found: dict[sp.Expr, ValueRange | None] = {}

    def range(self, expression: sp.Expr) -> ValueRange | None:
        """A range that holds all values; None if they are not known to be real."""
        if expression not in self._found:
            self._found[expression] = None  # no rule asks for its own node
            self._found[expression] = self._range(expression)
        return self._found[expression]

    def is_real(self, expression: sp.Expr) -> bool:
        """Whether ``expression`` is shown to be real wherever it is smooth."""
        return self.range(expression) is not None

    def is_positive(self, expression: sp.Expr) -> bool:
        """Whether ``expression`` is shown to be positive."""
        found = self.range(expression)
        return found is not None and found.is_positive

    def is_nonnegative(self, expression: sp.Expr) -> bool:
        """Whether ``expression`` is shown to be at least 0."""
        found = self.range(expression)
        return found is not None and found.is_nonnegative

    def is_nonpositive(self, expression: sp.Expr) -> bool:
        """Whether ``expression`` is shown to be at most 0."""
        found = self.range(expression)
        return found is not None and found.is_nonpositive

    def is_nonzero(self, expression: sp.Expr) -> bool:
        """Whether ``expression``, real or not, is shown to be nowhere 0."""
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
        found = self.range(expression)
        return found is not None and found.excludes_zero

    def _range(self, node: sp.Expr) -> ValueRange | None:
        if node.is_Rational:
            value = Fraction(int(node.p), int(node.q))
            return ValueRange(value, value)
        if node.is_Symbol:
            return self._symbol(self._domains.get(node, Domain()))
        if node in CONSTANTS:
            return CONSTANTS[node]
        if node.is_Add:
            return self._sum(node)
        if node.is_Mul:
            return self._product(node)
        if node.is_Pow:
            return self._power(node)
        if isinstance(node, sp.Abs):
            inner = self.range(node.args[0])
            return NONNEGATIVE if inner is None else inner.absolute()
        if isinstance(node, sp.re | sp.im):
            return REAL
        if isinstance(node, sp.conjugate):
            return self.range(node.args[0])
        if isinstance(node, JacobiFunction):
            return self._jacobi(node)
        if isinstance(node, JetFunction | WeierstrassFunction | BesselBase):
            return self._special(node)
        rule = RULES.get(node.func)
        inner = self.range(node.args[0]) if rule else None
        return None if rule is None or inner is None else rule(inner)

    def _symbol(self, domain: Domain) -> ValueRange:
        lower, upper = self._end(domain.lower), self._end(domain.upper)
        return ValueRange(
            -INFINITY if lower is None else lower.lower,
            INFINITY if upper is None else upper.upper,
            domain.lower_open or (lower is not None and lower.lower_open),
            domain.upper_open or (upper is not None and upper.upper_open),
        )

    def _end(self, end: sp.Expr) -> ValueRange | None:
        return None if end in (sp.oo, -sp.oo) else self.range(end)

    def _sum(self, node: sp.Expr) -> ValueRange | None:
        total = ValueRange(ZERO, ZERO)
        for part in node.args:
            inner = self.range(part)
            if inner is None:
                return None
            total = total + inner
        if node in self._gaps and not total.excludes_zero:
            return self._gaps[node]
        small = len(node.free_symbols) <= FACTORABLE_SYMBOLS and is_small_polynomial(node)
        if total.excludes_zero or not small:
            return total
        return self._factored(node) or total

    def _factored(self, node: sp.Expr) -> ValueRange | None:
        """The range of a polynomial's factors; that of a sum without real root in the domain."""
        factored = sp.factor(node)
        if not factored.is_Add and factored != node:
            return self.range(factored)
        symbols = node.free_symbols
        return self._without_root(node, symbols.pop()) if len(symbols) == 1 else None

    def _without_root(self, node: sp.Expr, symbol: sp.Symbol) -> ValueRange | None:
        polynomial = sp.Poly(node, symbol, domain="QQ")
        found = self.range(symbol)
        if found is None:
            return None
        low, high = (_sympy(end) for end in (found.lower, found.upper))
        inner = polynomial.count_roots(
            None if low == -sp.oo else low, None if high == sp.oo else high
        )
        for end, is_open in ((low, found.lower_open), (high, found.upper_open)):
            if is_open and end.is_finite and polynomial(end) == 0:
                inner -= 1
        if inner:
            return None
        return POSITIVE if polynomial(_between(low, high)) > 0 else -POSITIVE

    def _product(self, node: sp.Expr) -> ValueRange | None:
        total = ValueRange(ONE, ONE)
        for part in node.args:
            inner = self.range(part)
            if inner is None:
                return None
            total = total * inner
        return total

    def _power(self, node: sp.Expr) -> ValueRange | None:
        base = self.range(node.base)
        if base is None:
            return None
        if node.exp.is_Integer:
            return base ** int(node.exp)
        if not base.is_nonnegative or not self.is_real(node.exp):
            return None
        if not node.exp.is_Rational:
            return NONNEGATIVE
        return _fractional(base, node.exp)

    def _special(self, node: sp.Expr) -> ValueRange | None:
        """Arbitrary functions, theta functions, those of Weierstrass and Bessel."""
        found = [self.range(inner) for inner in node.args]
        last = found[-1]
        if last is None or None in found:
            return None
        nome = isinstance(node, JetFunction) and len(found) > 1
        if (nome or isinstance(node, BesselBase)) and not (last.is_positive or is_entire(node)):
            return None
        return POSITIVE if isinstance(node, sp.besselk) else REAL

    def _jacobi(self, node: sp.Expr) -> ValueRange | None:
        argument, parameter = (self.range(inner) for inner in node.args)
        if argument is None or parameter is None:
            return None
        if isinstance(node, jacobi_epsilon | jacobi_zeta):
            return REAL if _is_below_one(parameter) else None
        if isinstance(node, jacobi_dn | jacobi_theta):
            return POSITIVE if _is_below_one(parameter) else REAL
        return UNIT if parameter.is_nonnegative and _is_below_one(parameter) else REAL


def is_entire(node: sp.Expr) -> bool:
    """Whether a Bessel function is J or I of an integer order."""
    return isinstance(node, sp.besselj | sp.besseli) and bool(node.order.is_Integer)


def _gaps(domains: Domains) -> Iterator[tuple[sp.Expr, ValueRange]]:
    """The differences of symbols and their ends in other symbols, with their signs."""
    for symbol, domain in domains.items():
        for end, is_open, side in (
            (domain.lower, domain.lower_open, 1),
            (domain.upper, domain.upper_open, -1),
        ):
            if end.free_symbols:
                found = POSITIVE if is_open else NONNEGATIVE
                yield side * (symbol - end), found
                yield side * (end - symbol), -found


def _is_below_one(inner: ValueRange) -> bool:
    return inner.upper < 1 or (inner.upper == 1 and inner.upper_open)


def _fractional(base: ValueRange, exponent: sp.Rational) -> ValueRange:
    """A power of non-negative numbers: the sign, and the place with respect to 1."""
    rising = exponent > 0
    low = ONE if (base.lower >= 1 if rising else base.upper <= 1) else ZERO
    high = ONE if (base.upper <= 1 if rising else base.lower >= 1) else INFINITY
    is_open = low == 0 and (base.is_positive or not rising)
    return ValueRange(low, high, is_open)


def _signed(inner: ValueRange, size: Number = INFINITY) -> ValueRange:
    """The range of an odd rising function between -size and size."""
    low: Number = ZERO if inner.is_nonnegative else -size
    high: Number = ZERO if inner.is_nonpositive else size
    return ValueRange(low, high, low != 0 or inner.is_positive, high != 0 or inner.is_negative)


def _exponential(inner: ValueRange) -> ValueRange:
    low = ONE if inner.is_nonnegative else ZERO
    high: Number = ONE if inner.is_nonpositive else INFINITY
    return ValueRange(low, high, low == 0 or inner.is_positive, high != 1 or inner.is_negative)


def _logarithm(inner: ValueRange) -> ValueRange | None:
    if not inner.is_nonnegative:
        return None
    return _signed(inner + ValueRange(-ONE, -ONE))


def _sign(inner: ValueRange) -> ValueRange:
    low = ONE if inner.is_positive else ZERO if inner.is_nonnegative else -ONE
    high = -ONE if inner.is_negative else ZERO if inner.is_nonpositive else ONE
    return ValueRange(low, high)


def _half_wave(inner: ValueRange) -> ValueRange:
    """The cosine, positive between -pi/2 and pi/2."""
    narrow = inner.lower >= -BELOW_PI / 2 and inner.upper <= BELOW_PI / 2
    return ValueRange(ZERO, ONE, True) if narrow else UNIT


CONSTANTS = {
    sp.pi: ValueRange(Fraction(3), Fraction(4)),
    sp.E: ValueRange(Fraction(2), Fraction(3)),
}

RULES: dict[type, Callable[[ValueRange], ValueRange | None]] = {
    sp.exp: _exponential,
    sp.log: _logarithm,
    sp.sign: _sign,
    sp.sinh: _signed,
    sp.cosh: lambda _: ValueRange(ONE),
    sp.tanh: lambda inner: _signed(inner, ONE),
    sp.sech: lambda _: ValueRange(ZERO, ONE, True),
    sp.coth: _signed,
    sp.csch: _signed,
    sp.sin: lambda inner: _half_wave(inner + ValueRange(-BELOW_PI / 2, -BELOW_PI / 2)),
    sp.cos: _half_wave,
    **dict.fromkeys((sp.tan, sp.cot, sp.sec, sp.csc), lambda _: REAL),
    sp.atan: lambda inner: _signed(inner, Fraction(2)),
    sp.erf: lambda inner: _signed(inner, ONE),
    **dict.fromkeys((sp.airyai, sp.airyaiprime, sp.airybi, sp.airybiprime), lambda _: REAL),
    sp.LambertW: lambda inner: _signed(inner) if inner.is_nonnegative else None,
    sp.asinh: _signed,
    sp.acosh: lambda inner: NONNEGATIVE if inner.lower >= 1 else None,
    sp.asin: lambda inner: _signed(inner, Fraction(2)) if inner.absolute().upper <= 1 else None,
    sp.acos: lambda inner: ValueRange(ZERO, Fraction(4)) if inner.absolute().upper <= 1 else None,
    sp.atanh: lambda inner: _signed(inner) if _is_below_one(inner.absolute()) else None,
    **dict.fromkeys(
        (sp.elliptic_k, sp.elliptic_e), lambda inner: POSITIVE if _is_below_one(inner) else None
    ),
}


def _sympy(end: Number) -> sp.Expr:
    if isinstance(end, Fraction):
        return sp.Rational(end.numerator, end.denominator)
    return sp.oo if end > 0 else -sp.oo


def _between(low: sp.Expr, high: sp.Expr) -> sp.Rational:
    if low == -sp.oo:
        return sp.S.Zero if high == sp.oo else high - 1
    return low + 1 if high == sp.oo else (low + high) / 2


POLES = {sp.tan: sp.cos, sp.sec: sp.cos, sp.cot: sp.sin, sp.csc: sp.sin}
HYPERBOLIC_POLES = (sp.coth, sp.csch)
COMPLEX_POLES = (sp.tanh, sp.sech, jacobi_sn, jacobi_cn, jacobi_dn, jacobi_epsilon, jacobi_zeta)
"""Functions with poles off the real axis alone."""
DEPTH = 3
"""Levels of a subexpression that a line shows."""


def singularities(expressions: Iterable[sp.Expr], domains: Domains) -> tuple[str, ...]:
    """One line for each place where ``expressions`` may fail to be smooth on ``domains``.

    >>> x = sp.Symbol("x", real=True)
    >>> singularities([sp.sqrt(x) / (1 + x**2)], {})
    ('branch point where x is not positive',)
    """
    signs = DomainSigns(domains)
    nodes = (node for expression in expressions for node in distinct_nodes(expression))
    found = (line for node in nodes for line in _lines(node, signs))
    return tuple(dict.fromkeys(found))


def _lines(node: sp.Expr, signs: DomainSigns) -> list[str]:
    plain = node.exp.is_Integer and node.exp.is_positive if node.is_Pow else not node.is_Function
    if plain or not node.free_symbols:
        return []
    lines = []
    if node.is_Pow and node.exp.could_extract_minus_sign() and not signs.is_nonzero(node.base):
        lines.append(f"pole where {_short(node.base)} = 0")
    is_root = node.is_Pow and not node.exp.is_Integer
    if (is_root or isinstance(node, sp.log)) and not signs.is_positive(node.args[0]):
        lines.append(f"branch point where {_short(node.args[0])} is not positive")
    if isinstance(node, sp.Abs | sp.sign) and not signs.is_nonzero(node.args[0]):
        lines.append(f"jump or corner where {_short(node.args[0])} = 0")
    if node.func in POLES:
        lines.append(f"pole where {_short(POLES[node.func](node.args[0]))} = 0")
    if isinstance(node, HYPERBOLIC_POLES) and not signs.is_nonzero(node.args[0]):
        lines.append(f"pole where {_short(sp.sinh(node.args[0]))} = 0")
    if isinstance(node, sp.asin | sp.acos | sp.atanh | sp.acosh) and not _is_off_cuts(node, signs):
        lines.append(f"branch point of {_short(node)}")
    if isinstance(node, sp.LambertW) and not signs.is_nonnegative(node.args[0]):
        lines.append(f"branch point of {_short(node)}")
    if isinstance(node, BesselBase) and not (is_entire(node) or signs.is_positive(node.args[1])):
        lines.append(f"branch point where {_short(node.args[1])} is not positive")
    if isinstance(node, COMPLEX_POLES) and not all(map(signs.is_real, node.args)):
        lines.append(f"poles of {_short(node)}")
    if isinstance(node, WeierstrassFunction):
        lines.append(f"poles of {_short(node)}")
    if isinstance(node, sp.atan | sp.asinh) and not signs.is_real(node.args[0]):
        lines.append(f"branch point of {_short(node)}")
    return lines


def _is_off_cuts(node: sp.Expr, signs: DomainSigns) -> bool:
    """Whether the argument is shown to be off the ends of the cuts."""
    inner = signs.range(node.args[0])
    if inner is None:
        return False
    if isinstance(node, sp.acosh):
        return (inner + ValueRange(-ONE, -ONE)).is_positive
    return _is_below_one(inner.absolute())


def _short(expression: sp.Expr) -> str:
    return abbreviated(expression, DEPTH)
