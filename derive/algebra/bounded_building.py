"""SymPy expressions from parts that a user wrote, built only if the result stays small.

SymPy evaluates while it builds: ``9**9**9``, ``exp(10**9*log(9))`` or the sign of a tower of
exponentials never finish.  Each function here checks its parts first and raises `TooLarge`
beyond what a printed formula contains.
"""

import cmath
import math
from collections.abc import Callable, Sequence
from itertools import islice

import sympy as sp

MOST_BITS = 1000
"""Most bits of an exact number, numerator and denominator together: about 300 digits."""

LARGEST_EXPONENT = 1000
"""Largest numerator or denominator of an exponent."""

MOST_FACTORS, MOST_TERMS = 200, 6000
"""Most factors of a product, and most terms of a sum. SymPy's time is quadratic in the factors."""

MOST_EXPANDED = 2000
"""Most terms into which abs, sign, re or im of an argument may be multiplied out."""

FIRST_STEPS, MOST_NODES_FIRST, MOST_NODES_LATER = 2, 20_000, 2000
"""The first ``FIRST_STEPS`` derivatives of an expression may have ``MOST_NODES_FIRST`` nodes, later
ones ``MOST_NODES_LATER``. The second derivative of log tau of a 4-soliton has 3191 nodes."""

HIGHEST_DERIVATIVE = 16
"""Highest order of a derivative."""

LARGEST_GROWTH = 1e6
"""Largest constant argument of an exponential, hyperbolic or trigonometric function."""

MOST_LOG_BITS = 32
"""Most bits of a number whose logarithm is in an exponent: SymPy turns exp(n log(a)) into a**n."""

GROWING = (sp.exp, sp.sinh, sp.cosh, sp.tanh, sp.coth, sp.sech, sp.csch)
OSCILLATING = (sp.sin, sp.cos, sp.tan, sp.cot, sp.sec, sp.csc)
MULTIPLIED_OUT = (sp.Abs, sp.re, sp.im, sp.sign)

_VALUES: dict[type, Callable[[complex], complex]] = {
    **{getattr(sp, n): getattr(cmath, n) for n in ("exp", "log", "sin", "cos", "tan", "atan")},
    sp.sinh: cmath.sinh,
    sp.cosh: cmath.cosh,
    sp.Abs: abs,
    sp.sec: lambda z: 1 / cmath.cos(z),
    sp.csc: lambda z: 1 / cmath.sin(z),
    sp.cot: lambda z: 1 / cmath.tan(z),
    sp.coth: lambda z: 1 / cmath.tanh(z),
    sp.csch: lambda z: 1 / cmath.sinh(z),
}
"""SymPy function -> the same function of a Python complex number."""


class TooLarge(ValueError):
    """Error for an expression that would be too large or is not finite."""


def total(terms: Sequence[sp.Expr]) -> sp.Expr:
    """Return the sum of the terms. Raises TooLarge if it would be too large.

    >>> x = sp.Symbol("x")
    >>> total([x, sp.Integer(2), x])
    2*x + 2
    """
    if len(terms) == 1:
        return terms[0]
    _check_bits(sum(_bits(term) for term in terms if term.is_Rational))
    result = sp.Add(*terms)
    if len(result.args) > MOST_TERMS:
        raise TooLarge(f"sums must have at most {MOST_TERMS} terms, got {len(result.args)}")
    return _finite(result)


def product(factors: Sequence[sp.Expr]) -> sp.Expr:
    """Return the product of the factors. Raises TooLarge if it would be too large."""
    if len(factors) == 1:
        return factors[0]
    count = sum(len(sp.Mul.make_args(factor)) for factor in factors)
    if count > MOST_FACTORS:
        raise TooLarge(f"products must have at most {MOST_FACTORS} factors, got {count}")
    _check_bits(sum(_bits(factor) for factor in factors))
    result = sp.Mul(*factors)
    for factor in sp.Mul.make_args(result):
        if not isinstance(factor, sp.exp):
            _check_exponent(factor.as_base_exp()[1])
    return _finite(result)


