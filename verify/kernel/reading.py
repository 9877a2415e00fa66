"""Read formulas from text without simplification, except for the arithmetic of numbers.

    sum      product (+|- product)...        product  sign (*|/ sign)...
    sign     (+|-)... power                  power    atom (** sign)?
    atom     number, name, function(sum, ...), unknown[index, ...], #place, (sum)

``a/b`` is ``a*b**(-1)`` and ``-a`` is ``(-1)*a``; brackets keep sums and products apart; ``f'(z)``
is the derivative of an arbitrary function, or of a theta function in its first argument.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from flint import fmpq

from .axioms import FUNCTIONS
from .function_values import THETA
from .limits import DIGITS, EXPONENT, NAME, NESTING, NODES, ORDER, SHIFT, CertificateError, within
from .nodes import DOMAIN_WORDS, Nodes

TOKEN = re.compile(
    r"\s+|(?P<number>(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)"
    r"|(?P<name>[A-Za-z][A-Za-z0-9_]*)|(?P<place>\#[0-9]{1,5})"
    r"|(?P<sign>\*\*|<=|>=|!=|[-+*/()\[\]<>=,:'])",
    re.ASCII,
)

HIDDEN = ("Abs", "power", "parity", "diff", "jet", "theta")
"""Names of nodes that a text cannot use as names of functions."""


def arity(name: str) -> int:
    """Return the number of arguments of the function called ``name``; 0 if it is unknown."""
    name = "Abs" if name == "abs" else "" if name in HIDDEN else name
    return len(FUNCTIONS[name].letters) if name in FUNCTIONS else 0


def is_reserved(name: str) -> bool:
    """Return whether a name has a fixed meaning in every statement."""
    return name in ("I", "pi", "diff", "sqrt", *THETA, *DOMAIN_WORDS) or arity(name) > 0


@dataclass
class Scope:
    """Meanings of the names in a statement; an undeclared name becomes a real parameter."""

    nodes: Nodes
    variables: list[int] = field(default_factory=list)
    known: dict[str, int] = field(default_factory=dict)
    unknowns: list[str] = field(default_factory=list)
    pending: set[str] = field(default_factory=set)

    def node(self, name: str) -> int:
        """Return the node that a name means; raises CertificateError if it has no meaning."""
        if name in self.unknowns:
            return self.unknown(name, (0,) * len(self.variables))
        if name in self.known and not self.is_function(name):
            return self.known[name]
        if is_reserved(name) or name in self.pending or name in self.known:
            raise CertificateError(f"the name {name} has no meaning at this place")
        base, _, steps = name.partition("_")
        if steps and base in self.unknowns:
            letters = self.letters()
            if not set(steps) <= letters.keys():
                raise CertificateError(f"subscripts must be variables, got {base}_{steps[:40]}")
            within("the order of a derivative", len(steps), ORDER)
            return self.nodes.add("diff", self.node(base), *sorted(letters[s] for s in steps))
        self.refuse_likeness(name)
        return self.declare(name, "real")

    def is_function(self, name: str) -> bool:
        """Return whether a name means an arbitrary function."""
        return self.nodes.all[self.known[name]][::2] == ("symbol", "function")

    def declare(self, name: str, kind: str) -> int:
        """Give a new name to a new symbol, and return its node."""
        within("the length of a name", len(name), NAME)
        self.define(name, self.nodes.add("symbol", name, kind))
        return self.known[name]

    def define(self, name: str, node: int) -> None:
        """Give a new name to ``node``; raises CertificateError if the name is taken."""
        if name in (*self.known, *self.unknowns) or is_reserved(name):
            raise CertificateError(f"the name {name[:40]} means two things (rename it)")
        self.known[name] = node

    def unknown(self, name: str, shifts: tuple[int, ...]) -> int:
        """Return the node of an unknown, with an integer shift for each variable."""
        return self.nodes.add("unknown", self.unknowns.index(name), shifts)

    def letters(self) -> dict[str, int]:
        """Return the nodes of the variables by their names."""
        return {self.nodes.all[variable][1]: variable for variable in self.variables}

    def refuse_likeness(self, name: str) -> None:
        """Raise CertificateError for a name such as ``u_t``, ``ut`` or ``ubar`` of an unknown u."""
        letters = "|".join(map(re.escape, self.letters()))
        for unknown in self.unknowns:
            rest = name.removeprefix(unknown)
            like = rest.startswith("_") or rest in ("bar", "star", "conj", "dot", "prime")
            if name != rest and (like or (letters and re.fullmatch(f"(?:{letters})+", rest))):
                raise CertificateError(
                    f"the name {name} reads as a derivative or conjugate of {unknown} (rename it)"
                )


def tokens(text: object) -> list[tuple[str, str]]:
    """Split a text into pairs of kind and word; raises CertificateError for any other character."""
    if not isinstance(text, str):
        raise CertificateError(f"formulas must be text, got {type(text).__name__}")
    words, place = [], 0
    while place < len(text):
        match = TOKEN.match(text, place)
        if match is None:
            got = text[place : place + 20]
            raise CertificateError(f"formulas must follow the grammar, got {got!a}")
        if match.lastgroup is not None:
            words.append((match.lastgroup, match[0]))
        place = match.end()
    return words


def rational(text: str) -> fmpq:
    """Return the exact value of a decimal number.

    >>> rational("0.25"), rational("3e-1")
    (1/4, 3/10)
    """
    within("digits of a number", len(text), DIGITS)
    mantissa, _, power = text.lower().partition("e")
    whole, _, part = mantissa.partition(".")
    value = fmpq(int(whole + part or "0"), 10 ** len(part))
    return value * fmpq(10) ** int(power or "0")


class TextReader:
    """Parser of one text; ``places`` are the nodes that ``#0``, ``#1``, ... mean."""

    def __init__(self, scope: Scope, text: object, places: Sequence[int] = ()) -> None:
        self._scope, self._nodes, self._places = scope, scope.nodes, places
        self._words = [*tokens(text), ("end", "the end")]
        within("the words of a text", len(self._words), 10 * NODES)
        self._at, self._nesting = 0, 0

    @property
    def next(self) -> str:
        """The next word."""
        return self._words[self._at][1]

    @property
    def ended(self) -> bool:
        """Whether all words were read."""
        return self._words[self._at][0] == "end"

    def take(self, *signs: str) -> str:
        """Read the next word and return it if it is one of ``signs``; else return an empty text."""
        if self.ended or self.next not in signs:
            return ""
        self._at += 1
        return self._words[self._at - 1][1]

    def expect(self, *signs: str) -> str:
        """Read the next word and return it; raises CertificateError if it is none of ``signs``."""
        taken = self.take(*signs)
        if not taken:
            raise CertificateError(f"expected {' or '.join(signs)}, got {self.next[:40]!a}")
        return taken

    def name(self) -> str:
        """Read the next word, which must be a name, and return it."""
        if self._words[self._at][0] != "name":
            raise CertificateError(f"expected a name, got {self.next[:40]!a}")
        return self.take(self.next)

    def end(self) -> None:
        """Raise CertificateError if words are left."""
        if not self.ended:
            raise CertificateError(f"expected the end of the formula, got {self.next[:40]!a}")

    def whole(self) -> int:
        """Read a sum that must extend to the end of the text; return its node."""
        total = self.sum()
        self.end()
        return total

    def sum(self) -> int:
        """Read a sum of one or more terms; return its node."""
        self._nesting = within("brackets in brackets", self._nesting + 1, NESTING)
        terms = [self._product(fmpq(1))]
        while sign := self.take("+", "-"):
            terms.append(self._product(fmpq(1 if sign == "+" else -1)))
        self._nesting -= 1
        return terms[0] if len(terms) == 1 else self._nodes.add("Add", *terms)

    def _product(self, number: fmpq) -> int:
        """Read a product; return its node, with ``number`` and all numbers in it as one factor."""
        factors: list[int] = []
        sign = "*"
        while sign:
            while turned := self.take("+", "-"):
                number = number if turned == "+" else -number
            factor = self._power()
            value = self._nodes.value(factor)
            if value is not None and (sign == "*" or value != 0):
                number = number * value if sign == "*" else number / value
                within("the bits of a number", number.height_bits(), 4 * DIGITS)
            else:
                factors.append(factor if sign == "*" else self.power(factor, fmpq(-1)))
            sign = self.take("*", "/")
        if number != 1 or not factors:
            factors.insert(0, self._nodes.add("number", number))
        return self._nodes.product(*factors)

    def _power(self) -> int:
        base = self.atom()
        if not self.take("**"):
            return base
        negative = fmpq(1)
        while turned := self.take("+", "-"):
            negative = negative if turned == "+" else -negative
        exponent = self._power()
        value = self._nodes.value(exponent)
        if value is not None:
            return self.power(base, negative * value)
        return self._power_of(base, exponent if negative == 1 else self._nodes.negative(exponent))

    def power(self, base: int, exponent: fmpq) -> int:
        """Return the node of the principal power ``base**exponent`` with a rational exponent."""
        for part, what in ((exponent.p, "exponents"), (exponent.q, "the degree of a root")):
            within(what, abs(int(part)), EXPONENT)
        return base if exponent == 1 else self._nodes.add("Pow", base, exponent)

    def _power_of(self, base: int, exponent: int) -> int:
        """Return the node of a power with symbols in the exponent; (-r)**n is (-1)**n r**n."""
        value, add = self._nodes.value(base), self._nodes.add
        if value == 0:
            raise CertificateError("0 must not be raised to a symbol")
        if value is None or value > 0 or not self._nodes.is_integer(exponent):
            return add("power", base, exponent)
        turn = add("parity", exponent)
        if value == -1:
            return turn
        return add("Mul", turn, add("power", add("number", -value), exponent))

    def atom(self) -> int:
        """Read a number, name, function call, reference or bracketed sum; return its node."""
        kind, word = self._words[self._at]
        self._at += kind != "end"
        match kind:
            case "number":
                return self._nodes.add("number", rational(word))
            case "place" if int(word[1:]) < len(self._places):
                return self._places[int(word[1:])]
            case "sign" if word == "(":
                inner = self.sum()
                self.expect(")")
                return inner
            case "name" if self.next in ("(", "'"):
                return self._function(word)
            case "name" if self.next == "[" and word in self._scope.unknowns:
                return self._unknown(word)
            case "name" if word in ("I", "pi"):
                return self._nodes.add(word)
            case "name":
                return self._scope.node(word)
        raise CertificateError(f"expected a formula, got {word[:40]!a}")

    def _listed(self, opening: str, closing: str) -> list[int]:
        self.expect(opening)
        arguments = [self.sum()]
        while self.take(","):
            arguments.append(self.sum())
        self.expect(closing)
        return arguments

    def _function(self, name: str) -> int:
        order = 0
        while self.take("'"):
            order = within("the order of a derivative", order + 1, 2 * ORDER)
        arguments, scope, add = self._listed("(", ")"), self._scope, self._nodes.add
        free = name in THETA or (name in scope.known and scope.is_function(name))
        if free and len(arguments) == (2 if name in THETA else 1):
            return add("theta" if name in THETA else "jet", *arguments, (name, order))
        if free or order:
            raise CertificateError(f"no function with derivatives is called {name[:40]}")
        if name == "diff" and 1 < len(arguments) <= ORDER + 1:
            return add("diff", arguments[0], *sorted(self._steps(arguments[1:])))
        if name == "sqrt" and len(arguments) == 1:
            return self.power(arguments[0], fmpq(1, 2))
        if arity(name) != len(arguments):
            raise CertificateError(
                f"no function of {len(arguments)} arguments is called {name[:40]}"
            )
        return add("Abs" if name == "abs" else name, *arguments)

    def _steps(self, listed: Sequence[int]) -> list[int]:
        """Return the variables of a derivative, with ``x, 3`` expanded to ``x, x, x``."""
        steps: list[int] = []
        for node in listed:
            count = self._nodes.value(node)
            if steps and count is not None and count.q == 1 and 0 < count <= ORDER:
                steps += steps[-1:] * (int(count.p) - 1)
            else:
                steps.append(node)
        if not set(steps) <= set(self._scope.variables):
            raise CertificateError("derivatives must be in the statement's variables")
        within("the order of a derivative", len(steps), ORDER)
        return steps

    def _unknown(self, name: str) -> int:
        """Read ``u[n+1]``, with one index for each integer variable or for each variable."""
        indices, variables = self._listed("[", "]"), self._scope.variables
        sites = [v for v in variables if self._nodes.all[v][2] == "integer"]
        shifts = dict.fromkeys(variables, 0)
        along = sites if len(indices) == len(sites) else variables
        if len(indices) != len(along):
            raise CertificateError(f"the unknown {name} must have an index for each site")
        for variable, index in zip(along, indices, strict=True):
            terms = self._nodes.terms(index)
            values = [value for value in map(self._nodes.value, terms) if value is not None]
            shifts[variable] = int(sum(value.p for value in values))
            whole = all(value.q == 1 for value in values)
            if not whole or variable not in terms or len(values) != len(terms) - 1:
                raise CertificateError("an index must be a variable plus an integer")
            within("a shift", abs(shifts[variable]), SHIFT)
        return self._scope.unknown(name, tuple(shifts.values()))


def formula(scope: Scope, text: object, places: Sequence[int] = ()) -> int:
    """Parse a whole text; return its node."""
    return TextReader(scope, text, places).whole()


def axiom(nodes: Nodes, text: str, **letters: int) -> int:
    """Parse an axiom with nodes in place of its letters; return its node."""
    return formula(Scope(nodes, known=letters), text)
