"""Forces as text in the strain ``r``: their Taylor polynomials, exact or in balls."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from flint import acb, acb_series, arb, ctx, fmpq, fmpq_poly

from .limits import CertificateError, decimal

_TOKEN = re.compile(r"\s*(\d+\.?\d*(?:[eE][-+]?\d+)?|[A-Za-z]+|\*\*|[-+*/()])", re.ASCII)


def _right(z: acb_series) -> acb_series:
    """Return a series in the right half-plane. Raises CertificateError for any other."""
    if not z[0].real > 0:
        raise CertificateError("force leaves its domain: a root or logarithm of what is not > 0")
    return z


def _nonzero(z: acb_series) -> acb_series:
    """Return a series that does not begin with 0. Raises CertificateError for any other."""
    if not z[0].abs_lower() > 0:
        raise CertificateError("force leaves its domain: a division by what may be 0")
    return z


FUNCTIONS: dict[str, Callable[[acb_series], acb_series]] = {
    "exp": acb_series.exp,
    "log": lambda z: _right(z).log(),
    "sqrt": lambda z: _right(z).sqrt(),
    "sin": acb_series.sin,
    "cos": acb_series.cos,
    "tan": acb_series.tan,
    "sinh": lambda z: (z.exp() - (-z).exp()) / 2,
    "cosh": lambda z: (z.exp() + (-z).exp()) / 2,
    "tanh": lambda z: 1 - 2 / _nonzero((2 * z).exp() + 1),
}
"""Analytic functions of the grammar, on power series."""

MAX_TOKENS, MAX_POWER, MAX_NESTING = 2000, 64, 60
MAX_HEIGHT = 50_000
"""Maximum number of bits of a coefficient of a polynomial force."""

Node = tuple[Any, ...]


@dataclass(frozen=True)
class Force:
    """A force V'(r), parsed; ``polynomial`` has its coefficients, or is None."""

    text: str
    node: Node
    polynomial: tuple[fmpq, ...] | None

    @property
    def size(self) -> int:
        """Number of symbols in the formula."""
        return len(_TOKEN.findall(self.text))

    def taylor(self, z: acb, terms: int) -> list[acb]:
        """Return the first ``terms`` Taylor coefficients at ``z``; not finite at poles."""
        before, ctx.cap = ctx.cap, terms  # flint drops what is beyond its cap, 10 by default
        try:
            series = _series(self.node, acb_series([z, 1], terms), terms)
        finally:
            ctx.cap = before
        if series.prec < terms:
            raise CertificateError("too few terms of the force's series are known")
        return [series[i] for i in range(terms)]

    @property
    def is_odd(self) -> bool:
        """Whether the force is a polynomial with odd powers of r only."""
        return self.polynomial is not None and not any(self.polynomial[::2])

    @property
    def at_rest(self) -> list[arb]:
        """Taylor coefficients of the force at r = 0: 0, K2, K3, K4."""
        if self.polynomial is not None:
            return [arb(c) for c in (*self.polynomial, *[fmpq(0)] * 4)[:4]]
        return [c.real for c in self.taylor(acb(0), 4)]

    def derivative(self, order: int) -> tuple[arb, ...]:
        """Return the coefficients of the derivative of this ``order`` of a polynomial force."""
        polynomial = fmpq_poly(list(self.polynomial or ()))
        for _ in range(order):
            polynomial = polynomial.derivative()
        return tuple(map(arb, polynomial.coeffs())) or (arb(0),)


def read_force(text: str) -> Force:
    """Parse the formula of a force. Raises CertificateError for a text outside the grammar."""
    tokens = _TOKEN.findall(text)
    if "".join(tokens) != "".join(text.split()) or len(tokens) > MAX_TOKENS:
        raise CertificateError(f"force must be a formula in r, got {text[:80]!r}")
    parser = _Parser(tokens)
    node = parser.sum()
    if parser.rest:
        raise CertificateError(f"force must be a formula in r, got {text[:80]!r}")
    polynomial = _polynomial(node)
    return Force(text, node, None if polynomial is None else tuple(polynomial.coeffs()))


