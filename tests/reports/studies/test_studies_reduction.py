"""The reduction's error against eps: laws from resolved points only, faults kept as records."""

import math

import pytest

from longwave.reports.studies import lattice_cost
from longwave.reports.studies.lattice_cost import PeakError, peak_error, peak_laws, peak_scene
from longwave.scenes.description.scene import Scene

EPS = (0.1, 0.05, 0.025, 0.0125, 0.00625)


def test_a_member_ends_at_its_peak_and_holds_all_extrema() -> None:
    scene = peak_scene(5, 0.025)
    assert (scene.end, scene.wave, scene.compared) == (0.0, "rational_5", 1000)
    assert scene.t0 == -80000.0


def test_laws_are_fitted_at_the_smallest_resolved_eps() -> None:
    """Catches large eps in the fit, points that are not resolved, and points without a value."""
    sound = [PeakError(2, eps, eps**2 if eps < 0.1 else 7.0, 1e-9) for eps in EPS]
    wrong = [
        PeakError(3, 0.1, 0.01, 1e-9),
        PeakError(3, 0.05, 0.0025, 1e-9),
        PeakError(3, 0.025, 0.9, 0.1),
        PeakError(3, 0.0125, fault="it blew up"),
    ]
    powers = peak_laws([*wrong, *sound, PeakError(4, 0.1, 1.0, 1e-9)])
    assert powers == {2: pytest.approx(2), 3: pytest.approx(2), 4: None}


def test_a_measured_point_is_the_reductions_own() -> None:
    point = peak_error(2, 0.1)
    assert point.resolved
    assert point.value == pytest.approx(0.34817, abs=2e-5)
    assert point.own < 1e-4
    assert point.seconds > 0


def test_a_run_that_is_refused_is_a_record(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(scene: Scene) -> None:
        raise ValueError("tolerance must be larger")

    monkeypatch.setattr(lattice_cost, "run", refuse)
    point = peak_error(2, 0.1)
    assert point.fault == "tolerance must be larger"
    assert math.isnan(point.value)
    assert not point.resolved
