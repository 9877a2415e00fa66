"""Axioms of each function as data: one row for each, with formulas as text.

The formulas are in the grammar of `reading`.  Their letters stand for the function's arguments, and
a slope is the derivative in z.  ``docs/trust.md`` explains each row.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from flint import acb, fmpq

from .bounds import POSITIVE, UNIT, Interval
from .function_values import jet_ball, theta_ball, weierstrass

HALF_PI = fmpq(15707963, 10**7)
"""Rational lower bound of pi/2, less than 1e-7 below it."""

ANYWHERE = Interval()

Ends = tuple[fmpq | None, fmpq | None]
"""Lower and upper end of an interval; None if it is unbounded on that side."""


@dataclass(frozen=True)
class Function:
    """Axioms and properties of one function f.

    ``kind``: "entire"; "regular", with poles only off the real axis; "poles", also on it; "arc",
    with cuts only off the real axis; "cut", also on it; "tame", not analytic but without poles and
    jumps; "jump", none of these.  ``values`` is the range for real arguments with z ``between`` two
    numbers (None: not known to be real).  ``symmetry`` is "odd" or "even" in z, "same" if f is odd
    and has the sign of a real z, "inverse" if f(-z) = 1/f(z).  A ``free`` f satisfies no polynomial
    relation and may be a generator.  ``below_one``: its parameter must be < 1; ``above_zero``: > 0.
    """

    kind: str
    slope: str = ""
    definition: str = ""
    letters: str = "z"
    values: Interval | None = ANYWHERE
    between: Ends = (None, None)
    symmetry: str = ""
    free: bool = False
    below_one: bool = False
    above_zero: bool = False
    ball: Callable[..., acb] | None = None

    def arguments(self, *nodes: int) -> dict[str, int]:
        """Return the nodes of the arguments by their letters in the axioms."""
        return dict(zip(self.letters, nodes, strict=True))

    def parameters(self, *nodes: int) -> list[int]:
        """Return the nodes of the arguments other than z."""
        return [node for letter, node in self.arguments(*nodes).items() if letter != "z"]


SQUARED = Interval(fmpq(0), fmpq(1), True)
INSIDE_UNIT = Interval(fmpq(-1), fmpq(1), True, True)
NOT_NEGATIVE = Interval(fmpq(0))
ABOVE: Ends = (fmpq(0), None)
UNIT_ENDS: Ends = (fmpq(-1), fmpq(1))

CYLINDER = {"bessel_j": (-1, 1), "bessel_y": (-1, 1), "bessel_i": (1, 1), "bessel_k": (-1, -1)}
"""Pairs (a, b) for Bessel functions C(v): C' = v/z C + a C(v + 1) = b C(v - 1) - v/z C."""


def _elliptic(kind: str, slope: str, symmetry: str, **more: Any) -> Function:
    return Function(kind, slope, letters="zm", symmetry=symmetry, **more)


def _free(kind: str, slope: str, **more: Any) -> Function:
    return Function(kind, slope, free=True, **more)


def _bessel(name: str, values: Interval = ANYWHERE) -> Function:
    slope = f"v/z*{name}(v, z) + ({CYLINDER[name][0]})*{name}(v + 1, z)"
    ball = lambda v, z: getattr(z, name)(v)  # noqa: E731
    return _free("cut", slope, letters="vz", values=values, between=ABOVE, ball=ball)


