"""Formulas as other systems and papers write them, rewritten in the grammar of `formula_text`.

Rules are data: a pattern, what stands in its place, grouped in stages that are each applied until
nothing changes. Nothing here decides what a formula means: the caller reads what comes out, and
shows it only if it is of the grammar.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

from longwave.derive.algebra.foreign_characters import GREEK, ascii_text
from longwave.derive.algebra.typing_rules import (
    ALIASES,
    BRACES,
    CALLS,
    DERIVATIVES,
    END,
    LATEX,
    SITE,
    SPELLED_NUMBERS,
    TIDY,
    VARIABLES,
    Rule,
)
from longwave.support.known_names import close_names

LONGEST_CORRECTED = 400
"""Characters of a text that is rewritten, and of what comes out: an error is one line."""

FUNCTIONS_BY_NAME = ("gamma", "beta", "zeta", "Gamma", "Delta", "delta", "O")
"""Names that read as functions where a bracket follows, unless they are declared."""

ROUNDS = 40
"""Most applications of a stage: each moves one sign further in."""


@dataclass(frozen=True)
class Spelling:
    """Names of a text by kind: functions of the grammar, unknowns, declared names.

    ``variables`` are the letters of the independent variables that occur.
    """

    functions: Collection[str]
    unknowns: Collection[str] = ()
    variables: Collection[str] = ()
    declared: Collection[str] = ()

    def patterns(self) -> dict[str, str]:
        """The patterns that the short names in rules stand for."""
        unknown = _either(self.unknowns)
        derived = rf"(?<![\w.]){unknown}(?:_[{VARIABLES}]+)?(?![A-Za-z0-9_])(?:\[[^\[\]]*\])?"
        return {
            "<U>": unknown,
            "<D>": derived,
            "<F>": _either({*self.functions, "diff"}),
            "<A>": r"(?:[^()\[\],;|]|<()>|<[]>)++",
            "<()>": _nested(r"\(", r"\)"),
            "<[]>": _nested(r"\[", r"\]"),
            "<e>": _constant("eE", self.declared),
            "<i>": _constant("ij", self.declared),
        }


def corrected(text: str, spelling: Spelling) -> str:
    """The text with every rule applied; the text itself if it is too long.

    >>> corrected("2 k^2 Sech[k x]^2", Spelling({"sech"}))
    '2*k**2*sech(k*x)**2'
    """
    if len(text) > LONGEST_CORRECTED:
        return text
    patterns = spelling.patterns()
    text = ascii_text(text)
    for stage in _stages(spelling):
        rules = [(_filled(pattern, patterns), replacement) for pattern, replacement in stage]
        for _ in range(ROUNDS):
            before = text
            for pattern, replacement in rules:
                text = re.sub(pattern, replacement, text)
            if text == before or len(text) > 4 * LONGEST_CORRECTED:
                break
    return balanced(text)


def balanced(text: str) -> str:
    """The text without closing brackets too many, and with the missing ones at its end.

    >>> balanced("sech(k*(x - t)"), balanced("x)")
    ('sech(k*(x - t))', 'x')
    """
    found, depth = [], 0
    for sign in text:
        depth += (sign == "(") - (sign == ")")
        if depth < 0:
            depth = 0
        else:
            found.append(sign)
    return "".join(found) + ")" * depth


def _nested(opening: str, closing: str, depth: int = 6) -> str:
    """Brackets with brackets inside; possessive, so that no text takes long to be refused."""
    inside = rf"[^{opening}{closing}]*+"
    found = rf"{opening}{inside}{closing}"
    for _ in range(depth):
        found = rf"{opening}{inside}(?:{found}{inside})*+{closing}"
    return found


def _either(names: Collection[str]) -> str:
    longest_first = sorted(names, key=lambda name: (-len(name), name))
    return f"(?:{'|'.join(map(re.escape, longest_first))})" if names else "(?!)"


def _constant(letters: str, declared: Collection[str]) -> str:
    free = [letter for letter in letters if letter not in declared]
    return f"[{''.join(free)}]" if free else "(?!)"


def _filled(pattern: str, patterns: dict[str, str]) -> str:
    for _ in range(2):
        for short, meaning in patterns.items():
            pattern = pattern.replace(short, meaning)
    return pattern


# names


def misread(name: str, spelling: Spelling, *, declared: bool = False) -> str | None:
    """The spelling for a name that reads as a derivative, conjugate, index or product.

    None for a name of its own; one that is ``declared`` may look like a product.

    >>> misread("uxx", Spelling((), "u", "xt")), misread("x0", Spelling((), "u", "xt"))
    ('u_xx', None)
    """
    for pattern, text in _READINGS if declared else _READINGS + _LOOSE_READINGS:
        match = re.fullmatch(_filled(pattern, spelling.patterns()), name)
        if match and (base := match["base"]) in {*spelling.variables, *spelling.unknowns}:
            return match.expand(text) if text else _free_name(match["rest"], spelling, base)
    if called := _called(name, spelling, declared):
        return called
    match = re.fullmatch(rf"(\w+)([{VARIABLES}])", name)
    if match is None or declared or match[2] not in spelling.variables:
        return None
    factors = {*spelling.declared, *spelling.variables, *GREEK}
    is_product = len(match[1]) == 1 or match[1] in factors
    factor = "I" if match[1] in set("ij") - {*spelling.declared} else match[1]
    return f"{factor}*{match[2]}" if is_product else None


def _called(name: str, spelling: Spelling, declared: bool) -> str | None:
    """The call that a name such as ``sin2x`` reads as, of a letter that occurs."""
    match = re.fullmatch(rf"({_either(spelling.functions)})(\d*)([A-Za-z])", name)
    if match is None or declared or match[3] not in {*spelling.variables, *spelling.declared}:
        return None
    function, factor, letter = match.groups()
    return f"{function}({factor}*{letter})" if factor else f"{function}({letter})"


_READINGS: tuple[tuple[str, str], ...] = (
    (rf"(?P<base><U>)_?(?P<rest>[{VARIABLES}]+)", r"\g<base>_\g<rest>"),
    (r"(?P<base><U>)_?(?:bar|star|conj|conjugate|dag|dagger)", r"conjugate(\g<base>)"),
    (r"(?:conj|conjugate|bar)_?(?P<base><U>)", r"conjugate(\g<base>)"),
    (r"d\d?(?P<base><U>)", r"diff(\g<base>, x)"),
    (rf"(?P<base>[{VARIABLES}{SITE}])(?P<rest>[1-9]\d*)", ""),
)
"""Names that are refused though they are declared."""

_LOOSE_READINGS = (
    (r"(?P<base><U>)c", r"conjugate(\g<base>)"),
    (rf"(?P<base><U>){SITE}", rf"\g<base>[{SITE}]"),
    (rf"(?P<base><U>){SITE}p(?P<rest>\d)", rf"\g<base>[{SITE}+\g<rest>]"),
    (rf"(?P<base><U>){SITE}m(?P<rest>\d)", rf"\g<base>[{SITE}-\g<rest>]"),
    (r"(?P<base><U>)(?P<rest><U>(?:_[xyzt]+)?)", r"\g<base>*\g<rest>"),
    (rf"d(?P<base>[{VARIABLES}])\d?", r"diff(u, \g<base>)"),
)


def _free_name(digits: str, spelling: Spelling, base: str) -> str:
    """A name that no other has, in the place of a variable's with an index."""
    letters = (letter for letter in "abcdfghpqrs" if letter != base)
    names = (f"{letter}{digits}" for letter in letters)
    return next(name for name in names if name not in spelling.declared)


