"""What is taken for granted of each function: definitions, derivatives, addition theorems.

The axioms are formulas in the grammar of `reading`, in letters that stand for the arguments.
``docs/trust.md`` says more of each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from .nodes import CYLINDER, Node, Nodes, children
from .reading import Scope, formula

HYPERBOLIC: Mapping[str, str] = {
    "cosh": "(exp(z) + 1/exp(z))/2",
    "sinh": "(exp(z) - 1/exp(z))/2",
    "tanh": "(exp(z)**2 - 1)/(exp(z)**2 + 1)",
    "coth": "(exp(z)**2 + 1)/(exp(z)**2 - 1)",
    "sech": "2*exp(z)/(exp(z)**2 + 1)",
    "csch": "2*exp(z)/(exp(z)**2 - 1)",
}

TRIGONOMETRIC: Mapping[str, str] = {
    "cos": "(exp(I*z) + 1/exp(I*z))/2",
    "sin": "(exp(I*z) - 1/exp(I*z))/(2*I)",
    "tan": "(exp(I*z)**2 - 1)/(I*(exp(I*z)**2 + 1))",
    "cot": "I*(exp(I*z)**2 + 1)/(exp(I*z)**2 - 1)",
    "sec": "2*exp(I*z)/(exp(I*z)**2 + 1)",
    "csc": "2*I*exp(I*z)/(exp(I*z)**2 - 1)",
}

INVERSE: Mapping[str, str] = {
    "asinh": "log(z + sqrt(1 + z**2))",
    "acosh": "log(z + sqrt(z - 1)*sqrt(z + 1))",
    "atanh": "(log(1 + z) - log(1 - z))/2",
    "asin": "-I*log(I*z + sqrt(1 - z**2))",
    "acos": "pi/2 - asin(z)",
}
"""All values are principal ones."""

DEFINITIONS: Mapping[str, str] = {
    **HYPERBOLIC,
    **TRIGONOMETRIC,
    **INVERSE,
    "sign": "z/abs(z)",
    "re": "(z + conjugate(z))/2",
    "im": "(z - conjugate(z))/(2*I)",
    "power": "exp(m*log(z))",
    "jacobi_eta": "m**(1/4)*jacobi_sn(z, m)*jacobi_theta(z, m)",
    "jacobi_zeta": "jacobi_epsilon(z, m) - z*elliptic_e(m)/elliptic_k(m)",
}

INVERSE_OF: Mapping[str, str] = {
    **{f"a{name}": name for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh")}
}

SLOPES: Mapping[str, str] = {
    "exp": "exp(z)",
    "log": "1/z",
    "atan": "1/(1 + z**2)",
    "erf": "2*exp(-z**2)/sqrt(pi)",
    "airy_ai": "airy_ai_prime(z)",
    "airy_ai_prime": "z*airy_ai(z)",
    "airy_bi": "airy_bi_prime(z)",
    "airy_bi_prime": "z*airy_bi(z)",
    "lambert_w": "lambert_w(z)/(z*(1 + lambert_w(z)))",
    "jacobi_sn": "jacobi_cn(z, m)*jacobi_dn(z, m)",
    "jacobi_cn": "-jacobi_sn(z, m)*jacobi_dn(z, m)",
    "jacobi_dn": "-m*jacobi_sn(z, m)*jacobi_cn(z, m)",
    "jacobi_epsilon": "jacobi_dn(z, m)**2",
    "jacobi_zeta": "jacobi_dn(z, m)**2 - elliptic_e(m)/elliptic_k(m)",
    "jacobi_theta": "jacobi_theta(z, m)*jacobi_zeta(z, m)",
    "weierstrass_p": "weierstrass_p_prime(z, g, h)",
    "weierstrass_p_prime": "6*weierstrass_p(z, g, h)**2 - g/2",
    **{name: f"v/z*{name}(v, z) + ({up})*{name}(v + 1, z)" for name, (up, _) in CYLINDER.items()},
}
"""Derivatives in z, all other arguments being constant."""

LETTERS: Mapping[str, str] = {
    **dict.fromkeys(CYLINDER, "vz"),
    **dict.fromkeys(("weierstrass_p", "weierstrass_p_prime"), "zgh"),
    **dict.fromkeys(("elliptic_k", "elliptic_e"), "m"),
}
"""The letters of the arguments, where they are not z and m."""

SQUARES: Mapping[tuple[str, str], str] = {
    ("jacobi_sn", "jacobi_cn"): "1 - jacobi_cn(z, m)**2",
    ("jacobi_sn", "jacobi_dn"): "(1 - jacobi_dn(z, m)**2)/m",
    ("jacobi_cn", "jacobi_sn"): "1 - jacobi_sn(z, m)**2",
    ("jacobi_cn", "jacobi_dn"): "1 - (1 - jacobi_dn(z, m)**2)/m",
    ("jacobi_dn", "jacobi_sn"): "1 - m*jacobi_sn(z, m)**2",
    ("jacobi_dn", "jacobi_cn"): "1 - m + m*jacobi_cn(z, m)**2",
    ("weierstrass_p_prime", "weierstrass_p"): (
        "4*weierstrass_p(z, g, h)**3 - g*weierstrass_p(z, g, h) - h"
    ),
}
"""The square of one function in another of the same arguments."""

EVEN = ("weierstrass_p", "jacobi_theta_2", "jacobi_theta_3", "jacobi_theta_4")
ODD = ("erf", "weierstrass_p_prime", "jacobi_theta_1")
"""Functions of which the value at -z follows."""

PHASE, HALF_PHASE = "(1 + I*z)/(1 - I*z)", "(1 + I*z)/sqrt(1 + z**2)"
"""exp(2 i atan z) and exp(i atan z)."""

UNITY: Mapping[int, str] = {
    1: "-1",
    2: "I",
    3: "(1 + I*sqrt(3))/2",
    4: "(1 + I)*sqrt(2)/2",
    6: "(sqrt(3) + I)/2",
}
"""exp(i pi/n)."""

BEHIND = (
    "(jacobi_theta(d, m)*jacobi_theta(u, m)/jacobi_theta(0, m))**2"
    "*(1 - m*jacobi_sn(u, m)**2*jacobi_sn(d, m)**2)/jacobi_theta(u + d, m)"
)
"""Theta(u - d)."""


def read(nodes: Nodes, text: str, **letters: int) -> int:
    """The node of an axiom, its letters standing for nodes."""
    return formula(Scope(nodes, known=letters), text)


def defined(nodes: Nodes, name: str, z: int, m: int = 0) -> int:
    """The node that a function is by definition."""
    return read(nodes, DEFINITIONS[name], z=z, m=m)


def letters(node: Node) -> dict[str, int]:
    """The arguments of a function by their letters."""
    return dict(zip(LETTERS.get(node[0], "zm"), children(node), strict=False))


Value = Any
"""An element of a field: + - * / with its own kind and ``**`` with integers."""


@dataclass(frozen=True)
class Station:
    """sn, cn, dn at an argument, and epsilon or zeta there (None where it is not wanted)."""

    m: Value
    sn: Value
    cn: Value
    dn: Value
    second: Value | None = None

    def __add__(self, other: Station) -> Station:
        """The addition theorems; epsilon and zeta have the same one."""
        one = self.sn.ring.number(1)
        below = one - self.m * self.sn**2 * other.sn**2
        sn = (self.sn * other.cn * other.dn + other.sn * self.cn * self.dn) / below
        cn = (self.cn * other.cn - self.sn * self.dn * other.sn * other.dn) / below
        dn = (self.dn * other.dn - self.m * self.sn * self.cn * other.sn * other.cn) / below
        second = None
        if self.second is not None and other.second is not None:
            second = self.second + other.second - self.m * self.sn * other.sn * sn
        return Station(self.m, sn, cn, dn, second)

    def __neg__(self) -> Station:
        """sn, epsilon and zeta are odd, cn and dn even."""
        second = None if self.second is None else -self.second
        return Station(self.m, -self.sn, self.cn, self.dn, second)

    def times(self, factor: int) -> Station:
        """The station at ``factor``, which is not 0, times the argument."""
        if factor < 0:
            return (-self).times(-factor)
        if factor == 1:
            return self
        half = self.times(factor // 2)
        return half + half + self if factor % 2 else half + half
