"""SymPy expressions and residuals in ball arithmetic (python-flint's arb and acb).

Derivatives come from truncated Taylor series in several variables.  A jet holds the Taylor
coefficients ``c[i, j, ...]`` of a function at a point, for a downward closed set of multi-indices.
Every operation is python-flint's, so each ball contains the true coefficient.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, reduce
from math import factorial
from operator import add, mul

import sympy as sp
from flint import acb, arb, ctx, fmpq

from longwave.solutions.functions.jacobi import JacobiFunction
from longwave.solutions.functions.jet_functions import JetFunction
from longwave.solutions.functions.weierstrass import WeierstrassFunction, weierstrass_p_prime

from . import taylor as functions
from .domain_signs import DomainSigns
from .domains import Point
from .text_names import BESSEL

Index = tuple[int, ...]


class JetShape:
    """Set of all multi-indices below the given ones, and the pairs whose sum belongs to it."""

    def __init__(self, tops: Sequence[Index]) -> None:
        indices = {tuple(0 for _ in tops[0])}
        waiting, axes = list(tops), range(len(tops[0]))
        while waiting:
            index = waiting.pop()
            if index not in indices:
                indices.add(index)
                lowered = (tuple(n - (i == axis) for i, n in enumerate(index)) for axis in axes)
                waiting += [inner for inner in lowered if min(inner) >= 0]
        self.indices = sorted(indices, key=lambda index: (sum(index), index))
        self.order = max(map(sum, self.indices))
        positions = {index: i for i, index in enumerate(self.indices)}
        self.products = [
            (i, j, positions[total])
            for i, left in enumerate(self.indices)
            for j, right in enumerate(self.indices)
            if (total := tuple(map(sum, zip(left, right, strict=True)))) in positions
        ]


@dataclass(frozen=True)
class Jet:
    """Taylor coefficients in the order of ``shape.indices``; the first is the value."""

    shape: JetShape
    coefficients: tuple[acb, ...]

    @property
    def value(self) -> acb:
        """The value at the point."""
        return self.coefficients[0]

    def __add__(self, other: Jet) -> Jet:
        pairs = zip(self.coefficients, other.coefficients, strict=True)
        return Jet(self.shape, tuple(a + b for a, b in pairs))

    def __mul__(self, other: Jet) -> Jet:
        total = [acb(0)] * len(self.coefficients)
        for i, j, k in self.shape.products:
            total[k] += self.coefficients[i] * other.coefficients[j]
        return Jet(self.shape, tuple(total))

    def composed(self, taylor: Callable[[acb, int], Sequence[acb]]) -> Jet:
        """Return ``f(self)``; ``taylor(z, n)`` gives the coefficients of f at z up to order n."""
        outer = taylor(self.value, self.shape.order)
        step = Jet(self.shape, (acb(0), *self.coefficients[1:]))
        result = constant(self.shape, outer[-1])
        for coefficient in reversed(outer[:-1]):
            result = result * step + constant(self.shape, coefficient)
        return result

    def conjugate(self) -> Jet:
        """Return the jet of the complex conjugate; the variables are real."""
        return Jet(self.shape, tuple(acb(c.real, -c.imag) for c in self.coefficients))


def constant(shape: JetShape, value: acb) -> Jet:
    """Return a constant as a jet."""
    return Jet(shape, (value,) + (acb(0),) * (len(shape.indices) - 1))


def variable(shape: JetShape, axis: int, value: acb) -> Jet:
    """Return the jet of variable number ``axis``, whose value is ``value``."""
    unit = tuple(int(i == axis) for i in range(len(shape.indices[0])))
    return Jet(shape, (value, *(acb(int(index == unit)) for index in shape.indices[1:])))


NUMBERS = {sp.I: lambda: acb(0, 1), sp.pi: acb.pi, sp.E: lambda: acb(1).exp()}
PERIODIC = (sp.sin, sp.cos, sp.sinh, sp.cosh)
QUOTIENTS = {
    sp.tan: (sp.sin, sp.cos),
    sp.cot: (sp.cos, sp.sin),
    sp.sec: (None, sp.cos),
    sp.csc: (None, sp.sin),
    sp.tanh: (sp.sinh, sp.cosh),
    sp.coth: (sp.cosh, sp.sinh),
    sp.sech: (None, sp.cosh),
    sp.csch: (None, sp.sinh),
}
"""Numerator (None for 1) and denominator of quotient functions."""

SPECIAL = {
    sp.erf: "erf",
    sp.LambertW: "lambertw",
    sp.airyai: "airy_ai",
    sp.airybi: "airy_bi",
    sp.airyaiprime: "airy_ai_prime",
    sp.airybiprime: "airy_bi_prime",
}
"""Names of FLINT's power series for special functions."""

