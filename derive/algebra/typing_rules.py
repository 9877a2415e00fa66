"""Rules that rewrite formulas of other systems and of papers, by stages: tables of patterns."""

from __future__ import annotations

import re
from collections.abc import Callable

VARIABLES = "xyzt"
SITE = "n"

Replacement = str | Callable[[re.Match[str]], str]
Rule = tuple[str, Replacement]
"""A pattern and its replacement. In patterns ``<U>`` is an unknown, ``<D>`` one with derivatives
and a site, ``<F>`` a function of the grammar, ``<A>`` an argument, ``<()>`` and ``<[]>``
bracketed text, with its brackets, ``<e>`` and ``<i>`` constants unless declared as names."""

_ALIASES_BY_NAME = (
    {f"a{name}": f"arc{name} Arc{name.title()}" for name in ("sin", "cos")}
    | {
        f"a{name}h": f"arc{name}h Arc{name.title()}h ar{name}h ar{name[0]}h arg{name[0]}h"
        for name in ("sin", "cos", "tan")
    }
    | {f"airy_{name}": f"airy{name} Airy{name.title()}" for name in ("ai", "bi")}
    | {f"airy_{name}_prime": f"airy{name}prime Airy{name.title()}Prime" for name in ("ai", "bi")}
    | {f"bessel_{letter}": f"bessel{letter} Bessel{letter.upper()}" for letter in "jyik"}
    | {f"jacobi_{name}": f"jacobi{name}" for name in ("sn", "cn", "dn")}
    | {"log": "ln Ln", "sqrt": "root", "tan": "tg", "cot": "ctg cotg", "csc": "cosec"}
    | {"atan": "arctan ArcTan arctg", "sinh": "sh", "cosh": "ch", "tanh": "th", "coth": "cth"}
    | {"abs": "fabs norm modulus mod", "sign": "sgn signum", "re": "real", "im": "imag"}
    | {"conjugate": "conj Conj cc", "lambert_w": "ProductLog LambertW lambertw W"}
    | {"elliptic_k": "ellipk ellipticK", "elliptic_e": "ellipe ellipticE"}
)

ALIASES = {alias: name for name, words in _ALIASES_BY_NAME.items() for alias in words.split()}
"""Alias -> function of the grammar; names that differ only in capital letters need no entry."""

CALLS: tuple[Rule, ...] = (
    *(
        (rf"(?<![\w.])Jacobi{name.upper()}\s*\[\s*(<A>),\s*(<A>)\]", rf"jacobi_{name}(\1, \2)")
        for name in ("sn", "cn", "dn")
    ),
    *(
        # Maple's second argument is the modulus k, Mathematica's the parameter m = k**2
        (rf"(?<![\w.])Jacobi{name.upper()}\s*\(\s*(<A>),\s*(<A>)\)", rf"jacobi_{name}(\1, (\2)**2)")
        for name in ("sn", "cn", "dn")
    ),
    (r"(?<![\w.])([scd]n)(\*\*\w+)\s*(<()>)", r"\1\3\2"),
    (r"(?<![\w.])([scd]n)\s*\(\s*(<A>)\|\s*(<A>)\)", r"jacobi_\1(\2, \3)"),
    (r"(?<![\w.])([scd]n)\s*\(\s*(<A>)[,;]\s*m\s*\)", r"jacobi_\1(\2, m)"),
    (r"(?<![\w.])([scd]n)\s*\(\s*(<A>)[,;]\s*k\s*\)", r"jacobi_\1(\2, k**2)"),
    (r"(?<![\w.])jacobi_([scd]n)\s*\(\s*(<A>)[|;]\s*(<A>)\)", r"jacobi_\1(\2, \3)"),
    (r"(?<![\w.])Elliptic([KE])\s*\[\s*(<A>)\]", lambda m: f"elliptic_{m[1].lower()}({m[2]})"),
    (r"(?<![\w.])Elliptic([KE])\s*\(\s*(<A>)\)", lambda m: f"elliptic_{m[1].lower()}(({m[2]})**2)"),
    (r"(?<![\w.])log_?(10|2)\s*(<()>)", r"(log\2/log(\1))"),
    (r"(?<![\w.])a(?:rc?)?sech\s*(<()>)", r"acosh(1/\1)"),
    (r"(?<![\w.])a(?:rc?)?csch\s*(<()>)", r"asinh(1/\1)"),
    (r"(?<![\w.])a(?:rc?)?coth\s*(<()>)", r"atanh(1/\1)"),
    (r"(?<![\w.])a(?:rc)?sec\s*(<()>)", r"acos(1/\1)"),
    (r"(?<![\w.])a(?:rc)?csc\s*(<()>)", r"asin(1/\1)"),
    (r"(?<![\w.])(?:pow|power|Power)\s*[\[(]\s*(<A>),\s*(<A>)[\])]", r"(\1)**(\2)"),
    (r"(?<![\w.])(?:Rational|Fraction)\s*[\[(]\s*(<A>),\s*(<A>)[\])]", r"((\1)/(\2))"),
    (r"(?<![\w.])(?:Integer|Float|sympify|S|float|int)\s*\(\s*(\d+(?:\.\d+)?)\s*\)", r"\1"),
    (r"(?<![\w.])(?:FullSimplify|Simplify|simplify|Expand|expand)\s*[\[(](<A>)[\])]", r"\1"),
    (r"(?<![\w.])Eq(?:uation|ual)?\s*[\[(]\s*(<A>),\s*(<A>)[\])]", r"\1 = \2"),
)
"""Rules for calls whose name or arguments other systems write differently."""


