r"""Formulas of texts as LaTeX, as they were typed: no term is moved, and lines break at signs.

Round brackets are no pair of \left and \right, so that TeX breaks a long formula at the plus and
minus signs in them; a fraction, root or exponent that is too wide is written in one line instead.
"""

from __future__ import annotations

import re
from fractions import Fraction

import sympy as sp

from longwave.derive.algebra.foreign_characters import GREEK
from longwave.derive.algebra.formula_text import FormulaError, Parser, Vocabulary, tokens
from longwave.derive.algebra.formula_tree import (
    MINUS_ONE,
    Call,
    Derivative,
    FormulaTree,
    Name,
    Number,
    Power,
    Product,
    Sum,
    Unknown,
)
from longwave.reports.formulas.printing import measure, nesting
from longwave.reports.latex import escape, symbol_latex
from longwave.verify.proof.text_names import FUNCTIONS
from longwave.verify.proof.typed_statement import Statement

SUM, PRODUCT, POWER, ATOM = range(4)
"""How strongly the outermost sign of a formula binds."""

FRACTION, EXPONENT, ROOT = 48.0, 34.0, 34.0
"""Widest numerator, exponent and root, in characters; wider ones are written in one line."""

PLAIN = ("exp", "log", "sin", "cos", "tan", "cot", "sec", "csc", "sinh", "cosh", "tanh", "coth")

NAMES = {
    **{name: rf"\{name}" for name in PLAIN},
    **{f"a{name}": rf"\arc{name}" for name in ("sin", "cos", "tan")},
    **{f"jacobi_{name}": rf"\operatorname{{{name}}}" for name in ("sn", "cn", "dn")},
    "jacobi_epsilon": r"\mathcal{E}",
    "jacobi_zeta": r"\mathrm{Z}",
    "jacobi_eta": "H",
    "jacobi_theta": r"\Theta",
    "elliptic_k": "K",
    "elliptic_e": "E",
    "weierstrass_p": r"\wp",
    "weierstrass_p_prime": r"\wp'",
    "airy_ai": r"\operatorname{Ai}",
    "airy_bi": r"\operatorname{Bi}",
    "airy_ai_prime": r"\operatorname{Ai}'",
    "airy_bi_prime": r"\operatorname{Bi}'",
    "lambert_w": "W",
    "re": r"\operatorname{Re}",
    "im": r"\operatorname{Im}",
    "sech": r"\operatorname{sech}",
    "csch": r"\operatorname{csch}",
    "sign": r"\operatorname{sgn}",
    "erf": r"\operatorname{erf}",
}
NAMES |= {
    "asinh": r"\operatorname{arsinh}",
    "acosh": r"\operatorname{arcosh}",
    "atanh": r"\operatorname{artanh}",
}
"""Functions as LaTeX; another one-argument function is a letter of its own."""

MODULAR = ("sn", "cn", "dn", "epsilon", "zeta", "eta", "theta")
"""Jacobi functions, whose second argument is the parameter: of a square the modulus is written."""

LETTERS = {"I": "i", "pi": r"\pi", **{name: NAMES[f"jacobi_{name}"] for name in ("sn", "cn", "dn")}}
"""Names that are not written as themselves."""


def typed_latex(formula: FormulaTree) -> str:
    r"""The LaTeX of a formula.

    >>> print(typed_text_latex("3*c**2/(1 - c**2)*sech(c*x/2)**2"))
    \frac{3 c^{2}}{1 - c^{2}} \operatorname{sech}^{2}\bigl(\frac{c x}{2}\bigr)
    >>> print(typed_text_latex("k*jacobi_cn(b*x, k**2)*exp(-I*t)"))
    k \operatorname{cn}(b x;k) e^{- i t}
    """
    return _written(formula)[0]


