"""Formulas as other systems and papers write them, rewritten in the grammar of `formula_text`.

Rules are data: a pattern, what stands in its place, grouped in stages that are each applied until
nothing changes. Nothing here decides what a formula means: the caller reads what comes out, and
shows it only if it is of the grammar.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

from derive.algebra.foreign_characters import GREEK, ascii_text
from derive.algebra.foreign_functions import ALIASES, CALLS

LONGEST_CORRECTED = 400
"""Characters of a text that is rewritten, and of what comes out: an error is one line."""

ROUNDS = 40
"""Most applications of a stage: each moves one sign further in."""

VARIABLES = "xyzt"
SITE = "n"

Replacement = str | Callable[[re.Match[str]], str]
Rule = tuple[str, Replacement]
"""A pattern and what stands in its place. In patterns ``<U>`` is an unknown, with derivatives
and a site ``<D>``, ``<F>`` a function of the grammar, ``<A>`` an argument, ``<()>`` and ``<[]>``
what stands in brackets, with these, ``<e>`` and ``<i>`` constants unless declared as names."""


@dataclass(frozen=True)
class Spelling:
    """What the names of a text are: functions of the grammar, unknowns, declared names.

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
    """What to write for a name that reads as a derivative, conjugate, index or product.

    None for a name of its own; one that is ``declared`` may look like a product.

    >>> misread("uxx", Spelling((), "u", "xt")), misread("x0", Spelling((), "u", "xt"))
    ('u_xx', None)
    """
    for pattern, text in _READINGS if declared else _READINGS + _LOOSE_READINGS:
        match = re.fullmatch(_filled(pattern, spelling.patterns()), name)
        if match and (base := match["base"]) in {*spelling.variables, *spelling.unknowns}:
            return match.expand(text) if text else _free_name(match["rest"], spelling, base)
    match = re.fullmatch(rf"(\w+)([{VARIABLES}])", name)
    if match is None or declared or match[2] not in spelling.variables:
        return None
    factors = {*spelling.declared, *spelling.variables, *GREEK}
    is_product = len(match[1]) == 1 or match[1] in factors
    return f"{match[1]}*{match[2]}" if is_product else None


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
    yield _SPELLED_NUMBERS
    yield (*CALLS, *_calls(spelling), *_DERIVATIVES, (_DIFF, _differentiated(spelling)))
    yield (*_products(spelling), *_TIDY)
    yield (*_TIDY, *_END)


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
    primes = {True: lambda m: f"{m[1]}_{continuous[0] * len(m[2])}"}.get(len(continuous) == 1, r"\g<0>")
    return (
        (r"(?<![\w.])(<U>)('+)", primes),
        (r"(?<![\w.])[A-Za-z]\w*(?=\s*(?:[\[(]|\*\*|\s[\w(-]))", named),
        (r"(?<![\w.])(<F>)\s*\[((?:[^\[\]]|<[]>)*)\]", r"\1(\2)"),
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
        return found[0] if found[1] in {*spelling.functions, "diff"} else f"{found[1]}*"

    atom = r"(?:\d+(?:\.\d+)?|(?!<F>\b)(?<![A-Za-z_])[A-Za-z]\w*|<()>)(?:\*\*(?:\w+|<()>))?"
    return (
        (r"(?<![\w.])(<F>)\s*\*\*\s*(\w+|<()>)\s*(<()>)", lambda m: _function_power(*m.groups())),
        (
            rf"(?<![\w.])(<F>)\s*\*\*\s*(\d+|\(-?\d+\))\s+((?!\(){atom}(?:\s*{atom})*)",
            lambda m: _function_power(m[1], m[2], f"({m[3]})"),
        ),
        (rf"(?<![\w.])(<F>)\s+(-?\s*(?!\()(?:{atom})(?:\s*{atom})*)", r"\1(\2)"),
        (r"(?<![\w.])(?!diff)(<F>)\s+(?=<()>)", r"\1"),
        (r"(?<![\w.])sqrt(\d+)\b", r"sqrt(\1)"),
        (r"(?<![\w.])(\d+(?:\.\d*)?|\.\d+)(?![\d.]|[eE][+-]?\d)\s*(?=[A-Za-z(])", r"\1*"),
        (r"(?<![\w.])((?!and\b|or\b)[A-Za-z]\w*)(?:\s+(?=[\w(])|(?=\())", multiplied),
        (r"([\])])\s*(?=[\w(])", r"\1*"),
        (r"(?<![\w.])[A-Za-z]\w*", read),
    )


def _decimal(found: re.Match[str]) -> str:
    """``0,5`` as ``0.5``, unless the comma parts arguments."""
    calls = re.findall(r"(\w*)\s*[\[(]|([\])])", found.string[: found.start()])
    opened: list[str] = []
    for name, closing in calls:
        if closing:
            del opened[-1:]
        else:
            opened.append(name)
    parts = opened and re.search(r"(?:[scd]n|zeta|epsilon|diff|D|[Pp]ow\w*|Rational)$", opened[-1], re.I)
    return found[0] if parts else f"{found[1]}.{found[2]}"


def _function_power(function: str, exponent: str, argument: str) -> str:
    inverse = exponent.replace(" ", "") == "(-1)"
    if inverse and function in ("sin", "cos", "tan", "sinh", "cosh", "tanh"):
        return f"a{function}{argument}"
    return f"{function}{argument}**{exponent}"


def _repeated(found: re.Match[str]) -> str:
    """A subscript ``3x`` or ``x,x`` as ``xxx`` or ``xx``."""
    inside = re.sub(r"(\d)([xyzt])", lambda m: m[2] * int(m[1]), found[1])
    return "_" + re.sub(r"[\s,]", "", inside)


def _quotient(found: re.Match[str]) -> str:
    """``du/dt``, ``d^2u/dx^2`` as ``u_t``, ``u_xx``; at a site with diff."""
    steps = re.findall(r"([xyzt])[\s*(]*(\d?)", found["steps"])
    letters = "".join(letter * int(order or 1) for letter, order in steps)
    return _derived(found["of"], letters)


def _partial(found: re.Match[str]) -> str:
    """``D_x u``, with a power, as ``u_x``."""
    order = int(found["order"] or found["within"] or 1)
    return _derived(found["of"], (found["many"] or found["one"]) * order)


def _derived(expression: str, letters: str) -> str:
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9]*", expression):
        return f"{expression}_{letters}"
    if expression.startswith("("):
        expression = expression[1:-1]
    return f"diff({expression}, {', '.join(letters)})"


