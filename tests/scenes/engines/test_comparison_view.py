"""Catches: numerator and denominator exchanged, the wrong reference, a silent NaN or 0/0."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from longwave.scenes.observed.view import relative_sup_error

ONE = np.ones(4)


@given(st.floats(-0.5, 0.5), st.floats(0.5, 2.0), st.integers(0, 3))
def test_one_site_off_by_a_share_of_the_amplitude(
    share: float, amplitude: float, site: int
) -> None:
    analytic = ONE.copy()
    analytic[2] += amplitude
    numeric = analytic.copy()
    numeric[site] += share * amplitude
    assert relative_sup_error(numeric, analytic, ONE) == pytest.approx(abs(share), abs=1e-15)


def test_the_denominator_uses_the_analytic_wave() -> None:
    numeric, analytic = np.array([1.0, 3.0]), np.array([1.0, 5.0])
    assert relative_sup_error(numeric, analytic, np.ones(2)) == 0.5


@pytest.mark.parametrize(
    ("numeric", "analytic", "background", "message"),
    [
        (ONE, ONE, ONE, "background must differ from the wave"),
        (ONE, ONE[:2], ONE, "must have one shape"),
        (ONE[:0], ONE[:0], ONE[:0], "must not be empty"),
        (np.array([np.nan]), np.array([2.0]), np.array([1.0]), "must be finite"),
    ],
)
def test_senseless_comparisons_are_refused(
    numeric: np.ndarray, analytic: np.ndarray, background: np.ndarray, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        relative_sup_error(numeric, analytic, background)
