"""A user's own solutions.py, verify.py or derive.py does not get in the way of longwave."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from longwave.rooms import ROOMS

HOUSE = Path(__file__).parents[2]
USE = "import longwave; print(longwave.closed_form('kink').name, longwave.Verdict.__name__)"


def python(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Python in the folder, which comes first on the path, the house after it."""
    environment = os.environ | {"PYTHONPATH": str(HOUSE)}
    return subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def shadowed(tmp_path: Path) -> Path:
    """A working folder with a file of every room's name; none of them may be run."""
    for room in ROOMS:
        (tmp_path / f"{room}.py").write_text("raise SystemExit('by mistake')", encoding="utf-8")
    return tmp_path


def test_a_script_beside_them_works_and_is_warned(shadowed: Path) -> None:
    (shadowed / "script.py").write_text(USE, encoding="utf-8")
    done = python(shadowed, "script.py")
    assert done.stdout == "kink Verdict\n", done.stderr
    for room in ROOMS:
        assert f"{room}.py has the name of a package of longwave" in done.stderr


@pytest.mark.parametrize("word", ["derive", "verify", "run", "report"])
def test_the_command_beside_them_works(shadowed: Path, word: str) -> None:
    done = python(shadowed, "-m", "longwave", word, "--help")
    assert done.returncode == 0
    assert done.stdout.startswith(f"Usage: longwave {word} ")


def test_a_folder_of_that_name_is_no_obstacle(tmp_path: Path) -> None:
    (tmp_path / "solutions").mkdir()
    (tmp_path / "solutions" / "__init__.py").write_text("raise SystemExit('by mistake')")
    assert python(tmp_path, "-c", USE).stdout == "kink Verdict\n"


def test_one_imported_before_is_named_in_one_line(tmp_path: Path) -> None:
    own = tmp_path / "solutions.py"
    own.write_text("answer = 42\n", encoding="utf-8")
    done = python(tmp_path, "-c", f"import solutions; {USE}")
    last = done.stderr.splitlines()[-1]
    assert last.startswith("ImportError: solutions must be longwave's own package, got ")
    assert str(own) in last


def test_nothing_is_said_where_nothing_is_in_the_way(tmp_path: Path) -> None:
    code = f"import sys; old = list(sys.meta_path); {USE}; assert old == sys.meta_path"
    done = python(tmp_path, "-W", "error", "-c", code)
    assert (done.stdout, done.stderr) == ("kink Verdict\n", "")


@pytest.mark.parametrize("room", ["runs", "reports"])
def test_a_folder_of_results_is_passed_over_in_silence(tmp_path: Path, room: str) -> None:
    (tmp_path / room / "ab").mkdir(parents=True)
    (tmp_path / room / "run.nc").touch()
    done = python(tmp_path, "-W", "error", "-c", f"{USE}; import {room}; print({room}.__file__)")
    assert done.stderr == ""
    assert done.stdout.splitlines()[1].startswith(str(Path(__file__).parents[2]))
