"""A parser of the report's LaTeX: a recursive descent that returns the SymPy expression."""

import re
from collections.abc import Mapping

import sympy as sp

from longwave.solutions.functions import (
    jacobi_cn,
    jacobi_dn,
    jacobi_epsilon,
    jacobi_eta,
    jacobi_sn,
    jacobi_theta,
    jacobi_zeta,
)

ELLIPTIC = {
    r"\mathrm{sn}": jacobi_sn, r"\mathrm{cn}": jacobi_cn, r"\mathrm{dn}": jacobi_dn,
    r"\mathcal{E}": jacobi_epsilon, r"\mathrm{Z}": jacobi_zeta, "H": jacobi_eta,
    r"\Theta": jacobi_theta,
}  # fmt: skip
ELEMENTARY = {
    r"\cos": sp.cos, r"\sin": sp.sin, r"\cosh": sp.cosh, r"\sinh": sp.sinh, r"\tanh": sp.tanh,
    r"\mathrm{sech}": sp.sech,
}  # fmt: skip
TOKEN = re.compile(r"\\math(?:rm|cal)\{\w+\}|\\[a-zA-Z]+|\d+|[a-zA-Z]|[{}()^_+;'-]")


class Reader:
    """A parser of one expression; `names` maps LaTeX names to symbols."""

    def __init__(self, text: str, names: Mapping[str, sp.Symbol]) -> None:
        clean = text.replace(r"\,", " ").replace(r"\left(", "{").replace(r"\right)", "}")
        self.tokens = TOKEN.findall(clean)
        self.names = names

    def read(self) -> sp.Expr:
        """Return the whole text's expression."""
        total = self.sum()
        assert not self.tokens, self.tokens
        return total

    def peek(self) -> str:
        return self.tokens[0] if self.tokens else ""

    def take(self, expected: str = "") -> str:
        token = self.tokens.pop(0)
        assert not expected or token == expected, (token, self.tokens)
        return token

    def sum(self) -> sp.Expr:
        total = sp.S.Zero
        sign = 1
        if self.peek() in ("+", "-"):
            sign = 1 if self.take() == "+" else -1
        while True:
            total += sign * self.product()
            if self.peek() not in ("+", "-"):
                return total
            sign = 1 if self.take() == "+" else -1

    def product(self) -> sp.Expr:
        product = sp.S.One
        while self.peek() not in ("", "+", "-", ")", "}", ";"):
            product *= self.power()
        return product

    def power(self) -> sp.Expr:
        base = self.atom()
        return base ** self.group() if self.raised() else base

    def raised(self) -> bool:
        if self.peek() != "^":
            return False
        self.take("^")
        return True

    def group(self, opening: str = "{", closing: str = "}") -> sp.Expr:
        self.take(opening)
        inside = self.sum()
        self.take(closing)
        return inside

    def atom(self) -> sp.Expr:
        if self.peek() == "{":
            return self.group()
        token = self.take()
        if token.isdigit():
            return sp.Integer(token)
        if token == r"\frac":
            return self.group() / self.group()
        if token == r"\sqrt":
            return sp.sqrt(self.group())
        if token == "e":
            self.take("^")
            return sp.exp(self.group())
        if token in ELEMENTARY:
            return self.function(token)
        if token in ELLIPTIC and (token not in self.names or self.peek() == "("):
            return self.elliptic(token)
        return self.symbol(token)

    def function(self, token: str) -> sp.Expr:
        power = self.group() if self.raised() else sp.S.One
        argument = self.group("(", ")") if self.peek() == "(" else self.symbol(self.take())
        return ELEMENTARY[token](argument) ** power

    def elliptic(self, token: str) -> sp.Expr:
        power = self.group() if self.raised() else sp.S.One
        self.take("(")
        argument = self.sum()
        self.take(";")
        modulus = self.sum()
        self.take(")")
        return ELLIPTIC[token](argument, modulus**2) ** power

    def symbol(self, token: str) -> sp.Expr:
        if self.peek() == "_":
            self.take()
            self.take("{")
            token += f"_{{{self.take()}}}"
            self.take("}")
        if self.peek() == "'":
            token += self.take()
        return self.names[token]
