r"""LaTeX of typed formulas: terms keep their order, and lines break at plus and minus signs.

Round brackets are not \left and \right pairs, so that TeX can break a long formula at the signs
inside them. A fraction, root or exponent that is too wide is written in one line instead.
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
"""Binding strength of the outermost operation of a formula."""

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
"""LaTeX of function names; other names are printed as symbols."""

MODULAR = ("sn", "cn", "dn", "epsilon", "zeta", "eta", "theta")
"""Jacobi functions whose second argument is the parameter; for k**2 the modulus k is printed."""

LETTERS = {"I": "i", "pi": r"\pi", **{name: NAMES[f"jacobi_{name}"] for name in ("sn", "cn", "dn")}}
"""LaTeX of names with a special meaning."""


def typed_latex(formula: FormulaTree) -> str:
    r"""Return the LaTeX of a formula.

    >>> print(typed_text_latex("3*c**2/(1 - c**2)*sech(c*x/2)**2"))
    \frac{3 c^{2}}{1 - c^{2}} \operatorname{sech}^{2}\bigl(\frac{c x}{2}\bigr)
    >>> print(typed_text_latex("k*jacobi_cn(b*x, k**2)*exp(-I*t)"))
    k \operatorname{cn}(b x;k) e^{- i t}
    """
    return _latex_and_binding(formula)[0]


def typed_text_latex(text: str) -> str:
    """Return the LaTeX of a formula's text. Raises FormulaError if it cannot be parsed."""
    fields = {letter: sp.Function(letter)(*sp.symbols("x y z t")) for letter in "uvw"}
    variables = dict(zip("xyzt", sp.symbols("x y z t"), strict=True))
    words = Vocabulary(FUNCTIONS, variables=variables, fields=fields, unknown_name=sp.Symbol)
    return typed_latex(Parser(text, tokens(text), words, "formula").whole())


def statement_parts(statement: Statement) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return a typed statement's equations, each with "= 0", and its solutions, in LaTeX.

    The definitions of named parts follow the solutions. Both are empty without a typed text.
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


def _latex_and_binding(formula: FormulaTree) -> tuple[str, int]:
    """Return the LaTeX, and the binding strength of its outermost operation."""
    match formula:
        case Number(value=value):
            return _number(value)
        case Name(name=name):
            return LETTERS.get(name) or symbol_latex(name), ATOM
        case Unknown(name=name, steps=steps, site=site, shift=shift):
            index = f"{site}{shift:+d}" if shift else site
            subscript = ",".join(part for part in (index, "".join(steps)) if part)
            return symbol_latex(name) + (f"_{{{subscript}}}" if subscript else ""), ATOM
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
    numerator, denominator = abs(value.numerator), value.denominator
    text = str(numerator) if denominator == 1 else rf"\frac{{{numerator}}}{{{denominator}}}"
    return (f"- {text}", SUM) if value < 0 else (text, ATOM)


def _enclosed(formula: FormulaTree, binding: int) -> str:
    """Return the LaTeX, in brackets if its outermost operation binds less than ``binding``."""
    text, level = _latex_and_binding(formula)
    return text if level >= binding else _brackets(text)


def _brackets(text: str) -> str:
    """Enclose LaTeX in round brackets of a fitting size, in which a line may break."""
    big = r"\bigl", r"\bigr"
    opening, closing = big if r"\frac" in text or "(" in text else ("", "")
    return f"{opening}({text}{closing})"


def _sum(parts: tuple[FormulaTree, ...]) -> str:
    text = ""
    for part in parts:
        term, level = _latex_and_binding(part)
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
    """Return a product; the factors between two divisions are the numerator of the second."""
    minus = False
    if _plain(parts):
        parts = tuple(sorted(parts, key=lambda part: not isinstance(part, Number)))
    texts: list[str] = []
    numerator: list[FormulaTree] = []
    denominator: list[FormulaTree] = []

    def close_fraction() -> None:
        nonlocal numerator, denominator
        if denominator:
            texts.append(_fraction(numerator, denominator))
        else:
            texts.extend(_factors(numerator))
        numerator, denominator = [], []

    for part in parts:
        if part == MINUS_ONE:
            minus = not minus
        elif isinstance(part, Power) and part.parts[1] == MINUS_ONE:
            denominator.append(part.parts[0])
        else:
            if denominator:
                close_fraction()
            numerator.append(part)
    close_fraction()
    return ("- " if minus else "") + _side_by_side(texts or ["1"])


def _plain(parts: tuple[FormulaTree, ...]) -> bool:
    """Return whether a product has no division."""
    return not any(isinstance(p, Power) and p.parts[1] == MINUS_ONE for p in parts)


def _factors(parts: list[FormulaTree]) -> list[str]:
    return [_enclosed(part, PRODUCT if not isinstance(part, Number) else ATOM) for part in parts]


