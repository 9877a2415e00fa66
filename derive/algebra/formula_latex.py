r"""Formulas in LaTeX from their syntax trees: nothing is simplified, brackets stay.

Names of several letters are roman, so that ``ab`` and ``a*b`` differ; so are the constants e and i.
A breakable formula has no \left and \right pairs, so that TeX can break it at the signs inside
brackets; its fractions, roots and exponents that are too wide are written in one line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from longwave.derive.algebra.formula_tree import (
    ATOM,
    POWER,
    PRODUCT,
    SUM,
    Call,
    Derivative,
    FormulaTree,
    Name,
    Number,
    Part,
    Power,
    Product,
    Sum,
    Unknown,
    quotient,
    signed_sum,
)
from longwave.derive.algebra.latex_width import measure, nesting

GREEK = {
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa"),
    *("lambda", "mu", "nu", "xi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega"),
    *("Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega"),
}

CONSTANTS = {"pi": r"\pi", "I": r"\mathrm{i}"}

COMMANDS = (
    *("sin", "cos", "tan", "cot", "sec", "csc", "sinh", "cosh", "tanh", "coth", "exp", "log"),
)
"""Functions with a TeX command of the same name."""

BESSEL = {f"bessel_{letter}": letter.upper() for letter in "jyik"}
"""Bessel function -> its letter; the order, its first argument, is written as a subscript."""

OPERATORS = {
    "re": "Re",
    "im": "Im",
    "elliptic_k": "K",
    "elliptic_e": "E",
    "lambert_w": "W",
    **BESSEL,
}
"""Function -> the roman letters that LaTeX shows instead of its name."""

SYMBOLS = {
    **{f"a{name}": rf"\arc{name}" for name in ("sin", "cos", "tan")},
    **{f"jacobi_theta_{n}": rf"\vartheta_{{{n}}}" for n in range(1, 5)},
    **{f"airy_{name}i": rf"\operatorname{{{name.upper()}i}}" for name in "ab"},
    **{f"airy_{name}i_prime": rf"\operatorname{{{name.upper()}i}}'" for name in "ab"},
    "jacobi_epsilon": r"\mathcal{E}",
    "jacobi_zeta": r"\mathrm{Z}",
    "jacobi_eta": r"\mathrm{H}",
    "jacobi_theta": r"\mathrm{\Theta}",
    "weierstrass_p": r"\wp",
    "weierstrass_p_prime": r"\wp'",
}
"""Function -> the LaTeX of its name, where that is not the name in roman letters."""

SHAPED = ("exp", "sqrt", "abs", "conjugate")
"""Functions written without their name: as a power of e, a root sign, bars or an overline."""

MAX_FRACTION_WIDTH, MAX_EXPONENT_WIDTH, MAX_ROOT_WIDTH = 48.0, 34.0, 34.0
"""Largest widths in a breakable formula, in characters, of the parts that TeX cannot break: a
fraction's numerator or denominator, an exponent, and a root."""


def formula_latex(formula: FormulaTree, breakable: bool = False) -> str:
    r"""Return the formula in LaTeX.

    >>> from longwave.derive.algebra.formula_tree import MINUS_ONE
    >>> formula = Power((Call((Name("x"),), "sech"), MINUS_ONE))
    >>> print(formula_latex(formula), formula_latex(formula, breakable=True))
    \frac{1}{\operatorname{sech}\left(x\right)} \frac{1}{\operatorname{sech}(x)}
    """
    return _Writer(breakable).text(formula)


def name_latex(name: str) -> str:
    r"""Return a name in LaTeX: Greek letters as commands, digits at the end as a subscript.

    >>> print(name_latex("alpha1"), name_latex("ab"))
    \alpha_{1} \mathrm{ab}
    """
    base = name.rstrip("0123456789")
    latex = base if len(base) == 1 else f"\\{base}" if base in GREEK else rf"\mathrm{{{base}}}"
    return f"{latex}_{{{name[len(base) :]}}}" if base != name else latex


