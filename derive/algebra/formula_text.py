"""Formulas in text, read with a whitelist: tokens, a precedence parser, errors with a caret.

The parser builds a syntax tree (`formula_tree`); nothing is evaluated as Python.  A caller passes a
`Vocabulary`: the functions, variables, fields and names that the texts may contain.  Numbers are
exact (``0.1`` is 1/10), ``**`` binds as in Python, ``u_xxt`` and ``diff(u, x, x, t)`` are
derivatives, ``q[n+1]`` is a field at a lattice site.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import sympy as sp
from sympy.core.function import AppliedUndef

from longwave.derive.algebra import formula_tree as syntax
from longwave.derive.algebra.bounded_building import HIGHEST_DERIVATIVE
from longwave.support.known_names import did_you_mean

LONGEST = 20_000
"""Longest formula that is read, in characters."""

DEEPEST = 40
"""Deepest nesting of brackets and exponents."""

MOST_DIGITS = 100
"""Most digits of a number, and largest exponent of ten of a decimal."""

NAME_LENGTH = 40
"""Longest name, in characters."""

MOST_SHIFT = 1000
"""Largest shift in the index of a lattice site, such as 1 in ``q[n+1]``."""

ROWS = " (one site is read; write a row of a second one m as an unknown: v[n] for u[n,m+1])"
"""End of the error message for a site with two indices: each row needs an unknown of its own."""

WINDOW = 60
"""Number of characters of the text that are shown in the picture of an error."""

CONSTANTS = {"pi": sp.pi, "I": sp.I}

_TOKEN = re.compile(
    r"(?P<space>[ \t\r\n]+)"
    r"|(?P<number>(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)"
    r"|(?P<name>[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)*)"
    r"|(?P<sign>\*\*|<=|>=|!=|;;|[-+*/()\[\],=<>:;])",
    re.ASCII,
)
_REMEDIES = {
    "^": "write ** for a power",
    "_": "names begin with a letter and hold _ before a derivative's variables only",
    "{": "write round brackets",
    "}": "write round brackets",
    "|": "write abs(...)",
    "'": "write u_x for a derivative",
    '"': "write the formula without quotes",
}


class FormulaError(ValueError):
    """Error in a text that cannot be read; its note is a picture of the position in the text.

    ``text`` and ``position`` locate the error; `picture` shows it with a caret.
    """

    def __init__(self, name: str, words: str, text: str, position: int) -> None:
        super().__init__(f"{name}: {words} (column {position + 1})")
        self.name, self.words, self.text, self.position = name, words, text, position
        self.add_note(self.picture)

    def within(self, location: str) -> FormulaError:
        """Return the same error, with ``location`` before the name of the text."""
        return FormulaError(f"{location}: {self.name}", self.words, self.text, self.position)

    @property
    def picture(self) -> str:
        """Two lines: the text around the position, and a caret below it."""
        start = max(0, min(self.position - WINDOW // 2, len(self.text) - WINDOW))
        excerpt = self.text[start : start + WINDOW]
        plain = "".join(c if c.isascii() and c.isprintable() else "?" for c in excerpt)
        left = "..." if start else ""
        right = "..." if start + WINDOW < len(self.text) else ""
        caret = " " * (len(left) + self.position - start) + "^"
        return f"    {left}{plain}{right}\n    {caret}"


@dataclass(frozen=True)
class Token:
    """A token: its kind (number, name, sign, end), its characters, and its position in the text."""

    kind: str
    text: str
    start: int

    def __str__(self) -> str:
        return "the end" if self.kind == "end" else f"'{self.text[:NAME_LENGTH]}'"


@dataclass(frozen=True)
class Vocabulary:
    """Words that a text may contain.

    ``functions`` has each function with its number of arguments, ``variables`` the independent
    variables by letter, ``fields`` the unknowns as applied functions (with the site as their first
    argument if they are indexed), ``names`` everything else.  ``unknown_name`` returns the symbol
    of any other name; without it such a name is an error.
    """

    functions: Mapping[str, tuple[Callable[..., sp.Expr], int]]
    variables: Mapping[str, sp.Symbol] = field(default_factory=dict)
    fields: Mapping[str, AppliedUndef] = field(default_factory=dict)
    names: Mapping[str, sp.Expr] = field(default_factory=dict)
    unknown_name: Callable[[str], sp.Expr] | None = None
    site: sp.Symbol | None = None

    def meaning(self, name: str) -> sp.Expr | None:
        """Return the expression of a name that is no field or function; None for an unknown name.

        Raises ValueError, as ``unknown_name`` does, for a name that is likely to be a misspelling.
        """
        for known in (CONSTANTS, self.variables, self.names):
            if name in known:
                return known[name]
        return None if "_" in name or self.unknown_name is None else self.unknown_name(name)


def tokens(text: str, name: str = "formula") -> list[Token]:
    """Split a text into tokens, with one of kind "end" last.

    Raises FormulaError, with ``name`` for the text, for a character that no formula contains.

    >>> [token.text for token in tokens("2*u_xx")]
    ['2', '*', 'u_xx', '']
    """
    if not isinstance(text, str):
        raise TypeError(f"{name} must be text, got {type(text).__name__} (such as 'u_t + u_xxx')")
    if len(text) > LONGEST:
        words = f"texts must have at most {LONGEST} characters, got {len(text)}"
        raise FormulaError(name, words, text, LONGEST)
    result: list[Token] = []
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            sign = text[position]
            remedy = _REMEDIES.get(sign, "letters of ASCII, digits and + - * / ** ( ) [ ] are read")
            words = f"expected a formula, got {sign!a} ({remedy})"
            raise FormulaError(name, words, text, position)
        if match.lastgroup != "space":
            result.append(Token(str(match.lastgroup), match[0], position))
        position = match.end()
    return [*result, Token("end", "", len(text))]


class Parser:
    """Recursive-descent parser of formulas from tokens.

    ``used`` collects the names that occur.
    """

    def __init__(
        self, text: str, words: Sequence[Token], vocabulary: Vocabulary, name: str
    ) -> None:
        self.text, self.words, self.vocabulary, self.name = text, words, vocabulary, name
        self.position = self._depth = 0
        self.used: set[str] = set()

    @property
    def next(self) -> Token:
        """The next token, which is not consumed."""
        return self.words[self.position]

    def take(self) -> Token:
        """Consume and return the next token."""
        token = self.next
        self.position = min(self.position + 1, len(self.words) - 1)
        return token

    def take_sign(self, *signs: str) -> Token | None:
        """Consume and return the next token if it is one of ``signs``, else return None."""
        return self.take() if self.next.kind == "sign" and self.next.text in signs else None

    def expect(self, sign: str, why: str = "") -> Token:
        """Consume and return the token ``sign``. Raises FormulaError, with ``why``, for another."""
        token_ = self.take_sign(sign)
        if token_ is None:
            raise self.error(f"expected '{sign}'{why}, got {self.next}")
        return token_

    def expect_end(self) -> None:
        """Raise FormulaError if tokens are left."""
        if self.next.kind != "end":
            juxtaposed = self.next.kind in ("number", "name") or self.next.text == "("
            expected = "an operator such as *" if juxtaposed else "an operator or the end"
            raise self.error(f"expected {expected}, got {self.next}")

    def error(self, words: str, token: Token | None = None) -> FormulaError:
        """Return the error with the message ``words`` at a token, by default the next one."""
        return self.error_at((token or self.next).start, words)

    def error_at(self, position: int, words: str) -> FormulaError:
        """Return the error with the message ``words`` at a position in the text."""
        return FormulaError(self.name, words, self.text, position)

    def formula(self) -> syntax.FormulaTree:
        """Parse a sum."""
        start = self.next.start
        terms = [self._term()]
        while sign := self.take_sign("+", "-"):
            term = self._term()
            minus = sign.text == "-"
            terms.append(syntax.Product((syntax.MINUS_ONE, term), at=sign.start) if minus else term)
        return terms[0] if len(terms) == 1 else syntax.Sum(tuple(terms), at=start)

    def whole(self) -> syntax.FormulaTree:
        """Parse a sum that must end the text."""
        tree = self.formula()
        self.expect_end()
        return tree

    def _term(self) -> syntax.FormulaTree:
        """Parse a product; numbers and signs remain separate factors."""
        start = self.next.start
        factors = self._signed()
        while sign := self.take_sign("*", "/"):
            further = self._signed()
            if sign.text == "/":
                divisor = _product(further, sign.start)
                further = [syntax.Power((divisor, syntax.MINUS_ONE), at=sign.start)]
            factors += further
        return _product(factors, start)

    def _signed(self) -> list[syntax.FormulaTree]:
        """Parse a power with its sign; return it as factors, with -1 first if negative."""
        start, negative = self.next, False
        while sign := self.take_sign("+", "-"):
            negative ^= sign.text == "-"
        self._depth += 1
        if self._depth > DEEPEST:
            raise self.error(f"brackets and powers must be at most {DEEPEST} deep", start)
        operand = self._power()
        self._depth -= 1
        return [syntax.MINUS_ONE, operand] if negative else [operand]

    def _power(self) -> syntax.FormulaTree:
        base = self._operand()
        sign = self.take_sign("**")
        if sign is None:
            return base
        return syntax.Power((base, _product(self._signed(), sign.start)), at=sign.start)

    def _operand(self) -> syntax.FormulaTree:
        token = self.next
        if token.kind == "number":
            return self._number(self.take())
        if token.kind == "name":
            return self._named(self.take())
        if self.take_sign("("):
            tree = self.formula()
            self.expect(")", f" for the '(' of column {token.start + 1}")
            return tree
        raise self.error(f"expected a number, a name or '(', got {token}")

    def _number(self, token: Token) -> syntax.Number:
        digits, _, exponent = token.text.lower().partition("e")
        if max(len(digits), abs(int(exponent[:5] or 0))) > MOST_DIGITS or len(exponent) > 5:
            raise self.error(f"numbers must have at most {MOST_DIGITS} digits", token)
        following = self.next
        if following.kind == "name" and following.start == token.start + len(token.text):
            raise self.error(f"expected an operator such as *, got {following}", following)
        return syntax.Number(Fraction(token.text), at=token.start)

    def _named(self, token: Token) -> syntax.FormulaTree:
        name, words = token.text, self.vocabulary
        if len(name) > NAME_LENGTH:
            raise self.error(f"names must have at most {NAME_LENGTH} characters", token)
        if self.next.text == "(" and self.next.kind == "sign":
            return self._call(token)
        if name in words.functions or name == "diff":
            raise self.error(f"expected '(' after the function {name}, got {self.next}")
        base, _, steps = name.partition("_")
        if base in words.fields:
            return self._field(token, base, steps)
        self.used.add(name)
        try:
            is_known = words.meaning(name) is not None
        except ValueError as error:
            raise self.error(str(error), token) from None
        if not is_known:
            expectation = "a name without _" if "_" in name else "a known name"
            raise self.error(f"expected {expectation}, got {token}{self._nearest(name)}", token)
        return syntax.Name(name, at=token.start)

    def _field(self, token: Token, base: str, steps: str) -> syntax.Unknown:
        """Parse the site of the unknown ``base``, if it has one; ``steps`` are its derivatives."""
        site, arguments = self.vocabulary.site, self.vocabulary.fields[base].args
        self.used.add(base)
        index, shift = str(site) if site in arguments else "", 0
        if index:
            self.expect("[", f" after the lattice field {base}")
            shift = self._shift(index)
        variables = self.vocabulary.variables
        known = [str(a) for a in arguments if a != site]
        for letter in steps:
            if letter not in known or letter not in variables:
                words = f"expected variables of {base} behind _ ({' '.join(known)}), got {token}"
                derived = (w.text.partition("_") for w in self.words)
                letters = dict.fromkeys("".join(end for start, _, end in derived if start == base))
                if steps.isalpha():
                    words += f" (or name all of them: --variables {','.join(letters)})"
                raise self.error(words, token)
        return syntax.Unknown(base, tuple(steps), index, shift, at=token.start)

    def _shift(self, site: str) -> int:
        """Parse the integer in an index such as ``n+1``, with its closing bracket."""
        start = self.next
        index = self.formula()
        if self.next.text == ",":
            raise self.error(f"expected ']' after the site, got ','{ROWS}")
        self.expect("]", " after the site")
        terms = index.inner() if isinstance(index, syntax.Sum) else (index,)
        offsets = [syntax.rational(term) for term in terms if term != syntax.Name(site)]
        shift = sum((value for value in offsets if value is not None), Fraction(0))
        whole = len(offsets) == len(terms) - 1 and None not in offsets and shift.denominator == 1
        if not whole or abs(shift) > MOST_SHIFT:
            raise self.error(f"expected a site such as {site}+1, got another index", start)
        return int(shift)

    def _call(self, token: Token) -> syntax.FormulaTree:
        name, functions = token.text, self.vocabulary.functions
        if name == "diff":
            return self._derivative(token)
        if name not in functions:
            remedy = self._nearest(name, functions)
            known = name in self.vocabulary.names or name in self.vocabulary.fields
            if known or name in self.vocabulary.variables or (len(name) == 1 and not remedy):
                may_be_declared = self.vocabulary.unknown_name is not None and not known
                other = f", or declare {name}: function" if may_be_declared else ""
                remedy = f" (write {name}*(...) for a product{other})"
            raise self.error(f"expected a known function, got '{name}'{remedy}", token)
        arity = functions[name][1]
        arguments = [argument for argument, _ in self._arguments(token)]
        if len(arguments) != arity:
            plural = "" if arity == 1 else "s"
            words = f"expected {arity} argument{plural} of {name}, got {len(arguments)}"
            raise self.error(words, token)
        return syntax.Call(tuple(arguments), name, at=token.start)

    def _arguments(self, token: Token) -> Iterator[tuple[syntax.FormulaTree, str]]:
        """Parse the arguments of a call; yield each with its text."""
        sign: Token | None = self.expect("(")
        while sign:
            start = self.next.start
            argument = self.formula()
            yield argument, self.text[start : self.next.start].strip()
            sign = self.take_sign(",")
        self.expect(")", f" for the '(' of {token.text}")

    def _derivative(self, token: Token) -> syntax.Derivative:
        """Parse ``diff(expression, x, x)``, or the same as ``diff(expression, x, 2)``."""
        (expression, _), *steps = self._arguments(token)
        variables: list[str] = []
        known = self.vocabulary.variables.keys() - {str(self.vocabulary.site)}
        for step, text in steps:
            count = syntax.rational(step)
            if isinstance(step, syntax.Name) and step.name in known:
                variables.append(step.name)
            elif variables and count and count.denominator == 1 and 0 < count <= HIGHEST_DERIVATIVE:
                variables += [variables[-1]] * (int(count) - 1)
            else:
                words = f"expected variables behind the first argument of diff, got {text}"
                raise self.error(words, token)
        if not variables:
            raise self.error("expected a variable in diff, as in diff(u, x)", token)
        return syntax.Derivative((expression,), tuple(variables), at=token.start)

    def _nearest(self, name: str, among: Iterable[str] | None = None) -> str:
        words = self.vocabulary
        known = [*words.functions, *words.names, *words.fields] if among is None else [*among]
        close = did_you_mean(name, known, 1)
        return f" ({close})" if close else ""


def _product(factors: list[syntax.FormulaTree], at: int) -> syntax.FormulaTree:
    return factors[0] if len(factors) == 1 else syntax.Product(tuple(factors), at=at)
