"""Catches: a double-double run that is no better than the double one, or another scheme."""

from fractions import Fraction
from itertools import pairwise

import mpmath
import numpy as np
import pytest

from longwave.lattice.model import Model
from longwave.lattice.schemes import KAHAN_LI_8, STOERMER_VERLET
from longwave.lattice.stepper import advance
from longwave.reports.studies.doubledouble_ring import advance_doubled, doubled


def test_it_agrees_with_mpmath_to_28_digits(rng: np.random.Generator) -> None:
    """The same composition written out in 40 digits, all three constants present."""
    constants, h, steps = Model(1.3, 0.2, -0.7), 0.25, 3
    y, s = 0.3 * rng.standard_normal((2, 7))
    pairs_y, pairs_s = doubled(y), doubled(s)
    advance_doubled(KAHAN_LI_8, pairs_y, pairs_s, h, steps, constants)
    context = mpmath.MPContext()
    context.dps = 40
    K2, K3, K4 = (context.mpf(value) for value in (1.3, 0.2, -0.7))
    kicks = [Fraction(gamma) * Fraction(h) for gamma in KAHAN_LI_8.gammas]
    drifts = [(a + b) / 2 for a, b in pairwise([Fraction(0), *kicks, Fraction(0)])]

    def number(value: Fraction) -> object:
        return context.mpf(value.numerator) / value.denominator

    Y, S = [context.mpf(v) for v in y], [context.mpf(v) for v in s]
    for _ in range(steps):
        for i, drift in enumerate(drifts):
            Y = [a + number(drift) * b for a, b in zip(Y, S, strict=True)]
            if i < len(kicks):
                f = [v * (K2 + v * (K3 + v * K4)) for v in Y]
                bends = [f[j - 1] - 2 * f[j] + f[(j + 1) % 7] for j in range(7)]
                S = [a + number(kicks[i]) * g for a, g in zip(S, bends, strict=True)]
    for pairs, exact in ((pairs_y, Y), (pairs_s, S)):
        sums = [context.mpf(high) + context.mpf(low) for high, low in pairs]
        misses = [abs(a - b) for a, b in zip(sums, exact, strict=True)]
        assert max(misses) < 1e-28


def test_the_double_kernel_is_the_same_scheme(rng: np.random.Generator) -> None:
    constants = Model(1.0, 0.1, 1.0)
    y, s = 0.2 * rng.standard_normal((2, 50))
    pairs_y, pairs_s = doubled(y), doubled(s)
    advance_doubled(STOERMER_VERLET, pairs_y, pairs_s, 0.1, 200, constants)
    advance(STOERMER_VERLET, y[None], s[None], 0.1, 200, constants.lattice)
    assert np.max(np.abs(y - pairs_y[:, 0])) == pytest.approx(0.0, abs=1e-13)
    assert np.max(np.abs(s - pairs_s[:, 0])) == pytest.approx(0.0, abs=1e-13)
