"""Catches: a bench that is not read as written, a sensor at another cell or time."""

import copy
import re
import tomllib
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import erf

from longwave.__main__ import main
from longwave.derive import LATTICES
from longwave.lattice import SiteForce, State, driven_chain, integrate
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.lattice.time_integral import Integral
from longwave.runs.run_file import load_run
from longwave.runs.sweep_scene import changed_document, check_field, make_scene
from longwave.scenes.description.bench import SENSOR_QUANTITIES, Bench
from longwave.scenes.description.named_scenes import load_scene, scene_of_toml, shipped_scenes
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_file import toml_text
from longwave.scenes.description.time_functions import Samples, time_function
from longwave.scenes.engines.bench_readings import bench_and_chain
from longwave.scenes.engines.methods import expected_cost
from longwave.scenes.engines.scene_run import resume, run
from longwave.scenes.starts.bench_chain import READINGS
from tests.lattice.test_lattice_driving import modal_chain

DRIVEN: dict[str, Any] = {
    "name": "driven",
    "lattice": "beta_fput",
    "constants": {"K2": 1, "K4": 2},
    "times": [0, 3, 6],
    "tolerance": 1e-7,
    "chain": {"sites": 12, "left": {"displacement": "0.05*sin(1.3*t)"}, "right": "free"},
    "start": {"impact": [{"site": 4, "velocity": 0.1}, {"site": 5, "velocity": -0.2}]},
    "losses": {"site": 0.03},
    "force": [{"site": 10, "value": "0.3*cos(9*t/10)"}],
    "observables": {
        "sensors": {"sites": [0, 7, 11], "of": ["displacement", "velocity", "strain", "force"]},
        "energy": True,
        "state": True,
        "every": 0.75,
    },
}


def changed(**tables: Any) -> dict[str, Any]:
    return copy.deepcopy(DRIVEN) | tables


def test_a_scene_is_the_same_in_every_spelling(tmp_path: Path) -> None:
    scene = Scene.of(**DRIVEN)
    assert scene.start.method == "bench"
    assert Scene.from_json(scene.json()) == scene == scene_of_toml(scene.toml())
    path = tmp_path / "driven.toml"
    path.write_text(toml_text(DRIVEN | {"times": [0, 3, 6]}), encoding="utf-8")
    assert load_scene(path) == scene
    assert scene.changed(losses={"site": 0.5}) == Scene.of(**changed(losses={"site": 0.5}))
    assert scene.changed(tolerance=1e-5).bench == scene.bench
    assert repr(scene) == "<Scene driven: beta_fput on a bench, t = 0 .. 6, to 1e-07>"


def test_losses_and_ends_are_swept() -> None:
    document = tomllib.loads(Scene.of(**DRIVEN).toml())
    for field, value in (("losses.site", 0.5), ("chain.sites", 16), ("constants.K4", 0)):
        check_field(field)
        scene = make_scene(changed_document(document, {field: value}), "driven", Path())
        table, _, key = field.partition(".")
        assert scene == Scene.of(**changed(**{table: DRIVEN[table] | {key: value}}))


def test_sensors_read_what_the_cells_do() -> None:
    found = run(Scene.of(**DRIVEN))
    assert found.time.values.tolist() == np.arange(0, 6.1, 0.75).tolist()
    places = list(DRIVEN["observables"]["sensors"]["sites"])
    for name in ("displacement", "velocity"):
        np.testing.assert_array_equal(found[f"sensor_{name}"], found[name][:, places])
    u = found.displacement.values
    wall = 0.05 * np.sin(1.3 * found.time.values)
    stretch = found.sensor_strain.values
    np.testing.assert_allclose(stretch[:, 1], u[:, 8] - u[:, 7], atol=1e-15)
    force = stretch[:, :2] + 2 * stretch[:, :2] ** 3
    np.testing.assert_allclose(found.sensor_force[:, :2], force, atol=1e-15)
    np.testing.assert_array_equal(found.sensor_force[:, 2], 0.0)  # the free end
    inner = np.diff(u, axis=1, prepend=wall[:, None])
    energy = np.sum(inner**2 / 2 + inner**4 / 2, axis=1) + np.sum(found.velocity**2, axis=1) / 2
    np.testing.assert_allclose(found.energy, energy, rtol=1e-12)
    assert found.attrs["error_estimate"] <= 1e-7
    at_start = found.velocity[0].values
    assert at_start.nonzero()[0].tolist() == [4, 5]
    assert at_start[4:6].tolist() == [0.1, -0.2]


