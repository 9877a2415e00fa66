"""Linear chains: their branches against hand calculations and an eigenproblem in NumPy."""

import json
from typing import Any

import numpy as np
import pytest
from sympy import cos, simplify, sqrt

from longwave.derive.__main__ import main
from longwave.derive.lattice_file import lattice_of
from longwave.derive.linear_waves import LinearWaves
from longwave.derive.symbols import k
from searches.carriers import omegas, random_case

TWO_SPRINGS = (
    'fields = ["u", "v"]\nmasses = ["1", "1"]\npositive = ["C"]\n'
    '[[spring]]\nbetween = ["u[n]", "v[n]"]\nforce = "C*x"\n'
    '[[spring]]\nbetween = ["v[n]", "u[n+1]"]\nforce = "5*C*x"\n'
)


@pytest.fixture
def chain(tmp_path: Any) -> str:
    """Write the file of a chain with two equal masses and springs C and 5 C; return its path."""
    path = tmp_path / "textbook.toml"
    path.write_text(TWO_SPRINGS)
    return str(path)


def test_a_linear_lattice_prints_its_dispersion_relation(
    chain: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Catches: "its waves are in the dispersion relation alone", which is not shown."""
    assert main([chain]) == 0
    output = capsys.readouterr().out
    assert output.startswith("textbook\n")
    assert "  omega^2 = 6 C - C sqrt(36 - 20 sin(k/2)^2)\n" in output
    assert main([chain, "--latex"]) == 0
    assert r"\omega^{2} = 6 C + C \sqrt{36" in capsys.readouterr().out
    assert main([chain, "--json", "--set", "C=1"]) == 0
    found = json.loads(capsys.readouterr().out)
    first, last = found["waves"][0], found["waves"][-1]
    assert [row[0] for row in first[1]] == pytest.approx([0, 12**0.5], abs=1e-12)
    assert first[1][0][1] == pytest.approx((5 / 12) ** 0.5, rel=1e-12)
    assert [row[0] for row in last[1]] == pytest.approx([2**0.5, 10**0.5], rel=1e-12)
    assert [row[1] for row in last[1]] == pytest.approx([0, 0], abs=1e-12)
    assert main([chain, "--set", "C=1"]) == 0
    assert "3.16227766" in capsys.readouterr().out


def test_the_branches_are_the_textbooks() -> None:
    [C] = (waves := LinearWaves.of(lattice_of(document()))).lattice.constants
    for sign, found in zip((-1, 1), waves.branches, strict=True):
        assert simplify(found - C * (6 + sign * sqrt(26 + 10 * cos(k)))) == 0


def document() -> dict[str, Any]:
    """Return the tables of the same chain."""
    springs = [("u[n]", "v[n]", "C*x"), ("v[n]", "u[n+1]", "5*C*x")]
    return {
        "fields": ["u", "v"],
        "positive": ["C"],
        "spring": [{"between": [a, b], "force": force} for a, b, force in springs],
    }


def test_an_envelope_of_a_linear_lattice_is_linear(
    chain: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([chain, "--envelope", "k=pi", "--set", "C=1", "--branch", "optical"]) == 0
    output = capsys.readouterr().out
    assert "  omega = 3.16227766017\n" in output
    assert "q = 0: waves do not interact" in output


@pytest.mark.parametrize("words", [["--set", "D=1"], ["--set", "C=-1"], ["--set", "C=eps"]])
def test_wrong_constants_are_refused_in_one_line(
    chain: str, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([chain, *words]) == 2
    assert capsys.readouterr().err.startswith("error: ")


@pytest.mark.parametrize("seed", range(5))
def test_random_chains_have_the_frequencies_of_an_eigenproblem(seed: int) -> None:
    """Catches: a sign, a branch out of order, a velocity of another branch."""
    case = random_case(seed)
    rows = LinearWaves.of(case.lattice).table(case.constants)
    for at, found in rows:
        expected = omegas(case, float(at))
        assert [own for own, _ in found] == pytest.approx(list(expected), abs=1e-6)
        slopes = (omegas(case, float(at) + 1e-5) - omegas(case, float(at) - 1e-5)) / 2e-5
        for (own, speed), slope in zip(found, slopes, strict=True):
            if own > 1e-3 and speed is not None and abs(expected[1] - expected[0]) > 1e-3:
                assert np.isclose(speed, slope, atol=1e-5)
