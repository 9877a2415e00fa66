"""Functions as other systems call them, as the grammar of `formula_text` does."""

from __future__ import annotations

import re
from collections.abc import Callable

Replacement = str | Callable[[re.Match[str]], str]
Rule = tuple[str, Replacement]
"""A pattern and what stands in its place. In patterns ``<U>`` is an unknown, with derivatives
and a site ``<D>``, ``<F>`` a function of the grammar, ``<A>`` an argument, ``<()>`` and ``<[]>``
what stands in brackets, with these, ``<e>`` and ``<i>`` constants unless declared as names."""

ALIASES = {
    "ln": "log",
    "Ln": "log",
    "Exp": "exp",
    "Sqrt": "sqrt",
    "root": "sqrt",
    **{f"arc{name}": f"a{name}" for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh")},
    **{f"Arc{name}": f"a{name.lower()}" for name in ("Sin", "Cos", "Tan", "Sinh", "Cosh", "Tanh")},
    **{f"ar{name}": f"a{name}" for name in ("sinh", "cosh", "tanh")},
    **{f"arg{name}": f"a{name}" for name in ("sh", "ch", "th")},
    "arctg": "atan",
    "tg": "tan",
    "ctg": "cot",
    "cotg": "cot",
    "cosec": "csc",
    "sh": "sinh",
    "ch": "cosh",
    "th": "tanh",
    "cth": "coth",
    "arsh": "asinh",
    "arch": "acosh",
    "arth": "atanh",
    "argsh": "asinh",
    "argch": "acosh",
    "argth": "atanh",
    "Abs": "abs",
    "fabs": "abs",
    "norm": "abs",
    "modulus": "abs",
    "mod": "abs",
    "sgn": "sign",
    "signum": "sign",
    "Sign": "sign",
    "conj": "conjugate",
    "Conj": "conjugate",
    "cc": "conjugate",
    "Re": "re",
    "real": "re",
    "Im": "im",
    "imag": "im",
    **{f"airy{name}": f"airy_{name}" for name in ("ai", "bi")},
    **{f"Airy{name}": f"airy_{name.lower()}" for name in ("Ai", "Bi")},
    **{f"Airy{name}Prime": f"airy_{name.lower()}_prime" for name in ("Ai", "Bi")},
    **{f"airy{name}prime": f"airy_{name}_prime" for name in ("ai", "bi")},
    **{f"bessel{name}": f"bessel_{name}" for name in "jyik"},
    **{f"Bessel{name}": f"bessel_{name.lower()}" for name in "JYIK"},
    **dict.fromkeys(("ProductLog", "LambertW", "lambertw", "W"), "lambert_w"),
    "ellipk": "elliptic_k",
    "ellipticK": "elliptic_k",
    "elliptic_K": "elliptic_k",
    "ellipe": "elliptic_e",
    "ellipticE": "elliptic_e",
    "elliptic_E": "elliptic_e",
    **{f"jacobi{name}": f"jacobi_{name}" for name in ("sn", "cn", "dn")},
}
"""Names of functions; those that differ by capital letters alone need no line."""

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
    (
        r"(?<![\w.])Elliptic([KE])\s*\(\s*(<A>)\)",
        lambda m: f"elliptic_{m[1].lower()}(({m[2]})**2)",
    ),
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
"""Calls whose arguments are written otherwise. ``<A>`` is an argument, ``<()>`` one in brackets."""