ENTIRE = (sp.exp, sp.erf, sp.airyai, sp.airyaiprime, sp.airybi, sp.airybiprime)
BRANCH_OF_LAMBERT = fmpq(-36, 100)
"""Number above the end -1/e = -0.367... of the branch cut of Lambert's W."""

ORDERS = {kind: name for name, kind in BESSEL.items()}
"""Name in the grammar, for each of SymPy's Bessel functions."""

INVERSE = (sp.asin, sp.acos, sp.atan, sp.asinh, sp.acosh, sp.atanh)
ELEMENTARY = {
    sp.exp: functions.special("exp"),
    sp.log: functions.logarithm,
    **{function: functions.periodic(function.__name__) for function in PERIODIC},
    **{function: functions.special(name) for function, name in SPECIAL.items()},
    **{function: functions.inverse(function.__name__) for function in INVERSE},
}


def touches_cut(function: type, value: acb) -> bool:
    """Return whether a value may lie on a function's branch cut (for a power, on that of log)."""
    if function in ENTIRE:
        return False
    if function is sp.LambertW:
        return bool(value.imag.contains(0)) and not value.real > BRANCH_OF_LAMBERT
    if function in (sp.atan, sp.asinh):
        return bool(value.real.contains(0)) and not abs(value.imag) < 1
    if function in (sp.asin, sp.acos, sp.atanh):
        return bool(value.imag.contains(0)) and not abs(value.real) < 1
    start = 1 if function is sp.acosh else 0
    return bool(value.imag.contains(0)) and not value.real > start


def powered(base: Jet, exponent: Fraction) -> Jet:
    """Return the principal power; integer powers by squaring (24 squares for base**10**7)."""
    if exponent.denominator != 1 or exponent < 0:
        return base.composed(functions.power(exponent))
    if exponent == 0:
        return constant(base.shape, acb(1))
    result = base
    for digit in f"{exponent.numerator:b}"[1:]:
        result = result * result
        result = result * base if digit == "1" else result
    return result


