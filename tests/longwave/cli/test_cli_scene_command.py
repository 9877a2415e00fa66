"""Catches: tracebacks at the command line, wrong exit statuses, files that cannot be read back."""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from longwave.__main__ import main

SHORT = """
title = "A short run"
wave = "soliton_dn"
eps = 0.05
t0 = -10
snapshots = [-10, 10]
curve_points = 5
[lattice]
K2 = 1
K4 = 1
[parameters]
k = 0.7
[scheme]
step = 0.5
[domain]
kind = "ring"
sites = 512
compared = 100
"""


@pytest.fixture
def short(tmp_path: Path) -> Path:
    path = tmp_path / "short.toml"
    path.write_text(SHORT)
    return path


def test_summary_and_file(short: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "run.nc"
    assert main(["run", str(short), "--output", str(output)]) == 0
    out = capsys.readouterr().out
    for expected in (
        "A short run",
        "relative error",
        "kahan_li_8: 40 steps, 512 sites",
        "-10",
        "stable",
    ):
        assert expected in out
    with xr.open_dataset(output) as read:
        assert read.strain.shape == (2, 201)
        assert np.array_equal(read.time, [-10.0, 10.0])
        assert "soliton_dn" in read.attrs["scene"]
        assert read.attrs["trust_rate"] == 0.0
        assert read.attrs["trust_horizon"] == np.inf


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("k = 0.7", "k = 1.2", "k must satisfy 0 < k < 1, got 1.2"),
        ("step = 0.5", "step = 5", "step must satisfy step <= "),
        ("K4 = 1", "K4 = -1", "K4 must satisfy K4 > 0"),
        ("K4 = 1", "K4 = 1" + "0" * 400, "|K4| <= 1e+50, got an integer of 1329 bits (such as 1)"),
        ("K4 = 1", "K4 = 1e-300", "1e-50 <= |K4|"),
        ("eps = 0.05", "eps = -0.05", "eps must satisfy eps > 0, got -0.05 (such as 0.05)"),
        ("eps = 0.05", "eps = true", "eps must be a number, got True (such as 0.05)"),
        ("k = 0.7", 'k = "1/2;import os"', "k: expected an operator or the end, got ';'"),
        ("step = 0.5", "step = 1e-40", "more than 1e+10 steps"),
        ("sites = 512", "sites = 9999999999999", "1 <= sites <= 1e+09"),
        ('kind = "ring"', "kind = 3", "domain must be a text, got 3 (write it in quotes)"),
        ("-10, 10]", "1e300]", "|snapshots| <= 1e+50"),
        ("soliton_dn", "[red]", "[red]"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    short: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, expected: str
) -> None:
    short.write_text(SHORT.replace(old, new))
    assert main(["run", str(short)]) == 2
    captured = capsys.readouterr()
    lines = [line for line in captured.err.splitlines() if "error:" in line]
    assert captured.out == ""
    assert len(lines) == 1
    assert expected in lines[0]


def test_an_unknown_scene_lists_the_shipped_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "nowhere"]) == 2
    assert "breather_sn_k_0.5" in capsys.readouterr().err


def test_an_output_in_no_folder_is_refused_before_the_run(
    short: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", str(short), "--output", "/nonexistent/run.nc"]) == 2
    assert "--output must lie in an existing folder" in capsys.readouterr().err


def test_a_tolerance_and_an_engine_on_the_command_line(
    short: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", str(short), "--tolerance", "1e-3", "--engine", "stencil"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "stencil, reduced_phase_6: " in out
    assert re.search(r"error estimate \S+ of 0.001 allowed, planned in .* times as long", out)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--tolerance", "0"], "tolerance must satisfy tolerance > 0, got 0"),
        (["--engine", "spectral"], "tolerance must be given for engine 'spectral'"),
        (["--tolerance", "1e-3", "--engine", "steam"], "got 'steam' (one of stencil, spectral)"),
    ],
)
def test_bad_options_are_one_line_and_status_2(
    short: Path, capsys: pytest.CaptureFixture[str], words: list[str], expected: str
) -> None:
    assert main(["run", str(short), *words]) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if line]
    assert len(lines) == 1
    assert expected in lines[0]


def test_a_file_with_step_and_tolerance_is_refused(
    short: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short.write_text("tolerance = 1e-4\n" + SHORT)
    assert main(["run", str(short)]) == 2
    assert "step must not be given with a tolerance" in capsys.readouterr().err