def _decimal(match: re.Match[str]) -> str:
    """Return ``0,5`` as ``0.5``, unless the comma separates arguments."""
    calls = re.findall(r"(\w*)\s*[\[(]|([\])])", match.string[: match.start()])
    opened: list[str] = []
    for name, closing in calls:
        if closing:
            del opened[-1:]
        else:
            opened.append(name)
    of_two = r"(?:[scd]n|zeta|epsilon|diff|D|pow\w*|Rational)$"
    separates = opened and re.search(of_two, opened[-1], re.I)
    return match[0] if separates else f"{match[1]}.{match[2]}"


def _repeated(match: re.Match[str]) -> str:
    """Return a subscript ``3x`` or ``x,x`` as ``xxx`` or ``xx``."""
    inside = re.sub(r"(\d)([xyzt])", lambda m: m[2] * int(m[1]), match[1])
    return "_" + re.sub(r"[\s,]", "", inside)


def _at_its_variables(match: re.Match[str]) -> str:
    """Return ``u(x, t)`` as ``u``, unless u occurs with different arguments."""
    letters_used = re.findall(r"[xyzt]", match["at"])
    lists = re.findall(rf"{re.escape(match['of'])}\s*[\[(]([xyzt_,\s]+)[\])]", match.string)
    distinct = {"".join(re.findall(r"[xyzt]", letters)) for letters in lists}
    is_repeated = len(set(letters_used)) < len(letters_used)
    return match[0] if is_repeated or len(distinct) > 1 else match["of"]


def _join_subscripts(match: re.Match[str]) -> str:
    """Join subscripts separated by a comma, unless the comma separates arguments."""
    preceding = match.string[: match.start()]
    is_inside = any(preceding.count(a) > preceding.count(b) for a, b in ("()", "[]"))
    return match[0] if is_inside else match[1] + match[2]


def _quotient(match: re.Match[str]) -> str:
    """Return ``du/dt``, ``d^2u/dx^2`` as ``u_t``, ``u_xx``, or with diff at a site."""
    steps = re.findall(r"([xyzt])[\s*(]*(\d?)", match["steps"])
    letters = "".join(letter * int(order or 1) for letter, order in steps)
    return _derived(match["of"], letters)


def _partial(match: re.Match[str]) -> str:
    """Return ``D_x u``, with an optional power, as ``u_x``."""
    order = int(match["order"] or match["within"] or 1)
    return _derived(match["of"], (match["many"] or match["one"]) * order)


def _derived(expression: str, letters: str) -> str:
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9]*", expression):
        return f"{expression}_{letters}"
    if expression.startswith("("):
        expression = expression[1:-1]
    return f"diff({expression}, {', '.join(letters)})"


LATEX: tuple[Rule, ...] = (
    (r"\s*#.*", ""),
    (r"(?<=[xyzt])\s*\$\s*(?=\d)", ","),
    (r"(?<=[=\s])'([^']*)'\s*$", r"\1"),
    (r"\\(?:operatorname|math(?:rm|it|bf|cal|bb)|text(?:rm|it)?)\*?\s*\{([^{}]*)\}", r" \1 "),
    (r"\\(?:left|right|[bB]igg?[lr]?|displaystyle|limits|rm)(?![A-Za-z])", ""),
    (r"\\[,;:! ]|\\q?quad\b|(?<!\s)~(?!\s)|\$|\\\\|(?<!&)&(?!&)", " "),
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
    (
        r"(<D>)\s*\^\s*(?:\{\s*)?(?:\*(?!\w)|\\ast\b|\\star\b|\\dagger\b|†)(?:\s*\})?",
        r"conjugate(\1)",
    ),
    (r"(<D>)\s*†", r"conjugate(\1)"),
    (r"(?<![\w.])(<U>(?:_[xyzt]+)?)_\{\s*(n\s*(?:[+-]\s*\d+)?)\s*(?:,\s*t\s*)?\}", r"\1[\2]"),
    (r"(?<![\w.])(<U>(?:_[xyzt]+)?)_(n(?:[+-]\d+)?)(?!\w)", r"\1[\2]"),
    (r"(?<![\w.])([A-Za-z]+)_\{?(\d+)\}?(?![A-Za-z])", r"\1\2"),
    (r"\\partial\s*_\s*(?:\{\s*([xyzt]+)\s*\}|([xyzt]+(?![A-Za-z])|[xyzt]))", r" D_(\1\2) "),
    (r"_\{\s*((?:\d?\s*[xyzt][\s,]*)+)\}", _repeated),
    (r"(?<=[A-Za-z0-9])_\{\s*(\w+)\s*\}", r"\1"),
    (r"\^\s*\{([^{}]*)\}", r"**(\1)"),
    (r"\\partial\s*", " \\\\partial"),
)
"""Rules for LaTeX commands; those in the innermost braces are rewritten first."""

