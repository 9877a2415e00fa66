"""`--output` and `check`: certificates are written, accepted, or rejected in one line."""

import json
import random
import re
from pathlib import Path

import pytest

from longwave.__main__ import main as longwave
from longwave.verify.__main__ import main

Output = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("certificates") / "two.json"
    assert main(["--only", "kink", "--only", "wave_cn", "--output", str(path)]) == 0
    return path.read_text(encoding="utf-8")


def rejected(text: str, folder: Path, capsys: Output) -> str:
    """Return the line on stderr."""
    path = folder / "changed.json"
    path.write_text(text, encoding="utf-8")
    assert longwave(["check", str(path)]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith(f"{path}: rejected: ")
    return error


def test_a_written_certificate_is_accepted(written: str, tmp_path: Path, capsys: Output) -> None:
    path = tmp_path / "c.json"
    path.write_text(written)
    assert longwave(["check", str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if line.endswith(": accepted")] == [
        "kink: accepted",
        "wave_cn: accepted",
    ]
    assert lines[0] == "kink:"
    assert lines[1].startswith("    equation: ")
    assert lines[2] == "    solution: U = A*tanh(X*A*a + 1/12*T*c*A**3*a**3)"
    assert lines[3].startswith("    for all real A, T, X, a, c with A: 0 < A")


def test_a_single_certificate_is_accepted_too(written: str, tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    path.write_text(json.dumps(json.loads(written)[0]))
    assert longwave(["check", str(path)]) == 0


@pytest.mark.slow
def test_one_digit_changed_is_rejected(written: str, tmp_path: Path, capsys: Output) -> None:
    draw = random.Random(1)
    for match in draw.sample(list(re.finditer(r"[0-9]", written)), 10):
        other = draw.choice([d for d in "0123456789" if d != match.group()])
        rejected(written[: match.start()] + other + written[match.end() :], tmp_path, capsys)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda text: text[: len(text) // 2], "not JSON"),
        (lambda text: "", "not JSON"),
        (lambda text: "kink: proved", "not JSON"),
        (lambda text: "[" * 100_000, "not JSON"),
        (lambda text: "[]", "no certificate"),
        (lambda text: "[3]", "certificate must be an object, got int"),
        (lambda text: '"yes"', "certificate must be an object, got str"),
        (lambda text: "{}", "lacks 'format'"),
        (lambda text: text.replace("longwave proof 4", "longwave proof 3"), "format must be"),
        (lambda text: text.replace('"solutions"', '"solution"'), "kink: the digest does not"),
    ],
)
def test_damage_is_told_in_one_line(
    damage: object, message: str, written: str, tmp_path: Path, capsys: Output
) -> None:
    assert callable(damage)
    assert message in rejected(damage(written), tmp_path, capsys)


def test_binary_is_no_certificate(tmp_path: Path, capsys: Output) -> None:
    path = tmp_path / "c.json"
    path.write_bytes(b"\xff\xfe\x00\x01")
    assert longwave(["check", str(path)]) == 1
    assert "must be a text in UTF-8" in capsys.readouterr().err


def test_an_input_file_is_not_overwritten(
    tmp_path: Path, capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("p.toml").write_text(
        '[[problem]]\nequation = "u_t + u_x"\nsolution = "u = x - t"\n', encoding="utf-8"
    )
    assert longwave(["prove", "p.toml", "--output", "p.json"]) == 0
    before = {name: Path(name).read_bytes() for name in ("p.toml", "p.json")}
    for words in (
        "prove p.toml --output ./p.toml",
        "prove p.toml --export pari --output p.toml",
        "check p.json --export pari --output p.json",
    ):
        for force in ([], ["--force"]):
            assert longwave([*words.split(), *force]) == 2
            assert "must not be an input file, got " in capsys.readouterr().err
    assert before == {name: Path(name).read_bytes() for name in before}