def test_the_shipped_driven_chain_is_its_modes() -> None:
    found = run(load_scene("driven_chain").changed(times=[0, 20, 60]))
    times, readings = found.time.values, found.sensor_displacement.values
    exact = [modal_chain(24, 0.05, 5, 0.7, t)[[0, 5, 23]] for t in times[1:]]
    assert np.abs(readings[1:] - exact).max() < found.attrs["error_estimate"] <= 1e-10


def test_work_and_heat_of_the_shipped_driven_chain_are_those_of_its_modes() -> None:
    """Compare with power and squared velocities, by difference quotients of the closed form."""
    found = run(load_scene("driven_chain").changed(times=[0, 10], tolerance=1e-9))
    nodes, weights = np.polynomial.legendre.leggauss(40)
    t, weights = 5.0 * (1.0 + nodes), 5.0 * weights
    step, factors = 0.02, np.array([672.0, -168.0, 32.0, -3.0]) / 840.0
    v = np.array(
        [
            sum(
                part
                / step
                * (modal_chain(24, 0.05, 5, 0.7, at + by) - modal_chain(24, 0.05, 5, 0.7, at - by))
                for part, by in zip(factors, step * np.arange(1, 5), strict=True)
            )
            for at in t
        ]
    )
    assert found.work[-1] == pytest.approx(weights @ (np.cos(0.7 * t) * v[:, 5]), abs=1e-9)
    assert found.heat[-1] == pytest.approx(0.05 * weights @ np.sum(v**2, axis=1), abs=1e-9)


def test_energy_is_what_was_done_less_what_was_lost() -> None:
    losses, observables = (
        {"site": 0.03, "bond": 0.1},
        {"energy": True, "flux": [3, 8], "every": 1.5},
    )
    found = run(Scene.of(**changed(losses=losses, observables=observables)))
    gained = found.energy - found.energy[0]
    error = found.attrs["error_estimate"]
    assert np.abs(gained - found.work + found.heat).max() < 3.0 * error <= 3e-7
    assert found.heat[-1] > 0.05
    np.testing.assert_allclose(found.driver_work.sum("driver"), found.work, atol=1e-15)
    assert found.driver.values.tolist() == ["left wall", "force 1"]
    assert found.work.attrs["units"] == found.heat.attrs["units"] == "lattice units"
    assert found.cut.values.tolist() == [3, 8]


def test_what_went_through_a_bond_is_beyond_it() -> None:
    """Check without losses; half of the bond's own energy is on either side."""
    observables = {"flux": [5], "state": True}
    found = run(Scene.of(**changed(losses={}, force=[], observables=observables, times=[0, 6, 9])))
    stretch = np.diff(found.displacement, axis=1)[:, 5:]
    stored = stretch**2 / 2 + stretch**4 / 2
    beyond = np.sum(found.velocity[:, 6:] ** 2, axis=1) / 2 + stored.sum(axis=1) - stored[:, 0] / 2
    sent = found.transmitted[:, 0]
    np.testing.assert_allclose(sent, beyond - beyond[0], atol=2 * found.attrs["error_estimate"])
    assert abs(sent[-1]) > 1e-3
    assert "energy" not in found
    assert found.flux.attrs["units"] == "lattice units per lattice time"


def test_what_neither_gains_nor_loses_is_not_followed() -> None:
    tables = changed(chain={"sites": 12, "right": "free"}, losses={}, force=[])
    scenes = [
        Scene.of(**tables | {"observables": {"state": True, "energy": on}}) for on in (False, True)
    ]
    bare, found = (run(scene) for scene in scenes)
    assert set(found) - set(bare) == {"energy"}
    assert bare.attrs["steps"] == found.attrs["steps"]
    np.testing.assert_array_equal(bare.displacement, found.displacement)


def test_every_reading_has_its_name() -> None:
    assert tuple(READINGS) == SENSOR_QUANTITIES


