"""The house itself: what imports what, how long things are, what may not be mentioned."""

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from solutions.run.source_digest import ROOMS as SOURCE_ROOMS

HOUSE = Path(__file__).parents[1]
ROOMS = ("derive", "solutions", "lattice", "verify", "reports", "longwave")
SOURCES = sorted(path for room in ROOMS for path in (HOUSE / room).rglob("*.py"))


def imported_modules(path: Path, text: str | None = None) -> Iterator[str]:
    """Yield the dotted names of the modules that the file imports, relative ones resolved."""
    package = path.relative_to(HOUSE).parent.parts
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8") if text is None else text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            stem = ".".join([*above, *([node.module] if node.module else [])])
            yield stem
            yield from (f"{stem}.{alias.name}" for alias in node.names)


def name_of(path: Path) -> str:
    return str(path.relative_to(HOUSE))


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_a_room_imports_nothing_on_its_right(path: Path) -> None:
    room = ROOMS.index(path.relative_to(HOUSE).parts[0])
    later = set(ROOMS[room + 1 :])
    wrong = {name for name in imported_modules(path) if name.split(".")[0] in later}
    assert not wrong


@pytest.mark.parametrize(("room", "other"), [("proof", "comparison"), ("comparison", "proof")])
def test_proof_and_comparison_do_not_import_each_other(room: str, other: str) -> None:
    for path in (HOUSE / "verify" / room).rglob("*.py"):
        names = set(imported_modules(path))
        assert not {name for name in names if name.startswith(f"verify.{other}")}, path


def test_relative_imports_are_resolved() -> None:
    """The direction test would be blind to `from ..verdict import Verdict` if this failed."""
    text = "from ..verdict import Verdict\nfrom . import scene\nimport solutions.wave\n"
    names = set(imported_modules(HOUSE / "verify" / "comparison" / "imagined.py", text))
    assert {"verify.verdict", "verify.comparison.scene", "solutions.wave"} <= names


@pytest.mark.parametrize(
    ("room", "unwanted"),
    [
        ("derive", {"numpy", "scipy", "numba", "matplotlib", "xarray", "solutions"}),
        ("solutions", {"sympy", "matplotlib", "jinja2", "lattice", "verify"}),
        ("lattice", {"sympy", "matplotlib", "xarray", "derive", "verify"}),
        ("longwave", {"sympy", "numpy", "matplotlib", "numba"}),
    ],
)
def test_importing_a_room_pulls_in_only_what_it_needs(room: str, unwanted: set[str]) -> None:
    code = f"import sys, {room}; print(*(set(sys.modules) & {unwanted!r}))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=HOUSE, check=True
    )
    assert done.stdout.split() == []


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_no_function_is_longer_than_60_lines(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            assert node.end_lineno is not None
            assert node.end_lineno - node.lineno < 60, node.name


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_no_text_is_evaluated(path: Path) -> None:
    """`eval`, `exec`, `sympify` and `parse_expr` run their argument as Python."""
    called = {
        node.func.id if isinstance(node.func, ast.Name) else node.func.attr
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name | ast.Attribute)
    }
    assert not called & {"eval", "exec", "parse_expr"}


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_kernels_are_compiled_through_the_cache_that_follows_sources(path: Path) -> None:
    """Numba's own ``cache=True`` serves old machine code after a change in another file."""
    if path.relative_to(HOUSE) != Path("solutions", "run", "jit.py"):
        wrong = {"numba.njit", "numba.jit", "numba.vectorize", "numba.guvectorize", "numba.cfunc"}
        assert not set(imported_modules(path)) & {*wrong, "numba.np.ufunc"}


def test_the_rooms_whose_sources_count_for_kernels_are_all_rooms() -> None:
    assert SOURCE_ROOMS == ROOMS


def text_files() -> Iterator[Path]:
    """Yield the repository's text files, in a checkout or an unpacked archive alike."""
    skipped = {".git", ".venv", "build", "__pycache__"}
    kinds = {".py", ".md", ".toml", ".j2", ".sh", ""}
    for folder, inner, files in os.walk(HOUSE):
        inner[:] = [name for name in inner if name not in skipped and not name.endswith("_cache")]
        yield from (Path(folder) / name for name in files if Path(name).suffix in kinds)


def test_nothing_reaches_outside_the_repository() -> None:
    outside = "../" + "shared"
    absolute = "/work/" + "shared"
    for path in text_files():
        text = path.read_text(encoding="utf-8")
        assert outside not in text, path
        assert absolute not in text, path
