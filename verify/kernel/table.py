"""The table of the kernel's rules, in the order in which they are tried, and their assumptions.

A generator, a hint for the argument and a function's symmetry come before the rules of "image",
its definition (`axioms.FUNCTIONS`) behind them.  The first rule that applies decides.

    image        the image of a function that is no generator
    relation     the power of a generator that is a polynomial in earlier ones
    branch       whether a value is the principal root; one yes is enough
    continuity   whether a value is the principal one of an inverse function; one yes is enough
    equation     whether an equation holds, before the formulas are put in and multiplied out
"""

from __future__ import annotations

from . import exponential_rules as exponential
from . import inverse_rules as inverse
from . import quotients
from . import root_rules as roots
from . import special_rules as special
from .axioms import CYLINDER, SUMS
from .field import Rule, Rules

RULES = Rules(
    Rule("image", ("Pow",), roots.root, "a hint w with w^q = f, and a rule of `branch` for it"),
    Rule("image", ("Abs",), roots.absolute_value, "a hint w with w^2 = f conj f and w >= 0"),
    Rule("image", ("conjugate",), roots.conjugate, "conjugation passes through the function"),
    Rule("image", ("diff",), roots.derivative, "the slopes of generators"),
    Rule("image", ("exp",), exponential.exponential_of_lambert,
         "exp(n W(f)) = (f/W(f))^n for integers n"),
    Rule("image", ("exp",), exponential.phase_of_arctangent,
         "exp(2 i atan f) = (1 + i f)/(1 - i f) and exp(i atan f) = (1 + i f)/sqrt(1 + f^2)"),
    Rule("image", ("exp",), exponential.turns_of_integer,
         "exp(i pi n) = (-1)^n for an integer n, 1 for an even multiple"),
    Rule("image", ("exp",), exponential.root_of_unity,
         "exp(i pi q) is a power of another, or known in i, sqrt 2 and sqrt 3"),
    Rule("image", ("exp",), exponential.exponential,
         "exp(u + v) = exp u exp v, exp(n u) = (exp u)^n, exp(q log f) = f^q"),
    Rule("image", tuple(special.ENDS), special.at_end,
         "the image of m is 0 or 1: sin, tanh and the like, K(0) = E(0) = pi/2, E(1) = 1"),
    Rule("image", tuple(SUMS), special.elliptic,
         "addition theorems, values at 0 and K, symmetries; m constant, m < 1 for zeta"),
    Rule("image", ("jacobi_theta",), special.theta,
         "the product theorem of Theta; m constant, 0 < m < 1"),
    Rule("image", ("theta",), special.odd_or_even, "theta_1 is odd, the others are even"),
    Rule("image", ("parity",), exponential.parity,
         "(-1)^(j n + l) = ((-1)^n)^j (-1)^l for integers"),
    Rule("image", ("power",), exponential.power_of_negative,
         "f^n = (-1)^n (-f)^n for f < 0 and an integer n"),
    Rule("image", ("log",), inverse.logarithm,
         "log of a product: all factors >= 0 but one of exponent 1; log exp z = z for real z and "
         "for z = i r, abs r < pi; log i = i pi/2; log f = log(-f) + i pi for f < 0"),
    Rule("image", tuple(inverse.PRINCIPAL), inverse.inverse_function,
         "a hint r of which the function is f, within the principal values or by `continuity`"),
    Rule("image", ("lambert_w",), inverse.lambert, "a hint r with r exp r = f and r >= -1"),
    Rule("image", tuple(CYLINDER), special.cylinder,
         "recurrences in the order; the orders -1/2 and 1/2; K of order -v is K of order v"),
    Rule("relation", ("exp",), exponential.cyclotomic_relation,
         "exp(i pi q) is a root of the cyclotomic polynomial of its order"),
    Rule("relation", ("parity",), exponential.parity_relation,
         "the square of (-1)^n is 1 for an integer n"),
    Rule("branch", ("Pow",), roots.is_not_negative, "a value that is real and >= 0"),
    Rule("branch", ("Pow",), roots.is_multiple,
         "r f^s with r >= 0 and 0 < s <= 1/q, or r f^s g^t with f, g real and f + g > 0"),
    Rule("branch", ("Pow",), roots.is_principal,
         "q = 2 and Re w > 0, Re w without poles or jumps, or w = i s with s >= 0"),
    Rule("continuity", ("atan", "asin", "acos"), inverse.is_kept,
         "f and r real and continuous on a convex domain, r within the principal values at the "
         "point, f^2 < 1 for asin and acos"),
    Rule("equation", ("=",), quotients.quotient_vanishes,
         "a polynomial is 0 if it is at more values of a generator than its degree"),
)  # fmt: skip