# the rules, by stages

LATEX: tuple[Rule, ...] = (
    (r"\\(?:operatorname|math(?:rm|it|bf|cal|bb)|text(?:rm|it)?)\*?\s*\{([^{}]*)\}", r" \1 "),
    (r"\\(?:left|right|[bB]igg?[lr]?|displaystyle|limits|rm)(?![A-Za-z])", ""),
    (r"\\[,;:! ]|\\q?quad\b|~|\$|\\\\|(?<!&)&(?!&)", " "),
    (r"\\(?:cdot|times|ast)\b(?!\s*\})", "*"),
    (r"\\leq?(?:slant)?\b", "<="),
    (r"\\geq?(?:slant)?\b", ">="),
    (r"\\(?:neq?)\b", "!="),
    (r"\\lvert|\\rvert|\\vert|\\mid", "|"),
    (r"\\[dt]?frac\s*(\d)\s*(\d)", r"(\1/\2)"),
    (r"\\[dt]?frac\s*\{([^{}]*)\}\s*\{([^{}]*)\}", r"((\1)/(\2))"),
    (r"\\sqrt\s*\[([^\[\]]*)\]\s*\{([^{}]*)\}", r"(\2)**(1/(\1))"),
    (r"\\sqrt\s*\{([^{}]*)\}", r"sqrt(\1)"),
    (r"\\sqrt\s*(\w)", r"sqrt(\1)"),
    (r"\\dot\s*\{?\s*(<U>)\b\s*\}?", r"\1_t"),
    (r"\\ddot\s*\{?\s*(<U>)\b\s*\}?", r"\1_tt"),
    (r"\\(?:bar|overline)\s*(?:\{([^{}]*)\}|(\w))", r"conjugate(\1\2)"),
    (r"(<D>)\s*\^\s*(?:\{\s*)?(?:\*(?!\w)|\\ast\b|\\star\b|\\dagger\b|†)(?:\s*\})?", r"conjugate(\1)"),
    (r"(<D>)\s*†", r"conjugate(\1)"),
    (
        r"(?<![\w.])(<U>(?:_[xyzt]+)?)_\{\s*(n\s*(?:[+-]\s*\d+)?)\s*(?:,\s*t\s*)?\}",
        r"\1[\2]",
    ),
    (r"(?<![\w.])(<U>(?:_[xyzt]+)?)_(n(?:[+-]\d+)?)(?!\w)", r"\1[\2]"),
    (r"(?<![\w.])([A-Za-z]+)_\{?(\d+)\}?(?![A-Za-z])", r"\1\2"),
    (r"\\partial\s*_\s*(?:\{\s*([xyzt]+)\s*\}|([xyzt]+(?![A-Za-z])|[xyzt]))", r" D_(\1\2) "),
    (r"_\{\s*((?:\d?\s*[xyzt][\s,]*)+)\}", _repeated),
    (r"(?<=[A-Za-z0-9])_\{\s*(\w+)\s*\}", r"\1"),
    (r"\^\s*\{([^{}]*)\}", r"**(\1)"),
    (r"\\partial\s*", " \\\\partial"),
)
"""LaTeX, innermost braces first."""

BRACES: tuple[Rule, ...] = (
    (r"\{", "("),
    (r"\}", ")"),
    (r"\^", "**"),
    (r"\\partial\s*", " d "),
    (r"\\([A-Za-z]+)", r" \1 "),
    (r"^\s*[\"`]+|[\"`]+\s*$", ""),
)

