"""Formulas as syntax trees of a few kinds of nodes, as they were typed: nothing is simplified.

``a - b`` is ``a + (-1)*b``, ``a/b`` is ``a*b**(-1)``; brackets keep sums and products apart.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import prod


@dataclass(frozen=True)
class FormulaTree:
    """A node of a formula's syntax tree; ``at`` is the position of its sign or name in the text."""

    at: int = field(default=0, compare=False, kw_only=True)

    def inner(self) -> tuple[FormulaTree, ...]:
        """Return the child nodes."""
        return ()

    def made_of(self, parts: tuple[FormulaTree, ...]) -> FormulaTree:
        """Return a node of the same class with the children ``parts``, as many as before."""
        return self

    def nodes(self) -> Iterator[FormulaTree]:
        """Yield the nodes of the tree, children before parents."""
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
    """An unknown with the derivatives ``steps`` in its subscript and the index ``site + shift``."""

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
    """A sum of two or more terms."""


@dataclass(frozen=True)
class Product(_OfParts):
    """A product of two or more factors."""


@dataclass(frozen=True)
class Power(_OfParts):
    """A power with a base and an exponent."""


@dataclass(frozen=True)
class Call(_OfParts):
    """A function call with its arguments."""

    name: str


@dataclass(frozen=True)
class Derivative(_OfParts):
    """The derivative of one formula in variables, one after the other."""

    steps: tuple[str, ...]


MINUS_ONE = Number(Fraction(-1))


LARGEST_POWER = 64
"""Largest exponent for which `rational` evaluates a power."""


def rational(formula: FormulaTree) -> Fraction | None:
    """Return the value of sums, products and integer powers of numbers; None for any other."""
    values = [rational(part) for part in formula.inner()]
    numbers = [value for value in values if value is not None]
    if len(numbers) < len(values):
        return None
    match formula:
        case Number(value=value):
            return value
        case Sum():
            return sum(numbers, Fraction(0))
        case Product():
            return Fraction(prod(numbers))
        case Power() if numbers[1].denominator == 1 and abs(numbers[1]) <= LARGEST_POWER:
            return Fraction(numbers[0] ** int(numbers[1])) if numbers[0] or numbers[1] > 0 else None
    return None


def mapped(formula: FormulaTree, image: Callable[[FormulaTree], FormulaTree | None]) -> FormulaTree:
    """Replace nodes by ``image(node)``, from the root down; where it is None, map the children."""
    replacement = image(formula)
    if replacement is not None:
        return replacement
    parts = tuple(mapped(part, image) for part in formula.inner())
    return formula.made_of(parts) if parts else formula


SUM, PRODUCT, POWER, ATOM = range(4)
"""Binding strengths of the outermost operation of a text, weakest first."""

Part = tuple[str, int]
"""Text, and the binding strength of its outermost operation."""


def formula_text(formula: FormulaTree) -> str:
    """Return the formula as text that is parsed to the same tree."""
    return _write(formula, True)[0]


def plain_text(formula: FormulaTree) -> str:
    """Return the formula as users type it, with few brackets; it is parsed to an equal formula.

    >>> plain_text(Product((MINUS_ONE, Name("x"), Power((Name("t"), MINUS_ONE)))))
    '-x/t'
    """
    return _write(formula, False)[0]


Quotient = tuple[bool, tuple[FormulaTree, ...], tuple[FormulaTree, ...]]
"""Parts of a product: whether it has a minus sign, numerator factors, denominator factors."""


def quotient(formula: FormulaTree) -> Quotient:
    """Split a product as typed: a first -1 is the sign, factors with exponent -1 are divisors."""
    parts = formula.inner() if isinstance(formula, Product) else (formula,)
    minus = parts[0] == MINUS_ONE and len(parts) > 1
    parts = parts[1:] if minus else parts
    if minus and isinstance(parts[0], Product) and len(parts) == 1:  # of a difference
        is_negative, *both = quotient(parts[0])
        return not is_negative, both[0], both[1]
    divisors = [part for part in parts if isinstance(part, Power) and part.parts[1] == MINUS_ONE]
    numerator = tuple(part for part in parts if part not in divisors)
    return minus, numerator, tuple(part.parts[0] for part in divisors)


def signed_sum(terms: Sequence[str]) -> str:
    """Join the terms of a sum; a minus sign at the start of a term becomes the operator."""
    first, *others = terms
    return first + "".join(f" - {t[1:]}" if t[0] == "-" else f" + {t}" for t in others)


def _write(formula: FormulaTree, exact: bool) -> Part:
    """Return the text and its binding strength; ``exact`` text is read back as the same tree."""

    def enclosed(part: FormulaTree, binding: int) -> str:
        text, level = _write(part, exact)
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
            head, *others = above or (Number(Fraction(1)),)
            is_first = isinstance(head, Number) and not minus
            texts = [enclosed(head, PRODUCT if is_first else POWER)]
            texts += [enclosed(part, POWER) for part in others]
            text = "-" * minus + "*".join(texts)
            return text + "".join(f"/{enclosed(part, POWER)}" for part in below), PRODUCT
        case Call(parts=parts, name=name):
            return f"{name}({', '.join(enclosed(part, SUM) for part in parts)})", ATOM
        case Derivative(parts=(inner,), steps=steps):
            return f"diff({', '.join((enclosed(inner, SUM), *steps))})", ATOM
    raise TypeError(f"formula must be a node of a tree, got {type(formula).__name__}")
