"""A user's own lattice.py, solutions.py or runs/ does not conflict with longwave."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from house import HOUSE, ROOMS
from tests.families import family

USE = "import longwave; print(longwave.closed_form('kink').name, longwave.Verdict.__name__)"
OWN = f"import {', '.join(ROOMS[:-1])}; print({' + '.join(f'{room}.OWN' for room in ROOMS[:-1])})"


def python(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run Python in the folder, which comes first on the path, before the repository."""
    environment = os.environ | {"PYTHONPATH": str(HOUSE)}
    return subprocess.run(
        [sys.executable, "-W", "error", *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(params=family(["{}.py", "{}/__init__.py"], quick=("{}.py",)))
def shadowed(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    """Create a working folder with a file, or a package, of every room's name."""
    for room in ROOMS[:-1]:
        path = tmp_path / request.param.format(room)
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"OWN = '{room[0]}'", encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("code", [f"{OWN}\n{USE}", f"{USE}\n{OWN}"], ids=["before", "after"])
def test_both_are_imported(shadowed: Path, code: str) -> None:
    (shadowed / "script.py").write_text(code, encoding="utf-8")
    done = python(shadowed, "script.py")
    own = "".join(room[0] for room in ROOMS[:-1])
    assert sorted(done.stdout.splitlines()) == sorted([own, "kink Verdict"]), done.stderr
    assert done.stderr == ""


@pytest.mark.parametrize("word", ["derive", "verify", "run", "report"])
def test_the_command_beside_them_works(shadowed: Path, word: str) -> None:
    done = python(shadowed, "-m", "longwave", word, "--help")
    assert done.returncode == 0
    assert done.stdout.startswith(f"Usage: longwave {word} ")
