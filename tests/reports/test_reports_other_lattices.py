"""The chapter of other lattices: its rows are derived, and what fails makes it unsound."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from sympy import symbols

from longwave.derive import LATTICES, find_scaling
from longwave.reports.build import TABLES, Findings, all_jobs
from longwave.reports.pictures.drawing import STABLE
from longwave.reports.pictures.lattice_figures import (
    modulation_figure,
    rate_figure,
    strain_maps,
)
from longwave.reports.pictures.run_data import snapshots
from longwave.reports.pictures.style import styled
from longwave.reports.sections.lattice_runs import (
    PEREGRINES,
    ROGUES,
    rate_errors,
    rate_panels,
    rate_table,
    scene_maps,
    scene_table,
)
from longwave.reports.sections.other_lattices import (
    FURTHER_FORMS,
    envelope_row,
    envelope_table,
    form_table,
    model_rows,
    model_table,
    shortest,
)
from longwave.reports.studies.evaluation_accuracy import Accuracy
from longwave.reports.studies.lattice_models import LatticeModel, lattice_models, modulation_plane
from longwave.reports.studies.lattice_runs import SceneRun
from longwave.reports.studies.proofs import ProofRecord
from longwave.scenes.convergence import ConvergencePoint, FittedRate, SceneConvergence
from longwave.scenes.description.named_scenes import load_scene, shipped_scenes
from longwave.scenes.rate_cases import rate_cases
from longwave.solutions import CATALOGUE
from longwave.support.processes import Key
from longwave.verify.verdict import Outcome, Verdict

POINTS = tuple(
    ConvergencePoint(at, 2.0 * at**3, at**2, 1e-3 * at**3, 100, 1.0) for at in (0.2, 0.1, 0.05)
)


def measured_rate(rate: float = 2.98, case: str = "6a") -> SceneConvergence:
    given = {"K2": "4/3", "K3": "eps/2", "K4": 1}
    scene = rate_cases()["3"].scene.changed(name=case, constants=given)
    return SceneConvergence(scene, "mKdV", 1, POINTS, FittedRate(rate, rate - 0.05, rate + 0.05), 3)


def run(estimate: float = 1e-6, axes: int = 1) -> xr.Dataset:
    """Two times of a wave on five cells, the lattice 0.02 above it at the second one."""
    places = ("time", "site", "row")[: axes + 1]
    shape = (2, *(5,) * axes)
    wave = np.broadcast_to(np.arange(5.0).reshape(1, 5, *(1,) * (axes - 1)), shape)
    apart = np.zeros(shape)
    apart[1] = 0.02
    data: dict[str, Any] = {
        "strain": (places, wave + apart),
        "analytic": (places, wave),
        "n": (("time", "site"), np.array([np.arange(-2, 3), np.arange(8, 13)])),
        "error": ("time", [0.0, 0.005]),
        "sup_error": ("time", [0.0, 0.2]),
        "slow_time": ("time", [0.0, 1.0]),
    }
    coordinates = {"time": [0.0, 10.0], "site": np.arange(-2, 3)}
    if axes == 2:
        coordinates["row"] = np.arange(-2, 3)
    attributes = {
        "equation": "focusing mKdV: Y_T = 0",
        "frame_speed": 1.0,
        "error_estimate": estimate,
        "sites": 40991,
        "seconds": 2.0,
        "planning_seconds": 1.0,
    }
    return xr.Dataset(data, coordinates, attributes)


SCENE = load_scene("toda_soliton")


def row_of(name: str, case: str = "") -> list[str]:
    (place,) = (
        i
        for i, model in enumerate(lattice_models())
        if model.lattice.name == name and model.case == case
    )
    text = model_table(model_rows(place))
    return text[text.index(r"\endfoot") :].splitlines()[1:-1]


def test_a_lattice_has_each_long_wave_with_what_it_needs() -> None:
    title, kdv, mkdv = row_of("mass_dimer")
    assert "two masses in turn" in title
    assert "soliton, two soliton, cnoidal" in kdv
    for text in (r"$\epsilon^{2}$", r"\frac{K_{3}}{4 c \left(m_{1} + m_{2}\right)} Y Y_{X}"):
        assert text in kdv
    assert r"c^{2} = \frac{K_{2}}{2 \left(m_{1} + m_{2}\right)}$; needs $K_{3} = 0$" in mkdv
    assert r"the 16 of section~\ref{sec:solutions}" in mkdv


def test_a_condition_that_cannot_be_met_is_no_row() -> None:
    """Catches mKdV of Hertz contacts, whose quadratic force never vanishes."""
    title, kdv = row_of("granular")
    assert r"$F_{2} = - \frac{3 A}{8 \sqrt{d}}$" in title
    assert "KdV" in kdv


def test_small_and_tied_constants_are_told() -> None:
    title, gardner = row_of("fput_strain", "with a small quadratic force")
    assert r"$y_n = u_{n+1} - u_n$" in title
    assert r"$K_{3} = \epsilon k_{3}$" in title
    assert "Gardner" in gardner
    assert "table soliton" in gardner


def test_only_waves_whose_signs_fit_are_named() -> None:
    """Catches the lump of KP-I on the square lattice, which is KP-II."""
    _, kp, generalised = row_of("square")
    assert kp.endswith(r"line soliton \\*")
    assert generalised.endswith(r"none \\")


def test_a_pinned_chain_has_no_long_wave() -> None:
    assert LatticeModel(LATTICES["klein_gordon"]).reductions() == ()


@pytest.mark.slow
def test_a_shorter_coefficient_has_the_same_value() -> None:
    """Catches a replacement that meets only a part of the equation."""
    m, n, h = symbols("m n h")
    plain = (m**2 + 2 * m * n * h + n**2 * h**2 + m**2 * h).factor()
    assert len(shortest(plain, [m, n])) <= len(shortest(plain, []))
    dimer = next(r for r in find_scaling(LATTICES["dimer"]) if r.pde.kind == "KdV")
    (printed,) = {line for line in row_of("dimer") if "Y Y_{X}" in line and "KdV" in line}
    assert printed.count("Y_{XXX}") == dimer.pde.latex().count("Y_{XXX}") == 1
    assert r"m_{1}^{2} \left(H_{2} + K_{2}\right)^{2}" in printed


def test_an_envelope_row_has_the_coefficients_in_half_angles() -> None:
    text = envelope_table([envelope_row(0)])
    assert r"$\displaystyle - \frac{\omega}{8}$" in text
    assert r"8 K_{3}^{2} s^{2}" in text
    assert "sin" not in text


def test_further_forms_are_apart_from_the_papers() -> None:
    """Catches a form of mKdV in the chapter, and one of another equation in no table."""
    record = ProofRecord("kp_lump", "exact", Outcome.PROVED, 0.1, 1000, 0.1, True)
    residual = Verdict("kp_lump", "KP-I", "mpmath", Outcome.CHECKED, "", 1e-99)
    worst = Accuracy("kp_lump", 8, (1e-16, 3e-15, 2e-16), "")
    text = form_table([record], {"kp_lump": residual}, [worst])
    assert r"proved & $1.0\times 10^{-99}$ & $3.0\times 10^{-15}$" in text
    assert len(re.findall(r"& [^&]* \\\\\*?\n", text)) == len(FURTHER_FORMS) + 2
    assert not set(FURTHER_FORMS) & set(CATALOGUE.of("mKdV").names)


def test_a_scene_is_a_row_with_its_own_error() -> None:
    text = scene_table({"toda_soliton": SceneRun(SCENE, run())})
    errors = r"$0.200000$ & $1.0\times 10^{-6}$ & $0.00500000$ & $2.5\times 10^{-8}$"
    assert rf"focusing mKdV & $0.1$ & {errors}" in text
    assert r"$40\,991$ & $3.0$" in text
    assert r"\texttt{toda\_soliton}" in text


def test_a_scene_that_fails_says_why() -> None:
    runs = {
        "one": SceneRun(SCENE, None, "times must end before it blows up, got 50 % of it"),
        "two": SceneRun(SCENE, run(estimate=1.0)),
    }
    text = scene_table(runs)
    assert r"did not run: times must end before it blows up, got 50 \% of it" in text
    assert text.count("(TOO LARGE)") == 1
    assert [found.kept for found in runs.values()] == [False, False]


def test_a_rate_that_is_not_reached_is_seen() -> None:
    text = rate_table([measured_rate(), measured_rate(2.2)])
    assert (
        r"$y_n = u_{n+1} - u_n$; $K_{2} = \frac{4}{3}$, $K_{3} = \frac{\epsilon}{2}$, $K_{4} = 1$"
        in text
    )
    assert text.count("6a:") == 1
    assert "Gardner soliton" in text
    assert r"leading & $3$ & $2.98$ & $2.9\ldots 3.1$ \\" in text
    assert r"$2.20$ & $2.1\ldots 2.3$ (NOT REACHED)" in text
    errors = rate_errors([measured_rate()])
    assert r"$0.2$ & $0.0160000$ & $8.0\times 10^{-6}$ & $0.1$ & " in errors
    assert r" &  &  &  \\" in errors


@pytest.mark.parametrize(
    ("found", "sound"),
    [
        ({}, True),
        ({("rate", "6a"): measured_rate(2.2)}, False),
        ({("scene", "one"): SceneRun(SCENE, None, "blew up")}, False),
        ({("scene", "one"): SceneRun(SCENE, run(estimate=1.0))}, False),
        ({("scene", "one"): SceneRun(SCENE, run())}, True),
    ],
)
def test_what_fails_makes_the_report_unsound(found: dict[Key, Any], sound: bool) -> None:
    assert Findings({("rate", "6a"): measured_rate()} | found, {}).sound is sound


def test_tables_of_nothing_are_latex_still() -> None:
    found = Findings({("scene", "one"): SceneRun(SCENE, None, "blew up")}, {})
    for name in ("model_table", "envelope_table", "scene_table", "scene_maps", "rate_table"):
        text = TABLES[name](found)
        assert text.count(r"\begin") == text.count(r"\end{"), name


@pytest.mark.slow
def test_every_case_and_scene_is_a_job() -> None:
    short, full = all_jobs({}, full=False), all_jobs({}, full=True)
    assert short.keys() < full.keys()
    assert {name for part, name in short if part == "scene"} == set(shipped_scenes("lattices"))
    assert {name for part, (name, _) in _rates(full)} == {*rate_cases()}
    corrected = {name for part, (name, order) in _rates(full) if order == "corrected"}
    assert corrected.isdisjoint(("6c", "6d"))
    assert {name for part, (name, _) in _rates(short)} == {
        name for name, case in rate_cases().items() if not case.is_long
    }
    assert {*ROGUES, *PEREGRINES} <= set(shipped_scenes("lattices"))


def _rates(jobs: Any) -> list[Any]:
    return [key for key in jobs if key[0] == "rate"]


def test_errors_have_bars_and_each_power_its_panel() -> None:
    found = [measured_rate(), measured_rate(case="1"), replace(measured_rate(), theory=4)]
    panels = rate_panels(found)
    assert list(panels) == [3, 4]
    assert list(panels[3]) == ["6a", "1"]
    with styled():
        left, right = rate_figure(panels).axes[:2]
    assert len(left.containers) == 2
    line = right.lines[-1]
    x, y = (np.asarray(part, float) for part in line.get_data())
    assert np.log(y[1] / y[0]) / np.log(x[1] / x[0]) == pytest.approx(4.0)


def test_stable_carriers_are_grey_and_the_line_is_where_pq_vanishes() -> None:
    grid, quadratic = modulation_plane(24)
    with styled():
        figure = modulation_figure(grid, quadratic)
    grey, growth = figure.axes[0].collections[:2]
    assert to_hex(grey.get_cmap()(0.5)) == STABLE
    shown = np.ma.getmaskarray(np.ma.masked_invalid(np.ma.asarray(growth.get_array())))
    assert np.array_equal(shown.reshape(grid.product.shape), grid.product <= 0)
    limit = np.sqrt(1.5 / (1 + 1 / np.sin(grid.k / 2) ** 2))
    assert np.array_equal(grid.product > 0, quadratic < limit)


def test_snapshots_are_about_the_frame() -> None:
    found = run()
    offset = found.n - found.attrs["frame_speed"] * found.time
    told = found.assign_coords(offset=offset).assign_attrs(unit=1.0, carried=0)
    (late,) = snapshots(told, 1, [1])
    assert late["offset"].values.tolist() == [-1.0, 0.0, 1.0]
    apart = late["strain"].values - late["analytic"].values
    assert apart.tolist() == pytest.approx([0.02] * 3)


def test_a_run_on_two_axes_is_drawn_with_its_difference() -> None:
    found = {"flat": SceneRun(SCENE, run(axes=2)), "line": SceneRun(SCENE, run())}
    assert scene_maps(found).count(r"\includegraphics{figures/scene_flat.pdf}") == 1
    assert "scene_line" not in scene_maps(found)
    with styled():
        figure = strain_maps(run(axes=2)).figure()
    meshes = [ax.collections[0] for ax in figure.axes[:4]]
    assert np.max(np.ma.asarray(meshes[3].get_array())) == pytest.approx(0.02)
