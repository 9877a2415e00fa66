"""Names with a meaning in statements: variables, functions, and constants of other systems."""

from __future__ import annotations

from typing import Any

import sympy as sp

from longwave.solutions import functions
from longwave.solutions.functions.jet_functions import THETA, jet_function
from longwave.solutions.functions.weierstrass import weierstrass_p, weierstrass_p_prime

CONTINUOUS, SITE = "xyzt", "n"

PARTS = 50
"""Most equations, solutions or parameters of a statement."""

MISREAD = {
    **dict.fromkeys(("i", "j"), "write I for the imaginary unit"),
    **dict.fromkeys(("e", "E"), "write exp(1)"),
    **dict.fromkeys(("Pi", "PI"), "write pi"),
    **dict.fromkeys(("oo", "inf"), "leave the bound out"),
    **dict.fromkeys(("nan", "zoo"), "formulas have values"),
}
"""Names that are constants in other systems and must be declared here."""

_ONE = (
    *(sp.exp, sp.log, sp.sqrt, sp.sin, sp.cos, sp.tan, sp.cot, sp.sec, sp.csc),
    *(sp.sinh, sp.cosh, sp.tanh, sp.coth, sp.sech, sp.csch),
    *(sp.asin, sp.acos, sp.atan, sp.asinh, sp.acosh, sp.atanh),
    *(sp.erf, sp.sign, sp.conjugate, sp.re, sp.im, sp.elliptic_k, sp.elliptic_e),
)
BESSEL = {f"bessel_{kind}": getattr(sp, f"bessel{kind}") for kind in "jyik"}
"""SymPy's Bessel functions by name; their arguments are (order, z)."""

OTHERS = {
    "airy_ai": sp.airyai,
    "airy_ai_prime": sp.airyaiprime,
    "airy_bi": sp.airybi,
    "airy_bi_prime": sp.airybiprime,
    "lambert_w": sp.LambertW,
}
"""Functions whose name in SymPy differs from that in the grammar."""

FUNCTIONS = {
    "abs": (sp.Abs, 1),
    **{function.__name__: (function, 1) for function in _ONE},
    **{name: (getattr(functions, name), 2) for name in functions.__all__},
    **{name: (function, 1) for name, function in OTHERS.items()},
    **{name: (function, 2) for name, function in BESSEL.items()},
    **{name: (jet_function(name), 2) for name in THETA},
    **{function.__name__: (function, 3) for function in (weierstrass_p, weierstrass_p_prime)},
}
"""Functions of the grammar, each with its arity."""


def function_named(name: str) -> Any:
    """Return the function of the grammar with this name, else an arbitrary function."""
    return FUNCTIONS[name][0] if name in FUNCTIONS else jet_function(name)