class BallEvaluator:
    """Evaluator of jets at a rational point, at python-flint's working precision."""

    def __init__(
        self,
        shape: JetShape,
        variables: Sequence[sp.Symbol],
        point: Point,
        signs: DomainSigns | None = None,
    ) -> None:
        self._shape = shape
        self._signs = DomainSigns({}) if signs is None else signs
        self._found: dict[sp.Expr, Jet] = {s: constant(shape, exact(v)) for s, v in point.items()}
        for place, symbol in enumerate(variables):
            self._found[symbol] = variable(shape, place, exact(point[symbol]))
        self._elliptic: dict[sp.Expr, functions.Elliptic] = {}

    def jet(self, expression: sp.Expr) -> Jet:
        """Return an expression's jet; raises ValueError if it has no value or is not smooth."""
        if expression not in self._found:
            self._found[expression] = self._jet(expression)
        return self._found[expression]

    def know(self, values: Mapping[sp.Symbol, acb]) -> None:
        """Set the values of symbols to balls, for values that need not be rational."""
        self._found |= {symbol: constant(self._shape, ball) for symbol, ball in values.items()}

    def _jet(self, node: sp.Expr) -> Jet:
        if node.is_Rational:
            return constant(self._shape, exact(node))
        if node in NUMBERS:
            return constant(self._shape, NUMBERS[node]())
        if node.is_Add or node.is_Mul:
            return reduce(add if node.is_Add else mul, map(self.jet, node.args))
        if node.is_Pow and node.base is sp.S.NegativeOne and node.exp.is_integer:
            whole = self.jet(node.exp).value.real.unique_fmpz()
            if whole is None:
                raise ValueError(f"exponents of -1 must be settled integers, got {node.exp}")
            return constant(self._shape, acb(-1 if int(whole) % 2 else 1))
        if node.is_Pow and node.exp.is_Rational:
            if not node.exp.is_Integer:
                self._check_smooth(node, node.base)
            return powered(self.jet(node.base), Fraction(int(node.exp.p), int(node.exp.q)))
        if isinstance(node, sp.conjugate | sp.re | sp.im | sp.Abs | sp.sign):
            return size_jet(node.func.__name__.lower(), self.jet(node.args[0]))
        if isinstance(node, JacobiFunction):
            elliptic = self._parameter(node.args[1])
            taylor = getattr(elliptic, node.func.__name__.removeprefix("jacobi_"))
            return self.jet(node.args[0]).composed(taylor)
        if isinstance(node, sp.elliptic_k | sp.elliptic_e) and len(node.args) == 1:
            m = self._constant(node.args[0])
            return constant(self._shape, getattr(m, node.func.__name__)())
        if node.func in ELEMENTARY and node.func not in PERIODIC:
            self._check_smooth(node, node.args[0])
        return function_jet(node.func, list(map(self.jet, node.args)))

    def _check_smooth(self, node: sp.Expr, inner: sp.Expr) -> None:
        """Raise ValueError if the argument of ``node`` may cross a branch cut."""
        if not inner.free_symbols or not touches_cut(node.func, self.jet(inner).value):
            return
        along = node.is_Pow or isinstance(node, sp.log)
        if along and self._signs.is_real(inner) and not self.jet(inner).value.contains(0):
            return
        raise ValueError(f"points must lie off the cuts, got one on that of {node} (take another)")

    def _parameter(self, m: sp.Expr) -> functions.Elliptic:
        if m not in self._elliptic:
            self._elliptic[m] = functions.Elliptic(self._constant(m))
        return self._elliptic[m]

    def _constant(self, m: sp.Expr) -> acb:
        """Return the value of a parameter, order or invariant; ValueError if it has derivatives."""
        return constant_value(self.jet(m), str(m))


def constant_value(jet: Jet, shown: str = "one with slopes") -> acb:
    """Return the value of a parameter; raises ValueError if it has derivatives."""
    value, *slopes = jet.coefficients
    if not all(slope == 0 for slope in slopes):
        raise ValueError(f"parameters must be constant, got {shown} (hold it fixed)")
    return value


def size_jet(name: str, inner: Jet) -> Jet:
    """Return conjugate, re, im, abs or sign of a jet; ValueError if abs or sign is not smooth."""
    other = inner.conjugate()
    if name == "conjugate":
        return other
    if name in ("re", "im"):
        fraction, sign = (acb(0.5), acb(1)) if name == "re" else (acb(0, -0.5), acb(-1))
        return constant(inner.shape, fraction) * (inner + constant(inner.shape, sign) * other)
    if inner.value.contains(0):
        raise ValueError("points must be smooth, got one where a modulus is 0 (take another)")
    if name == "abs":
        return powered(inner * other, Fraction(1, 2))
    return inner * powered(inner * other, Fraction(-1, 2))


def function_jet(function: type, jets: Sequence[Jet]) -> Jet:
    """Return a function of jets; raises ValueError if it is unknown or not smooth there."""
    if function in ORDERS or issubclass(function, JetFunction | WeierstrassFunction):
        return special_jet(function, jets)
    if function in QUOTIENTS:
        above, below = QUOTIENTS[function]
        inverse = powered(jets[0].composed(ELEMENTARY[below]), Fraction(-1))
        return inverse if above is None else jets[0].composed(ELEMENTARY[above]) * inverse
    if function not in ELEMENTARY or len(jets) > 1:
        got = f"{function.__name__}, stated or SymPy's form of a part"
        raise ValueError(
            f"functions must have ball arithmetic, got {got} (express it by functions that have)"
        )
    return jets[0].composed(ELEMENTARY[function])


