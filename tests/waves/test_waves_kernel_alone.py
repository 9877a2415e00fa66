"""The checker of waves stands alone: the standard library and FLINT, in a folder of its own."""

import ast
import json
import shutil
import subprocess
import sys
from pathlib import Path

from house import HOUSE
from longwave.derive import LATTICES
from longwave.waves.exact_wave import exact_wave

KERNEL = HOUSE / "waves" / "kernel"


def test_the_checker_imports_the_standard_library_and_flint_alone() -> None:
    for path in KERNEL.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names = {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names = {(node.module or "").partition(".")[0]}
            else:
                continue
            assert names <= {*sys.stdlib_module_names, "flint"}, path.name


def test_it_runs_with_nothing_beside_it(tmp_path: Path) -> None:
    shutil.copytree(KERNEL, tmp_path / "kernel")
    lattice = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 1, "K4": 0})
    wave = exact_wave(lattice, period=15, first_mode="1/50")
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    wave.save(good)
    bad.write_text(json.dumps({**wave.certificate, "speed_squared": "1.01"}), encoding="utf-8")
    for path, status, word in ((good, 0, "accepted"), (bad, 1, "rejected")):
        command = [sys.executable, "-m", "kernel", str(path)]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == status
        assert word in done.stdout + done.stderr
