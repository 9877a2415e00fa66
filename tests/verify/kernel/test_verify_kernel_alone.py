"""The kernel by itself: what it imports, what the page on trust says, and a run of its folder."""

import ast
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from longwave.solutions import closed_form
from longwave.verify.proof import prove_form
from tests.test_house import lines_of_code

HOUSE = Path(__file__).parents[3]
KERNEL = HOUSE / "verify" / "kernel"
FILES = sorted(KERNEL.rglob("*.py"))


def imports(path: Path) -> set[str]:
    """The modules that a file imports, those of the kernel as paths within it."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            folder = path.parents[node.level - 1] if node.level else None
            names = [node.module] if node.module else [alias.name for alias in node.names]
            found |= {str(folder / name) if folder else name for name in names}
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_kernel_imports_the_standard_library_and_flint_alone(path: Path) -> None:
    own = {str(other.with_suffix("")) for other in FILES}
    for name in imports(path):
        assert name in own or name.split(".")[0] in {*sys.stdlib_module_names, "flint"}, name


def lines(paths: list[Path]) -> int:
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in paths)


def test_the_page_on_trust_counts_the_lines() -> None:
    page = (HOUSE / "docs" / "trust.md").read_text(encoding="utf-8")
    (stated,) = re.findall(r"([0-9]+) lines of our own", page)
    assert abs(int(stated) - lines(FILES)) <= 50, f"docs/trust.md should say {lines(FILES)}"


def test_the_kernel_is_read_in_an_afternoon() -> None:
    """Count lines with more than a comment or a docstring."""
    assert sum(lines_of_code(path.read_text(encoding="utf-8")) for path in FILES) <= 2800


def alone(folder: Path, text: str) -> subprocess.CompletedProcess[str]:
    """``python -m kernel FILE`` in a folder with nothing else."""
    without = shutil.ignore_patterns("__pycache__")
    folder.mkdir(exist_ok=True)
    shutil.copytree(KERNEL, folder / "kernel", ignore=without)
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
