"""Measured rates at which lattices come near their envelope equations."""

from dataclasses import replace

import numpy as np
import pytest
from sympy import Integer, pi

from verify.lattices.envelope_study import (
    ENVELOPE_CASES,
    EnvelopeCase,
    closing_count,
    envelope_study,
)

SOLITON = ENVELOPE_CASES["bright, displacement"]


# Measured: (rate, largest eps) of data of each order, with eps / (1, 0.7, 0.5).
RATES = {
    ("bright, strain", "slaved"): 2.07,
    ("bright, strain", "corrected"): 2.92,
}


def test_a_soliton_comes_near_at_the_second_power() -> None:
    case = replace(ENVELOPE_CASES["bright, strain"], span=(0, 2))
    study = envelope_study(case, "slaved", (0.1, 0.07, 0.05))
    assert abs(study.rate - 2.0) < 0.2
    assert all(found.discretisation < 0.02 * found.error for found in study.errors)


def test_rings_close_where_carrier_and_wave_come_round() -> None:
    still, turned = np.ones(2, dtype=complex), np.array([-1.0, 1.0], dtype=complex)
    assert closing_count(100.5, 2 * pi / 3, still) == 102
    assert closing_count(100.5, pi, turned) == 101
    assert closing_count(100.5, Integer(1), np.array([0.0, 0.0j])) == 101
    with pytest.raises(ValueError, match="k must close the ring of a wave that does not end"):
        closing_count(100.5, Integer(1), still)
