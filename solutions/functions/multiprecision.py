"""Jacobi functions of (z, m) to any precision, in an mpmath context that the caller passes.

The parameter is `m = k**2` (mpmath's order of arguments).  Every function works at the context's
precision, takes complex arguments, and raises the working precision for large `z` and for `m`
near 0 and 1; the global mpmath context is not used.

>>> from mpmath import MPContext
>>> ctx = MPContext()
>>> ctx.dps = 30
>>> print(sn(ctx, 1, ctx.mpf(1) / 4))
0.822635578...
>>> print(dn(ctx, 1, 0.25) ** 2 + sn(ctx, 1, 0.25) ** 2 / 4)
1.0
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial, wraps
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sympy import Expr

Number = Any
"""An `mpf` or `mpc` of some context, or anything its `convert` accepts."""

_GUARD_BITS = 20
_CACHE_SIZE = 512


Implementation = Callable[[Any, Number, Number], Number]
"""Function of an mpmath context, z and m."""


def _guarded(function: Implementation) -> Implementation:
    """Wrap a function to work with the extra bits that large `z`, small `m` or `1 - m` cost."""

    @wraps(function)
    def guarded(ctx: Any, z: Number, m: Number) -> Number:
        z, m = ctx.convert(z), ctx.convert(m)
        extra = _GUARD_BITS + (max(0, ctx.mag(z)) if z else 0)
        extra += sum(max(0, -ctx.mag(x)) for x in (m, ctx.one - m) if x)
        with ctx.workprec(ctx.prec + extra):
            value = function(ctx, z, m)
        return +value

    return guarded


def _theta_argument(ctx: Any, z: Number, m: Number) -> tuple[Number, Number]:
    """Return `(v, q)` with `v = pi z / (2 K)` and the nome `q`."""
    if m == 1:
        raise ValueError(
            "m must satisfy m != 1, got 1 (H and Theta have no limit there; use m < 1)"
        )
    K, q = _integral_and_nome(ctx, ctx.prec, m)
    return ctx.pi * z / (2 * K), q


@lru_cache(maxsize=_CACHE_SIZE)
def _integral_and_nome(ctx: Any, precision: int, m: Number) -> tuple[Number, Number]:
    """Return K and the nome at the context's precision; ``precision`` only enters the cache key."""
    return ctx.ellipk(m), ctx.qfrom(m=m)


@lru_cache(maxsize=_CACHE_SIZE)
def _theta(ctx: Any, precision: int, n: int, v: Number, q: Number, derivative: int = 0) -> Number:
    """Return theta_n(v, q), or a derivative in v, at the context's ``precision``.

    Cached, because sn, cn, dn and epsilon of one phase share theta functions, and all points share
    the constants.
    """
    return ctx.jtheta(n, v, q, derivative)


def _ellipfun(ctx: Any, kind: str, z: Number, m: Number) -> Number:
    """Return sn, cn or dn (``kind``) as theta_a(0)/theta_b(0) theta_c(v)/theta_4(v), DLMF 22.2."""
    if m in (0, 1):
        return ctx.ellipfun(kind, z, m=m)
    a, b, c = {"sn": (3, 2, 1), "cn": (4, 2, 2), "dn": (4, 3, 3)}[kind]
    v, q = _theta_argument(ctx, z, m)
    at = partial(_theta, ctx, ctx.prec)
    return at(a, ctx.zero, q) / at(b, ctx.zero, q) * at(c, v, q) / at(4, v, q)


@_guarded
def sn(ctx: Any, z: Number, m: Number) -> Number:
    """Return Jacobi's sn(z | m)."""
    return _ellipfun(ctx, "sn", z, m) if z else ctx.zero


@_guarded
def cn(ctx: Any, z: Number, m: Number) -> Number:
    """Return Jacobi's cn(z | m)."""
    return _ellipfun(ctx, "cn", z, m)


@_guarded
def dn(ctx: Any, z: Number, m: Number) -> Number:
    """Return Jacobi's dn(z | m)."""
    return _ellipfun(ctx, "dn", z, m)


def _zeta(ctx: Any, z: Number, m: Number) -> Number:
    if m == 1:
        return ctx.tanh(z)
    v, q = _theta_argument(ctx, z, m)
    slope = ctx.pi / (2 * _integral_and_nome(ctx, ctx.prec, m)[0])
    return slope * _theta(ctx, ctx.prec, 4, v, q, 1) / _theta(ctx, ctx.prec, 4, v, q)


@_guarded
def zeta(ctx: Any, z: Number, m: Number) -> Number:
    """Return Jacobi's zeta function Z(z | m) = Theta'(z) / Theta(z), of period 2 K."""
    return _zeta(ctx, z, m)


@_guarded
def epsilon(ctx: Any, z: Number, m: Number) -> Number:
    """Return Jacobi's epsilon function, the integral of dn^2 from 0 to z, as Z(z) + z E / K."""
    slope = 0 if m == 1 else ctx.ellipe(m) / _integral_and_nome(ctx, ctx.prec, m)[0]
    return _zeta(ctx, z, m) + slope * z


