"""Numbers in a scene that are multiples of the quarter period: "K/2", "3*K/4", "K".

The grammar is ``[integer *] K [/ integer]`` and nothing else; nothing is evaluated as code.
"""

import re
from fractions import Fraction

import sympy as sp

GRAMMAR = re.compile(r"(?:(?P<times>\d{1,6})\s*\*\s*)?K(?:\s*/\s*(?P<over>\d{1,6}))?")


def quarter_period_multiple(name: str, text: str) -> Fraction:
    """The rational r for which ``text`` means r K.

    Raises ValueError for anything outside the grammar.

    >>> quarter_period_multiple("alpha", "3*K/4")
    Fraction(3, 4)
    """
    match = GRAMMAR.fullmatch(text.strip())
    if match is None or int(match["over"] or 1) == 0:
        raise ValueError(
            f"{name} must be a number or a multiple of K, got {text!r} (such as 0.7 or '3*K/4')"
        )
    return Fraction(int(match["times"] or 1), int(match["over"] or 1))


def exact_quantity(name: str, value: float | str, k: sp.Expr | None) -> float | sp.Expr:
    """``value`` as a wave takes it: a number unchanged, "K/2" as SymPy's elliptic_k(k**2)/2.

    ``k`` is the exact modulus, None if the wave has none (then a multiple of K is refused).
    """
    if not isinstance(value, str):
        return value
    multiple = quarter_period_multiple(name, value)
    if k is None:
        raise ValueError(f"{name} must be a number, got {value!r} (K needs the modulus k)")
    return sp.Rational(multiple.numerator, multiple.denominator) * sp.elliptic_k(k**2)
