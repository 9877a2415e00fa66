"""Catches: samples with a wrong covariance, samples that change, intervals of the wrong number."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from longwave.__main__ import main
from longwave.runs import sampled_sweep as room
from longwave.runs import sweep_dataset
from longwave.runs.run_file import load_run
from longwave.runs.run_store import RunStore
from longwave.runs.sampled_sweep import MIN_SAMPLES, ObservedNumber, sampled_sweep

CHAIN = """
fields = ["u"]
masses = ["m"]
positive = ["K2", "m"]
spring = [{between = ["u[n]", "u[n+1]"], force = "K2*x + K3*x**2"}]

[constants]
K2 = 1.5
K3 = 0
m = 2

[covariance]
K2 = {K2 = 0.0025, m = 0.004}
m = {K2 = 0.004, m = 0.01}
"""

MODE = """
lattice = "chain.toml"
times = [0, 2, 5]
tolerance = 1e-7
chain = { sites = 3 }
start = { mode = { number = 1, amplitude = 0.2 } }
[observables]
sensors = { sites = [1], of = ["displacement", "velocity"] }
energy = true
mode_energies = [1]
"""

WAVE = """
lattice = "chain.toml"
wave = "kdv_soliton"
parameters = { kappa = 1 }
constants = { K3 = 1, m = 1 }
eps = 0.3
slow_times = [0, 0.05]
half_width = 4
tolerance = 1e-3
"""


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in (("chain", CHAIN), ("mode", MODE), ("wave", WAVE)):
        Path(f"{name}.toml").write_text(text, encoding="utf-8")


def rows(samples: int, seed: int = 0) -> np.ndarray:
    return np.array(sampled_sweep("mode.toml", samples, seed).dimensions[0].rows)


def test_samples_have_the_covariance_of_the_lattice_file() -> None:
    sweep = sampled_sweep("mode.toml", 4000)
    assert sweep.dimensions[0].fields == ("constants.K2", "constants.m")
    drawn = rows(4000)
    np.testing.assert_allclose(drawn.mean(axis=0), [1.5, 2.0], atol=5e-3)
    np.testing.assert_allclose(np.cov(drawn.T), [[0.0025, 0.004], [0.004, 0.01]], rtol=0.08)
    np.testing.assert_array_equal(rows(50), drawn[:50])
    assert not np.any(rows(50, seed=1) == drawn[:50])


def test_constants_stated_by_the_scene_are_exact() -> None:
    assert sampled_sweep("wave.toml", MIN_SAMPLES).dimensions[0].fields == ("constants.K2",)


@pytest.mark.slow
def test_intervals_are_those_of_a_mode_in_closed_form(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["sweep", "mode.toml", "--samples", "39", "--seed", "3", "--processes", "1"]
    assert main(words) == 0
    message = capsys.readouterr().out
    K2, m = rows(39, seed=3).T
    rate = np.sqrt(K2 / m * (2 - np.sqrt(2)))
    found = load_run("mode_samples.nc")
    for place, t in enumerate((0.0, 2.0, 5.0)):
        exact = np.sort(0.2 * np.cos(rate * t))
        interval = found["sensor_displacement_interval"].values[:, place, 0]
        np.testing.assert_allclose(interval, exact[[0, 19, 38]], atol=1e-7)
    ends = np.sort(0.2 * rate * np.sin(2.0 * rate))
    half = (ends[-1] - ends[0]) / 2
    line = f"cell 1: largest velocity {ends[19]:.4f} +- {half:.2g} (data) +- "
    assert line in message
    assert "(reduction)" not in message
    assert message.count("(numerics)") == 4
    energy = np.sort(0.5 * K2 * 0.04 * (2 - np.sqrt(2)) * 2)
    assert f"mode energy 1 {energy[19]:.4f} +- {(energy[-1] - energy[0]) / 2:.2g} (data)" in message
    again = found.attrs["sweep"]
    assert main(words) == 0
    assert "were run now" not in capsys.readouterr().out
    assert load_run("mode_samples.nc").attrs["sweep"] == again


@pytest.mark.slow
def test_the_error_of_theory_is_a_part_of_the_interval(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["sweep", "wave.toml", "--samples", "39", "--processes", "1"]) == 0
    [line] = [line for line in capsys.readouterr().out.splitlines() if line.startswith("crest")]
    found = load_run("wave_samples.nc")
    low, middle, high = np.abs(found["strain_interval"].values[:, -1]).max(axis=1)
    value, data, reduction, numerics = (float(part.split()[0]) for part in line[6:].split("+-"))
    assert value == pytest.approx(middle, rel=0.02)
    assert data == pytest.approx((high - low) / 2, rel=0.2)
    apart = np.abs(found["strain_interval"] - found["analytic_interval"]).values[:, -1]
    assert 0.05 * apart.max() < reduction < 2.0 * apart.max()
    assert numerics == pytest.approx(found["error_estimate"].values.max() * 0.09, rel=0.05)


def test_the_crest_is_measured_from_the_background_at_the_last_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The wave falls from 1.5 to 0.5 on a background of 2; theory is 0.1 too low at sample 3."""
    sweep = sampled_sweep("wave.toml", MIN_SAMPLES)
    wave = np.zeros((MIN_SAMPLES, 2, 5))
    wave[:, 0, 1], wave[:, 1, 3] = 1.5, -0.5
    theory = wave.copy()
    theory[3, 1, 3] = -0.4
    data = {
        name: (("sample", "time", "site"), values)
        for name, values in (
            ("strain", wave + 2),
            ("analytic", theory + 2),
            ("background", 0 * wave + 2),
        )
    }
    status = ("sample", np.array(["refused"] + ["done"] * (MIN_SAMPLES - 1), dtype=object))
    estimates = ("sample", np.where(np.arange(MIN_SAMPLES) == 5, 4e-6, 1e-6))
    found = xr.Dataset({**data, "status": status, "error_estimate": estimates})
    monkeypatch.setattr(sweep_dataset, "cell_run", lambda *_, **__: xr.Dataset(attrs={"power": 2}))
    [crest] = room.observed_numbers(sweep, RunStore("none"), found)
    np.testing.assert_allclose(crest.samples, 0.5)
    assert crest.reduction == pytest.approx(0.1)
    assert crest.numerics == pytest.approx(4e-6 * 0.3**2)