@dataclass(frozen=True)
class _Writer:
    breakable: bool

    def text(self, formula: FormulaTree) -> str:
        return self.part(formula)[0]

    def part(self, formula: FormulaTree) -> Part:
        """Return the LaTeX, and the binding strength of its outermost operation."""
        match formula:
            case Number(value=value):
                numerator, denominator = str(abs(value.numerator)), value.denominator
                text = numerator if denominator == 1 else rf"\frac{{{numerator}}}{{{denominator}}}"
                if value < 0:
                    return f"-{text}", PRODUCT
                return text, ATOM if denominator == 1 else POWER
            case Name(name=name):
                return CONSTANTS.get(name) or name_latex(name), ATOM
            case Unknown(name=name, steps=steps, site=site, shift=shift):
                index = f"{name_latex(site)}{f'{shift:+d}' * bool(shift)}" * bool(site)
                return _unknown(name, index, steps), ATOM
            case Derivative(
                parts=(Unknown(name=name, site=site, shift=shift, steps=first),), steps=steps
            ):
                return self.part(Unknown(name, (*first, *steps), site, shift))
            case Derivative(parts=(inner,), steps=steps):
                return rf"{self.brackets(self.text(inner))}_{{{_subscripts(steps)}}}", ATOM
            case Sum(parts=parts):
                return signed_sum([self.enclosed(part, PRODUCT) for part in parts]), SUM
            case Product() | Power(parts=(_, Number(value=-1))):
                return self.product(formula)
            case Power(parts=(base, exponent)):
                return self.power(base, exponent), POWER
            case Call(parts=parts, name=name):
                return self.call(name, parts)
        raise TypeError(f"formula must be a node of a tree, got {type(formula).__name__}")

    def brackets(self, text: str) -> str:
        """Enclose LaTeX in round brackets of a fitting size."""
        if not self.breakable:
            return rf"\left({text}\right)"
        return rf"\bigl({text}\bigr)" if r"\frac" in text or "(" in text else f"({text})"

    def enclosed(self, formula: FormulaTree, binding: int) -> str:
        """Return a formula's LaTeX, in brackets if its operation binds less than ``binding``."""
        text, level = self.part(formula)
        return text if level >= binding else self.brackets(text)

    def fits(self, text: str, limit: float) -> bool:
        """Return whether the text is at most ``limit`` wide, or the formula is not breakable."""
        return not self.breakable or measure(text) <= limit

    def product(self, formula: FormulaTree) -> Part:
        """Return a product; divisors are in the denominator of a fraction, or behind a slash."""
        is_negative, numerator, denominator = quotient(formula)
        sign = "-" * is_negative
        if not denominator:
            return sign + self.factors(numerator, POWER), PRODUCT
        above, below = self.factors(numerator), self.factors(denominator)
        if self.fits(above, MAX_FRACTION_WIDTH) and self.fits(below, MAX_FRACTION_WIDTH):
            return rf"{sign}\frac{{{above}}}{{{below}}}", PRODUCT if sign else POWER
        above = self.factors(numerator, PRODUCT)
        return rf"{sign}{above} \Big/ {self.brackets(below)}", PRODUCT

    def factors(self, parts: Sequence[FormulaTree], binding: int = SUM) -> str:
        """Join the factors; a single factor gets brackets if it binds less than ``binding``."""
        if len(parts) < 2:
            return self.enclosed(parts[0], binding) if parts else "1"
        texts = [self.enclosed(part, POWER) for part in parts]
        digits = [text[0].isdigit() or text.startswith(r"\frac") for text in texts]
        signs = [r" \cdot " if later else " " for _, later in pairwise(digits)]
        return texts[0] + "".join(s + t for s, t in zip(signs, texts[1:], strict=True))

    def power(self, base: FormulaTree, exponent: FormulaTree) -> str:
        raised = self.exponent(self.text(exponent))
        match base, exponent:
            case Call(name=name, parts=parts), Number() if name not in SHAPED:
                return self.call(name, parts, raised)[0]
        return f"{self.enclosed(base, ATOM)}^{{{raised}}}"

    def exponent(self, text: str) -> str:
        """Return the LaTeX of an exponent, with smaller brackets and fractions if breakable."""
        if not self.breakable:
            return text
        return text.replace(r"\frac", r"\tfrac").replace(r"\bigl", "").replace(r"\bigr", "")

    def call(self, name: str, parts: Sequence[FormulaTree], power: str = "") -> Part:
        texts = [self.text(part) for part in parts]
        first = texts[0]
        match name:
            case "exp" if self.fits(first, MAX_EXPONENT_WIDTH) and (
                not self.breakable or nesting(first) < 2
            ):
                return rf"\mathrm{{e}}^{{{self.exponent(first)}}}", POWER
            case "sqrt" if self.fits(first, MAX_ROOT_WIDTH):
                return rf"\sqrt{{{first}}}", POWER
            case "sqrt":
                return f"{self.brackets(first)}^{{1/2}}", POWER
            case "abs":
                return rf"\left|{first}\right|", ATOM
            case "conjugate":
                return rf"\overline{{{first}}}", ATOM
        label = _function(name)
        if name in BESSEL:
            label += f"_{{{texts.pop(0)}}}"
        label += f"^{{{power}}}" * bool(power)
        separator = r" \mid " if name.startswith("jacobi_") else ", "
        return label + self.brackets(separator.join(texts)), ATOM


def _unknown(name: str, index: str, steps: Sequence[str]) -> str:
    symbol, subscript = name_latex(name), ", ".join(filter(None, (index, _subscripts(steps))))
    if not subscript:
        return symbol
    return (f"{{{symbol}}}" if "_" in symbol else symbol) + f"_{{{subscript}}}"


def _subscripts(steps: Sequence[str]) -> str:
    names = [*map(name_latex, steps)]
    return "".join(names) if all(len(name) == 1 for name in names) else " ".join(names)


def _function(name: str) -> str:
    """Return the LaTeX of a function's name; one letter with digits is written like a symbol."""
    if name in SYMBOLS:
        return SYMBOLS[name]
    if name in COMMANDS:
        return f"\\{name}"
    if len(name.rstrip("0123456789")) == 1:
        return name_latex(name)
    plain = OPERATORS.get(name, name.removeprefix("jacobi_")).replace("_", r"\_")
    return rf"\operatorname{{{plain}}}"
