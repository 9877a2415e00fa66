"""One generator of a differential field, and the list of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import sympy as sp


class Unsupported(ValueError):
    """The expression contains something that has no entry in the table of generators."""


@dataclass(frozen=True)
class Generator:
    """A symbol, what it stands for, its derivatives, and the power of it that is known.

    ``meaning`` is written in the variables and parameters of the formula; ``slopes`` (one for
    each variable, 0 if absent) and the relation ``symbol**degree = value`` in the generators.
    """

    symbol: sp.Symbol
    meaning: sp.Expr
    slopes: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    degree: int = 0
    value: sp.Expr = sp.S.Zero


class GeneratorList:
    """Generators in the order of registration; a relation's value contains earlier ones only."""

    def __init__(self) -> None:
        self._found: dict[sp.Expr, Generator] = {}
        self._names: set[str] = set()

    def __iter__(self) -> Iterator[Generator]:
        return iter(self._found.values())

    def __len__(self) -> int:
        return len(self._found)

    def known(self, meaning: sp.Expr) -> sp.Symbol | None:
        """The symbol that stands for ``meaning``, if there is one."""
        generator = self._found.get(meaning)
        return None if generator is None else generator.symbol

    def symbol(self, name: str) -> sp.Symbol:
        """A new symbol called ``name``, numbered where that is taken."""
        unique, number = name, 1
        while unique in self._names:
            number += 1
            unique = f"{name}_{number}"
        self._names.add(unique)
        return sp.Symbol(unique)

    def add(self, generator: Generator) -> sp.Symbol:
        """Register a generator made with `symbol`; return its symbol."""
        self._found[generator.meaning] = generator
        return generator.symbol