def test_an_interval_is_printed_with_its_parts() -> None:
    samples = np.linspace(0.0, 2.0, 39)
    assert ObservedNumber("crest", samples).text() == "crest 1.0 +- 1 (data)"
    parts = ObservedNumber("crest", 1e-3 * samples + 1, 3e-4, 1e-8)
    assert parts.text() == (
        "crest 1.0010 +- 0.001 (data) +- 0.0003 (reduction) +- 1e-08 (numerics)"
    )
    some = np.where(np.arange(39) < 3, np.nan, samples)
    assert ObservedNumber("crest", some).ends[1] == pytest.approx(np.median(samples[3:]))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["mode.toml", "--samples", "38"], "samples must be 39 to 1000000, got 38"),
        (["mode.toml", "--seed", "1"], "--seed must be given with --samples, got 1"),
        (["toda_soliton", "--samples", "40"], "constants with a covariance from its lattice file"),
        (["none.toml", "--samples", "40"], "got none.toml"),
    ],
)
def test_a_scene_without_covariance_is_a_one_line_error(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sweep", *words]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not list(Path().glob("*.nc"))


@pytest.mark.slow
def test_a_sample_without_a_run_is_left_out(tmp_path: Path) -> None:
    Path("chain.toml").write_text(CHAIN.replace("0.0025", "2.25").replace("0.004", "0"))
    assert main(["sweep", "mode.toml", "--samples", "39", "--processes", "1"]) == 1
    with xr.open_dataset("mode_samples.nc") as found:
        refused = found["status"].values == "refused"
        assert np.isfinite(found["sensor_velocity_interval"]).all()
    negative = rows(39)[:, 0] <= 0
    assert negative.any()
    assert refused[negative].all()
    assert refused.sum() < 20