FUNCTIONS: Mapping[str, Function] = {
    "exp": Function("entire", "exp(z)", values=POSITIVE, symmetry="inverse", free=True),
    "cosh": Function("entire", definition="(exp(z) + 1/exp(z))/2", values=Interval(fmpq(1))),
    "sinh": Function("entire", definition="(exp(z) - 1/exp(z))/2", symmetry="same"),
    "tanh": Function("regular", definition="(exp(z)**2 - 1)/(exp(z)**2 + 1)", symmetry="same",
                     values=INSIDE_UNIT),
    "coth": Function("poles", definition="(exp(z)**2 + 1)/(exp(z)**2 - 1)", symmetry="same"),
    "sech": Function("regular", definition="2*exp(z)/(exp(z)**2 + 1)", values=SQUARED),
    "csch": Function("poles", definition="2*exp(z)/(exp(z)**2 - 1)", symmetry="same"),
    "cos": Function("entire", definition="(exp(I*z) + 1/exp(I*z))/2", values=UNIT),
    "sin": Function("entire", definition="(exp(I*z) - 1/exp(I*z))/(2*I)", values=UNIT),
    "tan": Function("poles", definition="(exp(I*z)**2 - 1)/(I*(exp(I*z)**2 + 1))"),
    "cot": Function("poles", definition="I*(exp(I*z)**2 + 1)/(exp(I*z)**2 - 1)"),
    "sec": Function("poles", definition="2*exp(I*z)/(exp(I*z)**2 + 1)"),
    "csc": Function("poles", definition="2*I*exp(I*z)/(exp(I*z)**2 - 1)"),
    "log": Function("cut", "1/z", between=ABOVE, free=True),
    "atan": Function("arc", "1/(1 + z**2)", symmetry="same", free=True),
    "power": Function("cut", definition="exp(m*log(z))", letters="zm", values=None),
    "Abs": Function("tame"),
    "sign": Function("jump", definition="z/abs(z)", symmetry="same"),
    "conjugate": Function("tame", symmetry="same"),
    "re": Function("tame", definition="(z + conjugate(z))/2", symmetry="same"),
    "im": Function("tame", definition="(z - conjugate(z))/(2*I)"),
    "diff": Function("jump"),
    "elliptic_k": Function("cut", letters="m", values=POSITIVE, free=True, below_one=True),
    "elliptic_e": Function("cut", letters="m", values=POSITIVE, free=True, below_one=True),
    "jacobi_sn": _elliptic("regular", "jacobi_cn(z, m)*jacobi_dn(z, m)", "odd", values=UNIT),
    "jacobi_cn": _elliptic("regular", "-jacobi_sn(z, m)*jacobi_dn(z, m)", "even", values=UNIT),
    "jacobi_dn": _elliptic("regular", "-m*jacobi_sn(z, m)*jacobi_cn(z, m)", "even"),
    "jacobi_epsilon": _elliptic("regular", "jacobi_dn(z, m)**2", "odd", free=True),
    "jacobi_zeta": _elliptic("regular", "jacobi_dn(z, m)**2 - elliptic_e(m)/elliptic_k(m)", "odd",
                             free=True, below_one=True),
    "jacobi_theta": _elliptic("regular", "jacobi_theta(z, m)*jacobi_zeta(z, m)", "even",
                              values=POSITIVE, free=True, below_one=True, above_zero=True),
    "jacobi_eta": Function("regular", letters="zm", below_one=True, above_zero=True,
                           definition="m**(1/4)*jacobi_sn(z, m)*jacobi_theta(z, m)"),
    "jet": Function("regular", free=True, ball=jet_ball),
    "theta": Function("regular", letters="zq", free=True, below_one=True, above_zero=True,
                      ball=theta_ball),
    "parity": Function("jump"),
    "asinh": Function("arc", definition="log(z + sqrt(1 + z**2))", symmetry="same"),
    "acosh": Function("cut", definition="log(z + sqrt(z - 1)*sqrt(z + 1))",
                      values=NOT_NEGATIVE, between=(fmpq(1), None)),
    "atanh": Function("cut", definition="(log(1 + z) - log(1 - z))/2", symmetry="same",
                      between=UNIT_ENDS),
    "asin": Function("cut", definition="-I*log(I*z + sqrt(1 - z**2))", symmetry="same",
                     between=UNIT_ENDS),
    "acos": Function("cut", definition="pi/2 - asin(z)", values=NOT_NEGATIVE, between=UNIT_ENDS),
    "erf": _free("entire", "2*exp(-z**2)/sqrt(pi)", symmetry="same", values=INSIDE_UNIT),
    "airy_ai": _free("entire", "airy_ai_prime(z)"),
    "airy_ai_prime": _free("entire", "z*airy_ai(z)", ball=lambda z: z.airy_ai(derivative=1)),
    "airy_bi": _free("entire", "airy_bi_prime(z)"),
    "airy_bi_prime": _free("entire", "z*airy_bi(z)", ball=lambda z: z.airy_bi(derivative=1)),
    "lambert_w": _free("cut", "lambert_w(z)/(z*(1 + lambert_w(z)))", values=NOT_NEGATIVE,
                       between=ABOVE, ball=lambda z: z.lambertw()),
    "bessel_j": _bessel("bessel_j"),
    "bessel_y": _bessel("bessel_y"),
    "bessel_i": _bessel("bessel_i"),
    "bessel_k": _bessel("bessel_k", POSITIVE),
    "weierstrass_p": _free("poles", "weierstrass_p_prime(z, g, h)", letters="zgh", symmetry="even",
                           ball=lambda *z: weierstrass(*z)[0]),
    "weierstrass_p_prime": _free("poles", "6*weierstrass_p(z, g, h)**2 - g/2", letters="zgh",
                                 symmetry="odd", ball=lambda *z: weierstrass(*z)[1]),
}  # fmt: skip

