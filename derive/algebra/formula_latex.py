"""Formulas in LaTeX from their syntax trees: nothing is simplified, brackets stay.

Names of several letters are roman, so that ``ab`` and ``a*b`` differ; so are the constants e and i.
"""

from __future__ import annotations

from collections.abc import Sequence
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

GREEK = {
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa"),
    *("lambda", "mu", "nu", "xi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega"),
    *("Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega"),
}

CONSTANTS = {"pi": r"\pi", "I": r"\mathrm{i}"}

COMMANDS = ("sin", "cos", "tan", "cot", "sec", "csc", "sinh", "cosh", "tanh", "coth", "log")
OPERATORS = {"re": "Re", "im": "Im", "elliptic_k": "K", "elliptic_e": "E", "lambert_w": "W"}

SHAPED = ("exp", "sqrt", "abs", "conjugate")
"""Functions with a notation of their own instead of a name."""


def formula_latex(formula: FormulaTree) -> str:
    r"""Return the formula in LaTeX.

    >>> from longwave.derive.algebra.formula_tree import MINUS_ONE
    >>> print(formula_latex(Power((Call((Name("x"),), "sech"), MINUS_ONE))))
    \frac{1}{\operatorname{sech}\left(x\right)}
    """
    return _latex_and_binding(formula)[0]


def name_latex(name: str) -> str:
    r"""Return a name in LaTeX: Greek letters as commands, digits at the end as a subscript.

    >>> print(name_latex("alpha1"), name_latex("ab"))
    \alpha_{1} \mathrm{ab}
    """
    base = name.rstrip("0123456789")
    latex = base if len(base) == 1 else f"\\{base}" if base in GREEK else rf"\mathrm{{{base}}}"
    return f"{latex}_{{{name[len(base) :]}}}" if base != name else latex


def _enclosed(formula: FormulaTree, binding: int) -> str:
    text, level = _latex_and_binding(formula)
    return text if level >= binding else rf"\left({text}\right)"


def _latex_and_binding(formula: FormulaTree) -> Part:
    match formula:
        case Number(value=value):
            size, denominator = str(abs(value.numerator)), value.denominator
            text = size if denominator == 1 else rf"\frac{{{size}}}{{{denominator}}}"
            return (
                (f"-{text}", PRODUCT) if value < 0 else (text, ATOM if denominator == 1 else POWER)
            )
        case Name(name=name):
            return CONSTANTS.get(name) or name_latex(name), ATOM
        case Unknown(name=name, steps=steps, site=site, shift=shift):
            return _unknown(
                name, f"{name_latex(site)}{f'{shift:+d}' * bool(shift)}" * bool(site), steps
            )
        case Derivative(
            parts=(Unknown(name=name, site=site, shift=shift, steps=first),), steps=steps
        ):
            return _latex_and_binding(Unknown(name, (*first, *steps), site, shift))
        case Derivative(parts=(inner,), steps=steps):
            return rf"\left({_latex_and_binding(inner)[0]}\right)_{{{_subscripts(steps)}}}", ATOM
        case Sum(parts=parts):
            return signed_sum([_enclosed(part, PRODUCT) for part in parts]), SUM
        case Product() | Power(parts=(_, Number(value=-1))):
            return _product(formula)
        case Power(parts=(base, exponent)):
            return _power(base, exponent), POWER
        case Call(parts=parts, name=name):
            return _call(name, parts)
    raise TypeError(f"formula must be a node of a tree, got {type(formula).__name__}")


def _unknown(name: str, site: str, steps: Sequence[str]) -> Part:
    symbol, subscript = name_latex(name), ", ".join(filter(None, (site, _subscripts(steps))))
    if not subscript:
        return symbol, ATOM
    return (f"{{{symbol}}}" if "_" in symbol else symbol) + f"_{{{subscript}}}", ATOM


def _subscripts(steps: Sequence[str]) -> str:
    names = [*map(name_latex, steps)]
    return "".join(names) if all(len(name) == 1 for name in names) else " ".join(names)


def _product(formula: FormulaTree) -> Part:
    """Return a product in LaTeX; divisors are in the denominator of a fraction."""
    is_negative, numerator, denominator = quotient(formula)
    sign = "-" * is_negative
    if not denominator:
        return sign + _factors(numerator, POWER), PRODUCT
    text = rf"\frac{{{_factors(numerator)}}}{{{_factors(denominator)}}}"
    return sign + text, PRODUCT if sign else POWER


def _factors(parts: Sequence[FormulaTree], binding: int = SUM) -> str:
    """Return the factors side by side; a single one has brackets unless it binds as ``binding``."""
    if len(parts) < 2:
        return _enclosed(parts[0], binding) if parts else "1"
    texts = [_enclosed(part, POWER) for part in parts]
    digits = [text[0].isdigit() or text.startswith(r"\frac") for text in texts]
    signs = [r" \cdot " if later else " " for _, later in pairwise(digits)]
    return texts[0] + "".join(s + t for s, t in zip(signs, texts[1:], strict=True))


def _power(base: FormulaTree, exponent: FormulaTree) -> str:
    power = _latex_and_binding(exponent)[0]
    match base, exponent:
        case Call(name=name, parts=parts), Number() if name not in SHAPED:
            return _call(name, parts, power)[0]
    return f"{_enclosed(base, ATOM)}^{{{power}}}"


def _call(name: str, parts: Sequence[FormulaTree], power: str = "") -> Part:
    texts = [_latex_and_binding(part)[0] for part in parts]
    match name:
        case "exp":
            return rf"\mathrm{{e}}^{{{texts[0]}}}", POWER
        case "sqrt":
            return rf"\sqrt{{{texts[0]}}}", POWER
        case "abs":
            return rf"\left|{texts[0]}\right|", ATOM
        case "conjugate":
            return rf"\overline{{{texts[0]}}}", ATOM
    plain = OPERATORS.get(name, name.removeprefix("jacobi_")).replace("_", r"\_")
    label = f"\\{name}" if name in COMMANDS else rf"\operatorname{{{plain}}}"
    if len(name.rstrip("0123456789")) == 1:
        label = name_latex(name)
    separator = r" \mid " if name.startswith("jacobi_") else ", "
    return rf"{label}{f'^{{{power}}}' * bool(power)}\left({separator.join(texts)}\right)", ATOM