class _Parser:
    def __init__(self, tokens: Sequence[str]) -> None:
        self.rest = list(tokens)
        self.depth = 0

    def take(self, *signs: str) -> str:
        return self.rest.pop(0) if self.rest and self.rest[0] in signs else ""

    def sum(self) -> Node:
        node = self.product()
        while sign := self.take("+", "-"):
            node = sign, node, self.product()
        return node

    def product(self) -> Node:
        node = self.signed()
        while sign := self.take("*", "/"):
            node = sign, node, self.signed()
        return node

    def signed(self) -> Node:
        self.depth += 1
        if self.depth > MAX_NESTING:
            raise CertificateError(f"a force must have at most {MAX_NESTING} nested parts")
        node = self._signed()
        self.depth -= 1
        return node

    def _signed(self) -> Node:
        if self.take("-"):
            return "-", ("number", fmpq(0)), self.signed()
        return self.power()

    def power(self) -> Node:
        base = self.atom()
        return ("**", base, self.signed()) if self.take("**") else base

    def atom(self) -> Node:
        if not self.rest:
            raise CertificateError("force must be a whole formula, got one that ends too early")
        word = self.rest.pop(0)
        if word == "r":
            return ("r",)
        if word[0].isdigit():
            return "number", decimal(word)
        if word == "(" or (word in FUNCTIONS and self.take("(")):
            inner = self.sum()
            if self.take(")"):
                return inner if word == "(" else (word, inner)
        raise CertificateError(f"force must be a formula in r, got {word[:20]!r}")


def _polynomial(node: Node) -> fmpq_poly | None:
    """Return a formula as a polynomial in r, or None if it is not a polynomial."""
    kind, *parts = node
    if kind == "r":
        return fmpq_poly([0, 1])
    if kind == "number":
        return fmpq_poly([parts[0]])
    if kind in FUNCTIONS:
        return None
    left, right = map(_polynomial, parts)
    if left is None or right is None:
        return None
    result = _combined(kind, left, right)
    if result is not None:
        _require_small(result.degree(), _height(result))
    return result


def _height(polynomial: fmpq_poly) -> int:
    """Return the number of bits of the largest numerator or denominator of a coefficient."""
    parts = [int(part) for c in polynomial.coeffs() for part in (c.p, c.q)]
    return max((part.bit_length() for part in parts), default=0)


def _require_small(degree: int, height: int) -> None:
    if degree > MAX_POWER or height > MAX_HEIGHT:
        raise CertificateError(
            f"a polynomial force must have at most degree {MAX_POWER} and {MAX_HEIGHT} bits"
        )


def _combined(kind: str, left: fmpq_poly, right: fmpq_poly) -> fmpq_poly | None:
    if kind in "+-":
        return left + right if kind == "+" else left - right
    if kind == "*":
        return left * right
    exponent = right[0]
    if right.degree() > 0 or (kind == "/" and exponent == 0):
        return None
    if kind == "/":
        return left * (1 / exponent)
    if exponent.q != 1 or not 0 <= exponent <= MAX_POWER:
        return None
    power = int(exponent.p)
    _require_small(left.degree() * power, _height(left) * power)
    return left**power


def _series(node: Node, r: acb_series, terms: int) -> acb_series:
    kind, *parts = node
    if kind == "r":
        return r
    if kind == "number":
        return acb_series([acb(arb(parts[0]))], terms)
    values = [_series(part, r, terms) for part in parts]
    if kind in FUNCTIONS:
        return FUNCTIONS[kind](values[0])
    left, right = values
    if kind == "**":
        exponent = _polynomial(parts[1])
        if exponent is None or exponent.degree() > 0:
            raise CertificateError("an exponent in the force must be a number")
        number = exponent[0]
        if number.q == 1 and abs(number.p) <= MAX_POWER:
            power = left ** abs(int(number.p))
            return power if number.p >= 0 else acb_series([1], terms) / _nonzero(power)
        return (_right(left).log() * acb(arb(number))).exp()
    operations = {
        "+": lambda: left + right,
        "-": lambda: left - right,
        "*": lambda: left * right,
        "/": lambda: left / _nonzero(right),
    }
    result: acb_series = operations[kind]()
    return result
