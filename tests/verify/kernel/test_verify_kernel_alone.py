"""The kernel by itself: what it imports, what the page on trust says, and a run of its folder."""

import ast
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from solutions import closed_form
from verify.proof import prove_form

HOUSE = Path(__file__).parents[3]
KERNEL = HOUSE / "verify" / "kernel"
FILES = sorted(KERNEL.glob("*.py"))


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            stem = "." * node.level + (node.module or "")
            found |= {stem} if node.module else {f".{alias.name}" for alias in node.names}
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_kernel_imports_the_standard_library_and_flint_alone(path: Path) -> None:
    own = {f".{other.stem}" for other in FILES}
    for name in imports(path):
        assert name in own or name.split(".")[0] in {*sys.stdlib_module_names, "flint"}, name


def test_the_page_on_trust_counts_the_lines() -> None:
    lines = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in FILES)
    page = (HOUSE / "docs" / "trust.md").read_text(encoding="utf-8")
    (stated,) = re.findall(r"([0-9]+) lines of our own", page)
    assert abs(int(stated) - lines) <= 50, f"docs/trust.md should say {lines}"


def alone(folder: Path, text: str) -> subprocess.CompletedProcess[str]:
    """``python -m kernel FILE`` in a folder with nothing else."""
    shutil.copytree(KERNEL, folder / "kernel")
    (folder / "proof.json").write_text(text, encoding="utf-8")
    command = [sys.executable, "-P", "-c", RUN, "proof.json"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


RUN = """
import runpy, sys
sys.path = ["."] + [p for p in sys.path if "site-packages" in p or "lib" in p]
sys.meta_path = [f for f in sys.meta_path if "editable" not in repr(f)]
runpy.run_module("kernel", run_name="__main__", alter_sys=True)
"""


def test_the_folder_alone_repeats_a_proof(tmp_path: Path) -> None:
    certificate = prove_form(closed_form("kink")).certificate
    assert certificate is not None
    done = alone(tmp_path, json.dumps([certificate]))
    assert done.returncode == 0, done.stderr
    typed = certificate["statement"]
    assert typed["equations"][0] in done.stdout
    assert typed["solutions"][0] in done.stdout
    assert done.stdout.endswith("accepted\n")


@pytest.mark.parametrize(
    ("text", "status", "words"),
    [("[", 1, "no JSON text"), ("{}", 1, "lacks"), ("[3]", 1, "must be an object")],
)
def test_the_folder_alone_refuses(tmp_path: Path, text: str, status: int, words: str) -> None:
    done = alone(tmp_path, text)
    assert (done.returncode, done.stdout) == (status, "")
    assert words in done.stderr
