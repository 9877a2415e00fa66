"""A user's own solutions.py, verify.py or derive.py does not get in the way of longwave."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

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


@pytest.fixture(params=["solutions", "verify", "derive", "reports"])
def shadow(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """A file of a room's name in the working folder, which nobody may run."""
    room = str(request.param)
    (tmp_path / f"{room}.py").write_text("raise SystemExit('run by mistake')\n", encoding="utf-8")
    return room


def test_a_script_beside_it_works_and_is_warned(shadow: str, tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(USE, encoding="utf-8")
    done = python(tmp_path, "script.py")
    assert done.stdout == "kink Verdict\n", done.stderr
    assert f"{shadow}.py has the name of a package of longwave" in done.stderr
    assert "rename" in done.stderr


@pytest.mark.parametrize("words", [["list"], ["derive", "--help"], ["run", "--help"]])
def test_the_command_beside_it_works(shadow: str, tmp_path: Path, words: list[str]) -> None:
    done = python(tmp_path, "-m", "longwave", *words)
    alone = python(HOUSE, "-m", "longwave", *words)
    assert (done.returncode, done.stdout) == (alone.returncode, alone.stdout)


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