_SPELLED_NUMBERS: tuple[Rule, ...] = (
    (r"(?<![\w.])(?:np|sp|numpy|sympy|math|cmath|mp|mpmath|scipy|torch)\.(?=[A-Za-z])", ""),
    (r"(?<=[\w)\]])\.(?=[*/])", ""),
    (r"\*\s+\*", "**"),
    (r"(?<![\w.,])(\d+),(\d+)(?![\w.,])", _decimal),
    (r"(?<![\w.])(\d+)(?=<e>(?![\w+-]))", r"\1*"),
    (r"(?<![\w.])(?:Pi|PI)\b", "pi"),
    (r"(?<![\w.])exp\s*\*\*\s*(?=\()", "exp"),
    (r"(?<![\w.])exp\s*\*\*\s*(\w+)", r"exp(\1)"),
    (r"(?<![\w.])<e>\s*\*\*\s*(?=<()>(?!\s*\*\*))", "exp"),
    (
        r"(?<![\w.])<e>\s*\*\*\s*(-?(?:\w+(?:\.\d+)?(?:<()>)?|<()>)(?:\s*\*\*\s*(?:\w+|<()>))*)",
        r"exp(\1)",
    ),
    (r"(?<![\w.])<e>(?![\w(\[]|\s*\*\*)", "exp(1)"),
    (r"(?<![\w.])(\d+)<i>\b", r"\1*I"),
    (r"(?<![\w.])<i>\b(?!\s*[\[(])", "I"),
    (r"(?<![\w.])<i>\b(?=\s*\()", "I*"),
)

_ORDER = r"(?:\s*\*\*\s*(?:\d|\(\s*\d\s*\))|\d)?"
_STEP = rf"d\s*[xyzt]{_ORDER}"

_DERIVATIVES: tuple[Rule, ...] = (
    (
        rf"(?<![\w.])(<U>(?:_[{VARIABLES}]+)?)\s*[\[(]\s*(?:[{VARIABLES}]_?\s*,\s*)*"
        rf"[{VARIABLES}]_?\s*[\])]",
        r"\1",
    ),
    (
        r"(?<![\w.])(<U>(?:_[xyzt]+)?)\s*[\[(]\s*(n)_?(\s*[+-]\s*\d+)?\s*(?:,\s*t_?\s*)?[\])]"
        r"(?:\s*[\[(]\s*t_?\s*[\])])?",
        r"\1[\2\3]",
    ),
    (
        rf"(?<![\w.])(?P<open>\(\s*)?d\s*{_ORDER}\s*(?P<of><U>(?![A-Za-z0-9_])(?:\[[^\[\]]*\])?)"
        rf"(?(open)\s*\))\s*/\s*(?P<below>\(\s*)?(?P<steps>{_STEP}(?:\s*\*?\s*{_STEP})*)"
        r"(?(below)\s*\))",
        _quotient,
    ),
    (
        rf"\(\s*\(?\s*d\s*\)?\s*/\s*\(?\s*(?P<steps>{_STEP})\s*\)?\s*\)\s*(?P<of><D>|<()>)",
        _quotient,
    ),
    (rf"(?<![\w.])d\s*/\s*(?P<steps>{_STEP})\s*(?P<of><D>|<()>)", _quotient),
    (
        r"(?<![\w.])D_(?:\((?P<many>[xyzt]+)\)|(?P<one>[xyzt]+(?![A-Za-z])))"
        r"(?:\s*\*\*\s*(?:(?P<order>\d)|\((?P<within>\d)\)))?\s*(?P<of><U>(?![A-Za-z0-9_])"
        r"(?:\[[^\[\]]*\])?|<()>|<F><()>)",
        _partial,
    ),
    (rf"(?<![\w.])(<U>)_([{VARIABLES}]+)_([{VARIABLES}]+)", r"\1_\2\3"),
    (rf"(?<![\w.])(<U>)_(\d)([{VARIABLES}])\b", lambda m: f"{m[1]}_{m[3] * int(m[2])}"),
    (rf"(?<![\w.])(<U>)_([{VARIABLES}])(\d)\b", lambda m: f"{m[1]}_{m[2] * int(m[3])}"),
    (r"(<D>)\s*\.\s*conj(?:ugate)?\s*\(\s*\)", r"conjugate(\1)"),
    (r"\|([^|]+)\|", r"abs(\1)"),
    (r"(<D>)\s*\*(?=\s*(?:$|[)=,;]|\s[+-]\s))", r"conjugate(\1)"),
)

_TIDY: tuple[Rule, ...] = (
    (r"(?<![\w\])])\(\s*(\w+|\d+\.\d+)\s*\)", r"\1"),
    (r"(?<!\w)\(\(([^()]*)\)\)", r"(\1)"),
    (r"\s*(\*\*?|/)\s*", r"\1"),
    (r"\(\s+", "("),
    (r"\s+([),])", r"\1"),
    (r"\s+", " "),
    (r"^\s+|\s+$", ""),
)

_END: tuple[Rule, ...] = (
    (r"\s*[.,;]+$", ""),
    (r"=\s*$", "= 0"),
)