def _stages(spelling: Spelling) -> Iterator[tuple[Rule, ...]]:
    yield LATEX
    yield BRACES
    yield SPELLED_NUMBERS
    yield (*CALLS, *_calls(spelling), *DERIVATIVES, (_DIFF, _differentiated(spelling)))
    yield (*_products(spelling), *TIDY)
    yield (*TIDY, *END)


def _differentiated(spelling: Spelling) -> Callable[[re.Match[str]], str]:
    """``diff`` from ``D[u, {x, 2}]`` and the like; as a subscript where it can be."""
    unknown = re.compile(_either(spelling.unknowns))

    def written(found: re.Match[str]) -> str:
        name, inside = found["name"], found["inside"][1:-1]
        if name in spelling.declared:
            return found[0]
        first, *steps = _arguments(inside)
        if found["method"]:
            first, steps = found["method"], [s for s in (first, *steps) if s]
        letters = ""
        for step in ",".join(steps).replace("$", ",").replace("(", "").replace(")", "").split(","):
            plain = step.strip().strip("'")
            if plain in VARIABLES and len(plain) == 1:
                letters += plain
            elif plain in "123456789" and letters and plain:
                letters += letters[-1] * (int(plain) - 1)
            else:
                return found[0]
        if unknown.fullmatch(first.strip()) and (name != "diff" or found["method"]):
            return f"{first.strip()}_{letters}"
        return f"diff({first.strip()}, {', '.join(letters)})"

    return written


_DIFF = (
    r"(?:(?P<method><D>|(?<!\w)<()>)\s*\.\s*)?(?<!\w)"
    r"(?P<name>D|Diff|Derivative|pdiff|deriv|diff)\s*(?P<inside><()>|<[]>)"
)


