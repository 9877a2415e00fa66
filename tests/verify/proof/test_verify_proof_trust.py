"""What the trusted part imports, and what the page on trust says of it."""

import ast
import re
from pathlib import Path

import pytest

HOUSE = Path(__file__).parents[3]
CHECKER = sorted((HOUSE / "verify" / "proof" / "checker").glob("*.py"))
BALLS = HOUSE / "verify" / "proof" / "taylor.py"
STANDARD = {
    *("__future__", "abc", "collections", "dataclasses", "functools", "fractions", "hashlib"),
    *("itertools", "json", "math", "operator", "re", "typing"),
}
"""Modules of Python that the checker may use; FLINT and its own files are all else."""


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            stem = "." * node.level + (node.module or "")
            found |= {stem} if node.module else {f".{alias.name}" for alias in node.names}
    return found


@pytest.mark.parametrize("path", [*CHECKER, BALLS], ids=lambda path: path.name)
def test_the_checker_uses_nothing_of_the_prover_and_no_sympy(path: Path) -> None:
    own = {f".{other.stem}" for other in CHECKER}
    for name in imports(path):
        outside = name.split(".")[0] in {*STANDARD, "flint"}
        assert outside or name in own or name == "verify.proof.taylor", name


def test_the_page_on_trust_counts_the_lines() -> None:
    lines = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in [*CHECKER, BALLS])
    page = (HOUSE / "docs" / "trust.md").read_text(encoding="utf-8")
    (stated,) = re.findall(r"([0-9]+) lines of our own", page)
    assert abs(int(stated) - lines) <= 50, f"docs/trust.md should say {lines}"
