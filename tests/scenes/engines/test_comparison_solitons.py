"""The lattice carries solitons and breathers: catches a wrong background, sign or velocity."""

from dataclasses import replace

import numpy as np
import pytest

from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene

WANTED = ("strain", "domain_error")
Y2 = load_scene("rational_2_eps_0.05")


def scene(wave: str, K4: float, **parameters: float) -> Scene:
    """The wave from t = 0, where Y2's scene has its window, to T = 1."""
    values = tuple(parameters.items())
    short = replace(Y2, eps=0.1, t0=0.0, snapshots=(0.0, 1000.0), observables=WANTED)
    return short.changed(name=wave, wave=wave, K4=K4, parameters=values, sites=2048, compared=500)


@pytest.mark.parametrize(
    ("wave", "K4", "parameters"),
    [
        ("breather", 1, {"p": 0.5, "q": 0.8}),
        ("double_pole", 1, {"A": 1.0}),
        ("two_soliton", 1, {"A_1": 1.0, "A_2": 0.4}),
        ("soliton_background", 1, {"U_0": 0.5, "kappa": 1.0}),
        ("kink_antikink", -1, {"A": 1.0, "kappa": 1.9}),
    ],
)
def test_wave_lives_on_the_lattice(wave: str, K4: float, parameters: dict[str, float]) -> None:
    measured = run(scene(wave, K4, **parameters))
    moved = np.max(np.abs(measured.analytic[-1] - measured.analytic[0].values))
    deviation = np.max(np.abs(measured.strain[-1] - measured.analytic[-1]))
    assert float(measured.domain_error.max()) < 1e-6
    assert float(deviation) < 0.1 * float(moved)


@pytest.mark.parametrize(
    ("wave", "K4", "needed"), [("breather", -1, ">"), ("kink_antikink", 1, "<")]
)
def test_wrong_sign_of_K4_is_refused(wave: str, K4: float, needed: str) -> None:
    with pytest.raises(ValueError, match=f"K4 must satisfy K4 {needed} 0 for {wave}"):
        run(scene(wave, K4, p=1.0, q=1.0))
