"""Catches: a closed form of one's own that needs the catalogue, or is taken for a shipped one."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from longwave.runs import load_run, save_run
from longwave.scenes import resume, run
from longwave.scenes.description.named_scenes import scene_of
from longwave.scenes.description.scene import Scene
from longwave.solutions import ClosedForm, closed_form

SHIPPED = closed_form("kink")
OWN = ClosedForm(
    name="kink",
    title="a kink of one's own",
    expression=SHIPPED.expression,
    equation=SHIPPED.equation,
    parameters=SHIPPED.parameters,
    background=SHIPPED.background,
    far_fields=SHIPPED.far_fields,
    reference=SHIPPED.reference,
)


def scene(wave: str | ClosedForm, **changes: object) -> Scene:
    known = {
        "name": "kinks",
        "parameters": {"A": 1},
        "eps": 0.1,
        "t0": 0,
        "snapshots": [0, 20, 40],
        "K2": 1,
        "K4": -1,
        "compared": 40,
        "observables": ("strain", "state"),
    }
    stated = {"step": 0.5, "domain": "closed_ring", "sites": 3072}
    return Scene.of(wave=wave, **(known | (changes or stated)))


def test_the_same_formula_gives_the_same_run() -> None:
    shipped, own = run(scene("kink")), run(scene(OWN))
    assert np.array_equal(shipped.strain, own.strain)
    assert np.array_equal(shipped.analytic, own.analytic)


@pytest.mark.parametrize("engine", ["stencil", "spectral"])
def test_it_is_run_to_a_tolerance(engine: str) -> None:
    given = {"observables": ("strain",), "tolerance": 1e-4, "engine": engine}
    assert run(scene(OWN, **given)).attrs["error_estimate"] <= 1e-4


def test_a_saved_run_says_that_its_wave_is_not_shipped(tmp_path: Path) -> None:
    """The name alone would call up the shipped wave of that name."""
    save_run(run(scene(OWN)), tmp_path / "own.nc")
    loaded = load_run(tmp_path / "own.nc")
    assert "not shipped" in str(scene_of(loaded).wave)
    assert scene_of(loaded).wave != "kink"
    with pytest.raises(ValueError, match=r"got 'kink \(a closed form that is not shipped\)'"):
        resume(loaded, at=20.0)
    resumed = resume(loaded, at=20.0, wave=OWN)
    assert np.array_equal(resumed.strain[-1], loaded.strain[-1])


USER = """
import longwave
import sympy as sp
from longwave.solutions import ClosedForm, FarFields, Parameter, Reference
from longwave.solutions.record import Bound
from longwave.solutions.equation import DEFOCUSING_MKDV
from longwave.solutions.symbols import A, tau, xi

kink = A * sp.tanh(A * (xi + 2 * A**2 * tau))
form = ClosedForm(name="mine", title="mine", expression=kink, equation=DEFOCUSING_MKDV,
                  parameters=(Parameter(A, Bound(sp.S(0), "0")),), background=sp.S(0),
                  far_fields=FarFields(-A, A), reference=Reference("me", "here"))
print(longwave.prove(form.equation, form.expression).outcome.value)
scene = longwave.Scene.of(name="s", wave=form, parameters={"A": 1}, eps=0.1, t0=0, snapshots=[10],
                          K2=1, K4=-1, compared=40, tolerance=1e-4)
print(longwave.run(scene).error.values[-1] < 0.01)
"""


@pytest.mark.slow
def test_it_is_proved_and_run_from_outside_of_the_checkout(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(USER)
    path = {"PYTHONPATH": str(Path(__file__).parents[3])}
    done = subprocess.run(
        [sys.executable, "mine.py"],
        cwd=tmp_path,
        env=os.environ | path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.split() == ["PROVED", "True"], done.stderr


def test_a_wave_that_is_neither_is_refused() -> None:
    with pytest.raises(ValueError, match=r"wave must be a text or a ClosedForm, got tanh\(x\)"):
        scene(sp.tanh(sp.Symbol("x")))
