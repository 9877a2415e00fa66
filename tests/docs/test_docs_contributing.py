"""CONTRIBUTING's answers hold, and no text names a file that is not there."""

import ast
import re
from pathlib import Path

import pytest

from house import HOUSE, ROOMS

CONTRIBUTING = (HOUSE / "CONTRIBUTING.md").read_text(encoding="utf-8")
QUESTIONS = re.findall(r"^\| ([^|]+\?) \| `([^`|]+)` \| ([^|]+) \|$", CONTRIBUTING, re.MULTILINE)
TEXTS = [
    HOUSE / "README.md",
    HOUSE / "CONTRIBUTING.md",
    *(path for path in sorted((HOUSE / "docs").rglob("*.md")) if "build" not in path.parts),
]
FOLDERS = (*ROOMS, "tests", "docs")
PATHS = re.compile(rf"`((?:{'|'.join((*FOLDERS, 'benchmarks', 'tools'))})/[\w./-]*)`")
MODULES = re.compile(rf"`~?((?:{'|'.join(ROOMS)})(?:\.\w+)+)`")


def names_in(text: str) -> set[str]:
    """The names that a source defines at its top, and those in its classes after a dot."""
    found: set[str] = set()
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            inner = (part for part in node.body if isinstance(part, ast.FunctionDef))
            found |= {f"{node.name}.{part.name}" for part in inner}
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found |= {target.id for target in targets if isinstance(target, ast.Name)}
    return found


def test_the_questions_are_found() -> None:
    assert len(QUESTIONS) == CONTRIBUTING.count("? |") > 20


@pytest.mark.parametrize(("question", "path", "answer"), QUESTIONS)
def test_each_question_is_answered_by_a_file_and_what_it_holds(
    question: str, path: str, answer: str
) -> None:
    text = (HOUSE / path).read_text(encoding="utf-8")
    named = re.match(r"`([\w.]+)`", answer)
    assert named is not None or path.endswith(".toml")
    if named is not None:
        assert named[1] in names_in(text)


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: str(path.relative_to(HOUSE)))
def test_files_and_modules_that_are_named_exist(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    made = ("reports/build", "docs/build")
    for named in PATHS.findall(text):
        assert (HOUSE / named).exists() or named.startswith(made), named
    for module in MODULES.findall(text):
        assert is_held(module), module


def is_held(dotted: str) -> bool:
    """Whether a dotted name is a module, or is defined in one."""
    parts = dotted.split(".")
    parts = parts[1:] if len(parts) > 1 and parts[1] in ROOMS else parts
    for cut in range(len(parts), 0, -1):
        place = HOUSE.joinpath(*parts[:cut])
        for source in (place / "__init__.py", place.with_suffix(".py")):
            if source.is_file():
                rest = ".".join(parts[cut:])
                text = source.read_text(encoding="utf-8")
                offered = (
                    re.search(rf'"([\w ]* )?{re.escape(rest)}( [\w ]*)?"', text)
                    or f" as {rest}\n" in text
                )
                return not rest or rest in names_in(text) or bool(offered)
    return False


def test_a_file_that_is_gone_and_a_name_that_is_gone_are_noticed() -> None:
    assert PATHS.findall("in `derive/gone.py` and `make docs`") == ["derive/gone.py"]
    assert is_held("longwave.derive.multiscale.reduce")
    assert is_held("derive.reduce")
    assert not is_held("longwave.derive.multiscale.gone")
    assert not is_held("derive.gone")
