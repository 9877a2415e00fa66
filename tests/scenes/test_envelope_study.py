"""Measured rates at which lattices come near their envelope equations."""

from dataclasses import replace

import numpy as np
import pytest
from sympy import Integer, pi

from longwave.scenes.envelope_study import (
    ENVELOPE_CASES,
    closing_count,
    envelope_study,
)

SOLITON = ENVELOPE_CASES["bright, displacement"]


WIDE, FINE = (0.1, 0.07, 0.05, 0.035), (0.07, 0.05, 0.035)
COARSE, SHORT = (0.14, 0.1, 0.07), (0.1, 0.07, 0.05)

RATES = [
    ("bright, strain", "leading", WIDE, 2.0),
    ("bright, strain", "slaved", WIDE, 2.0),
    ("bright, strain", "corrected", WIDE, 3.0),
    ("bright, displacement", "corrected", WIDE, 3.0),
    ("dark, strain", "leading", WIDE, 2.1),
    ("dark, strain", "corrected", WIDE, 3.1),
    ("dark, Klein-Gordon", "slaved", WIDE, 2.1),
    ("bright, Klein-Gordon", "leading", WIDE, 2.1),
    ("bright, Klein-Gordon", "corrected", SHORT, 3.0),
    ("Peregrine, strain", "leading", FINE, 1.9),
    ("Peregrine, strain", "corrected", FINE, 2.9),
    ("Peregrine, optical dimer", "leading", COARSE, 2.2),
    ("Peregrine, optical dimer", "corrected", SHORT, 3.1),
    ("Peregrine, granular dimer", "slaved", FINE, 3.1),
]
"""Case, order of the data, values of eps, and the rate that was measured."""


@pytest.mark.slow
@pytest.mark.parametrize(("case", "order", "eps_values", "rate"), RATES)
def test_rates_are_those_of_the_theory(
    case: str, order: str, eps_values: tuple[float, ...], rate: float
) -> None:
    """2 for the NLS equation, 3 with its next order, and where there is none, at k = pi."""
    study = envelope_study(ENVELOPE_CASES[case], order, eps_values)
    assert abs(study.rate.value - rate) < 0.2, study
    assert all(found.discretisation < found.error for found in study.errors)


def test_a_soliton_comes_near_at_the_second_power() -> None:
    case = replace(ENVELOPE_CASES["bright, strain"], span=(0, 2))
    study = envelope_study(case, "slaved", (0.1, 0.07, 0.05))
    assert abs(study.rate.value - 2.0) < 0.2
    assert all(found.discretisation < 0.02 * found.error for found in study.errors)


def test_rings_close_where_carrier_and_wave_come_round() -> None:
    still, turned = np.ones(2, dtype=complex), np.array([-1.0, 1.0], dtype=complex)
    assert closing_count(100.5, 2 * pi / 3, still) == 102
    assert closing_count(100.5, pi, turned) == 101
    assert closing_count(100.5, Integer(1), np.array([0.0, 0.0j])) == 101
    with pytest.raises(ValueError, match="k must close the ring of a wave that does not end"):
        closing_count(100.5, Integer(1), still)