def special_jet(function: type, jets: Sequence[Jet]) -> Jet:
    """Return a Weierstrass, Bessel, theta or arbitrary function of jets; ValueError on a cut."""
    z, *others = jets
    if issubclass(function, WeierstrassFunction):
        g2, g3 = map(constant_value, others)
        slopes = int(issubclass(function, weierstrass_p_prime))
        return z.composed(functions.weierstrass(g2, g3, slopes))
    if issubclass(function, JetFunction):
        return _jet_of(function, z, *others)
    order, (argument,) = constant_value(z), others
    entire = function in (sp.besselj, sp.besseli) and order.unique_fmpz() is not None
    if not entire and argument.value.imag.contains(0) and not argument.value.real > 0:
        got = "one on a Bessel function's"
        raise ValueError(f"points must lie off the cuts, got {got} (take another)")
    return argument.composed(functions.bessel(ORDERS[function], order))


def _jet_of(function: type[JetFunction], z: Jet, *nome: Jet) -> Jet:
    """Return the jet of an arbitrary or theta function; theta has f_w = -f_zz/4, w = log q."""
    label, start, at = function.label, function.order, [q.value for q in nome]
    total = z.composed(functions.free(label, start, *at))
    for q in nome:
        if not q.value.real > 0:
            raise ValueError("nomes must be between 0 and 1, got one that is not positive")
        logarithm = q.composed(functions.logarithm).coefficients[1:]
        power = step = Jet(z.shape, (acb(0), *logarithm))
        for n in range(1, z.shape.order + 1):
            power = power * constant(z.shape, acb(-1) / (4 * n))
            slope = z.composed(functions.free(label, start + 2 * n, *at))
            total, power = total + slope * power, power * step
    return total


def exact(value: sp.Rational | Fraction) -> acb:
    """Return a rational number as a ball."""
    return acb(arb(fmpq(int(value.numerator), int(value.denominator))))


def ball_value(
    expression: sp.Expr, point: Point, bits: int, signs: DomainSigns | None = None
) -> acb:
    """Return a ball with the value of an expression at ``point``; ``signs`` tells what is real."""
    with ctx.workprec(bits):
        return BallEvaluator(JetShape([(0,)]), (), point, signs).jet(expression).value


def residual_ball(
    equation: sp.Expr,
    unknown: sp.Expr,
    expression: sp.Expr,
    point: Point,
    bits: int,
    signs: DomainSigns | None = None,
) -> acb:
    """Return a ball with the residual of ``equation`` with ``expression`` for ``unknown``."""
    variables = unknown.args
    flat_equation, symbols, tops, shape = _in_jets(equation, unknown)
    with ctx.workprec(bits):
        jet = BallEvaluator(shape, variables, point, signs).jet(expression)
        coefficients = dict(zip(shape.indices, jet.coefficients, strict=True))
        values = [coefficients[index] * reduce(mul, map(factorial, index)) for index in tops]
        flat = BallEvaluator(JetShape([(0,)]), (), point, signs)
        flat.know(dict(zip(symbols, values, strict=True)))
        return flat.jet(flat_equation).value


@lru_cache(maxsize=4)
def _in_jets(
    equation: sp.Expr, unknown: sp.Expr
) -> tuple[sp.Expr, list[sp.Symbol], list[Index], JetShape]:
    """Return the equation with symbols in place of the unknown and its derivatives.

    Also returned are these symbols, the orders of their derivatives, and the jets' shape."""
    jets = [unknown, *(d for d in equation.atoms(sp.Derivative) if d.expr == unknown)]
    tops = [_index(jet, unknown.args) for jet in jets]
    symbols = [sp.Dummy() for _ in jets]
    flat = equation.xreplace(dict(zip(jets, symbols, strict=True)))
    return flat, symbols, tops, JetShape(tops)


def _index(jet: sp.Expr, variables: Sequence[sp.Symbol]) -> Index:
    pairs = jet.variable_count if isinstance(jet, sp.Derivative) else ()
    counts = {symbol: int(count) for symbol, count in pairs}
    return tuple(counts.get(symbol, 0) for symbol in variables)
