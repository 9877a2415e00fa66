"""Arguments of the functions in an expression, collected before any generator is created.

They are split into variable and constant parts and written as integer combinations of a few basis
arguments: sn(2 x) and sn(3 x + K) follow from sn(x) and sn(K).
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from math import lcm

import sympy as sp
from flint import fmpz_mat
from sympy.functions.special.bessel import BesselBase

from longwave.solutions.functions import jacobi_eta, jacobi_theta
from longwave.solutions.functions.jacobi import JacobiFunction


class Dependence:
    """Split of expressions into constant parts (free of ``variables``) and variable parts.

    >>> x, a = sp.symbols("x a")
    >>> Dependence([x]).factors(a * sp.sin(a) * x**2)
    (a*sin(a), x**2)
    """

    def __init__(self, variables: Sequence[sp.Symbol]) -> None:
        self.variables = tuple(variables)
        self._depends: dict[sp.Basic, bool] = dict.fromkeys(variables, True)

    def depends(self, node: sp.Basic) -> bool:
        """Return whether ``node`` contains a variable."""
        if node not in self._depends:
            self._depends[node] = any(self.depends(inner) for inner in node.args)
        return self._depends[node]

    def factors(self, product: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        """Return the constant and the variable factor of ``product``."""
        return self._parts(product, sp.Mul)

    def summands(self, total: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        """Return the constant and the variable part of a sum."""
        return self._parts(total, sp.Add)

    def _parts(self, whole: sp.Expr, kind: type[sp.Expr]) -> tuple[sp.Expr, sp.Expr]:
        parts = whole.args if isinstance(whole, kind) else (whole,)
        moving = [part for part in parts if self.depends(part)]
        if len(moving) == len(parts):
            return kind(), whole
        return kind(*(part for part in parts if not self.depends(part))), kind(*moving)


Vector = dict[sp.Expr, sp.Rational]

INVERSE = (sp.asin, sp.acos, sp.asinh, sp.acosh, sp.atanh)
OPAQUE = (sp.log, sp.atan, sp.LambertW, *INVERSE)
"""Functions left as they are written, because their exponentials are known."""

TURN, UNITY = sp.I * sp.pi, (1, 2, 3, 4, 6)
"""Exponent i pi, and the denominators n for which exp(i pi/n) has a known closed form."""

LONGEST_CANCELLED = 60
"""Most operations of an expression whose common factors are cancelled."""


def expanded_terms(expression: sp.Expr) -> Vector:
    """Return the expanded terms of ``expression`` with their rational coefficients.

    >>> x, y = sp.symbols("x y")
    >>> expanded_terms(2 * (x - y / 3))
    {x: 2, y: -2/3}
    """
    terms: Vector = {}
    names = {f: sp.Dummy(real=f.is_real) for f in expression.atoms(*OPAQUE)}
    hidden = sp.expand(cancelled(expression.xreplace(names)))
    originals = {name: f for f, name in names.items()}
    for term in sp.Add.make_args(hidden):
        coefficient, rest = term.as_coeff_Mul(rational=True)
        rest = rest.xreplace(originals)
        terms[rest] = terms.get(rest, sp.S.Zero) + coefficient
    return {rest: value for rest, value in terms.items() if value != 0}


def cancelled(expression: sp.Expr) -> sp.Expr:
    """Cancel common factors in a quotient of short sums.

    >>> x = sp.Symbol("x")
    >>> cancelled((x**2 - 1) / (x + 1))
    x - 1
    """
    below = (node.base for node in expression.atoms(sp.Pow) if node.exp.is_negative)
    if not any(base.is_Add for base in below) or expression.count_ops() > LONGEST_CANCELLED:
        return expression
    result: sp.Expr = sp.cancel(expression)
    return result


def definition(node: sp.Expr) -> sp.Expr:
    """Return an inverse function other than atan in terms of logarithms, with principal values.

    For a Bessel function of half-odd order, return the root and exponential that it contains.

    >>> definition(sp.asinh(sp.Symbol("x")))
    log(x + sqrt(x**2 + 1))
    """
    if isinstance(node, BesselBase):
        z, turn = node.args[1], sp.I if isinstance(node, sp.besselj | sp.bessely) else sp.S.One
        return sp.sqrt(2) / (sp.sqrt(sp.pi) * sp.sqrt(z)) * sp.exp(turn * z)
    (f,) = node.args
    if isinstance(node, sp.asinh):
        return sp.log(f + sp.sqrt(1 + f**2))
    if isinstance(node, sp.acosh):
        return sp.log(f + sp.sqrt(f - 1) * sp.sqrt(f + 1))
    if isinstance(node, sp.atanh):
        return (sp.log(1 + f) - sp.log(1 - f)) / 2
    arc = -sp.I * sp.log(sp.I * f + sp.sqrt(1 - f**2))
    return arc if isinstance(node, sp.asin) else sp.pi / 2 - arc


def has_half_order(node: sp.Expr) -> bool:
    """Return whether the order of a Bessel function is half an odd number."""
    return bool(node.args[0].is_Rational and node.args[0].q == 2)


def with_definitions(expressions: Iterable[sp.Expr]) -> list[sp.Expr]:
    """Return the expressions, and the definitions of the inverse and Bessel functions in them."""
    collected = dict.fromkeys(expressions)
    waiting = list(collected)
    while waiting:
        expression = waiting.pop()
        halves = filter(has_half_order, expression.atoms(BesselBase))
        defined = map(definition, (*expression.atoms(*INVERSE), *halves))
        new = [d for d in dict.fromkeys(defined) if d not in collected]
        collected |= dict.fromkeys(new)
        waiting += new
    return list(collected)


def without_logarithms(exponent: sp.Expr) -> tuple[sp.Expr, Vector]:
    """Split ``exponent`` into the part free of logarithms and i atan, and the multiples of these.

    >>> x, y = sp.symbols("x y")
    >>> without_logarithms(2 * x - sp.log(y) / 2)
    (2*x, {log(y): -1/2})
    """
    terms = expanded_terms(exponent)
    logarithms = {term: value for term, value in terms.items() if _is_logarithm(term, value)}
    if not logarithms:
        return exponent, {}
    rest = sp.Add(*(value * term for term, value in terms.items() if term not in logarithms))
    return rest, logarithms


def _is_logarithm(term: sp.Expr, value: sp.Rational) -> bool:
    """Return whether exp(value * term) is algebraic: term is log f, W(f), i atan f or i pi."""
    is_phase = term.is_Mul and len(term.args) == 2 and term.has(sp.I)
    turned = is_phase and isinstance(term / sp.I, sp.atan) and value.is_Integer
    if isinstance(term, sp.LambertW):
        return bool(value.is_Integer)
    return bool(isinstance(term, sp.log) or turned or (term == TURN and value.q in UNITY))


def _nesting(expression: sp.Expr) -> int:
    """Return the nesting depth of functions, by which monomials are sorted (deepest first)."""
    inner = max(map(_nesting, expression.args), default=0)
    return inner + bool(expression.is_Function)


class IntegerCombinations:
    """Basis of the integer combinations of ``arguments``.

    >>> x, y = sp.symbols("x y")
    >>> found = IntegerCombinations([2 * x, 3 * x + 3 * y, -3 * y])
    >>> found.basis
    (x, 3*y)
    >>> found.coordinates(x - 6 * y)
    (1, -2)
    """

    def __init__(self, arguments: Iterable[sp.Expr]) -> None:
        given = list(dict.fromkeys(arguments))
        vectors = [expanded_terms(argument) for argument in given]
        monomials = {monomial for vector in vectors for monomial in vector}
        self._monomials = sorted(monomials, key=lambda m: (-_nesting(m), sp.default_sort_key(m)))
        self._scale = lcm(*(int(value.q) for vector in vectors for value in vector.values()))
        rows = [self._integers(vector) for vector in vectors] if monomials else []
        table = fmpz_mat(rows).hnf().table() if rows else []
        self._rows = [[int(value) for value in row] for row in table if any(row)]
        self.basis = tuple(self._written(row, given, vectors) for row in self._rows)

    def coordinates(self, argument: sp.Expr) -> tuple[int, ...]:
        """Return the integer coordinates of ``argument`` in the basis; ValueError if none."""
        rest, multiples = self._integers(expanded_terms(argument)), []
        for row in self._rows:
            pivot = next(i for i, value in enumerate(row) if value)
            multiple = rest[pivot] // row[pivot]
            rest = [value - multiple * step for value, step in zip(rest, row, strict=True)]
            multiples.append(multiple)
        if any(rest):
            words = f"argument must be a combination of {self.basis}"
            raise ValueError(f"{words}, got {argument} (extend the basis)")
        return tuple(multiples)

    def _integers(self, vector: Vector) -> list[int]:
        unknown = [monomial for monomial in vector if monomial not in self._monomials]
        if unknown:
            words = f"argument must be made of {self._monomials}"
            raise ValueError(f"{words}, got {unknown[0]} (extend the basis)")
        return [int(vector.get(m, sp.S.Zero) * self._scale) for m in self._monomials]

    def _written(self, row: list[int], given: list[sp.Expr], vectors: list[Vector]) -> sp.Expr:
        """Return the basis vector ``row`` as an expression, if possible as +- one of ``given``."""
        for argument, vector in zip(given, vectors, strict=True):
            integers = self._integers(vector)
            if integers == row:
                return argument
            if [-value for value in integers] == row:
                return -argument
        values = zip(row, self._monomials, strict=True)
        return sp.Add(*(sp.Rational(value, self._scale) * monomial for value, monomial in values))


HYPERBOLIC = (sp.sinh, sp.cosh, sp.tanh, sp.coth, sp.sech, sp.csch)
TRIGONOMETRIC = (sp.sin, sp.cos, sp.tan, sp.cot, sp.sec, sp.csc)


class Arguments:
    """Arguments of exponentials and of elliptic functions, as integer combinations.

    ``exponents`` combines the arguments of exponentials.  For an elliptic parameter m,
    ``moving(m)`` and ``fixed(m)`` combine the variable and the constant parts of the arguments.
    ``count`` has the number of occurrences of each elliptic function.  ``degrees`` maps a radicand
    to the degree of the single root of which all its roots are powers.  ``circles`` are the
    symbols s for which sqrt(1 - s**2) occurs and no root of another sum with s, since its relation
    to that root would be lost.  ``logarithms`` maps logarithms of products to sums.
    """

    def __init__(
        self,
        expressions: Iterable[sp.Expr],
        variables: Sequence[sp.Symbol],
        logarithms: Mapping[sp.Expr, sp.Expr] | None = None,
    ) -> None:
        self._logarithms = logarithms or {}
        self.dependence = Dependence(variables)
        self.count: Counter[tuple[type, sp.Expr]] = Counter()
        self._exponents: dict[sp.Expr, None] = {}
        self._parts: defaultdict[tuple[bool, sp.Expr], dict[sp.Expr, None]] = defaultdict(dict)
        self.degrees: dict[sp.Expr, int] = {}
        self._shifts: defaultdict[sp.Expr, dict[sp.Expr, None]] = defaultdict(dict)
        visited: set[sp.Basic] = set()
        for expression in expressions:
            self._visit(expression, visited)
        self.exponents = IntegerCombinations(self._exponents)
        self._combined = {key: IntegerCombinations(parts) for key, parts in self._parts.items()}
        self._steps = {m: IntegerCombinations(shifts) for m, shifts in self._shifts.items()}
        self.circles = {base.free_symbols.pop() for base in self.degrees if self._closes(base)}

    def moving(self, m: sp.Expr) -> IntegerCombinations:
        """Return the basis of the variable parts of elliptic arguments with parameter ``m``."""
        return self._combined.get((True, m), NOTHING)

    def fixed(self, m: sp.Expr) -> IntegerCombinations:
        """Return the basis of the constant parts of elliptic arguments with parameter ``m``."""
        return self._combined.get((False, m), NOTHING)

    def parts(self, argument: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        """Split ``argument`` into a variable and a constant summand."""
        constant, variable = self.dependence.summands(sp.expand(argument))
        return variable, constant

    def steps(self, shift: sp.Expr, m: sp.Expr) -> tuple[sp.Expr, int]:
        """Write ``shift``, a constant in theta's argument, as step times integer; return both."""
        combinations = self._steps[m]
        pairs = zip(combinations.basis, combinations.coordinates(shift), strict=True)
        multiples = [(step, times) for step, times in pairs if times]
        return multiples[0] if len(multiples) == 1 else (shift, int(shift != 0))

    def exponent(self, z: sp.Expr) -> tuple[sp.Expr, Vector]:
        """Split the exponent ``z`` into a part without logarithms, and multiples of logarithms."""
        z = z.xreplace({node: definition(node) for node in z.atoms(*INVERSE)})
        return without_logarithms(z.xreplace(self._logarithms) if z.has(sp.log) else z)

    def _visit(self, node: sp.Basic, visited: set[sp.Basic]) -> None:
        for inner in node.args:
            self._visit(inner, visited)
        if isinstance(node, JacobiFunction):
            self.count[type(node), node.args[1]] += 1
        if node in visited:
            return
        visited.add(node)
        if isinstance(node, (sp.exp, *HYPERBOLIC)):
            self._exponents[self.exponent(node.args[0])[0]] = None
        elif isinstance(node, sp.erf):
            self._exponents[self.exponent(-(node.args[0] ** 2))[0]] = None
        elif isinstance(node, TRIGONOMETRIC):
            self._exponents[self.exponent(sp.I * node.args[0])[0]] = None
        elif isinstance(node, JacobiFunction):
            argument, m = node.args
            if isinstance(node, jacobi_theta | jacobi_eta):
                self._shifts[m][self.parts(argument)[1]] = None
            for moves, part in zip((True, False), self.parts(argument), strict=True):
                if part != 0:
                    self._parts[moves, m][part] = None
                    if not moves and part.has(quarter := sp.elliptic_k(m)):
                        self._parts[moves, m][quarter] = None
        elif isinstance(node, sp.Pow) and node.exp.is_Rational and not node.exp.is_Integer:
            degree = int(node.exp.q)
            self.degrees[node.base] = lcm(self.degrees.get(node.base, 1), degree)
        elif node is sp.E:
            self._exponents[sp.S.One] = None

    def _closes(self, base: sp.Expr) -> bool:
        """Return whether ``base`` is 1 - s**2, with a constant s in no other composite radicand."""
        square = 1 - base
        if not (square.is_Pow and square.exp == 2 and square.base.is_Symbol):
            return False
        sums = [other for other in self.degrees if not other.is_Symbol and other.has(square.base)]
        return sums == [base] and square.base not in self.dependence.variables


NOTHING = IntegerCombinations(())