BRACES: tuple[Rule, ...] = (
    (r"\{", "("),
    (r"\}", ")"),
    (r"\^", "**"),
    (r"\\partial\s*", " d "),
    (r"\\(?!Delta|nabla)([A-Za-z]+)", r" \1 "),
    (r"^\s*[\"`]+|[\"`]+\s*$", ""),
)

SPELLED_NUMBERS: tuple[Rule, ...] = (
    (r"(?<![\w.])(?:np|sp|numpy|sympy|math|cmath|mp|mpmath|scipy|torch)\.(?=[A-Za-z])", ""),
    (r"(?<=[\w)\]])\.(?=[*/])", ""),
    (r"\*\s+\*|\*{3,}", "**"),
    (r"(?<![\w.,])(\d+),(?!\d{3}(?!\d))(\d+)(?![\w.,])", _decimal),
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
    (r"(?<![\w.])1<i>\b", "I"),
    (r"(?<![\w.])(\d+)<i>\b", r"\1*I"),
    (r"(?<![\w.])<i>\b(?!\s*[\[(])", "I"),
    (r"(?<![\w.])<i>\b(?=\s*\()", "I*"),
)

_ORDER = r"(?:\s*\*\*\s*(?:\d|\(\s*\d\s*\))|\d)?"
_STEP = rf"d\s*[xyzt]{_ORDER}"

DERIVATIVES: tuple[Rule, ...] = (
    (
        rf"(?<![\w.])(?P<of><U>(?:_[{VARIABLES}]+)?)\s*[\[(]"
        rf"(?P<at>\s*(?:[{VARIABLES}]_?\s*,\s*)*[{VARIABLES}]_?\s*)[\])]",
        _at_its_variables,
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
        rf"(?<![A-Za-z_])(<()>)_([{VARIABLES}]+)(?!\w)",
        lambda m: f"diff({m[1][1:-1]}, {', '.join(m[2])})",
    ),
    (rf"(?<![\w.])D([{VARIABLES}])\s*(?=\()", r"D_\1 "),
    (
        r"(?<![\w.])D_(?:\((?P<many>[xyzt]+)\)|(?P<one>[xyzt]+(?![A-Za-z])))"
        r"(?:\s*\*\*\s*(?:(?P<order>\d)|\((?P<within>\d)\)))?\s*(?P<of><U>(?![A-Za-z0-9_])"
        r"(?:\[[^\[\]]*\])?|<()>|<F><()>)",
        _partial,
    ),
    (rf"(?<![\w.])(<U>)_([{VARIABLES}]+)_([{VARIABLES}]+)", r"\1_\2\3"),
    (rf"(?<![\w.])(<U>_[{VARIABLES}]+)_(?!\w)", r"\1"),
    (rf"(?<![\w.])(<U>_[{VARIABLES}]+)\s*,\s*([{VARIABLES}]+)(?!\w)", _join_subscripts),
    (rf"(?<![\w.])(<U>)_(\d)([{VARIABLES}])\b", lambda m: f"{m[1]}_{m[3] * int(m[2])}"),
    (rf"(?<![\w.])(<U>)_([{VARIABLES}])(\d)\b", lambda m: f"{m[1]}_{m[2] * int(m[3])}"),
    (r"(<D>)\s*\.\s*conj(?:ugate)?\s*\(\s*\)", r"conjugate(\1)"),
    (r"(?<![\w.])(<F>|ln)\s*\|([^|]+)\|", r"\1(abs(\2))"),
    (r"\|([^|]+)\|", r"abs(\1)"),
    (r"(<D>)\s*\*(?=\s*(?:$|[)=,;]|\s[+-]\s))", r"conjugate(\1)"),
)

TIDY: tuple[Rule, ...] = (
    (r"(?<![\w\])])\(\s*(\w+|\d+\.\d+)\s*\)", r"\1"),
    (r"(?<!\w)\(\(([^()]*)\)\)", r"(\1)"),
    (r"\s*(\*\*?|/)\s*", r"\1"),
    (r"\(\s+", "("),
    (r"\s+([),])", r"\1"),
    (r"\s+", " "),
    (r"^\s+|\s+$", ""),
)

END: tuple[Rule, ...] = ((r"\s*[.,;]+$", ""), (r"=\s*$", "= 0"))