def test_mode_energies_are_those_of_a_linear_chain() -> None:
    scene = load_scene("fput_1955").changed(times=[0, 40], constants={"K2": 1, "K3": 0})
    found = run(scene.changed(start={"mode": {"number": 3, "amplitude": 2}}))
    omega = 2.0 * np.sin(3 * np.pi / 64)
    energies = [0.0, 0.0, 0.5 * omega**2 * 4 * 16, 0.0]
    np.testing.assert_allclose(found.mode_energy, [energies] * found.time.size, atol=1e-6)
    np.testing.assert_allclose(found.energy, energies[2], rtol=1e-7)


@pytest.mark.slow
def test_a_struck_hertz_chain_has_a_wave_of_its_speed() -> None:
    """The wave's speed scales as the fifth root of the impact velocity."""
    speeds = []
    for velocity in (0.05, 0.4):
        scene = load_scene("struck_grains")
        struck = {"impact": {"site": 0, "velocity": velocity}}
        observables = {"sensors": {"sites": [12, 24], "of": ["velocity"]}, "every": 0.05}
        end = 60 * (0.1 / velocity) ** 0.2
        found = run(
            scene.changed(start=struck, observables=observables, times=[0, end], tolerance=1e-4)
        )
        read = found.sensor_velocity.values
        first, second = found.time.values[read.argmax(axis=0)]
        speeds.append(12.0 / (second - first))
    assert np.log(speeds[1] / speeds[0]) / np.log(8.0) == pytest.approx(0.2, abs=0.004)


@pytest.mark.parametrize("name", shipped_scenes("bench"))
def test_shipped_benches_are_read(name: str) -> None:
    scene = load_scene(name)
    bench, chain = bench_and_chain(scene)
    assert scene.title
    assert chain.cells == bench.sites
    assert expected_cost(scene).seconds < 60.0


@pytest.mark.slow
def test_runs_are_stored_printed_and_repeated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "driven.toml").write_text(toml_text(DRIVEN), encoding="utf-8")
    path = tmp_path / "run.nc"
    assert main(["run", str(tmp_path / "driven.toml"), "--output", str(path)]) == 0
    output = capsys.readouterr().out
    assert re.search(r"3 +│ 0\.\d+", output)
    assert "cell 7: velocity at most" in output
    assert main(["run", str(path)]) == 0
    assert "same bits" in capsys.readouterr().out
    assert load_run(path).sizes["time"] == 9
    assert main(["plot", str(path), "--output", str(tmp_path / "run.png")]) == 0
    assert (tmp_path / "run.png").stat().st_size > 10_000
    capsys.readouterr()
    assert main(["converge", str(tmp_path / "driven.toml")]) == 2
    assert "scene must have a wave" in capsys.readouterr().err


def written(path: Path, **columns: Any) -> Path:
    """Write a CSV file of these columns, with every digit, and return its path."""
    lines = [
        ",".join(columns),
        *(",".join(map(repr, row)) for row in zip(*columns.values(), strict=True)),
    ]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


TIMES = np.linspace(-0.5, 6.5, 71)


