"""Catches: constants that are not the hidden ones, intervals too narrow, a wrong model believed,
records of another chain."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats
from scipy.integrate import solve_ivp

from longwave.derive import LATTICES, read_lattice
from longwave.derive.lattice_file import document_of_lattice, lattice_of
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.lattice.sensitivities import Sensor
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_file import toml_text
from longwave.scenes.fits.scene_fit import SceneFit, SceneModel, fit_scene
from longwave.scenes.fits.sensor_records import SensorRecord, read_record

Array = NDArray[np.float64]

SCENE: dict[str, Any] = {
    "name": "struck",
    "lattice": "beta_fput",
    "constants": {"K2": 1, "K4": 2},
    "times": [0, 12],
    "tolerance": 1e-6,
    "chain": {"sites": 6},
    "start": {"impact": {"site": 1, "velocity": 0.8}},
    "losses": {"site": 0.05},
}
FREE = ("K2", "K4", "losses.site")
HIDDEN = (1.1, 2.5, 0.03)
TIMES = np.arange(0.5, 12.1, 0.5)
SENSORS = (Sensor("displacement", 0, 2), Sensor("velocity", 0, 4))
NOISE = 2e-3


def hidden_readings(K3: float = 0.0) -> Array:
    """Return the sensor readings of the hidden chain, by SciPy from equations written here."""
    K2, K4, loss = HIDDEN

    def slopes(_: float, held: Array) -> Array:
        u, v = held.reshape(2, 6)
        stretch = np.diff(u, prepend=0.0, append=0.0)
        force = K2 * stretch + K3 * stretch**2 + K4 * stretch**3
        return np.concatenate([v, np.diff(force) - loss * v])

    start = np.zeros(12)
    start[7] = 0.8
    words = {"rtol": 1e-11, "atol": 1e-12, "t_eval": TIMES}
    found = solve_ivp(slopes, (0.0, 12.0), start, method="DOP853", **words).y
    return found[[2, 6 + 4]].T


def record(seed: int, K3: float = 0.0, known: bool = True) -> SensorRecord:
    values = hidden_readings(K3)
    values = values + NOISE * np.random.default_rng(seed).standard_normal(values.shape)
    if not known:
        return SensorRecord(TIMES, SENSORS[:1], values[:, :1], None)
    return SensorRecord(TIMES, SENSORS, values, np.full(values.shape, NOISE))


def write_csv(path: Path, held: SensorRecord) -> Path:
    names = ["displacement_2", "velocity_4"]
    rows = [
        [t, *row, NOISE, NOISE] for t, row in zip(held.times, held.values.tolist(), strict=True)
    ]
    head = ["time", *names, *(name + "_deviation" for name in names)]
    lines = [",".join(head), *(",".join(map(repr, map(float, row))) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def fitted() -> SceneFit:
    return fit_scene(Scene.of(**SCENE), [record(0), record(1)], FREE)


@pytest.mark.slow
def test_hidden_constants_and_losses_are_found(fitted: SceneFit) -> None:
    errors = fitted.values - HIDDEN
    distance = float(errors @ np.linalg.solve(fitted.covariance, errors))
    assert distance < stats.chi2.ppf(0.999, 3)
    assert (fitted.deviations < np.array([0.01, 0.2, 0.005])).all()
    assert fitted.degrees == 2 * 2 * 24 - 3
    assert 0.001 < fitted.p_value < 0.999
    assert fitted.doubts == []


@pytest.mark.slow
def test_without_noise_they_are_found_to_the_tolerance() -> None:
    values = hidden_readings()
    exact = SensorRecord(TIMES, SENSORS, values, np.full(values.shape, 1e-3))
    found = fit_scene(Scene.of(**SCENE | {"tolerance": 1e-9}), [exact], FREE)
    np.testing.assert_allclose(found.values, HIDDEN, rtol=1e-7)
    assert any("scatter less" in doubt for doubt in found.doubts)


def test_twice_the_records_have_half_the_variance(fitted: SceneFit) -> None:
    once = fit_scene(Scene.of(**SCENE), [record(0)], FREE)
    np.testing.assert_allclose(once.covariance, 2 * fitted.covariance, rtol=0.1)


@pytest.mark.slow
def test_noise_that_is_not_known_is_taken_from_the_residuals() -> None:
    found = fit_scene(Scene.of(**SCENE), [record(3, known=False)], FREE)
    assert found.noise == pytest.approx(NOISE, rel=0.5)
    assert (abs(found.values - HIDDEN) < 4 * found.deviations).all()
    assert np.isnan(found.p_value)
    assert not any("differs from" in doubt for doubt in found.doubts)


@pytest.mark.slow
@pytest.mark.parametrize(("free", "K3"), [(("K2", "K4"), 0.0), (FREE, 0.2)])
def test_a_wrong_model_is_doubted(free: tuple[str, ...], K3: float) -> None:
    found = fit_scene(Scene.of(**SCENE), [record(4, K3)], free)
    assert found.p_value < 1e-4
    assert found.serial_p_value < 0.01
    text = " ".join(found.doubts)
    assert "the scene differs from the readings" in text
    assert "correlated in time" in text


def test_white_noise_is_doubted_as_often_as_is_said(fitted: SceneFit) -> None:
    random = np.random.default_rng(1)
    drawn = [replace(fitted, left=(random.standard_normal((10, 6)),)) for _ in range(4000)]
    share = np.mean([one.serial_p_value < 0.01 for one in drawn])
    assert 0.004 < share < 0.016
    slow = np.cumsum(random.standard_normal((40, 1)), axis=0) / 5
    assert replace(fitted, left=(slow,)).serial_p_value < 0.01


def test_what_cannot_be_told_apart_is_named(tmp_path: Path) -> None:
    """Only the ratio of stiffness and mass can be determined; unused constants not at all."""
    chain = {
        "fields": ["u"],
        "masses": ["m"],
        "positive": ["K2", "m"],
        "spring": [{"between": ["u[n]", "u[n+1]"], "force": "K2*x + K4*x**3"}],
    }
    (tmp_path / "chain.toml").write_text(toml_text(chain), encoding="utf-8")
    tables = SCENE | {"lattice": "chain.toml", "constants": {"K2": 1, "K4": 0, "m": 1}}
    tables |= {"losses": {"site": 0}, "chain": {"sites": 6}}
    (tmp_path / "struck.toml").write_text(toml_text(tables), encoding="utf-8")
    with pytest.raises(ValueError, match=r"determined by the records, got K2, m, other values"):
        fit_scene(tmp_path / "struck.toml", [record(0)], ["K2", "m"])
    still = Scene.of(**SCENE | {"start": {"rest": True}})
    with pytest.raises(ValueError, match=r"determined by the records, got "):
        fit_scene(still, [record(0)], FREE)


@pytest.mark.slow
def test_a_loss_that_is_a_constant_is_fitted_as_one() -> None:
    named = SCENE | {"losses": {"site": "g"}, "constants": {"K2": 1, "K4": 2, "g": 0.05}}
    found = fit_scene(Scene.of(**named), [record(0)], ["K2", "K4", "g"])
    same = fit_scene(Scene.of(**SCENE), [record(0)], FREE)
    np.testing.assert_allclose(found.values, same.values, rtol=1e-6)
    np.testing.assert_allclose(found.covariance, same.covariance, rtol=1e-4)
    assert list(found.document()["constants"]) == ["K2", "K4"]


@pytest.mark.slow
def test_one_that_says_little_is_told() -> None:
    weak = Scene.of(**SCENE | {"start": {"impact": {"site": 1, "velocity": 0.02}}})
    model = SceneModel(weak, ["K2", "K4"])
    read = model.readings([1.0, 2.0], TIMES, SENSORS, 0.2)[..., 0]
    noisy = read + NOISE * np.random.default_rng(0).standard_normal(read.shape)
    found = fit_scene(
        weak, [SensorRecord(TIMES, SENSORS, noisy, np.full(read.shape, NOISE))], ["K2", "K4"]
    )
    assert any(doubt.startswith("K4 is not determined") for doubt in found.doubts)


def test_a_tolerance_that_is_not_small_is_told() -> None:
    rough = Scene.of(**SCENE | {"tolerance": 1e-3})
    found = fit_scene(rough, [record(0)], FREE)
    assert any("0.001, is not small compared with the deviation" in doubt for doubt in found.doubts)


def test_the_lattice_that_is_written_is_the_scenes_with_its_covariance(fitted: SceneFit) -> None:
    lattice = lattice_of(fitted.document())
    assert lattice.bonds[0].force == LATTICES["beta_fput"].bonds[0].force
    assert lattice.measured is not None
    assert list(lattice.measured.deviations) == ["K2", "K4"]
    np.testing.assert_allclose(lattice.measured.covariance, fitted.covariance[:2, :2])


@pytest.mark.parametrize("name", sorted(LATTICES))
def test_a_lattice_is_the_same_after_it_was_written(name: str) -> None:
    again = lattice_of(document_of_lattice(LATTICES[name]))
    assert again.equations() == LATTICES[name].equations()
    for bond, other in zip(again.bonds, LATTICES[name].bonds, strict=True):
        assert (bond.stretch, bond.force) == (other.stretch, other.force)
        assert {*bond.action} == {*other.action}
    assert again.masses == LATTICES[name].masses


HEAD = "time,displacement_2\n"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "line 1 must name the column time and"),
        ("displacement_2\n1\n", "line 1 must name the column time and"),
        ("time\n1\n", "line 1 must name the column time and"),
        ("time,displacement_2,displacement_2\n1,1,1\n", "must name each column once"),
        ("time,speed_2\n1,1\n", "columns must be time, or displacement, velocity"),
        ("time,displacement_6\n1,1\n", "cell of displacement_6 must be 0 to 5, got 6"),
        (
            "time,displacement_2_w\n1,1\n",
            "sensor displacement_2_w must be on a field or bond of beta_fput",
        ),
        ("time,strain_2_2\n1,1\n", "got '2' (one of 1)"),
        (
            "time,displacement_2,velocity_4,velocity_4_deviation\n1,1,1,1\n",
            "for all sensors or for",
        ),
        ("time,displacement_2,displacement_2_deviation\n1,1,0\n", "deviations must be above 0"),
        (HEAD + "1,1\n2\n", "line 3 must hold 2 numbers, time displacement_2"),
        (HEAD + "1,1\n2,nan\n", "line 3 must hold finite numbers"),
        (HEAD + "1,1\n12.5,1\n", "time must lie in the scene, 0 to 12, got 12.5 in line 3"),
        (HEAD + "1,1\n1,1\n", "time must rise from line to line, got 1 in line 3"),
        (HEAD + "1,1\n2,1\n", "readings must be at least 6 for 3 constants, got 2"),
    ],
)
def test_bad_records_are_told_in_one_line(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "record.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match="must") as refused:
        fit_scene(Scene.of(**SCENE), [path], FREE)
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)


def test_records_without_deviations_are_of_one_quantity() -> None:
    mixed = SensorRecord(TIMES, SENSORS, hidden_readings(), None)
    with pytest.raises(ValueError, match="displacement and velocity without"):
        fit_scene(Scene.of(**SCENE), [mixed], FREE)
    with pytest.raises(ValueError, match="in all records or in none"):
        fit_scene(Scene.of(**SCENE), [record(0), record(0, known=False)], FREE)


@pytest.mark.parametrize(
    ("scene", "free", "told"),
    [
        (SCENE, ["K5"], "free must name constants of the scene, each once, got 'K5'"),
        (SCENE, ["K2", "K2"], "each once, got 'K2'"),
        (SCENE, [], "free must name the constants to fit, got nothing"),
        (SCENE | {"losses": {"site": {"u": 0.1}}}, ["losses.site"], "got 'losses.site'"),
        (SCENE | {"noise": {"temperature": 1e-3}}, ["K2"], "must be among chain, start, force"),
        ("toda_soliton", ["a"], "scene must be a chain on a bench, got toda_soliton"),
    ],
)
def test_what_cannot_be_fitted_is_told_in_one_line(scene: Any, free: list[str], told: str) -> None:
    loaded = Scene.of(**scene) if isinstance(scene, dict) else scene
    with pytest.raises(ValueError, match="must") as refused:
        fit_scene(loaded, [record(0)], free)
    assert told in str(refused.value)


def test_columns_are_read_in_any_order_with_fields_and_bonds(tmp_path: Path) -> None:
    dimer = LATTICES["mass_dimer"]
    lattice = numeric_lattice(dimer, {str(symbol): 1 for symbol in dimer.constants})
    second = lattice.fields[1]
    path = tmp_path / "record.csv"
    path.write_text(f"velocity_3_{second};time;strain_0_2\n1;0.5;2\n3;0.75;4\n", encoding="utf-8")
    found = read_record(path, lattice, 4, (0.0, 1.0))
    assert found.sensors == (Sensor("velocity", 1, 3), Sensor("strain", 1, 0))
    assert found.times.tolist() == [0.5, 0.75]
    assert found.values.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert found.deviations is None


@pytest.mark.slow
def test_the_command_fits_writes_and_warns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from longwave.__main__ import main

    monkeypatch.chdir(tmp_path)
    Path("struck.toml").write_text(Scene.of(**SCENE).toml(), encoding="utf-8")
    first, second = write_csv(Path("a.csv"), record(0)), write_csv(Path("b.csv"), record(1))
    words = ["fit", str(first), str(second), "--scene", "struck.toml", "--free", ",".join(FREE)]
    assert main([*words, "--output", "chain.toml"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("struck, fitted to 96 readings of a.csv, b.csv\n")
    assert "│ losses.site │ 0.0" in printed
    assert "\nchi^2 " in printed
    assert "warning" not in printed
    text = Path("chain.toml").read_text("utf-8")
    assert "# losses.site = 0.0" in text
    measured = read_lattice(Path("chain.toml")).measured
    assert measured is not None
    assert measured.deviations["K4"] > 0
    wrong = ["fit", str(first), "--scene", "struck.toml", "--free", "K2", "--json"]
    assert main(wrong) == 0
    assert (
        '"warnings": [\n    "warning: the scene differs from the readings'
        in capsys.readouterr().out
    )


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["a.csv", "--scene", "struck.toml"], "--scene must be given with --free"),
        (["a.csv", "--free", "K2"], "--scene must be given with --free"),
        (["a.csv", "b.csv"], "FILE.csv must be one file without --scene, got 2"),
        (["a.csv", "--scene", "s", "--free", "K2", "--law", "K2*x"], "--law must not be given"),
    ],
)
def test_options_that_do_not_go_together_are_told(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from longwave.__main__ import main

    assert main(["fit", *words]) == 2
    assert told in capsys.readouterr().err
