"""Roots, absolute values, exponentials and Jacobi functions that are no generators.

Which value is the principal one is shown by signs.  The argument of a function may be in the words
of a hint; a sum of arguments is taken apart by an addition theorem, term by term.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from itertools import combinations
from operator import mul

from flint import fmpq

from .axioms import BEHIND, SPECIAL_VALUES, SUMS, ZETA
from .field import Field, rule
from .limits import EXPONENT, CertificateError, within
from .ring import Element


@rule("Pow")
def root(field: Field, node: int) -> Element:
    """base**(1/q): a value whose power and whose branch are checked."""
    _, base, exponent = field.nodes.all[node]
    value = field.hinted(node)
    if value is None:
        raise CertificateError("there is no generator for a Pow")
    if not (field.image(value) ** int(exponent.q) - field.image(base)).is_zero:
        raise CertificateError("the power of the value given for a root is not the radicand")
    if not any(shown(field, value, exponent) for shown in BRANCHES):
        raise CertificateError("the value given for a root is not shown to be >= 0 on the domain")
    return field.image(value)


def is_not_negative(field: Field, node: int, _exponent: fmpq) -> bool:
    """Whether a value is real and not negative."""
    return field.signs.not_negative(node)


def is_multiple(field: Field, node: int, exponent: fmpq) -> bool:
    """Whether a value is r f**s with r >= 0 and 0 < s <= 1/q, within half a turn over q of 0.

    So is r f**s g**t if f and g are real, and f + g > 0: one of the two is positive.
    """
    nodes = field.nodes
    factors = nodes.all[node][1:] if nodes.all[node][0] == "Mul" else (node,)
    powers = [_power(field, f) for f in factors if not field.signs.not_negative(f)]
    if not powers or not all(0 < share <= exponent for _, share in powers):
        return False
    bases = [base for base, _ in powers]
    if len(bases) > 1 and not all(map(field.signs.is_real, bases)):
        return False
    return all(_is_sum_positive(field, f, g) for f, g in combinations(bases, 2))


def _power(field: Field, node: int) -> tuple[int, fmpq]:
    """f and s of a node f**s, or (f**t)**n with an integer n and s = t n."""
    match field.nodes.all[node]:
        case ("Pow", base, exponent):
            inner, share = _power(field, base) if exponent.q == 1 else (base, fmpq(1))
            return inner, share * exponent
    return node, fmpq(1)


def _is_sum_positive(field: Field, left: int, right: int) -> bool:
    """Whether the sum of two nodes is a positive number, or shown to be positive."""
    total = field.image(left) + field.image(right)
    if total.numerator.is_constant() and not total.powers:
        return bool(not total.is_zero and total.numerator.leading_coefficient() > 0)
    return field.signs.positive(field.nodes.made("Add", left, right))


BRANCHES: list[Callable[[Field, int, fmpq], bool]] = [is_not_negative, is_multiple]
"""What may show that a value is a principal root, of which the exponent is given."""


@rule("Abs")
def absolute_value(field: Field, node: int) -> Element:
    """abs(f): a value whose square is right, and that is not negative."""
    value = field.hinted(node)
    if value is None:
        raise CertificateError("there is no generator for a Abs")
    if not (field.image(value) ** 2 - field.squared(field.nodes.all[node][1])).is_zero:
        raise CertificateError(
            "the square of the value given for an abs is not the square of its argument"
        )
    if not field.signs.not_negative(value):
        raise CertificateError("the value given for an abs is not shown to be >= 0 on the domain")
    return field.image(value)


@rule("conjugate")
def conjugate(field: Field, node: int) -> Element:
    """The conjugate, by its formula; that of a complex parameter must be a generator."""
    formula = field.signs.conjugate(field.nodes.all[node][1])
    if formula == node:
        raise CertificateError("there is no generator for the conjugate of a parameter")
    return field.image(formula)


@rule("diff")
def derivative(field: Field, node: int) -> Element:
    """A derivative of an image, step by step."""
    _, inner, *before, variable = field.nodes.all[node]
    lower = field.made("diff", inner, *before) if before else field.image(inner)
    return field.derivative(lower, variable)


def whole(value: fmpq) -> int:
    """The integer that a coefficient in an argument must be."""
    if value.q != 1:
        raise CertificateError("coefficients in a sum of arguments must be integers")
    within("coefficients", abs(int(value.p)), EXPONENT)
    return int(value.p)


@rule("exp")
def exponential(field: Field, node: int) -> Element:
    """exp(u + v) = exp(u) exp(v), exp(n u) = exp(u)**n, exp(q log f) = f**q."""
    z = field.nodes.all[node][1]
    terms = field.nodes.terms(z)
    if len(terms) > 1:
        return reduce(mul, (field.made("exp", term) for term in terms))
    times, u = field.nodes.multiple(z)
    if field.nodes.all[u][0] == "log":
        f = field.nodes.all[u][1]
        return field.image(f) if times == 1 else field.made("Pow", f, times)
    if times == 0:
        field.image(u)  # a divisor in it counts, though it is multiplied by 0
        return field.one
    if u == z:
        raise CertificateError("there is no generator for a function of a sum")
    return field.made("exp", u) ** whole(times)


@rule(*SUMS)
def elliptic(field: Field, node: int) -> Element | None:
    """sn, cn, dn, epsilon and zeta, by the addition theorems and their values at 0 and K."""
    nodes = field.nodes
    name, z, m = nodes.all[node]
    field.need_parameters(node)
    if name == "jacobi_zeta" and not field.primitives(name):
        return field.read(ZETA, z=z, m=m)
    terms, (times, u) = nodes.terms(z), nodes.multiple(z)
    if len(terms) > 1:
        rest = terms[1] if len(terms) == 2 else nodes.made("Add", *terms[1:])
        return field.read(SUMS[name], u=terms[0], v=rest, m=m, z=z)
    if times == 0 or (times == 1 and u == nodes.made("elliptic_k", m)):
        field.image(u)  # a divisor in it counts, though it is multiplied by 0
        return field.read(SPECIAL_VALUES[name][int(times.p)], m=m)
    if times == 1:
        raise CertificateError("there is no generator for a function of a sum")
    if times < 0:
        value = field.made(name, nodes.times(whole(-times), u), m)
        return value if name in ("jacobi_cn", "jacobi_dn") else -value
    half = whole(times) // 2
    rest = nodes.times(whole(times) - half, u)
    return field.read(SUMS[name], u=nodes.times(half, u), v=rest, m=m, z=z)


@rule("jacobi_theta")
def theta(field: Field, node: int) -> Element:
    """Theta(u - d) by the product theorem."""
    _, z, m = field.nodes.all[node]
    field.need_parameters(node)
    terms = field.nodes.terms(z)
    for place, term in enumerate(terms):
        times, d = field.nodes.multiple(term)
        if len(terms) == 2 and times == -1:
            return field.read(BEHIND, u=terms[1 - place], d=d, m=m)
    raise CertificateError("theta's argument must be a difference of two")
