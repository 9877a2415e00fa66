"""Linear phases in double-double against fractions."""

from fractions import Fraction

import numpy as np

from solutions.linear_phase import LinearPhase


def test_phase_of_a_far_site_keeps_thirty_digits(rng: np.random.Generator) -> None:
    """n - c t cancels ten digits here; doubles would keep six of the phase."""
    p, q = (
        Fraction("0.061237243569579452454932101867647"),
        Fraction("-0.12247448713915890490986420373529"),
    )
    n = rng.integers(-(10**9), 10**9, 50).astype(float)
    t = n / 2 + rng.uniform(-1, 1, 50)
    high, low = LinearPhase(p, q, Fraction(1, 3))(n, t)
    for i in range(n.size):
        exact = p * Fraction(n[i]) + q * Fraction(t[i]) + Fraction(1, 3)
        assert abs(Fraction(high[i]) + Fraction(low[i]) - exact) < Fraction(1, 10**22)