def _side_by_side(texts: list[str]) -> str:
    """Join factors with spaces, and with a dot between two digits."""
    text = texts[0]
    for further in texts[1:]:
        text += (r" \cdot " if further[0].isdigit() and text[-1].isdigit() else " ") + further
    return text


def _fraction(numerator: list[FormulaTree], denominator: list[FormulaTree]) -> str:
    """Return a fraction; a wide one is written in one line with a slash."""
    single = len(numerator) == 1
    top = (
        typed_latex(numerator[0])
        if single
        else _side_by_side(_factors(numerator))
        if numerator
        else "1"
    )
    bottom = (
        typed_latex(denominator[0])
        if len(denominator) == 1
        else _side_by_side(_factors(denominator))
    )
    if max(measure(top), measure(bottom)) <= FRACTION:
        return rf"\frac{{{top}}}{{{bottom}}}"
    top = _brackets(top) if single and isinstance(numerator[0], Sum) else top
    return rf"{top} \Big/ {_brackets(bottom)}"


def _power(base: FormulaTree, exponent: FormulaTree) -> tuple[str, int]:
    if exponent == MINUS_ONE:
        return _fraction([], [base]), PRODUCT
    raised = _exponent_latex(typed_latex(exponent))
    if isinstance(base, Call) and isinstance(exponent, Number) and base.name in NAMES:
        return _call(base.name, base.parts, f"^{{{raised}}}"), ATOM
    return f"{_enclosed(base, ATOM)}^{{{raised}}}", POWER


def _exponent_latex(text: str) -> str:
    """Return LaTeX adapted for an exponent: small fractions and brackets."""
    return text.replace(r"\frac", r"\tfrac").replace(r"\bigl", "").replace(r"\bigr", "")


def _call(name: str, parts: tuple[FormulaTree, ...], power: str) -> str:
    """Return a function of its arguments; a power is written after the function's name."""
    inside = [typed_latex(part) for part in parts]
    first = inside[0]
    if name == "exp" and not power and measure(first) <= EXPONENT and nesting(first) < 2:
        return f"e^{{{_exponent_latex(first)}}}"
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
    r"""Return the domains of a statement's parameters and variables, without definitions.

    >>> print(conditions_latex("k: 0<k<1; b: real; p = k*b", "t > 0"))
    $0 < k < 1$, $b$ real, $t > 0$
    """
    conditions = []
    for part in filter(None, (part.strip() for part in f"{parameters};{domain}".split(";"))):
        name, colon, words = part.partition(":")
        if not colon and re.fullmatch(r"\w+ *=[^=].*", part, re.DOTALL):
            continue
        conditions += [
            _condition(name.strip() if colon else "", c) for c in (words or part).split(",")
        ]
    return ", ".join(conditions)


def _condition(name: str, text: str) -> str:
    sides = _SIDES.split(text.strip())
    if len(sides) == 1:
        return f"${symbol_latex(name)}$ {escape(text.strip())}"
    return f"${' '.join(_SIGNS.get(side) or typed_text_latex(side) for side in sides)}$"


_WORD = re.compile(r"\S+")
_RAISED = re.compile(r"(\w+)\*\*(\w+)")


def prose_latex(text: str) -> str:
    r"""Return a sentence as LaTeX; the longest pieces that parse as formulas are set as formulas.

    >>> print(prose_latex("k**2 for 3*k**2 in the speed, a copy"))
    $k^{2}$ for $3 k^{2}$ in the speed, a copy
    """
    words = [(match.start(), match.end()) for match in _WORD.finditer(text)]
    latex, position, first = "", 0, 0
    while first < len(words):
        start = words[first][0]
        latex += escape(text[position:start])
        position, last = start, first
        for last in range(min(len(words) - 1, first + 12), first - 1, -1):
            piece = text[start : words[last][1]]
            formula_text = piece.rstrip(",.;:")
            formula = _formula_or_none(formula_text)
            if formula:
                latex += f"${formula}$" + piece[len(formula_text) :]
                break
        else:
            piece = text[start : words[first][1]]
            parts = _RAISED.split(piece)
            raised = [
                rf"$\mathrm{{{a}}}^{{{b}}}$" for a, b in zip(parts[1::3], parts[2::3], strict=True)
            ]
            parts[::3] = (part.replace("*", " ") for part in parts[::3])
            latex += "".join(escape(p) + r for p, r in zip(parts[::3], [*raised, ""], strict=True))
            last = first
        position, first = words[last][1], last + 1
    return latex + escape(text[position:])


_BESIDE = re.compile(r"(?<=[\w)])\s+(?=[\w(])")
"""Space between factors."""


_DERIVED = re.compile(r"\(([^()]*)\)_([xyzt])$")
"""Bracket with a derivative's subscript."""


def _formula_or_none(text: str) -> str | None:
    """Return the LaTeX of a piece of text that is a formula or relation, else None."""
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
