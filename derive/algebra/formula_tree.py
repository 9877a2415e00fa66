"""Formulas as trees of a few kinds of nodes, as they were typed: nothing is simplified.

``a - b`` is ``a + (-1)*b``, ``a/b`` is ``a*b**(-1)``; brackets keep sums and products apart.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import prod


@dataclass(frozen=True)
class FormulaTree:
    """A node; ``at`` is where its sign or name stands in the text."""

    at: int = field(default=0, compare=False, kw_only=True)

    def inner(self) -> tuple[FormulaTree, ...]:
        """Return the formulas that it is made of."""
        return ()

    def made_of(self, parts: tuple[FormulaTree, ...]) -> FormulaTree:
        """Return a node of the same kind with as many other parts."""
        return self

    def nodes(self) -> Iterator[FormulaTree]:
        """Yield the nodes of the tree, parts before the whole."""
        for part in self.inner():
            yield from part.nodes()
        yield self


@dataclass(frozen=True)
class Number(FormulaTree):
    """A rational number."""

    value: Fraction


@dataclass(frozen=True)
class Name(FormulaTree):
    """A variable, a parameter or a constant."""

    name: str


@dataclass(frozen=True)
class Unknown(FormulaTree):
    """An unknown with the derivatives of its subscripts, ``shift`` places from its ``site``."""

    name: str
    steps: tuple[str, ...] = ()
    site: str = ""
    shift: int = 0


@dataclass(frozen=True)
class _OfParts(FormulaTree):
    parts: tuple[FormulaTree, ...]

    def inner(self) -> tuple[FormulaTree, ...]:
        return self.parts

    def made_of(self, parts: tuple[FormulaTree, ...]) -> FormulaTree:
        return replace(self, parts=parts)


@dataclass(frozen=True)
class Sum(_OfParts):
    """Two or more terms."""


@dataclass(frozen=True)
class Product(_OfParts):
    """Two or more factors."""


@dataclass(frozen=True)
class Power(_OfParts):
    """A base and an exponent."""


@dataclass(frozen=True)
class Call(_OfParts):
    """A function of its arguments."""

    name: str


@dataclass(frozen=True)
class Derivative(_OfParts):
    """The derivative of one formula in variables one after the other."""

    steps: tuple[str, ...]


MINUS_ONE = Number(Fraction(-1))


WHOLE = 64
"""Largest exponent of a number that is worked out."""


def rational(formula: FormulaTree) -> Fraction | None:
    """Return the value of what is made of numbers by sums, products and whole powers; else None."""
    values = [rational(part) for part in formula.inner()]
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return None
    match formula:
        case Number(value=value):
            return value
        case Sum():
            return sum(known, Fraction(0))
        case Product():
            return Fraction(prod(known))
        case Power() if known[1].denominator == 1 and abs(known[1]) <= WHOLE:
            return Fraction(known[0] ** int(known[1])) if known[0] or known[1] > 0 else None
    return None


def mapped(formula: FormulaTree, image: Callable[[FormulaTree], FormulaTree | None]) -> FormulaTree:
    """Return the formula with ``image`` of a node in its place, from the top; None leaves it."""
    found = image(formula)
    if found is not None:
        return found
    parts = tuple(mapped(part, image) for part in formula.inner())
    return formula.made_of(parts) if parts else formula


SUM, PRODUCT, POWER, ATOM = range(4)
"""How strongly the outermost sign of a text binds."""

Part = tuple[str, int]
"""A text, and how strongly its outermost sign binds."""


def formula_text(formula: FormulaTree) -> str:
    """Return the formula in the grammar, read back as this tree."""
    return _written(formula, True)[0]


def plain_text(formula: FormulaTree) -> str:
    """Return the formula as one types it: an equal one is read back, with fewer brackets.

    >>> plain_text(Product((MINUS_ONE, Name("x"), Power((Name("t"), MINUS_ONE)))))
    '-x/t'
    """
    return _written(formula, False)[0]


Quotient = tuple[bool, tuple[FormulaTree, ...], tuple[FormulaTree, ...]]
"""Whether there is a minus sign, what is above the line, and what is below it."""


def quotient(formula: FormulaTree) -> Quotient:
    """Return a product as it is typed: a first -1 is a sign, exponents -1 are below the line."""
    parts = formula.inner() if isinstance(formula, Product) else (formula,)
    minus = parts[0] == MINUS_ONE and len(parts) > 1
    parts = parts[1:] if minus else parts
    if minus and isinstance(parts[0], Product) and len(parts) == 1:  # of a difference
        turned, *both = quotient(parts[0])
        return not turned, both[0], both[1]
    below = [part for part in parts if isinstance(part, Power) and part.parts[1] == MINUS_ONE]
    above = tuple(part for part in parts if part not in below)
    return minus, above, tuple(part.parts[0] for part in below)


def signed_sum(terms: Sequence[str]) -> str:
    """Return a sum with the minus signs that its terms begin with."""
    first, *rest = terms
    return first + "".join(f" - {t[1:]}" if t[0] == "-" else f" + {t}" for t in rest)


def _written(formula: FormulaTree, exact: bool) -> Part:
    """Return the text, and how strongly its outermost sign binds."""

    def enclosed(part: FormulaTree, binding: int) -> str:
        text, level = _written(part, exact)
        return text if level >= binding else f"({text})"

    match formula:
        case Number(value=value):
            if value.denominator == 1 and value >= 0:
                return str(value), ATOM
            return (f"({value})", ATOM) if exact else (str(value), PRODUCT)
        case Name(name=name):
            return name, ATOM
        case Unknown(name=name, steps=steps, site=site, shift=shift):
            subscripts = f"_{''.join(steps)}" if steps else ""
            index = f"{site}{shift:+d}" if shift else site
            return f"{name}{subscripts}" + (f"[{index}]" if site else ""), ATOM
        case Sum(parts=parts):
            terms = [enclosed(part, PRODUCT) for part in parts]
            return " + ".join(terms) if exact else signed_sum(terms), SUM
        case Power(parts=(base, exponent)) if exact or exponent != MINUS_ONE:
            return f"{enclosed(base, ATOM)}**{enclosed(exponent, ATOM)}", POWER
        case Product(parts=parts) if exact:
            return "*".join(enclosed(part, POWER) for part in parts), PRODUCT
        case Product() | Power():
            minus, above, below = quotient(formula)
            head, *tail = above or (Number(Fraction(1)),)
            is_first = isinstance(head, Number) and not minus
            texts = [enclosed(head, PRODUCT if is_first else POWER)]
            texts += [enclosed(part, POWER) for part in tail]
            text = "-" * minus + "*".join(texts)
            return text + "".join(f"/{enclosed(part, POWER)}" for part in below), PRODUCT
        case Call(parts=parts, name=name):
            return f"{name}({', '.join(enclosed(part, SUM) for part in parts)})", ATOM
        case Derivative(parts=(inner,), steps=steps):
            return f"diff({', '.join((enclosed(inner, SUM), *steps))})", ATOM
    raise TypeError(f"formula must be a node of a tree, got {type(formula).__name__}")