@_guarded
def eta(ctx: Any, z: Number, m: Number) -> Number:
    """Return Jacobi's H(z | m) = theta_1(pi z / (2 K), q). Raises ValueError at m = 1 (q = 1)."""
    return _theta(ctx, ctx.prec, 1, *_theta_argument(ctx, z, m)) if z else ctx.zero


@_guarded
def theta(ctx: Any, z: Number, m: Number) -> Number:
    """Return Jacobi's Theta(z | m) = theta_4(pi z / (2 K), q). Raises ValueError at m = 1."""
    return _theta(ctx, ctx.prec, 4, *_theta_argument(ctx, z, m))


IMPLEMENTATIONS = {f"jacobi_{f.__name__}": f for f in (sn, cn, dn, epsilon, zeta, eta, theta)}
"""Name of the SymPy function class -> implementation(ctx, z, m)."""


@lru_cache(maxsize=32)
def _functions(ctx: Any) -> dict[str, Callable[..., Number]]:
    """Return the functions of an mpmath context by the names that SymPy prints."""
    names = {name: getattr(ctx, name) for name in dir(ctx) if not name.startswith("_")}
    names |= {"elliptic_k": ctx.ellipk, "elliptic_e": ctx.ellipe, "Abs": ctx.fabs}
    names |= {"conjugate": ctx.conj}
    return names | {name: partial(f, ctx) for name, f in IMPLEMENTATIONS.items()}


@dataclass(frozen=True)
class MpmathFormula:
    """Expressions as straight-line code that runs in any mpmath context.

    An instruction is an operation and its operands: integers, or indices of earlier values (the
    arguments come first). All of it is plain data. All values are computed inside the context.

    >>> from mpmath import MPContext
    >>> from sympy import Rational, symbols, sqrt
    >>> from longwave.solutions.functions import jacobi_sn
    >>> z = symbols("z")
    >>> ctx = MPContext()
    >>> ctx.dps = 40
    >>> print(MpmathFormula.of([z], [sqrt(z) * jacobi_sn(z, Rational(1, 3))])(ctx, ctx.mpf(2))[0])
    1.380710253...
    """

    arguments: int
    code: Sequence[Sequence[Any]]
    results: Sequence[int]

    @classmethod
    def of(
        cls,
        arguments: Sequence[Expr],
        expressions: Sequence[Expr],
        statements: Iterable[tuple[Expr, Expr]] = (),
    ) -> MpmathFormula:
        """Return the formula of ``expressions``, whose symbols ``statements`` may define."""
        indices: dict[Expr, int] = {argument: n for n, argument in enumerate(arguments)}
        code: list[Sequence[Any]] = []

        def index_of(node: Expr) -> int:
            if node not in indices:
                instruction = _instruction(node, index_of)
                indices[node] = len(arguments) + len(code)
                code.append(instruction)
            return indices[node]

        for symbol, expression in statements:
            indices[symbol] = index_of(expression)
        return cls(len(arguments), code, [index_of(expression) for expression in expressions])

    def __call__(self, ctx: Any, *values: Number) -> list[Number]:
        """Return the values of the expressions at the context's precision.

        Raises NameError for a function without an implementation.
        """
        functions, known = _functions(ctx), list(values)
        for operation, *operands in self.code:
            known.append(_value(ctx, functions, operation, operands, known))
        return [known[index] for index in self.results]


def _instruction(node: Expr, index_of: Callable[[Expr], int]) -> Sequence[Any]:
    if node.is_Rational:
        return "rational", int(node.p), int(node.q)
    if node.is_Float:
        return "float", *map(int, node._mpf_)
    if node.is_Add or node.is_Mul:
        return "+" if node.is_Add else "*", *map(index_of, node.args)
    if node.is_Pow and node.exp.is_Integer:
        return "integer power", index_of(node.base), int(node.exp)
    if node.is_Pow and node.exp.is_Rational and node.exp.q == 2:
        return "half power", index_of(node.base), int(node.exp.p)
    if node.is_Pow:
        return "power", *map(index_of, node.args)
    if node.is_Atom:
        return "constant", str(node)
    return node.func.__name__, *map(index_of, node.args)


def _value(
    ctx: Any, functions: Mapping[str, Any], operation: str, operands: list[Any], known: list[Number]
) -> Number:
    match operation:
        case "rational":
            return ctx.mpf(operands[0]) / operands[1]
        case "float":
            return ctx.make_mpf(tuple(operands))
        case "constant":
            return _constant(ctx, operands[0])
        case "+":
            return sum((known[i] for i in operands[1:]), known[operands[0]])
        case "*":
            return math.prod((known[i] for i in operands[1:]), start=known[operands[0]])
        case "integer power":
            return known[operands[0]] ** operands[1]
        case "half power":
            return ctx.sqrt(known[operands[0]]) ** operands[1]
        case "power":
            return ctx.power(*(known[i] for i in operands))
    if operation not in functions:
        raise NameError(f"functions must have values in mpmath, got {operation} (add it)")
    return functions[operation](*(known[i] for i in operands))


def _constant(ctx: Any, name: str) -> Number:
    constants = {"pi": "pi", "E": "e", "I": "j", "EulerGamma": "euler", "GoldenRatio": "phi"}
    if name not in constants:
        raise NameError(f"symbols must have values, got {name} (give it one)")
    return +getattr(ctx, constants[name])