def power(base: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    """Return ``base**exponent``. Raises TooLarge if a number in it could exceed `MOST_BITS` bits.

    >>> power(sp.Integer(9), sp.Rational(1, 2))
    3
    >>> power(sp.Integer(9), sp.Integer(9) ** 9)
    Traceback (most recent call last):
    ...
    longwave.derive.algebra.bounded_building.TooLarge: exponents must be at most 1000
    """
    if base.is_zero and exponent.is_negative:
        raise TooLarge("denominators must not be 0")
    _check_exponent(exponent)
    if exponent.is_Rational:
        _check_bits(_bits(base) * (abs(exponent.p) // exponent.q + 1))
        if base.is_number and not base.is_Rational and exponent.is_Integer:
            _check_bits(sum(_bits(n) for n in base.atoms(sp.Rational)) * abs(int(exponent)))
    else:
        _check_logarithms(exponent)
    result = sp.Pow(base, exponent)
    _check_exponent(result.as_base_exp()[1])
    return _finite(result)


def applied(function: Callable[..., sp.Expr], arguments: Sequence[sp.Expr]) -> sp.Expr:
    """Return ``function(*arguments)``. Raises TooLarge if SymPy might not finish."""
    if function is sp.exp:
        _check_logarithms(arguments[0])
    if function in MULTIPLIED_OUT and 2 * _expanded(arguments[0]) ** 2 > MOST_EXPANDED:
        raise TooLarge(f"the argument would be multiplied out to more than {MOST_EXPANDED} terms")
    if function in GROWING or function in OSCILLATING:
        for argument in arguments:
            if argument.is_number and not abs(_value(argument)) <= LARGEST_GROWTH:
                raise TooLarge(f"constants in its argument must be at most {LARGEST_GROWTH:.0e}")
    if function is sp.sqrt:
        return power(arguments[0], sp.S.Half)
    if function is sp.sign and _is_complex(arguments[0]):
        return arguments[0] / sp.Abs(arguments[0])
    return _finite(function(*arguments))


def _is_complex(z: sp.Expr) -> bool:
    """Return whether a formula may be non-real, where SymPy's sign(z)**2 = 1 would be wrong."""
    return not (z.is_extended_real or z.is_zero) and (z.has(sp.I) or z.is_zero is False)


def derivative(expression: sp.Expr, variables: Sequence[sp.Symbol]) -> sp.Expr:
    """Differentiate the expression in the variables, one after the other.

    >>> x = sp.Symbol("x")
    >>> derivative(x**3, [x, x])
    6*x
    """
    if len(variables) > HIGHEST_DERIVATIVE:
        order = len(variables)
        raise TooLarge(f"derivatives must have order {HIGHEST_DERIVATIVE} at most, got {order}")
    result = without_sizes(expression)
    for step, variable in enumerate(variables):
        limit = MOST_NODES_FIRST if step < FIRST_STEPS else MOST_NODES_LATER
        nodes = islice(sp.preorder_traversal(result), limit + 1)
        if not result.is_Derivative and sum(1 for _ in nodes) > limit:
            raise TooLarge(f"derivatives must have at most {limit} parts on the way")
        result = sp.diff(result, variable)
    return result


def without_sizes(expression: sp.Expr) -> sp.Expr:
    """Return the expression with abs, sign, re and im of non-real parts written with conjugates.

    The results have derivatives in real variables; SymPy differentiates ``sign`` as if its
    argument were real.

    >>> u = sp.Function("u")(sp.Symbol("x", real=True))
    >>> without_sizes(abs(u) ** 2), without_sizes(sp.re(u))
    (u(x)*conjugate(u(x)), u(x)/2 + conjugate(u(x))/2)
    """
    images: dict[sp.Basic, sp.Basic] = {}

    def image(node: sp.Basic) -> sp.Basic:
        if node not in images:
            parts = [image(part) for part in node.args]
            complex_size = isinstance(node, MULTIPLIED_OUT) and not node.args[0].is_extended_real
            is_unchanged = all(new is old for new, old in zip(parts, node.args, strict=True))
            rebuilt = node if is_unchanged else node.func(*parts)
            images[node] = SIZES[node.func](parts[0]) if complex_size else rebuilt
        return images[node]

    return sp.sympify(image(expression)) if expression.has(*MULTIPLIED_OUT) else expression


SIZES: dict[type, Callable[[sp.Expr], sp.Expr]] = {
    sp.Abs: lambda f: sp.sqrt(f * sp.conjugate(f)),
    sp.sign: lambda f: f / sp.sqrt(f * sp.conjugate(f)),
    sp.re: lambda f: (f + sp.conjugate(f)) / 2,
    sp.im: lambda f: (f - sp.conjugate(f)) / (2 * sp.I),
}


def _bits(expression: sp.Expr) -> int:
    """Return the number of bits of an expression's rational factor; 0 without such a factor."""
    number = expression.as_coeff_Mul(rational=True)[0]
    return int(number.p).bit_length() + int(number.q).bit_length() - 2 if number.is_Rational else 0


def _check_bits(bits: int) -> None:
    if bits > MOST_BITS:
        raise TooLarge(f"numbers must have at most {int(MOST_BITS * math.log10(2))} digits")


def _check_exponent(exponent: sp.Expr) -> None:
    number = exponent.as_coeff_Mul(rational=True)[0]
    if number.is_Rational and max(abs(number.p), number.q) > LARGEST_EXPONENT:
        raise TooLarge(f"exponents must be at most {LARGEST_EXPONENT}")


def _check_logarithms(exponent: sp.Expr) -> None:
    """Raise TooLarge if SymPy would take a large power of a number inside a logarithm."""
    logarithms = [a for a in exponent.atoms(sp.log) if a.is_number]
    if not logarithms:
        return
    numbers = [n for a in logarithms for n in a.atoms(sp.Rational)]
    _check_bits(max(map(_bits, numbers), default=0) * MOST_BITS // MOST_LOG_BITS)
    for number in exponent.atoms(sp.Rational):
        _check_exponent(number)


def _finite(expression: sp.Expr) -> sp.Expr:
    """Return the expression; raise TooLarge if it is infinite, not a number, or huge."""
    if not expression.free_symbols and expression.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
        raise TooLarge("values must be finite")
    if expression.is_Rational:
        _check_bits(_bits(expression))
    elif expression.is_number and not abs(_value(expression)) < math.inf:
        raise TooLarge("constants must be below 1e300")
    return expression


def _value(constant: sp.Expr) -> complex:
    """Return a constant's approximate value; infinity on overflow; unknown functions count as 1."""
    try:
        return _evaluated(constant)
    except (OverflowError, ZeroDivisionError, ValueError):
        return math.inf


def _evaluated(node: sp.Expr) -> complex:
    if node.is_Rational:
        return complex(int(node.p) / int(node.q))
    if node is sp.I:
        return 1j
    if node.is_NumberSymbol:
        return complex(float(node))
    parts = [_evaluated(part) for part in node.args]
    if node.is_Add:
        return sum(parts)
    if node.is_Mul:
        return math.prod(parts)
    if node.is_Pow:
        return parts[0] ** parts[1]
    return complex(_VALUES.get(node.func, lambda _: 1)(parts[0]))


def _expanded(node: sp.Expr) -> int:
    """Return a bound on the terms of ``node`` when expanded, at most MOST_EXPANDED + 1."""
    count = 1
    if node.is_Add:
        count = sum(_expanded(term) for term in node.args)
    elif node.is_Mul:
        for factor in node.args:
            count = min(count * _expanded(factor), MOST_EXPANDED + 1)
    elif node.is_Pow and node.exp.is_Integer:
        exponent, terms = min(abs(int(node.exp)), LARGEST_EXPONENT), _expanded(node.base)
        count = math.comb(terms + exponent - 1, exponent)
    elif node.args:
        count = max(_expanded(argument) for argument in node.args)
    return min(count, MOST_EXPANDED + 1)
