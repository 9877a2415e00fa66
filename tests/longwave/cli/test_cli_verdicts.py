"""`longwave verify`: table, JSON, exit statuses, one-line errors, imports."""

import json
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import longwave.verify.proof.catalogue_proofs
from longwave.cli import verdicts as command
from longwave.solutions.catalogue import CATALOGUE, closed_form
from longwave.verify.__main__ import main
from longwave.verify.proof import prove_form
from longwave.verify.proof.catalogue_proofs import NAMES
from longwave.verify.verdict import Verdict

QUICK = ["--digits", "20,40", "--points", "2"]
Output = pytest.CaptureFixture[str]


def kinks(names: Iterable[str]) -> Iterator[Verdict]:
    """Return the proof of the kink under all the names."""
    verdict = prove_form(closed_form("kink"))
    yield from (replace(verdict, name=name) for name in names)


@pytest.mark.parametrize("proved", [kinks, pytest.param(None, marks=pytest.mark.slow)])
def test_by_default_every_form_is_proved(
    proved: Any, capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The prover's tests prove the forms; here the command requests and shows all of them."""
    if proved:
        monkeypatch.setattr(command, "prove_all", proved)
    assert main([]) == 0
    output = capsys.readouterr().out
    rows = [line for line in output.splitlines() if "PROVED" in line]
    assert [row.split()[1] for row in rows] == list(NAMES)
    for heading in ("solution", "equation", "method", "verdict", "evidence", "seconds"):
        assert heading in output
    assert f"{len(NAMES)} proved exactly" in output
    for form in CATALOGUE:
        assert any("bytes" in row for row in rows if form.name in row)


@pytest.mark.parametrize("options", [QUICK, ["--method", "residual", *QUICK]])
def test_a_residual_is_labelled_as_evidence(options: list[str], capsys: Output) -> None:
    assert main([*options, "--only", "kink", "--only", "rational_4"]) == 0
    output = capsys.readouterr().out
    assert "2 checked to the digits shown, which is no proof" in output
    assert "PROVED" not in output


def test_only_selects_forms_and_json_is_valid(capsys: Output) -> None:
    assert main(["--only", "kink", "--only", "rational_5", "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert [record["name"] for record in records] == ["kink", "rational_5"]
    assert [record["outcome"] for record in records] == ["PROVED", "PROVED"]
    assert records[0]["certificate_bytes"] > 0
    assert records[0]["assumptions"]


def test_stable_forms_are_proved_equal(capsys: Output) -> None:
    assert main(["--stable", "--only", "kink", "--only", "rational_2"]) == 0
    output = capsys.readouterr().out
    assert output.count("stable form = canonical form") == 2
    assert "2 stable forms" in output


def test_the_seed_changes_the_points(capsys: Output) -> None:
    residuals = []
    for seed in ("1", "1", "2"):
        main([*QUICK, "--only", "wave_dn", "--json", "--seed", seed])
        residuals.append(json.loads(capsys.readouterr().out)[0]["residual"])
    assert residuals[0] == residuals[1] != residuals[2]


@pytest.mark.parametrize("name", ["kink", "rational_2"])
def test_a_wrong_form_gives_status_1_and_its_witness(
    name: str, capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = closed_form(name)

    def spoiled(names: object) -> Iterator[Verdict]:
        yield prove_form(replace(right, expression=right.expression + 1))

    monkeypatch.setattr(command, "prove_all", spoiled)
    assert main(["--only", name]) == 1
    output = capsys.readouterr().out
    assert "REFUTED" in output
    assert "witness: " in output
    assert "excludes 0" in output


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--only", "peakon"], "'peakon' (one of rational_1, "),
        (["--only", "rational_0"], "'rational_0' (did you mean rational_"),
        (["--digits", "30"], "digits must be two or more"),
        (["--digits", "30,x"], "digits must be integers with commas between, got '30,x'"),
        (["--digits", "30,999999999999"], "from 15 to 10000"),
        (["--points", "0"], "points must satisfy 1 <= points <= 100000, got 0"),
        (["--points", "many"], "'many' is not a valid integer (see python -m verify --help)"),
        (["--method", "guess"], "invalid value for '--method': 'guess'"),
        (
            ["--method", "proof", "--digits", "30,50"],
            "--digits must not be given with",
        ),
        (["--seed", "1", "--stable"], "--stable must not be given with the method residual"),
        (
            ["--only", "kink", "--output", "/nowhere/x"],
            "must lie in an existing folder, got /nowhere/x",
        ),
        (["--nonsense"], "no such option"),
        (["walk"], "COMMAND must be a known one, got walk (one of recheck"),
        (["mutations", "--only", "peakon"], "'peakon' (one of rational_1, "),
    ],
)
def test_bad_input_is_one_line_and_status_2(argv: list[str], message: str, capsys: Output) -> None:
    assert main(argv) == 2
    output = capsys.readouterr()
    assert output.err.startswith("error: ")
    assert output.out == ""
    assert output.err.count("\n") == 1
    assert message in output.err


def test_an_unwritable_file_is_reported_before_any_proof(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: Output
) -> None:
    monkeypatch.setattr(
        command, "prove_all", lambda names: (pytest.fail("proved first") for _ in names)
    )
    assert main(["--output", str(tmp_path / "none" / "x.json")]) == 2
    assert "must lie in an existing folder" in capsys.readouterr().err


@pytest.mark.slow
def test_the_table_needs_no_lattice_engine() -> None:
    """Only `run` needs numba and xarray, which take seconds to import."""
    script = (
        "import sys; from longwave.verify.__main__ import main; main(sys.argv[1:]);"
        "sys.exit(any(name in sys.modules for name in ('numba', 'xarray', 'matplotlib')))"
    )
    finished = subprocess.run(
        [sys.executable, "-c", script, "--only", "kink"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert finished.returncode == 0, finished.stderr
    assert "━" in finished.stdout
    assert finished.stderr == ""


def test_output_to_a_pipe_fits_one_row_a_form(capsys: Output) -> None:
    main([*QUICK, "--only", "breather_sn"])
    rows = [line for line in capsys.readouterr().out.splitlines() if "CHECKED" in line]
    assert len(rows) == 1
    assert "breather_sn" in rows[0]
    assert "residual at 20, 40 digits" in rows[0]


def test_every_proof_has_a_certificate() -> None:
    assert longwave.verify.proof.catalogue_proofs.prove_named("rational_4").certificate is not None
    assert longwave.verify.proof.catalogue_proofs.prove_named("kink").certificate is not None
