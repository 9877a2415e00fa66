"""Simplify roots, logarithms, absolute values, signs and conjugates as far as domains allow.

Each rule holds at every point of the domains where both sides are defined:

    (a b)**q = a**q b**q  and  log(a b) = log a + log b     for a >= 0 and any b,
    (a**n)**q = a**(n q)  and  log(a**q) = q log a          for a >= 0,
    (a**n)**q = |a|**(n q)                                  for real a and even n,
    |a| = a, sign a = 1 for a > 0;  |a| = -a, sign a = -1 for a < 0;  log(exp z) = z for real z,
    W(z exp z) = z for z >= -1.

The conjugate is moved into sums, products, integer powers and functions that are real on the real
line.  It stops at a root or logarithm whose argument may be negative.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import sympy as sp
from flint import fmpq

from longwave.solutions.functions import jacobi_cn, jacobi_dn, jacobi_sn
from longwave.verify.kernel.inverse_rules import PRINCIPAL

from .arguments import HYPERBOLIC, TRIGONOMETRIC
from .domain_signs import BELOW_PI, DomainSigns, lies_between
from .factors import Quotients, TooLong, factored

ROOT_DIGITS, LARGEST_DENOMINATOR = 40, 10**6
"""Decimals to which a cube root is evaluated, and largest denominator in its exact value."""

REAL_ON_THE_LINE = (sp.exp, *HYPERBOLIC, *TRIGONOMETRIC)
"""Meromorphic functions f with f(conj z) = conj f(z)."""


class Rewriting:
    """Simpler forms of expressions on domains; ``found`` maps original nodes to new ones."""

    def __init__(self, signs: DomainSigns) -> None:
        self.signs = signs
        self.found: dict[sp.Expr, sp.Expr] = {}
        self._images: dict[sp.Expr, sp.Expr] = {}

    def __call__(self, expression: sp.Expr) -> sp.Expr:
        """Return ``expression`` with every rule applied, innermost first."""
        if expression not in self._images:
            self._images[expression] = self._rewritten(expression)
        return self._images[expression]

    def _rewritten(self, node: sp.Expr) -> sp.Expr:
        if not node.args:
            return node
        arguments = [self(argument) for argument in node.args]
        same = all(new is old for new, old in zip(arguments, node.args, strict=True))
        written = node if same else _rebuilt(node, arguments)
        simpler = self.simpler(written)
        if simpler is None:
            if isinstance(node, sp.log) and not isinstance(written, sp.log):
                self.found[node] = written
            return written
        self.found[node] = value = self(simpler)
        if node.is_Pow and node.exp.p != 1:
            self(sp.Pow(node.base, sp.Rational(1, node.exp.q), evaluate=False))
        return value

    def simpler(self, node: sp.Expr) -> sp.Expr | None:
        """Return the value of ``node`` by the rules; None if none applies."""
        if node.is_Pow and node.exp.is_Rational and not node.exp.is_Integer:
            value = self._power(node.base, node.exp)
        elif isinstance(node, sp.log):
            value = self._logarithm(node.args[0])
        elif isinstance(node, sp.Abs | sp.sign):
            value = None if needs_integers(node) else self._signed(node)
        elif isinstance(node, sp.conjugate | sp.re | sp.im):
            value = self._real_part(node)
        elif isinstance(node, sp.LambertW) and len(node.args) == 1:
            value = self._product_logarithm(node.args[0])
        elif (name := node.func.__name__) in PRINCIPAL and isinstance(
            node.args[0], getattr(sp, name.removeprefix("a"))
        ):
            inner = node.args[0].args[0]
            value = inner if lies_between(self.signs.range(inner), *PRINCIPAL[name]) else None
        else:
            return None
        return None if value == node else value

    def is_nonzero(self, total: sp.Expr) -> bool:
        """Return whether a formula, or each of its factors, is shown to be nowhere 0."""
        factors = self._factors(_squared_function(total) or total, 1)
        return all(self.signs.is_nonzero(f.base if f.is_Pow else f) for f in factors)

    def _power(self, base: sp.Expr, exponent: sp.Rational) -> sp.Expr | None:
        if not base.free_symbols and exponent == sp.S.Half and base.is_real:
            denested = sp.sqrtdenest(sp.sqrt(base))
            return None if denested.is_Pow else denested
        if not base.free_symbols and exponent.q == 3 and base.is_Add and base.is_positive:
            return _cube_root(base, exponent)
        is_sum = exponent.q == 2 and (base is sp.I or base.is_Add)
        if is_sum and (denested := _denested(base)) is not None:
            return denested ** (2 * exponent)
        factors = self._factors(_squared_function(base) or base, 2)
        if len(factors) > 1:
            outside, inside = self._known_factors(factors)
            if not outside or (len(outside) == 1 and inside == 1):
                return None
            return sp.Mul(*(sp.Pow(f, exponent) for f in outside)) * sp.Pow(inside, exponent)
        (base,) = factors
        if isinstance(base, sp.exp):
            z = base.args[0]
            if self.signs.is_real(z) or self._is_narrow(z / sp.I):
                return sp.exp(exponent * z)
        if not (base.is_Pow and base.exp.is_Rational):
            return None
        inner = base.base
        if self.signs.is_nonnegative(inner):
            return sp.Pow(inner, base.exp * exponent)
        if base.exp.is_Integer and base.exp % 2 == 0 and self.signs.is_real(inner):
            return sp.Pow(self._absolute(inner), base.exp * exponent)
        if exponent == sp.S.Half and base.exp == 2 and self._is_to_the_right(inner):
            return inner
        return None

    def _is_to_the_right(self, total: sp.Expr) -> bool:
        """Return whether a sum has a positive real part; square roots have a nonnegative one."""
        terms = [(term, *term.as_coeff_Mul(rational=True)) for term in sp.Add.make_args(total)]
        roots = [t for t, n, f in terms if n > 0 and f.is_Pow and f.exp == sp.S.Half]
        return bool(roots) and self.signs.is_positive(total - sp.Add(*roots))

    def _is_narrow(self, angle: sp.Expr) -> bool:
        """Return whether ``angle`` is real and between -pi and pi."""
        return lies_between(self.signs.range(sp.expand(angle)), -BELOW_PI, BELOW_PI)

    def _known_factors(self, factors: Sequence[sp.Expr]) -> tuple[list[sp.Expr], sp.Expr]:
        """Return the absolute values of factors of known sign, and the rest with the sign."""
        outside, inside, sign = [], sp.S.One, 1
        for factor in factors:
            if self.signs.is_nonnegative(factor):
                outside.append(factor)
            elif self.signs.is_nonpositive(factor):
                sign = -sign
                if factor != -1:
                    outside.append(-factor)
            else:
                inside *= factor
        return outside, sign * inside

    def _logarithm(self, argument: sp.Expr) -> sp.Expr | None:
        if argument.is_Rational and argument > 0:
            powers = sp.factorrat(argument)
            return sp.Add(*(n * sp.log(p) for p, n in powers.items()))
        factors = self._factors(argument, 1)
        if len(factors) > 1:
            outside = [f for f in factors if self.signs.is_positive(f)]
            inside = [f for f in factors if f not in outside]
            if not outside:
                return None
            parts = [*outside, sp.Mul(*inside)] if inside else outside
            return sp.Add(*map(sp.log, parts))
        (argument,) = factors
        if isinstance(argument, sp.exp):
            exponent = argument.args[0]
            if self.signs.is_real(exponent) or self._is_narrow(exponent / sp.I):
                return exponent
        if argument is sp.I:
            return sp.I * sp.pi / 2
        if not (argument.is_Pow and self.signs.is_real(argument.base)):
            return None
        base, exponent = argument.base, argument.exp
        if self.signs.is_positive(base) and self.signs.is_real(exponent):
            return exponent * sp.log(base)
        return exponent * sp.log(self._absolute(base)) if exponent.is_even else None

    def _product_logarithm(self, argument: sp.Expr) -> sp.Expr | None:
        """Return the z >= -1 with z exp(z) = ``argument``; None if it is not found."""
        evaluated = sp.LambertW(argument)
        if not evaluated.has(sp.LambertW):
            return evaluated
        known = [*(f.args[0] for f in argument.atoms(sp.exp)), *argument.atoms(sp.log)]
        for term in (*known, *(-part for part in known)):
            same = sp.expand(term * sp.exp(term) - argument) == 0
            if same and lies_between(self.signs.range(term), fmpq(-1), None):
                return term
        return None

    def _factors(self, product: sp.Expr, degree: int) -> Sequence[sp.Expr]:
        """Return the factors of ``product``, also if it is a sum that has useful factors.

        A factor is useful if it is no sum, or a power with exponent ``degree`` or more."""
        if product.is_Mul:
            return tuple(product.args)
        below = product.is_Pow and product.exp == -1
        if not (product.is_Add or (below and product.base.is_Add)):
            return (product,)
        plain, written = _in_one_exponential(product)
        try:
            unit, powers = factored(plain)
        except TooLong:
            return (product,)
        powers = [(base.xreplace(written), power) for base, power in powers]
        if not any(abs(power) >= degree or not base.is_Add for base, power in powers):
            return (product,)
        factors = [sp.Pow(_evidently_signed(base), power) for base, power in powers]
        if unit < 0 and not any(power % 2 and not base.is_Symbol for base, power in powers):
            return [sp.S.NegativeOne, -unit, *factors]
        return factors if unit == 1 else [unit, *factors]

    def _absolute(self, inner: sp.Expr) -> sp.Expr:
        if self.signs.is_nonnegative(inner):
            return inner
        return -inner if self.signs.is_nonpositive(inner) else sp.Abs(inner)

    def _signed(self, node: sp.Expr) -> sp.Expr | None:
        inner = node.args[0]
        factors = self._factors(inner, 1)
        if isinstance(node, sp.Abs) and len(factors) > 1:
            outside, rest = self._known_factors(factors)
            return sp.Mul(*outside) * sp.Abs(rest) if outside else None
        if isinstance(node, sp.Abs):
            return self._absolute(inner)
        if not (self.signs.is_positive(inner) or self.signs.is_positive(-inner)):
            return None
        if isinstance(modulus := sp.Abs(inner), sp.Abs):
            self.found[modulus] = self._absolute(inner)
        return sp.S.One if self.signs.is_positive(inner) else sp.S.NegativeOne

    def _real_part(self, node: sp.Expr) -> sp.Expr | None:
        inner = node.args[0]
        other = conjugated(inner, self.signs)
        if other is None:
            return None
        if isinstance(node, sp.conjugate):
            return other
        return (inner + other) / 2 if isinstance(node, sp.re) else (inner - other) / (2 * sp.I)


def _in_one_exponential(total: sp.Expr) -> tuple[sp.Expr, dict[sp.Basic, sp.Expr]]:
    """Replace the exponentials in a sum by powers of one symbol E; also return {E: value}."""
    exponentials = sorted(total.atoms(sp.exp), key=lambda node: (node.count_ops(), str(node)))
    for base in exponentials:
        ratios = [sp.cancel(node.args[0] / base.args[0]) for node in exponentials]
        if all(ratio.is_Integer for ratio in ratios) and min(ratios) < 0:
            letter = sp.Dummy("E", positive=True)
            powers = {node: letter**n for node, n in zip(exponentials, ratios, strict=True)}
            return total.xreplace(powers), {letter: base}
    return total, {}


SQUARES: Mapping[Any, Callable[..., dict[sp.Expr, sp.Expr]]] = {
    sp.cosh: lambda f, z: {f**2 - 1: sp.sinh(z)},
    sp.sinh: lambda f, z: {f**2 + 1: sp.cosh(z)},
    sp.tanh: lambda f, z: {1 - f**2: sp.sech(z)},
    sp.sech: lambda f, z: {1 - f**2: sp.tanh(z)},
    sp.coth: lambda f, z: {f**2 - 1: sp.csch(z)},
    sp.csch: lambda f, z: {f**2 + 1: sp.coth(z)},
    sp.sin: lambda f, z: {1 - f**2: sp.cos(z)},
    sp.cos: lambda f, z: {
        1 - f**2: sp.sin(z),
        1 + f: sp.sqrt(2) * sp.cos(z / 2),
        2 + 2 * f: 2 * sp.cos(z / 2),
        1 - f: sp.sqrt(2) * sp.sin(z / 2),
    },
    sp.tan: lambda f, z: {f**2 + 1: sp.sec(z)},
    sp.sec: lambda f, z: {f**2 - 1: sp.tan(z)},
    jacobi_sn: lambda f, z, m: {1 - f**2: jacobi_cn(z, m), 1 - m * f**2: jacobi_dn(z, m)},
    jacobi_cn: lambda f, z, m: {1 - f**2: jacobi_sn(z, m), 1 - m + m * f**2: jacobi_dn(z, m)},
    jacobi_dn: lambda f, z, m: {1 - f**2: sp.sqrt(m) * jacobi_sn(z, m)},
}
"""For each function f, expressions in f and a formula whose square each of them equals."""


def _squared_function(total: sp.Expr) -> sp.Expr | None:
    """Return the square that a sum equals by a Pythagorean identity; None if there is none."""
    if not (total.is_Add and len(total.args) == 2):
        return None
    for node in total.atoms(sp.cosh):
        if total == node + sp.sinh(node.args[0]):
            return sp.exp(node.args[0])
    for node in total.atoms(*SQUARES):
        root = SQUARES[node.func](node, *node.args).get(total)
        if root is not None:
            return root**2
    return None


def _evidently_signed(total: sp.Expr) -> sp.Expr:
    """Rewrite a sum as a square or as a sum of squares, if it is one."""
    square = _squared_function(total)
    if square is not None:
        return square
    squares = Quotients(total).squares() if total.is_Add else None
    return total if squares is None else squares


def _quadratics(base: sp.Expr) -> Iterator[tuple[sp.Expr, sp.Expr, sp.Expr]]:
    """Yield a, b and c with ``base = a + b sqrt(c)``."""
    quotient = Quotients(base)
    for atom, square in quotient.square_roots:
        parts = quotient.linear_in(atom)
        if parts is not None and quotient.below.is_constant():
            a, b = (part / int(quotient.below.leading_coefficient()) for part in parts)
            yield a, b, square


def _denested(base: sp.Expr) -> sp.Expr | None:
    """Return the square root of a + b sqrt(c) as a sum of two, if a**2 - b**2 c is a square."""
    try:
        for a, b, square in _quadratics(base):
            unit, powers = factored(a**2 - b**2 * square)
            root_of_unit = sp.sqrt(unit)
            if not root_of_unit.is_Rational or any(power % 2 for _, power in powers):
                continue
            half = sp.Mul(root_of_unit, *(f ** (power // 2) for f, power in powers)) / 2
            high, low = sp.expand(a / 2 + half), sp.expand(a / 2 - half)
            return _joined_roots(high, low, b, square)
    except TooLong:
        pass
    return None


def _joined_roots(high: sp.Expr, low: sp.Expr, b: sp.Expr, square: sp.Expr) -> sp.Expr | None:
    """Return sqrt(high) + sqrt(low), or the difference of these roots if b is negative."""
    if high.is_negative or (not high.is_positive and low.is_positive):
        high, low = low, high
    second = sp.I * sp.sqrt(-low) if square == -1 else sp.sqrt(low)
    if b.could_extract_minus_sign() or (square != -1 and b.is_negative):
        return sp.sqrt(high) - second
    return sp.sqrt(high) + second


def _cube_root(base: sp.Expr, exponent: sp.Rational) -> sp.Expr | None:
    """Return the cube root a + b sqrt(c) of a number of the same form; None if there is none."""
    for p, q, square in _quadratics(base):
        if not square.is_Rational or square < 0:
            continue
        norm, value = (
            sp.real_root(p**2 - q**2 * square, 3),
            sp.N(base, ROOT_DIGITS) ** (sp.S.One / 3),
        )
        if not norm.is_Rational:
            continue
        a = sp.Rational(str((value + norm / value) / 2)).limit_denominator(LARGEST_DENOMINATOR)
        b = sp.Rational(str((value - norm / value) / 2 / sp.sqrt(square).n(ROOT_DIGITS)))
        root = a + b.limit_denominator(LARGEST_DENOMINATOR) * sp.sqrt(square)
        if sp.expand(root**3 - base) == 0:
            return root ** (3 * exponent)
    return None


def _rebuilt(node: sp.Expr, arguments: Sequence[sp.Expr]) -> sp.Expr:
    """Return ``node`` with other arguments; a power of a sum is not evaluated (slow in SymPy)."""
    plain = node.is_Pow and arguments[0].is_Add and not arguments[0].is_number
    return node.func(*arguments, evaluate=False) if plain else node.func(*arguments)


def conjugated(expression: sp.Expr, signs: DomainSigns) -> sp.Expr | None:
    """Return the complex conjugate on the domains; None if no rule gives it.

    >>> x = sp.Symbol("x", real=True)
    >>> conjugated(sp.exp(sp.I * x), DomainSigns({})), conjugated(sp.sqrt(x), DomainSigns({}))
    (exp(-I*x), None)
    """
    if signs.is_real(expression):
        return expression
    if expression is sp.I:
        return -sp.I
    if isinstance(expression, sp.conjugate):
        inner: sp.Expr = expression.args[0]
        return inner
    through = expression.is_Add or expression.is_Mul
    through = through or (expression.is_Pow and expression.exp.is_Integer)
    if not through and not isinstance(expression, REAL_ON_THE_LINE):
        return None
    arguments = [conjugated(argument, signs) for argument in expression.args]
    return None if any(argument is None for argument in arguments) else expression.func(*arguments)


def needs_integers(node: sp.Expr) -> bool:
    """Return whether an abs or sign simplifies only for integers, such as abs(n-1) for n > 0."""
    whole = [s for s in node.free_symbols if s.is_integer]
    real = {s: sp.Dummy(real=True, positive=s.is_positive, negative=s.is_negative) for s in whole}
    if not whole or isinstance(sp.Abs(node.args[0]), sp.Abs):
        return False
    return isinstance(sp.Abs(node.args[0].xreplace(real)), sp.Abs)
