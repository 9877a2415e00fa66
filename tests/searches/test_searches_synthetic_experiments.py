"""Catches: hidden chains that are not the scene's, intervals that do not know the noise."""

from dataclasses import replace

import numpy as np
import pytest

from longwave.scenes.fits.scene_fit import SceneModel
from searches.synthetic_experiments import (
    FREE,
    RIGHT,
    TIMES,
    WRONG,
    Experiment,
    crest_apart,
    scatter,
)


@pytest.mark.parametrize("kind", RIGHT)
def test_the_hidden_chain_is_the_scenes(kind: str) -> None:
    experiment = Experiment.drawn(kind, 5)
    model = SceneModel(experiment.scene(experiment.truth), FREE[kind])
    read = model.readings(experiment.truth, TIMES, experiment.sensors, 0.1)[..., 0]
    np.testing.assert_allclose(read, experiment.exact, atol=1e-7)


def test_a_crest_is_predicted_within_its_interval_and_no_better() -> None:
    experiment = Experiment.drawn("cubic chain", 0)
    fit = experiment.fitted()
    assert fit.doubts == []
    assert abs(crest_apart(experiment, fit)) < 4.0
    certain = replace(fit, covariance=fit.covariance / 1e6)
    assert abs(crest_apart(experiment, certain)) > 100.0


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_hidden_is_noticed(kind: str) -> None:
    fit = Experiment.drawn(kind, 0).fitted()
    assert fit.p_value < 1e-6


@pytest.mark.slow
def test_estimates_scatter_by_the_bound() -> None:
    ratios = scatter(Experiment.drawn("quadratic chain", 1))
    assert (ratios < 2.0).all()
    assert ratios.max() > 0.4