def _arguments(text: str) -> list[str]:
    """The arguments between commas that are in no brackets."""
    found, depth = [""], 0
    for sign in text:
        depth += (sign in "([{") - (sign in ")]}")
        if sign == "," and not depth:
            found.append("")
        else:
            found[-1] += sign
    return found


def _calls(spelling: Spelling) -> tuple[Rule, ...]:
    """Functions by other names and in other brackets."""

    def named(found: re.Match[str]) -> str:
        name = found[0]
        other = ALIASES.get(name, name.lower())
        taken = name in spelling.functions or name in spelling.declared
        return other if other in spelling.functions and not taken else name

    continuous = [letter for letter in spelling.variables if letter in VARIABLES]

    def primed(found: re.Match[str]) -> str:
        unknown, site, primes = found.groups()
        letter = continuous[0] if continuous else "t" if site else ""
        if not letter or len(continuous) > 1:
            return found[0]
        steps = [letter] * len(primes)
        return (
            f"diff({unknown}{site}, {', '.join(steps)})" if site else f"{unknown}_{''.join(steps)}"
        )

    return (
        (r"(?<![\w.])(<U>)('+)(\[[^\[\]]*\])", r"\1\3\2"),
        (r"(?<![\w.])(<U>)(\[[^\[\]]*\])?('+)", primed),
        (r"(?<![\w.])[A-Za-z]\w*(?=\s*(?:[\[(]|\*\*|\s[\w(-]))", named),
        (r"(?<![\w.])(<F>(?:\*\*\w+)?)\s*\[((?:[^\[\]]|<[]>)*)\]", r"\1(\2)"),
        (r"(?<!\w)\[((?:[^\[\]]|<[]>)*)\]", r"(\1)"),
        (r"(?<![\w.])(?!<U>(?![A-Za-z0-9]))([A-Za-z]\w*)\s*\[((?:[^\[\]]|<[]>)*)\]", r"\1(\2)"),
    )


def _products(spelling: Spelling) -> tuple[Rule, ...]:
    """Functions without brackets, powers of functions, factors side by side, names."""

    def read(found: re.Match[str]) -> str:
        name = found[0]
        if name in spelling.functions or name in spelling.declared or name in spelling.unknowns:
            return name
        return misread(name, spelling) or name

    def multiplied(found: re.Match[str]) -> str:
        name = found[1]
        if name in {*spelling.functions, "diff"}:
            return found[0]
        free = len(name) > 2 and name not in {*spelling.declared, *GREEK}
        meant = close_names(name, spelling.functions, 1) if free else []
        if meant:
            return found[0].replace(name, meant[0])
        called = found[0] == name and found.string[found.end() :].startswith("(")
        is_function = free or (name in FUNCTIONS_BY_NAME and name not in spelling.declared)
        return found[0] if called and is_function else f"{name}*"

    atom = r"(?:\d+(?:\.\d+)?|(?!<F>\b)(?<![A-Za-z_])[A-Za-z]\w*|<()>)(?:\*\*(?:\w+|<()>))?"
    return (
        (r"(<F>)\*\*(-\d+)", r"\1**(\2)"),
        (r"(?<![\w.])(<F>)\s*\*\*\s*(\w+|<()>)\s*(<()>)", lambda m: _function_power(*m.groups())),
        (
            rf"(?<![\w.])(<F>)\s*\*\*\s*(\d+|\(-?\d+\))\s+((?!\(){atom}(?:\s*{atom})*)",
            lambda m: _function_power(m[1], m[2], f"({m[3]})"),
        ),
        (rf"(?<![\w.])(<F>)\s+(-?\s*(?!\()(?:{atom})(?:\s*{atom})*)", r"\1(\2)"),
        (r"(?<![\w.])(?!diff)(<F>)\s+(?=<()>)", r"\1"),
        (r"(?<![\w.])sqrt(\d+)\b", r"sqrt(\1)"),
        (
            r"(?<![\w.])(?!0[xX]\d)(\d+(?:\.\d*)?|\.\d+)(?![\d.]|[eE][+-]?\d)\s*(?=[A-Za-z(])",
            r"\1*",
        ),
        (r"(?<![\w.])((?!and\b|or\b)[A-Za-z]\w*)(?:\s+(?=[\w(])|(?=\())", multiplied),
        (r"([\])])\s*(?=[\w(])", r"\1*"),
        (r"(?<![\w.])[A-Za-z]\w*", read),
    )


def _function_power(function: str, exponent: str, argument: str) -> str:
    inverse = exponent.replace(" ", "") == "(-1)"
    if inverse and function in ("sin", "cos", "tan", "sinh", "cosh", "tanh"):
        return f"a{function}{argument}"
    return f"{function}{argument}**{exponent}"
