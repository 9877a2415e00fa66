"""A parameter of a closed form, with its domain and what happens at its ends."""

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from derive.algebra.exact_numbers import exact_number, instance

__all__ = ["Bound", "Parameter"]

COMPARISON_DIGITS = 60


@dataclass(frozen=True)
class Bound:
    """One end of a domain: its value, the neighbouring limit in words, open or closed.

    ``value`` may contain the symbols of other parameters (``elliptic_k(k**2)`` for alpha).
    """

    value: sp.Expr
    limit: str
    is_open: bool = True


@dataclass(frozen=True)
class Parameter:
    """A real parameter: symbol, bounds (None is unbounded) and default (None is required).

    >>> k = sp.Symbol("k")
    >>> modulus = Parameter(
    ...     k, Bound(sp.S.Zero, "the constant"), Bound(sp.S.One, "the sech soliton")
    ... )
    >>> modulus.check({"k": 0.7})
    7/10
    >>> modulus.check({"k": 1.2})
    Traceback (most recent call last):
    ...
    ValueError: k must satisfy 0 < k < 1, got 1.2 (k = 1 is the sech soliton)
    """

    symbol: sp.Symbol
    lower: Bound | None = None
    upper: Bound | None = None
    default: sp.Expr | None = None

    def __post_init__(self) -> None:
        instance("symbol", self.symbol, sp.Symbol, "solutions.symbols holds k, A, ...")

    @property
    def name(self) -> str:
        """The keyword by which the parameter is given."""
        return str(self.symbol.name)

    @property
    def domain(self) -> str:
        """The domain in words: ``0 < k < 1``, or ``X_0 real``."""
        if self.lower is None and self.upper is None:
            return f"{self.name} real"
        left = f"{self.lower.value} {_sign(self.lower)} " if self.lower else ""
        right = f" {_sign(self.upper)} {self.upper.value}" if self.upper else ""
        return f"{left}{self.name}{right}"

    def check(self, values: Mapping[str, object]) -> sp.Expr:
        """This parameter's exact value out of ``values`` (name to number).

        Raises ValueError if it is missing, no finite real number or outside the domain.
        """
        if self.name not in values:
            if self.default is not None:
                return self.default
            raise ValueError(
                f"{self.name} must satisfy {self.domain}, got nothing (give {self.name})"
            )
        exact = exact_number(self.name, values[self.name])
        if self.lower is not None:
            self._check_bound(self.lower, exact, values, side=+1)
        if self.upper is not None:
            self._check_bound(self.upper, exact, values, side=-1)
        return exact

    def _check_bound(
        self, bound: Bound, exact: sp.Expr, values: Mapping[str, object], side: int
    ) -> None:
        end = bound.value.subs(
            {symbol: exact_number(symbol.name, values[symbol.name]) for symbol in _symbols(bound)}
        )
        distance = sp.N(side * (exact - end), COMPARISON_DIGITS)
        if distance > 0 or (distance == 0 and not bound.is_open):
            return
        about = f" ({bound.value} = {sp.N(end, 6)})" if bound.value.free_symbols else ""
        got = values[self.name]
        raise ValueError(
            f"{self.name} must satisfy {self.domain}{about}, got {got} "
            f"({self.name} = {bound.value} is {bound.limit})"
        )


def _sign(bound: Bound) -> str:
    return "<" if bound.is_open else "<="


def _symbols(bound: Bound) -> list[sp.Symbol]:
    return sorted(bound.value.free_symbols, key=str)
