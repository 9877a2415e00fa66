"""Catches: a request that starts though it takes days or terabytes; Ctrl-C without effect."""

import random
from pathlib import Path
from typing import Any

import pytest

from longwave.__main__ import main

SCENE = """
wave = "soliton_sech"
eps = 0.05
{top}
[parameters]
A = 1
[lattice]
K2 = {K2}
K4 = 1
[scheme]
step = {step}
[domain]
kind = "ring"
sites = {sites}
compared = {compared}
"""
USUAL: dict[str, Any] = {
    "t0": 0,
    "snapshots": "[10]",
    "observables": '["strain"]',
    "K2": 1,
    "step": 0.5,
    "sites": 4096,
    "compared": 100,
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sites": 500_000_000}, "must fit"),
        ({"observables": '["error_curve"]', "curve_points": 10**9}, "must fit"),
        ({"observables": '["crest_track"]', "look_points": 10**9}, "must fit"),
        ({"step": 1e-7, "snapshots": "[900]"}, "must take at most 60 min, got about"),
        ({"t0": -1e9}, "must take at most 60 min, got about"),
        ({"compared": 10**9, "sites": 10**9}, "must fit"),
        ({"snapshots": "[1e49]", "step": 1e44}, "sites cannot be told apart"),
        ({"K2": 1e40}, "sites cannot be told apart"),
    ],
)
def test_an_expensive_request_is_refused_before_it_starts(
    changes: dict[str, Any], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = USUAL | changes
    tops = ("t0", "snapshots", "observables", "curve_points", "look_points")
    top = "\n".join(f"{key} = {given[key]}" for key in tops if key in given)
    path = tmp_path / "hostile.toml"
    path.write_text(SCENE.format(top=top, **given))
    assert main(["run", str(path)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert message in error


def test_a_limit_is_raised_and_lowered_by_an_option(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "rogue_cn_k_0.5_long", "--max-time", "0.5s"]) == 2
    assert "must take at most 0.5 s, got about" in capsys.readouterr().err
    assert main(["run", "dimer_peregrine", "--max-memory", "100M"]) == 2
    assert "must fit 100 MB, got about" in capsys.readouterr().err
    assert main(["verify", "--only", "rational_99"]) == 2
    assert "must take at most 60 min, got about" in capsys.readouterr().err


COMMANDS = (
    "run rogue_cn_k_0.5_long",
    "run dimer_peregrine",
    "plot rogue_cn_k_0.5_long",
    "converge toda_soliton",
    "verify --only rational_12",
    "derive mass_dimer",
    "verify accuracy",
    "verify mutations",
    "verify recheck",
    "list",
    "doctor",
)


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_ctrl_c_at_any_moment_is_one_line(command: str, tmp_path: Path, interrupt: Any) -> None:
    moment = random.Random(command).uniform(0.4, 3.0)
    done = interrupt(["longwave", *command.split()], moment, tmp_path)
    if done is None:
        return  # it had ended
    assert done.seconds < 4.0  # two, and as much for a loaded machine
    if done.status == 0 and done.seconds < 1.0:
        return  # it had done its work, and was ending
    assert done.status == 130, done.errors
    output = [line for line in done.errors.splitlines() if "interrupted" in line]
    others = [line for line in done.errors.splitlines() if "(Ctrl-C stops it)" not in line]
    assert [line for line in others if not line.startswith("measuring ")] == output
    assert len(output) == 1


@pytest.mark.slow
def test_a_derivation_of_hours_is_refused_before_it_starts(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["derive", "dimer", "--order", "13"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: derivation of dimer must take at most 60 min, got about ")
    assert "(take a lower --order, or a FILE.toml" in error
    assert main(["derive", "dimer", "--envelope", "k", "--max-time", "30s"]) == 2
    error = capsys.readouterr().err
    assert error.splitlines()[-1].startswith("error: formulas must have at most 2500 terms, got ")
    assert "(give numbers for some of H2, H3, H4, K2, K3, K4, m1, m2, such as H2=1)" in error
