"""Formulas as other systems and papers write them, rewritten in the grammar of `formula_text`.

Rules are data: a pattern and its replacement, grouped in stages that are each applied until nothing
changes. Nothing here decides what a formula means: the caller parses the result, and shows it
only if it follows the grammar.
"""

import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

from longwave.derive.algebra import typing_rules
from longwave.derive.algebra.foreign_characters import GREEK, ascii_text
from longwave.derive.algebra.typing_rules import SITE, VARIABLES
from longwave.support.known_names import close_names

LONGEST_CORRECTED = 400
"""Longest text that is rewritten, in characters."""

FUNCTIONS_BY_NAME = ("gamma", "beta", "zeta", "Gamma", "Delta", "delta", "O")
"""Names that mean functions, not factors, before a bracket, unless they are declared."""

ROUNDS = 40
"""Most times that the rules of one stage are applied to a text."""


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
        """Return the placeholders of rules, such as ``<U>``, with their regular expressions."""
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
    """Return the text with every rule applied, or unchanged if it is too long.

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
            previous = text
            for pattern, replacement in rules:
                text = re.sub(pattern, replacement, text)
            if text == previous or len(text) > 4 * LONGEST_CORRECTED:
                break
    return balanced(text)


def balanced(text: str) -> str:
    """Return the text without surplus closing brackets, and with missing ones appended.

    >>> balanced("sech(k*(x - t)"), balanced("x)")
    ('sech(k*(x - t))', 'x')
    """
    kept_characters, depth = [], 0
    for sign in text:
        depth += (sign == "(") - (sign == ")")
        if depth < 0:
            depth = 0
        else:
            kept_characters.append(sign)
    return "".join(kept_characters) + ")" * depth


def _nested(open_: str, closing: str, depth: int = 6) -> str:
    """Return a pattern of brackets nested up to ``depth``; possessive, so that it matches fast."""
    inside = rf"[^{open_}{closing}]*+"
    pattern = rf"{open_}{inside}{closing}"
    for _ in range(depth):
        pattern = rf"{open_}{inside}(?:{pattern}{inside})*+{closing}"
    return pattern


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
    """Return the correction of a name that reads as a derivative, conjugate, index or product.

    None for any other name, and for a ``declared`` name that looks like a product.

    >>> misread("uxx", Spelling((), "u", "xt")), misread("x0", Spelling((), "u", "xt"))
    ('u_xx', None)
    """
    for pattern, text in _READINGS if declared else _READINGS + _LOOSE_READINGS:
        match = re.fullmatch(_filled(pattern, spelling.patterns()), name)
        if match and (base := match["base"]) in {*spelling.variables, *spelling.unknowns}:
            return match.expand(text) if text else _free_name(match["suffix"], spelling, base)
    if called := _call_in_name(name, spelling, declared):
        return called
    match = re.fullmatch(rf"(\w+)([{VARIABLES}])", name)
    if match is None or declared or match[2] not in spelling.variables:
        return None
    factors = {*spelling.declared, *spelling.variables, *GREEK}
    is_product = len(match[1]) == 1 or match[1] in factors
    factor = "I" if match[1] in set("ij") - {*spelling.declared} else match[1]
    return f"{factor}*{match[2]}" if is_product else None


def _call_in_name(name: str, spelling: Spelling, declared: bool) -> str | None:
    """Return ``sin(2*x)`` for a name such as ``sin2x``; None unless x is a variable or declared."""
    match = re.fullmatch(rf"({_either(spelling.functions)})(\d*)([A-Za-z])", name)
    if match is None or declared or match[3] not in {*spelling.variables, *spelling.declared}:
        return None
    function, factor, letter = match.groups()
    return f"{function}({factor}*{letter})" if factor else f"{function}({letter})"


_READINGS: tuple[tuple[str, str], ...] = (
    (rf"(?P<base><U>)_?(?P<suffix>[{VARIABLES}]+)", r"\g<base>_\g<suffix>"),
    (r"(?P<base><U>)_?(?:bar|star|conj|conjugate|dag|dagger)", r"conjugate(\g<base>)"),
    (r"(?:conj|conjugate|bar)_?(?P<base><U>)", r"conjugate(\g<base>)"),
    (r"d\d?(?P<base><U>)", r"diff(\g<base>, x)"),
    (rf"(?P<base>[{VARIABLES}{SITE}])(?P<suffix>[1-9]\d*)", ""),
)
"""Pairs (pattern of a name, its correction) that apply even to declared names."""

_LOOSE_READINGS = (
    (r"(?P<base><U>)c", r"conjugate(\g<base>)"),
    (rf"(?P<base><U>){SITE}", rf"\g<base>[{SITE}]"),
    (rf"(?P<base><U>){SITE}p(?P<suffix>\d)", rf"\g<base>[{SITE}+\g<suffix>]"),
    (rf"(?P<base><U>){SITE}m(?P<suffix>\d)", rf"\g<base>[{SITE}-\g<suffix>]"),
    (r"(?P<base><U>)(?P<suffix><U>(?:_[xyzt]+)?)", r"\g<base>*\g<suffix>"),
    (rf"d(?P<base>[{VARIABLES}])\d?", r"diff(u, \g<base>)"),
)


def _free_name(digits: str, spelling: Spelling, base: str) -> str:
    """Return an undeclared name to replace a variable with an index, such as ``a1`` for ``x1``."""
    letters = (letter for letter in "abcdfghpqrs" if letter != base)
    names = (f"{letter}{digits}" for letter in letters)
    return next(name for name in names if name not in spelling.declared)


def _stages(spelling: Spelling) -> Iterator[tuple[typing_rules.Rule, ...]]:
    yield typing_rules.LATEX
    yield typing_rules.BRACES
    yield typing_rules.SPELLED_NUMBERS
    calls = (*typing_rules.CALLS, *_calls(spelling), *typing_rules.DERIVATIVES)
    yield (*calls, (_DIFF, _differentiated(spelling)))
    yield (*_products(spelling), *typing_rules.TIDY)
    yield (*typing_rules.TIDY, *typing_rules.END)


def _differentiated(spelling: Spelling) -> Callable[[re.Match[str]], str]:
    """Return a function that rewrites ``D[u, {x, 2}]`` and the like, as a subscript if possible."""
    unknown = re.compile(_either(spelling.unknowns))

    def rewrite(match: re.Match[str]) -> str:
        name, inside = match["name"], match["inside"][1:-1]
        if name in spelling.declared:
            return match[0]
        first, *steps = _arguments(inside)
        if match["method"]:
            first, steps = match["method"], [s for s in (first, *steps) if s]
        letters = ""
        for step in ",".join(steps).replace("$", ",").replace("(", "").replace(")", "").split(","):
            plain = step.strip().strip("'")
            if plain in VARIABLES and len(plain) == 1:
                letters += plain
            elif plain in "123456789" and letters and plain:
                letters += letters[-1] * (int(plain) - 1)
            else:
                return match[0]
        if unknown.fullmatch(first.strip()) and (name != "diff" or match["method"]):
            return f"{first.strip()}_{letters}"
        return f"diff({first.strip()}, {', '.join(letters)})"

    return rewrite


_DIFF = (
    r"(?:(?P<method><D>|(?<!\w)<()>)\s*\.\s*)?(?<!\w)"
    r"(?P<name>D|Diff|Derivative|pdiff|deriv|diff)\s*(?P<inside><()>|<[]>)"
)


def _arguments(text: str) -> list[str]:
    """Return the arguments between commas outside brackets."""
    arguments, depth = [""], 0
    for sign in text:
        depth += (sign in "([{") - (sign in ")]}")
        if sign == "," and not depth:
            arguments.append("")
        else:
            arguments[-1] += sign
    return arguments


def _calls(spelling: Spelling) -> tuple[typing_rules.Rule, ...]:
    """Return rules that give functions the names and round brackets of the grammar."""

    def rename_function(match: re.Match[str]) -> str:
        name = match[0]
        other = typing_rules.ALIASES.get(name, name.lower())
        taken = name in spelling.functions or name in spelling.declared
        return other if other in spelling.functions and not taken else name

    continuous = [letter for letter in spelling.variables if letter in VARIABLES]

    def rewrite_primes(match: re.Match[str]) -> str:
        unknown, site, primes = match.groups()
        letter = continuous[0] if continuous else "t" if site else ""
        if not letter or len(continuous) > 1:
            return match[0]
        if site:
            return f"diff({unknown}{site}, {', '.join(letter * len(primes))})"
        return f"{unknown}_{letter * len(primes)}"

    return (
        (r"(?<![\w.])(<U>)('+)(\[[^\[\]]*\])", r"\1\3\2"),
        (r"(?<![\w.])(<U>)(\[[^\[\]]*\])?('+)", rewrite_primes),
        (r"(?<![\w.])[A-Za-z]\w*(?=\s*(?:[\[(]|\*\*|\s[\w(-]))", rename_function),
        (r"(?<![\w.])(<F>(?:\*\*\w+)?)\s*\[((?:[^\[\]]|<[]>)*)\]", r"\1(\2)"),
        (r"(?<!\w)\[((?:[^\[\]]|<[]>)*)\]", r"(\1)"),
        (r"(?<![\w.])(?!<U>(?![A-Za-z0-9]))([A-Za-z]\w*)\s*\[((?:[^\[\]]|<[]>)*)\]", r"\1(\2)"),
    )


def _products(spelling: Spelling) -> tuple[typing_rules.Rule, ...]:
    """Return rules for misread names, functions without brackets, powers and implied products."""

    def split_name(match: re.Match[str]) -> str:
        name = match[0]
        if name in spelling.functions or name in spelling.declared or name in spelling.unknowns:
            return name
        return misread(name, spelling) or name

    def rewrite_product(match: re.Match[str]) -> str:
        name = match[1]
        if name in {*spelling.functions, "diff"}:
            return match[0]
        free = len(name) > 2 and name not in {*spelling.declared, *GREEK}
        suggestions = close_names(name, spelling.functions, 1) if free else []
        if suggestions:
            return match[0].replace(name, suggestions[0])
        is_call = match[0] == name and match.string[match.end() :].startswith("(")
        is_function = free or (name in FUNCTIONS_BY_NAME and name not in spelling.declared)
        return match[0] if is_call and is_function else f"{name}*"

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
        (r"(?<![\w.])((?!and\b|or\b)[A-Za-z]\w*)(?:\s+(?=[\w(])|(?=\())", rewrite_product),
        (r"([\])])\s*(?=[\w(])", r"\1*"),
        (r"(?<![\w.])[A-Za-z]\w*", split_name),
    )


def _function_power(function: str, exponent: str, argument: str) -> str:
    inverse = exponent.replace(" ", "") == "(-1)"
    if inverse and function in ("sin", "cos", "tan", "sinh", "cosh", "tanh"):
        return f"a{function}{argument}"
    return f"{function}{argument}**{exponent}"
