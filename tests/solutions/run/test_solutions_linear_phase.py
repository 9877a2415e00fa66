"""Linear phases in double-double against fractions."""

from fractions import Fraction

import numpy as np
import pytest

from longwave.solutions.run.linear_phase import LinearPhase, as_pairs


def test_phase_of_a_far_site_keeps_thirty_digits(rng: np.random.Generator) -> None:
    """n - c t cancels ten digits here; doubles would keep six of the phase."""
    p, q = (
        Fraction("0.061237243569579452454932101867647"),
        Fraction("-0.12247448713915890490986420373529"),
    )
    n = rng.integers(-(10**9), 10**9, 50).astype(float)
    t = n / 2 + rng.uniform(-1, 1, 50)
    high, low, bound = as_pairs(LinearPhase(p, q, Fraction(1, 3))(n, t))
    for i in range(n.size):
        exact = p * Fraction(n[i]) + q * Fraction(t[i]) + Fraction(1, 3)
        error = abs(Fraction(high[i]) + Fraction(low[i]) - exact)
        assert error <= Fraction(bound[i]) < Fraction(1, 10**29)


def test_phase_that_cancels_to_the_last_site() -> None:
    """At 10^15 and with 30 digits cancelling; pairs alone would leave nothing of the phase."""
    p, t = Fraction("0.33333333333333337034101242110772"), 3.0e15
    n = float(round(t * float(p)) * 3)
    high, low, bound = as_pairs(LinearPhase(p, -p, 0)(np.array([n]), np.array([n + 0.5])))
    error = abs(Fraction(high[0]) + Fraction(low[0]) + p / 2)
    assert error <= Fraction(bound[0]) < Fraction(1, 10**29)


def test_a_huge_phase_is_accurate_within_a_period() -> None:
    """At 10^25 a pair is off by 10^-7, three floats are within 10^-20."""
    p, q = Fraction("1234567.89012345678901234567890123456789"), Fraction(-(10**9), 7)
    n, t = 1.0e8 + 2.0**-20, 1.0e16 / 3
    *parts, bound = LinearPhase(p, q, Fraction(1, 3))(np.array([n]), np.array([t]))
    exact = p * Fraction(n) + q * Fraction(t) + Fraction(1, 3)
    error = abs(sum(Fraction(part[0]) for part in parts) - exact)
    assert error <= Fraction(bound[0]) < Fraction(1, 10**19)


def test_coefficients_out_of_range_are_refused() -> None:
    with pytest.raises(OverflowError, match=r"1\.0e-300"):
        LinearPhase(Fraction(1, 10**300), 0, 0)
