"""Catches: a fresh interpreter that imports from the current folder before the standard library."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.process_jobs import CLUSTER, POOL

HOUSE = Path(__file__).parents[2]

PLANTED = "open('{mark}', 'a').close()\n"


@pytest.mark.parametrize("name", ["pickle.py", "subprocess.py", "longwave/__init__.py"])
@pytest.mark.parametrize("code", [CLUSTER, POOL], ids=["cluster", "processes"])
def test_workers_run_no_files_of_their_folder(code: str, name: str, tmp_path: Path) -> None:
    folder, mark = tmp_path / "folder", tmp_path / "mark"
    planted = folder / name
    planted.parent.mkdir(parents=True)
    planted.write_text(PLANTED.format(mark=mark))
    script = tmp_path / "script.py"
    script.write_text(code)
    done = subprocess.run(
        [sys.executable, str(script)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(HOUSE)},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert "4" in done.stdout, done.stderr
    assert not mark.exists()
