"""``longwave orbit``: verdicts, numbers with errors, and certificates."""

import json
from pathlib import Path

import pytest

from longwave.__main__ import main

CHAIN = ["orbit", "alpha_fput", "--set", "K2=1,K3=1/5", "--sites", "2"]


def test_an_orbit_is_printed_written_and_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "o.json"
    words = [*CHAIN, "--energy", "1/10", "--certificate", str(path), "--digits", "12"]
    assert main(words) == 0
    text = capsys.readouterr().out
    assert text.startswith("EXISTS: The chain of 2 unit masses with V'(r) = r**2/5 + r")
    assert "  period                  6.28107343380 +- " in text
    assert "  multiplier 1 imaginary  " in text
    assert main(["check", str(path)]) == 0
    assert "orbit: accepted" in capsys.readouterr().out
    data = json.loads(path.read_text(encoding="utf-8"))
    data["claims"]["period"] = ["6.2", "6.21"]
    path.write_text(json.dumps(data), encoding="utf-8")
    assert main(["check", str(path)]) == 1
    assert "claim period is not proved" in capsys.readouterr().err
    assert main(words) == 2
    assert "--force" in capsys.readouterr().err


def test_json_has_the_ends_of_every_number(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*CHAIN, "--mode", "2", "--energy", "1/10", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["verdict"] == "EXISTS"
    for name in ("period", "energy", "amplitude"):
        assert float(data[name]["lower"]) <= float(data[name]["upper"])
    (multiplier,) = data["multipliers"]
    assert float(multiplier["imaginary"]["lower"]) > 0


def test_a_breather(capsys: pytest.CaptureFixture[str]) -> None:
    chain = ["orbit", "klein_gordon", "--set", "K2=2/25,g1=1,g2=0,g3=1"]
    assert main([*chain, "--frequency", "8/5"]) == 0
    text = capsys.readouterr().out
    assert "has a breather" in text
    assert "  amplitude  1.377751273481742 +- " in text
    assert main([*chain, "--frequency", "11/10"]) == 1
    assert "REFUSED: harmonic 1 of the frequency 1.1 is resonant" in capsys.readouterr().out
