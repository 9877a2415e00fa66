"""Rational functions of z and w in sines: the printed form equals the derived one."""

import cmath
import math

import pytest
from sympy import Expr, Symbol

from longwave.derive.algebra.rational_functions import RationalFunctions
from longwave.derive.sines import cosine, frequency, in_sines, sine

z, w, K, m = map(Symbol, "zwKm")


@pytest.mark.parametrize(
    "given",
    [
        K * (z - 2 + 1 / z) * w,
        (K * z + m) / (K + m * z**2),
        (K * z + m) ** 2 / z,
        (K * z + m) ** 3 * (z - 1) ** 3 * w**3,
        w**5 * (z + 1) / (z - 1) ** 2,
        (z**2 - 1) ** 2 / (w * (K * z + w) ** 2),
        1 / ((K * z + m) ** 2 * (z - 1) * w),
        (w**2 * m + K * (2 - z - 1 / z)) ** 2 * (z + K * w) / (m + z) ** 3,
    ],
)
@pytest.mark.parametrize(("k", "omega"), [(0.7, 1.3), (2.9, 0.4)])
def test_the_form_in_sines_has_the_value_of_the_one_in_exponentials(
    given: Expr, k: float, omega: float
) -> None:
    """Catches: a factor that is neither real nor imaginary, or that occurs more than once."""
    at = {K: 1.7, m: 0.6}
    value = complex(given.subs(at).subs({z: cmath.exp(1j * k), w: 1j * omega}))
    lines = {sine: math.sin(k / 2), cosine: math.cos(k / 2), frequency: omega}
    parts = in_sines(RationalFunctions((z, w, K, m)).from_expr(given))
    found = complex(*(float(part.subs(at).subs(lines)) for part in parts))
    assert found == pytest.approx(value, rel=1e-12)
