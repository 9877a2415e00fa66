"""The command line: table, JSON, exit statuses, one-line errors, what it imports."""

import json
import subprocess
import sys
from dataclasses import replace

import pytest

import verify.check
from solutions.catalogue import CATALOGUE, closed_form
from verify.__main__ import main
from verify.residual import Sampling
from verify.verdict import Verdict

QUICK = ["--digits", "20,40", "--points", "2"]


def test_the_table_has_a_row_for_every_form(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(QUICK) == 0
    output = capsys.readouterr().out
    for form in CATALOGUE:
        assert form.name in output
    for heading in ("solution", "equation", "method", "verdict", "residual", "seconds"):
        assert heading in output
    assert f"3 proved exactly; {len(CATALOGUE) - 3} checked" in output


def test_only_selects_and_json_is_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*QUICK, "--only", "kink", "--only", "rational_1", "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert [record["name"] for record in records] == ["kink", "rational_1"]
    assert [record["outcome"] for record in records] == ["CHECKED", "PROVED"]


def test_the_seed_changes_the_points(capsys: pytest.CaptureFixture[str]) -> None:
    residuals = []
    for seed in ("1", "1", "2"):
        main([*QUICK, "--only", "wave_dn", "--json", "--seed", seed])
        residuals.append(json.loads(capsys.readouterr().out)[0]["residual"])
    assert residuals[0] == residuals[1] != residuals[2]


@pytest.mark.parametrize("form", ["kink", "rational_2"])
def test_a_wrong_form_gives_status_1_and_its_witness(
    form: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    right = closed_form(form)
    checker = verify.check.check

    def spoiled(given: object, sampling: Sampling) -> Verdict:
        return checker(replace(right, expression=right.expression + 1), sampling)

    monkeypatch.setattr(verify.check, "check", spoiled)
    assert main([*QUICK, "--only", form]) == 1
    output = capsys.readouterr().out
    assert "REFUTED" in output
    assert "witness: " in output


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--only", "peakon"], "'peakon' (one of rational_1, "),
        (["--digits", "30"], "digits must be two or more"),
        (["--digits", "30,x"], "digits must be integers with commas between, got '30,x'"),
        (["--points", "0"], "points must be at least 1, got 0"),
        (["--points", "many"], "invalid int value: 'many'"),
        (["--nonsense"], "unrecognized arguments: --nonsense"),
        (["walk"], "unrecognized arguments: walk"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    argv: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main(argv)
    output = capsys.readouterr()
    assert stop.value.code == 2
    assert output.out == ""
    assert output.err.count("\n") == 1
    assert message in output.err


def test_the_table_needs_no_lattice_engine() -> None:
    """numba and xarray take seconds to import and are for `run` alone."""
    script = (
        "import sys; from verify.__main__ import main; main(sys.argv[1:]);"
        "sys.exit(any(name in sys.modules for name in ('numba', 'xarray', 'matplotlib')))"
    )
    arguments = [*QUICK, "--only", "kink"]
    finished = subprocess.run(
        [sys.executable, "-c", script, *arguments], capture_output=True, text=True, check=False
    )
    assert finished.returncode == 0, finished.stderr
    assert "━" in finished.stdout
    assert finished.stderr == ""


def test_output_to_a_pipe_fits_one_row_a_form(capsys: pytest.CaptureFixture[str]) -> None:
    main([*QUICK, "--only", "breather_sn"])
    rows = [line for line in capsys.readouterr().out.splitlines() if "CHECKED" in line]
    assert len(rows) == 1
    assert "breather_sn" in rows[0]
    assert "residual at 20, 40 digits" in rows[0]
