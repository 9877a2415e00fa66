"""``longwave wave``: verdicts, numbers, certificates; mistakes at it and ``longwave orbit``."""

import json
from pathlib import Path

import pytest

from longwave.__main__ import main

CHAIN = ["wave", "fput_strain", "--set", "K2=1,K3=0,K4=1"]
ORBIT = ["orbit", "alpha_fput", "--set", "K2=1,K3=1/5", "--sites", "2"]
NEAR = ["--near", "wave_dn", "--k", "3/5", "--eps", "2/25"]


def test_a_wave_is_printed_written_and_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "w.json"
    assert main([*CHAIN, *NEAR, "--certificate", str(path), "--digits", "12"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("EXISTS: The chain of unit masses")
    assert "speed     1.00256126177 +- 3.4e-12" in text
    assert main(["check", str(path)]) == 0
    assert "periodic: accepted" in capsys.readouterr().out
    assert main([*CHAIN, *NEAR, "--certificate", str(path)]) == 2
    assert "--force" in capsys.readouterr().err


def test_a_changed_certificate_is_rejected_by_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "w.json"
    assert main([*CHAIN, *NEAR, "--certificate", str(path)]) == 0
    data = json.loads(path.read_text(encoding="utf-8"))
    data["claims"]["speed"] = ["1.1", "1.2"]
    path.write_text(json.dumps(data), encoding="utf-8")
    assert main(["check", str(path)]) == 1
    assert "claim speed is not proved" in capsys.readouterr().err


def test_json_has_the_ends_of_every_number(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--near", "cn", "--k", "3/5", "--eps", "3/25", "--stability", "1/4", "--json"]
    assert main([*CHAIN, *words]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["verdict"] == "EXISTS"
    for name in ("speed", "crest", "energy", "distance"):
        assert float(data[name]["lower"]) <= float(data[name]["upper"])
    (exponent,) = data["exponents"]
    assert exponent["bloch"] == "1/4"
    assert float(exponent["growth"]["lower"]) > 3.317e-4


@pytest.mark.slow
def test_all_small_eps(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*CHAIN, "--near", "dn", "--k", "3/5", "--every-eps-to", "1/10"]) == 0
    assert "For every 0 < eps <= 1/10" in capsys.readouterr().out


def test_json_of_all_small_eps_has_no_radius(capsys: pytest.CaptureFixture[str]) -> None:
    """Catches a KeyError: a tie has a radius for each piece, and none for all."""
    words = ["wave", "alpha_fput", "--set", "K2=1,K3=1", "--near", "soliton"]
    assert main([*words, "--every-eps-to", "1/50", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert [*data] == ["verdict", "reason", "distance_over_eps4"]


def test_a_ring_is_printed_written_and_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "w.json"
    words = [*CHAIN, "--near", "dn", "--k", "3/5", "--period", "10", "--ring", "2"]
    assert main([*words, "--certificate", str(path)]) == 0
    assert "  ring of 2 wavelengths  STABLE, proved" in capsys.readouterr().out
    assert main(["check", str(path)]) == 0
    assert "ring: accepted" in capsys.readouterr().out
    assert main([*words, "--json"]) == 0
    ring = json.loads(capsys.readouterr().out)["ring"]
    assert ring["verdict"] == "STABLE"
    assert ring["growth"] == {"lower": "0", "upper": "0"}


def test_a_soliton_of_all_small_eps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, words = tmp_path / "w.json", ["wave", "alpha_fput", "--set", "K2=1,K3=1"]
    words += ["--near", "kdv_soliton", "--every-eps-to", "1/50", "--certificate", str(path)]
    assert main(words) == 0
    text = capsys.readouterr().out
    assert "For every 0 < eps <= 1/50" in text
    assert "distance_over_eps4  0.92" in text
    assert main(["check", str(path)]) == 0
    assert "line_tie: accepted" in capsys.readouterr().out
    assert main([*words, "--k", "1/2", "--force"]) == 2
    assert "a soliton has none" in capsys.readouterr().err


def test_what_is_not_proved_has_status_1(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["wave", "alpha_fput", "--set", "K2=1,K3=1", "--speed", "1/2"]
    assert main(words) == 1
    assert "NOT PROVED: speed must be above the speed of sound" in capsys.readouterr().out
    dimer = ["wave", "mass_dimer", "--set", "K2=1,K3=0,K4=1,m1=1,m2=2", "--speed", "2"]
    assert main(dimer) == 1
    assert "REFUSED: the lattice must have one field" in capsys.readouterr().out


MISTAKES = [
    ([*CHAIN], "one of near, period and speed must be given"),
    ([*CHAIN, "--near", "dn", "--k", "3/5"], "eps"),
    ([*CHAIN, "--period", "x", "--first-mode", "1"], "period"),
    ([*CHAIN, "--period", "12"], "first_mode must not be 0"),
    (["wave", "fput_strain", "--speed", "2"], "constants must have values"),
    (["wave", "nolattice", "--speed", "2"], "MODEL must be a lattice"),
    ([*CHAIN, "--near", "dn", "--k", "3/5", "--every-eps-to", "1/10", "--eps", "1"], "--eps"),
    ([*CHAIN, "--near", "kn", "--k", "3/5", "--eps", "1/10"], "near must be one of dn, cn, sn"),
    ([*CHAIN, *NEAR, "--digits", "1"], "--digits"),
    ([*CHAIN, *NEAR, "--ring", "8"], "a ring needs a wave whose period is an integer"),
    ([*ORBIT[:4]], "one of sites and frequency must be given"),
    ([*ORBIT], "energy must be positive"),
    ([*ORBIT, "--energy", "x"], "energy"),
    ([*ORBIT, "--energy", "1", "--mode", "3"], "mode must be from 1 to the number of sites"),
    (["orbit", "alpha_fput", "--sites", "3", "--energy", "1"], "constants must have values"),
]


@pytest.mark.parametrize(("words", "message"), MISTAKES)
def test_mistakes_are_answered_in_one_line(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