def typed_text_latex(text: str) -> str:
    """The LaTeX of a formula's text; raises FormulaError for what is none."""
    fields = {letter: sp.Function(letter)(*sp.symbols("x y z t")) for letter in "uvw"}
    variables = dict(zip("xyzt", sp.symbols("x y z t"), strict=True))
    words = Vocabulary(FUNCTIONS, variables=variables, fields=fields, unknown_name=sp.Symbol)
    return typed_latex(Parser(text, tokens(text), words, "formula").whole())


def statement_parts(statement: Statement) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The equations of a typed statement, with = 0 behind each, and its solutions.

    Behind the solutions are the names for parts of them.
    """
    trees = statement.trees
    if trees is None:
        return (), ()
    equations = tuple(f"{typed_latex(equation)} = 0" for equation in trees.equations)
    nodes = (node for equation in trees.equations for node in equation.nodes())
    site = "_{n}" if any(isinstance(node, Unknown) and node.site for node in nodes) else ""
    solved = [f"{symbol_latex(n)}{site} = {typed_latex(f)}" for n, f in trees.solutions.items()]
    named = [f"{symbol_latex(n)} = {typed_latex(f)}" for n, f in trees.definitions.items()]
    return equations, (*solved, *named)


def _written(formula: FormulaTree) -> tuple[str, int]:
    """The LaTeX, and how strongly its outermost sign binds."""
    match formula:
        case Number(value=value):
            return _number(value)
        case Name(name=name):
            return LETTERS.get(name) or symbol_latex(name), ATOM
        case Unknown(name=name, steps=steps, site=site, shift=shift):
            index = f"{site}{shift:+d}" if shift else site
            below = ",".join(part for part in (index, "".join(steps)) if part)
            return symbol_latex(name) + (f"_{{{below}}}" if below else ""), ATOM
        case Sum(parts=parts):
            return _sum(parts), SUM
        case Product(parts=parts):
            return _product(parts), PRODUCT
        case Power(parts=(base, exponent)):
            return _power(base, exponent)
        case Call(parts=parts, name=name):
            return _call(name, parts, ""), ATOM
        case Derivative(parts=(inner,), steps=steps):
            return _derivative(inner, steps), PRODUCT
    raise TypeError(f"formula must be a node of a tree, got {type(formula).__name__}")


def _number(value: Fraction) -> tuple[str, int]:
    over, under = abs(value.numerator), value.denominator
    text = str(over) if under == 1 else rf"\frac{{{over}}}{{{under}}}"
    return (f"- {text}", SUM) if value < 0 else (text, ATOM)


def _enclosed(formula: FormulaTree, binding: int) -> str:
    """The LaTeX, in brackets where its outermost sign binds less than ``binding``."""
    text, level = _written(formula)
    return text if level >= binding else _brackets(text)


def _brackets(text: str) -> str:
    """Round brackets of a fitting size, in which a line may break."""
    big = r"\bigl", r"\bigr"
    opening, closing = big if r"\frac" in text or "(" in text else ("", "")
    return f"{opening}({text}{closing})"


def _sum(parts: tuple[FormulaTree, ...]) -> str:
    text = ""
    for part in parts:
        term, level = _written(part)
        if level == SUM and isinstance(part, Sum):
            term = _brackets(term)
        if not text:
            text = term
        elif term.startswith("- "):
            text += f" {term}"
        else:
            text += f" + {term}"
    return text


def _product(parts: tuple[FormulaTree, ...]) -> str:
    """Factors side by side; those before a division since the last one are its numerator."""
    minus = False
    if _plain(parts):
        parts = tuple(sorted(parts, key=lambda part: not isinstance(part, Number)))
    done: list[str] = []
    above: list[FormulaTree] = []
    below: list[FormulaTree] = []

    def close() -> None:
        nonlocal above, below
        if below:
            done.append(_fraction(above, below))
        else:
            done.extend(_factors(above))
        above, below = [], []

    for part in parts:
        if part == MINUS_ONE:
            minus = not minus
        elif isinstance(part, Power) and part.parts[1] == MINUS_ONE:
            below.append(part.parts[0])
        else:
            if below:
                close()
            above.append(part)
    close()
    return ("- " if minus else "") + _beside(done or ["1"])


def _plain(parts: tuple[FormulaTree, ...]) -> bool:
    """Whether nothing in a product is divided by."""
    return not any(isinstance(p, Power) and p.parts[1] == MINUS_ONE for p in parts)


def _factors(parts: list[FormulaTree]) -> list[str]:
    return [_enclosed(part, PRODUCT if not isinstance(part, Number) else ATOM) for part in parts]


def _beside(texts: list[str]) -> str:
    """Factors with a dot before a number and nothing elsewhere."""
    text = texts[0]
    for further in texts[1:]:
        text += (r" \cdot " if further[0].isdigit() and text[-1].isdigit() else " ") + further
    return text


def _fraction(above: list[FormulaTree], below: list[FormulaTree]) -> str:
    """A fraction; of wide ones the numerator and denominator in one line."""
    alone = len(above) == 1
    top = typed_latex(above[0]) if alone else _beside(_factors(above)) if above else "1"
    bottom = typed_latex(below[0]) if len(below) == 1 else _beside(_factors(below))
    if max(measure(top), measure(bottom)) <= FRACTION:
        return rf"\frac{{{top}}}{{{bottom}}}"
    top = _brackets(top) if alone and isinstance(above[0], Sum) else top
    return rf"{top} \Big/ {_brackets(bottom)}"


def _power(base: FormulaTree, exponent: FormulaTree) -> tuple[str, int]:
    if exponent == MINUS_ONE:
        return _fraction([], [base]), PRODUCT
    raised = _small(typed_latex(exponent))
    if isinstance(base, Call) and isinstance(exponent, Number) and base.name in NAMES:
        return _call(base.name, base.parts, f"^{{{raised}}}"), ATOM
    return f"{_enclosed(base, ATOM)}^{{{raised}}}", POWER


def _small(text: str) -> str:
    """What is written as an exponent: small fractions and brackets."""
    return text.replace(r"\frac", r"\tfrac").replace(r"\bigl", "").replace(r"\bigr", "")


def _call(name: str, parts: tuple[FormulaTree, ...], power: str) -> str:
    """A function of its arguments, itself raised to a power that is written behind its name."""
    inside = [typed_latex(part) for part in parts]
    first = inside[0]
    if name == "exp" and not power and measure(first) <= EXPONENT and nesting(first) < 2:
        return f"e^{{{_small(first)}}}"
    if name == "sqrt" and measure(first) <= ROOT:
        return rf"\sqrt{{{first}}}" if not power else rf"\bigl(\sqrt{{{first}}}\bigr){power}"
    if name == "sqrt":
        return rf"{_brackets(first)}^{{1/2}}" if not power else rf"[{first}]^{{1/2}}{power}"
    if name == "abs":
        return rf"\lvert {first} \rvert{power}"
    if name == "conjugate":
        return rf"\overline{{{first}}}{power}" if measure(first) <= ROOT else f"({first})^{{*}}"
    if name.startswith("bessel_"):
        return f"{name[-1].upper()}_{{{first}}}{power}{_brackets(inside[1])}"
    return f"{_function(name)}{power}{_brackets(_arguments(name, parts, inside))}"


def _function(name: str) -> str:
    if name.startswith("jacobi_theta_"):
        return rf"\vartheta_{{{name[-1]}}}"
    return NAMES.get(name) or symbol_latex(name)


def _arguments(name: str, parts: tuple[FormulaTree, ...], inside: list[str]) -> str:
    if name.removeprefix("jacobi_") in MODULAR and len(parts) == 2:
        match parts[1]:
            case Power(parts=(base, Number(value=value))) if value == 2:
                return f"{inside[0]};{typed_latex(base)}"
        return rf"{inside[0]}\mid {inside[1]}"
    return ",".join(inside)


def _derivative(inner: FormulaTree, steps: tuple[str, ...]) -> str:
    order = "".join(steps)
    text = typed_latex(inner)
    text = text if isinstance(inner, Call | Unknown | Name) else _brackets(text)
    return rf"\partial_{{{order}}} {text}"


_SIDES = re.compile(r"(<=|>=|!=|<|>|=)")
_SIGNS = {"<=": r"\le", ">=": r"\ge", "!=": r"\ne", "<": "<", ">": ">", "=": "="}


def conditions_latex(parameters: str, domain: str) -> str:
    r"""The domains of a statement's parameters and variables, without the names for parts.

    >>> print(conditions_latex("k: 0<k<1; b: real; p = k*b", "t > 0"))
    $0 < k < 1$, $b$ real, $t > 0$
    """
    found = []
    for part in filter(None, (part.strip() for part in f"{parameters};{domain}".split(";"))):
        name, colon, words = part.partition(":")
        if not colon and re.fullmatch(r"\w+ *=[^=].*", part, re.DOTALL):
            continue
        found += [_condition(name.strip() if colon else "", c) for c in (words or part).split(",")]
    return ", ".join(found)


def _condition(name: str, text: str) -> str:
    sides = _SIDES.split(text.strip())
    if len(sides) == 1:
        return f"${symbol_latex(name)}$ {escape(text.strip())}"
    return f"${' '.join(_SIGNS.get(side) or typed_text_latex(side) for side in sides)}$"


_WORD = re.compile(r"\S+")
_RAISED = re.compile(r"(\w+)\*\*(\w+)")


def prose_latex(text: str) -> str:
    r"""A sentence with formulas in it as LaTeX: the longest pieces that are formulas, set as such.

    >>> print(prose_latex("k**2 for 3*k**2 in the speed, a copy"))
    $k^{2}$ for $3 k^{2}$ in the speed, a copy
    """
    words = [(found.start(), found.end()) for found in _WORD.finditer(text)]
    told, place, first = "", 0, 0
    while first < len(words):
        start = words[first][0]
        told += escape(text[place:start])
        place, last = start, first
        for last in range(min(len(words) - 1, first + 12), first - 1, -1):
            piece = text[start : words[last][1]]
            bare = piece.rstrip(",.;:")
            shown = _formula_or_none(bare)
            if shown:
                told += f"${shown}$" + piece[len(bare) :]
                break
        else:
            piece = text[start : words[first][1]]
            parts = _RAISED.split(piece)
            raised = [
                rf"$\mathrm{{{a}}}^{{{b}}}$" for a, b in zip(parts[1::3], parts[2::3], strict=True)
            ]
            parts[::3] = (part.replace("*", " ") for part in parts[::3])
            told += "".join(escape(p) + r for p, r in zip(parts[::3], [*raised, ""], strict=True))
            last = first
        place, first = words[last][1], last + 1
    return told + escape(text[place:])


_BESIDE = re.compile(r"(?<=[\w)])\s+(?=[\w(])")
"""Between factors that stand side by side."""


_DERIVED = re.compile(r"\(([^()]*)\)_([xyzt])$")
"""A bracket with a derivative's subscript."""


def _formula_or_none(text: str) -> str | None:
    """The LaTeX of a piece of a sentence that is a formula or a relation, and no word or number."""
    names = [name.partition("_")[0] for name in re.findall(r"[A-Za-z_]+", text)]
    symbols = [name for name in names if name not in FUNCTIONS]
    if text in ("a", "I", "A") or not (symbols or "/" in text or names):
        return None
    if any(len(name) > 1 and name not in (*GREEK, *LETTERS, "diff") for name in symbols):
        return None
    try:
        sides = _SIDES.split(_BESIDE.sub("*", _DERIVED.sub(r"diff(\1, \2)", text)))
        return " ".join(_SIGNS.get(side) or typed_text_latex(side) for side in sides)
    except FormulaError:
        return None