@pytest.mark.slow
def test_files_stand_for_their_numbers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A run is repeated bit by bit without the files; another number gives another scene."""
    wave = (0.05 * np.sin(1.3 * TIMES)).tolist()
    drive = written(tmp_path / "drive.csv", t=TIMES.tolist(), value=wave)
    written(tmp_path / "state.csv", site=[0, 5], u=[0.1, -0.1], du=[0.0, 0.3])
    named = changed(
        chain={"sites": 12, "left": {"velocity": {"file": "drive.csv"}}, "right": "free"},
        force=[{"site": 3, "file": "drive.csv"}],
        start=[{"file": "state.csv"}, {"impact": {"site": 5, "velocity": 0.25}}],
    )
    path = tmp_path / "driven.toml"
    path.write_text(toml_text(named), encoding="utf-8")
    scene, table = load_scene(path), {"t": TIMES, "value": wave}
    assert scene == Scene.of(
        **changed(
            chain={"sites": 12, "left": {"velocity": table}, "right": "free"},
            force=[{"site": 3, **table}],
            start=[
                {"site": [0.0, 5.0], "u": [0.1, -0.1], "du": [0.0, 0.3]},
                {"impact": {"site": 5, "velocity": 0.25}},
            ],
        )
    )
    assert Scene.from_json(scene.json()) == scene == scene_of_toml(scene.toml())
    monkeypatch.chdir(tmp_path)
    assert Scene.of(**named) == scene
    assert main(["run", "driven.toml", "--output", "run.nc"]) == 0
    written(drive, t=TIMES.tolist(), value=[*wave[:-1], 1.0])
    assert load_scene(path) != scene
    drive.unlink()
    assert main(["run", "run.nc"]) == 0
    assert "same bits" in capsys.readouterr().out
    found = load_run(tmp_path / "run.nc")
    assert found.displacement[0].values[[0, 4, 5]].tolist() == [0.1, 0.0, -0.1]
    assert found.velocity[0].values[[0, 5]].tolist() == [0.0, 0.55]


def test_measured_drives_keep_the_order_of_a_scheme() -> None:
    """A spline of degree 3 would reduce the order to 4, a monotone one to 3."""
    times = np.arange(26) / 2
    noise = 0.1 * np.random.default_rng(0).standard_normal(26)
    measured = Samples.of("value", {"t": times, "value": noise})
    lattice = numeric_lattice(LATTICES["alpha_fput"], {"K2": 1, "K3": 1})
    chain = driven_chain(lattice, 20, left="free", right="free", forces=[SiteForce(3, measured)])
    state = State(0.0, *np.zeros((2, 1, 20)))
    coarse, fine, exact = (
        integrate(chain, state, [12.0], step=12 / steps, measure_error=False).f
        for steps in (37, 148, 1480)
    )
    assert np.log2(np.abs(coarse - exact).max() / np.abs(fine - exact).max()) / 2 > 5.5
    np.testing.assert_allclose(measured(times), noise, atol=1e-16)
    within = times[1:-1]
    difference = measured(within + 1e-5) - measured(within - 1e-5)
    np.testing.assert_allclose(measured.slope(within), difference / 2e-5, atol=1e-9)


@pytest.mark.parametrize(
    ("formula", "exact"),
    [
        ("sin(50*t)", lambda t: -np.cos(50 * t) / 50),
        ("exp(-((t - 7)/0.001)**2)", lambda t: 5e-4 * np.sqrt(np.pi) * erf((t - 7) / 1e-3)),
        ("sqrt(t - 3)", lambda t: (t - 3) ** 1.5 / 1.5),
        ("tanh(100000*(t - 5))", lambda t: np.abs(t - 5) - np.log(2) / 1e5),
    ],
)
def test_integrals_are_exact(formula: str, exact: Any) -> None:
    moved = Integral.of(time_function("velocity", formula), 3.0, 12.0)
    times = np.linspace(3.0, 12.0, 1001)[np.abs(np.linspace(-2.0, 7.0, 1001)) > 1e-3]
    np.testing.assert_allclose(moved(times), exact(times) - exact(3.0), atol=2e-14)
    assert float(moved(np.array(3.0))) == 0.0


def test_a_pushed_end_is_a_free_one_with_a_force() -> None:
    """A free chain gets the momentum of both pushes, which are to the right."""
    ends = {"left": {"force": "sin(t)"}, "right": {"force": "t/10"}}
    tables = {"losses": {"site": 0}, "force": [], "start": {"rest": True}}
    scene = Scene.of(**changed(chain={"sites": 12, **ends}, **tables))
    bench, chain = bench_and_chain(scene)
    assert bench.ends == ("free", "free")
    assert [force.site for force in chain.outer_forces] == [0, 11]
    found = run(scene)
    got = found.velocity.sum("cell").values
    np.testing.assert_allclose(got, 1 - np.cos(found.time) + found.time**2 / 20, atol=1e-6)


def test_defects_are_of_single_cells_and_bonds() -> None:
    defects = {"mass": {"2": 3, "4": {"u": 0.5}}, "spring": {"-1": 2, "5": [0.25], "10": 0}}
    scene = Scene.of(**changed(defects=defects))
    assert Scene.from_json(scene.json()) == scene == scene_of_toml(scene.toml())
    chain = bench_and_chain(scene)[1]
    masses = np.ones(12)
    masses[[2, 4]] = 3, 0.5
    np.testing.assert_array_equal(chain.cell_masses[0, :12], masses)
    f = np.zeros((1, chain.deviations.shape[1]))
    f[0, :12] = np.arange(1, 13)
    forces = chain.forces(f)[0]
    assert forces[[-1, 0, 5, 10]].tolist() == [6.0, 3.0, 0.75, 0.0]
    document = tomllib.loads(scene.toml())
    check_field("defects.mass")
    swept = make_scene(changed_document(document, {"defects.mass": {"2": 4}}), "driven", Path())
    assert swept == Scene.of(**changed(defects=defects | {"mass": {"2": 4}}))


def test_what_defects_and_measured_walls_gain_is_work_less_heat() -> None:
    wall = {"velocity": {"t": TIMES, "value": 0.05 * np.sin(1.3 * TIMES)}}
    scene = Scene.of(
        **changed(
            chain={"sites": 12, "left": wall, "right": {"force": "0.1*sin(t)"}},
            losses={"site": 0.05, "bond": 0.1},
            defects={"mass": {0: 2, 10: 0.3, 11: 4}, "spring": {-1: 3, 5: 0.25}},
            observables={"energy": True},
            tolerance=1e-9,
        )
    )
    found = run(scene)
    assert found.heat[-1] > 1e-2
    gained = found.energy - found.energy[0]
    np.testing.assert_allclose(gained, found.work - found.heat, rtol=0, atol=3e-9)


def test_formulas_in_time_are_read_not_run() -> None:
    t = np.array([0.0, 0.5])
    np.testing.assert_allclose(
        time_function("value", "exp(-t)*sin(2*t)")(t), np.exp(-t) * np.sin(2 * t)
    )
    np.testing.assert_array_equal(time_function("value", 2)(t), 2.0)
    for text in ("x + 1", "K2*t", "contact(t)", "__import__('os')", "t.real", ""):
        with pytest.raises(ValueError, match="value"):
            time_function("value", text)


REFUSED: list[tuple[dict[str, Any], str]] = [
    (
        {"observables": {"energy": False}},
        "observables must name at least one quantity, got nothing",
    ),
    (
        {"observables": {"sensors": {"sites": [0], "of": []}}},
        "observables must name at least one quantity",
    ),
    ({"observables": {"every": 1, "sensors": {"every": 2}}}, "every must be in [observables] or"),
    (
        {"chain": {"sites": date(2000, 1, 1)}},
        "tables of a bench must hold numbers, texts and lists",
    ),
    ({"start": {}}, "start must be stated, got nothing"),
    (
        {"force": [{"site": 1, "value": 10**400}]},
        "value in [[force]] must be 0 or satisfy 1e-50 <=",
    ),
    ({"force": [{"site": 1, "value": "sqrt(-1)*t"}]}, "numbers in a formula must be real, got I"),
    ({"chain": {"left": "free"}}, "sites in [chain] must be stated"),
    ({"chain": {"sites": 1}}, "sites in [chain] must be a whole number, 2 <="),
    ({"chain": {"sites": 8, "lefft": "free"}}, "keys in [chain] must be known ones, got lefft"),
    ({"chain": {"sites": 8, "left": "loose"}}, 'left in [chain] must be "fixed"'),
    ({"chain": {"sites": 8, "left": {"displacement": "s"}}}, "displacement of left"),
    ({"chain": {"sites": 8, "left": {"velocity": "1/0"}}}, "velocity of left"),
    (
        {"chain": {"sites": 12, "left": {"velocity": "sin(1e9*t)"}}},
        "must change slowly enough to be",
    ),
    (
        {"chain": {"sites": 8, "right": {"speed": "t"}}},
        'right in [chain] must be "fixed"',
    ),
    ({"chain": {"sites": 8, "right": {"force": "t", "velocity": "t"}}}, "one of displacement, vel"),
    ({"chain": {"sites": 8, "left": {"velocity": {"t": [0, 9]}}}}, "a table of t and value, got {"),
    ({"force": [{"site": 1, "t": [0, 1], "value": [0, 1]}]}, "at least 6 times and as many values"),
    ({"force": [{"site": 1, "t": [*range(9)], "value": [0] * 8}]}, "values, got 9 and 8"),
    ({"force": [{"site": 1, "t": [*range(9)], "value": "t"}]}, "must be a real number, got 't'"),
    (
        {"force": [{"site": 1, "t": "0", "value": [0] * 9}]},
        "t of value in [[force]] must be",
    ),
    (
        {"force": [{"site": 1, "t": [0] * 9, "value": [0] * 9}]},
        "must increase, got 0 before 0",
    ),
    ({"force": [{"site": 1, "t": [*range(9)], "value": [np.nan] * 9}]}, "finite, got nan in row 1"),
    (
        {"force": [{"site": 1, "t": [*range(6)], "value": [0] * 6}]},
        "within those of a table of",
    ),
    (
        {"force": [{"site": 1, "t": [*range(9)], "value": [-1, 1] * 4 + [-1]}]},
        "dense and even",
    ),
    ({"force": [{"site": 1, "file": 3}]}, "file must be a name, got 3"),
    ({"force": [{"site": 1, "file": "no.csv"}]}, "no.csv: No such file or directory"),
    ({"force": [{"site": 1, "value": "t", "file": "/dev/null"}]}, "must be a regular file, got"),
    (
        {"start": {"site": [0, 0], "u": [1, 1]}},
        "columns in [start] must be equally long and have each cell once, got 2 rows",
    ),
    (
        {"start": {"site": [0, 1], "u": [1]}},
        "must be equally long and have each cell once, got 2 rows with 2 cells",
    ),
    ({"start": {"site": [0.5], "u": [1]}}, "site in [start] must be a whole number"),
    ({"start": {"site": [12], "u": [1]}}, "site in [start] must be 0 to 11, got 12"),
    ({"start": {"site": [1], "w": [1]}}, "field in state must be one of beta_fput, got 'w'"),
    ({"start": {"u": [1]}}, "keys in [start] must be known ones, got u"),
    ({"defects": {"masses": {1: 2}}}, "keys in [defects] must be known ones, got masses"),
    ({"defects": {"mass": 2}}, "mass in [defects] must be a table by cells, got 2"),
    ({"defects": {"mass": {"x": 2}}}, "mass in [defects] must have cell numbers as keys, got x"),
    (
        {"defects": {"mass": {12: 2}}},
        "mass factors must be within",
    ),
    ({"defects": {"mass": {1: 0}}}, "mass factors must be > 0, one number or 1, got 0"),
    ({"defects": {"mass": {1: {"w": 2}}}}, "field in [defects] must be one of beta_fput, got 'w'"),
    ({"defects": {"mass": {1: [2]}}}, "mass of 1 in [defects] must be a number, got [2]"),
    ({"defects": {"spring": {20: "2*K2"}}}, "must be a number, got '2*K2'"),
    (
        {"defects": {"spring": {1: [2, 2]}}},
        "spring factors must be >= 0, one number or 1, got (2.0",
    ),
    ({"defects": {"spring": {-2: 2}}}, "spring factors must be within the chain"),
    ({"start": None}, "start must be stated"),
    ({"start": {"rest": False}}, "rest in [start] must be true"),
    ({"start": {"impact": {"site": 99, "velocity": 1}}}, "site of impact must be 0 to 11, got 99"),
    ({"start": {"impact": {"site": 1}}}, "velocity of impact must be a number"),
    ({"start": {"mode": {"number": 13, "amplitude": 1}}}, "modes must be 1 to 12, got 13"),
    ({"losses": {"site": -1}}, "site in [losses] must be 0 or more"),
    ({"losses": {"bonds": 1}}, "keys in [losses] must be known ones, got bonds"),
    ({"losses": {"bond": -0.1}}, "bond in [losses] must be 0 or more, got -0.1"),
    ({"losses": {"bond": [0.1, 0.1]}}, "bond in [losses] must be a loss for each of 1 springs"),
    ({"losses": {"site": {"w": 1}}}, "site must be a loss of u, got one of 'w'"),
    ({"force": [{"site": 1}]}, "value in [[force]] must be stated"),
    ({"force": [{"site": 12, "value": "1"}]}, "site of [[force]] must be 0 to 11, got 12"),
    ({"force": [{"site": 1, "value": "log(t - 9)"}]}, "in time must be finite, got nan"),
    ({"force": [{"site": 1, "value": "1/(t - 1/3)"}]}, "jumps, got one that is not near t = 0.333"),
    (
        {"force": [{"site": 1, "value": "sqrt((t-5)**2)"}]},
        "value in [[force]] must have a slope wi",
    ),
    ({"losses": {"bond": 1e12}}, "must need at most 1e+10 steps, got about"),
    ({"observables": {"sensors": {"sites": []}}}, "sites of sensors must be a list of cells"),
    ({"observables": {"sensors": {"sites": [12]}}}, "site of sensors must be 0 to 11, got 12"),
    ({"observables": {"mode_energies": [1]}}, "mode_energies must be of a chain of one field"),
    ({"observables": {"flux": 3}}, "flux must be a list of numbers of cells, got 3"),
    ({"observables": {"flux": [12]}}, "site of flux must be 0 to 11, got 12"),
    ({"observables": {"energy": 1}}, "energy in [observables] must be true or false"),
    ({"observables": {"every": 1e-9}}, "every in [observables] must give at most 1e+06 times"),
    ({"wave": "kdv_soliton"}, "wave must not be given with a chain on a bench"),
    ({"half_width": 3}, "half_width must not be given with a chain on a bench"),
    ({"tolerance": None, "step": 0.1, "domain": "ring", "sites": 8}, "tolerance must be given"),
    ({"engine": "spectral"}, "tolerance must be given for a chain on a bench, without an engine"),
    ({"times": [0, 0.0]}, "times must increase"),
    ({"lattice": "mass_dimer", "constants": {}}, "constant K2 of mass_dimer must be given"),
    ({"lattice": "fput_strain"}, "need a chain of displacements, got fput_strain"),
    ({"constants": {"K2": 1}}, "constant K4 of beta_fput must be given"),
]


@pytest.mark.parametrize(("tables", "text"), REFUSED, ids=[text for _, text in REFUSED])
def test_what_is_refused(tables: dict[str, Any], text: str) -> None:
    with pytest.raises(ValueError, match=re.escape(text)) as caught:
        run(Scene.of(**changed(**tables)))
    assert "\n" not in str(caught.value)


def test_a_bench_is_run_from_its_start_and_with_a_chain() -> None:
    with pytest.raises(ValueError, match="without defects"):
        run(load_scene("fput_1955").changed(defects={"spring": {3: 2}}))
    with pytest.raises(ValueError, match=r"force must be with a chain on a bench, got no \[chain"):
        Scene.of(name="pushed", wave="kdv_soliton", lattice="toda", eps=0.1, force=[])
    found = run(Scene.of(**changed(times=[0, 1], observables={"state": True})))
    with pytest.raises(ValueError, match="run must hold its states"):
        resume(found)
    assert Bench.of_tables({"chain": {"sites": 3}, "start": {"rest": True}}).state


def test_a_piston_goes_further_than_a_grain_is_compressed(tmp_path: Path) -> None:
    """Reference values are from SciPy's DOP853 at 1e-12."""
    (tmp_path / "c.toml").write_text(
        'fields = ["u"]\npositive = ["A", "d", "p"]\n[[spring]]\n'
        'between = ["u[n]", "u[n+1]"]\nforce = "-A*(d - x)**p"\n',
        encoding="utf-8",
    )
    tables = {
        "lattice": "c.toml",
        "times": [0, 30, 60],
        "tolerance": 1e-6,
        "constants": {"A": 1, "d": 1, "p": 1.4},
        "chain": {"sites": 120, "left": {"velocity": "0.1"}, "right": "fixed"},
        "start": {"rest": True},
        "observables": {"energy": True, "state": True},
    }
    path = tmp_path / "piston.toml"
    path.write_text(toml_text(tables), encoding="utf-8")
    found = run(load_scene(path))
    assert abs(float(found.displacement[-1, 0]) - 5.9161930295) < found.error_estimate <= 1e-6
    assert abs(float(found.displacement[-1, 20]) - 4.2399894328) < found.error_estimate
    assert abs(float(found.energy[-1] - found.work[-1])) < 1e-6
    assert found.steps < 1000


def test_the_reason_for_too_many_steps_is_what_asks_for_them() -> None:
    """Catches: stiff springs that are reported as losses or drives."""
    for tables, reason in (
        ({"constants": {"K2": 1e30, "K4": 2}}, "the highest frequency is 2e\\+15"),
        ({"losses": {"site": 1e15}}, "losses and drivers must need at most"),
    ):
        with pytest.raises(ValueError, match=reason):
            run(Scene.of(**changed(**tables)))