SQUARES: Mapping[tuple[str, str], str] = {
    ("jacobi_sn", "jacobi_cn"): "1 - jacobi_cn(z, m)**2",
    ("jacobi_sn", "jacobi_dn"): "(1 - jacobi_dn(z, m)**2)/m",
    ("jacobi_cn", "jacobi_sn"): "1 - jacobi_sn(z, m)**2",
    ("jacobi_cn", "jacobi_dn"): "1 - (1 - jacobi_dn(z, m)**2)/m",
    ("jacobi_dn", "jacobi_sn"): "1 - m*jacobi_sn(z, m)**2",
    ("jacobi_dn", "jacobi_cn"): "1 - m + m*jacobi_cn(z, m)**2",
    ("weierstrass_p_prime", "weierstrass_p"):
        "4*weierstrass_p(z, g, h)**3 - g*weierstrass_p(z, g, h) - h",
}  # fmt: skip
"""Square of the first function in a key, in terms of the second at the same arguments."""

SINE_OF_SUM = "1 - m*jacobi_sn(u, m)**2*jacobi_sn(v, m)**2"

SUMS: Mapping[str, str] = {
    "jacobi_sn": "(jacobi_sn(u, m)*jacobi_cn(v, m)*jacobi_dn(v, m)"
    f" + jacobi_sn(v, m)*jacobi_cn(u, m)*jacobi_dn(u, m))/({SINE_OF_SUM})",
    "jacobi_cn": "(jacobi_cn(u, m)*jacobi_cn(v, m)"
    f" - jacobi_sn(u, m)*jacobi_dn(u, m)*jacobi_sn(v, m)*jacobi_dn(v, m))/({SINE_OF_SUM})",
    "jacobi_dn": "(jacobi_dn(u, m)*jacobi_dn(v, m)"
    f" - m*jacobi_sn(u, m)*jacobi_cn(u, m)*jacobi_sn(v, m)*jacobi_cn(v, m))/({SINE_OF_SUM})",
    **{
        name: f"{name}(u, m) + {name}(v, m) - m*jacobi_sn(u, m)*jacobi_sn(v, m)*jacobi_sn(z, m)"
        for name in ("jacobi_epsilon", "jacobi_zeta")
    },
}
"""Addition theorems: each function at z = u + v."""

SPECIAL_VALUES: Mapping[str, tuple[str, str]] = {
    "jacobi_sn": ("0", "1"),
    "jacobi_cn": ("1", "0"),
    "jacobi_dn": ("1", "sqrt(1 - m)"),
    "jacobi_epsilon": ("0", "elliptic_e(m)"),
    "jacobi_zeta": ("0", "0"),
}
"""Values of each function at z = 0 and at z = K(m)."""

ZETA = "jacobi_epsilon(z, m) - z*elliptic_e(m)/elliptic_k(m)"
"""Jacobi's zeta in terms of epsilon, used if no zeta is a generator."""

BEHIND = (
    "(jacobi_theta(d, m)*jacobi_theta(u, m)/jacobi_theta(0, m))**2"
    "*(1 - m*jacobi_sn(u, m)**2*jacobi_sn(d, m)**2)/jacobi_theta(u + d, m)"
)
"""Theta(u - d) by the product theorem, in terms of Theta at u + d, u, d and 0."""
