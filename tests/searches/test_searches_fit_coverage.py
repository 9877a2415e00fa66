"""Catches: a search for wrong intervals that finds none of the faults that there were."""

import numpy as np
import pytest

from longwave.scenes.fits import force_fit
from longwave.scenes.fits.force_fit import ForceFit
from longwave.scenes.fits.force_law import stated_law
from searches.fit_coverage import Experiment, coverage, doubted, draws, hostile, missing_term


def test_the_missing_term_is_so_many_of_its_standard_deviations() -> None:
    experiment = Experiment("cubic", "even", 21, known=True)
    law = stated_law("K2*x + K4*x**3 + K6*x**5")
    assert law is not None
    assert law != "table"
    more = missing_term(experiment.stretch, 3.0)
    fit = force_fit.fit_points(experiment.data(np.zeros(21), more), law)
    assert fit.values[2] / fit.deviations[2] == pytest.approx(3.0, rel=1e-6)


def test_correlated_noise_has_its_correlation_and_variance_1() -> None:
    noise = np.array(list(draws(4000, 6, 0, 0.5)))
    assert np.var(noise, axis=0) == pytest.approx(np.ones(6), abs=0.1)
    assert np.mean(noise[:, 2] * noise[:, 3]) == pytest.approx(0.5, abs=0.05)


def test_intervals_of_the_chosen_law_alone_are_found_to_be_wrong(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    experiment = Experiment("small cubic", "even", 8, known=False)
    assert coverage(experiment, 30, 0, states=False)[0] == 0.0
    monkeypatch.setattr(ForceFit, "_doubts_of_choice", lambda self: [])
    monkeypatch.setattr(force_fit, "_averaged", lambda chosen, fits, evidence: chosen.covariance)
    quiet, held = coverage(experiment, 30, 0, states=False)
    assert quiet > 0.5
    assert held < 0.8


def test_shares_of_doubted_fits_are_those_of_the_kinds() -> None:
    right, missing = (doubted(21, True, 60, 0, case) for case in ("right", "missing"))
    assert right <= 0.15
    assert missing >= 0.65


@pytest.mark.parametrize("seed", [*range(8), 106, 461])
def test_hostile_points_are_fitted_or_refused_in_one_line(seed: int) -> None:
    """Catches: a spline of too few points (106), constants whose squares are no doubles (461)."""
    assert hostile(seed) is None
