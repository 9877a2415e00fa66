"""Studies of cost on the lattice: methods agree, orders show, shares are those of the step."""

from dataclasses import replace

import numpy as np
import pytest

from verify.lattice import run
from verify.study.cost_precision import by_scheme, crest, smooth, spectral
from verify.study.cost_scaling import ScalingPoint, fit_law, rk4_share, window_error


def test_stencil_and_ring_agree_on_the_smooth_problem() -> None:
    """Each is the other's reference: catches a reference on other sites or at another time."""
    scene = smooth()
    scene = replace(scene, snapshots=(scene.t0 + 50.0,))
    strains = [
        run(variant)["strain"].values[-1]
        for variant in (by_scheme(scene, "kahan_li_8", 0.25), spectral(scene, 1e-7))
    ]
    assert np.max(np.abs(strains[0] - strains[1])) / scene.eps < 2e-7


def test_a_share_of_one_is_stable_on_the_crest() -> None:
    """Catches a limit taken at rest: the crest's stiffness is larger."""
    scene = crest()
    for name in ("rk4", "kahan_li_8"):
        short = replace(by_scheme(scene, name, 0.99), snapshots=(scene.t0 + 20.0,))
        assert run(short).attrs["blow_up"] == ""


def test_rk4_has_its_order_in_the_error_figure() -> None:
    found = {point.x: point.value for point in rk4_share((0.3, 0.15), t0=-200.0)}
    ratio = (found[0.3] - found[0.0]) / (found[0.15] - found[0.0])
    assert 8 < ratio < 40


def test_the_windows_error_falls_with_its_size() -> None:
    first, second = window_error((2048, 4096, 16384), t0=-2000.0)
    assert first.value > 4 * second.value > 0


def test_a_law_is_the_power_that_was_put_in() -> None:
    points = [ScalingPoint("s", x, 7.0 * x**-3.5) for x in (1.0, 2.0, 5.0)]
    law = fit_law(points)
    assert (law.exponent, law.factor) == (pytest.approx(-3.5), pytest.approx(7.0))
