"""The house itself: what imports what, how long things are, what may not be mentioned."""

import ast
import io
import os
import subprocess
import sys
import tokenize
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

import pytest

from house import HOUSE, ROOMS, dotted_name

SOURCES = sorted(path for room in ROOMS for path in (HOUSE / room).rglob("*.py"))

LONGEST_CHAIN, LONGEST_OF_PROOFS = 9, 15
"""Modules in the longest chain of imports, those in functions and for types alone left out: of all
but the proofs, and with them."""


SEES: Mapping[str, tuple[str, ...]] = {
    "support": (),
    "derive": ("support",),
    "solutions": ("support", "derive"),
    "verify": ("support", "derive", "solutions"),
    "lattice": ("support", "derive"),
    "waves": ("support", "derive"),
    "scenes": ("support", "derive", "solutions", "lattice"),
    "runs": ("support", "derive", "solutions", "lattice", "scenes"),
    "reports": tuple(room for room in ROOMS if room not in ("reports", "longwave")),
    "longwave": ROOMS[:-1],
}
"""What each room may import: `verify` answers for formulas, `scenes` for lattices, and neither
knows the other."""


@cache
def tree_of(path: Path) -> ast.Module:
    """A file as Python reads it."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """All nodes of a file, which several tests walk over."""
    return tuple(ast.walk(tree_of(path)))


@cache
def imported_modules(path: Path, text: str | None = None) -> frozenset[str]:
    """The dotted names of the modules that the file imports, relative ones resolved."""
    package = dotted_name(path.parent / "__init__.py").split(".")
    found: set[str] = set()
    for node in nodes_of(path) if text is None else ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            stem = ".".join([*above, *([node.module] if node.module else [])])
            found |= {f"{stem}.{alias.name}" for alias in node.names}
            if stem != "longwave":  # `from longwave import lattice` asks for the room alone
                found.add(stem)
    return frozenset(found)


def name_of(path: Path) -> str:
    return str(path.relative_to(HOUSE))


def test_a_room_imports_only_what_it_may_know() -> None:
    wrong = []
    for path in SOURCES:
        room = path.relative_to(HOUSE).parts[0]
        seen = {room, "", *SEES[room]}
        if path.name != "__main__.py":  # a room's own command has its words from the face
            wrong += [(name_of(path), n) for n in imported_modules(path) if room_of(n) not in seen]
    assert not wrong


def room_of(module: str) -> str:
    """The room of a module, "longwave" for the face; "" if it is none of ours."""
    package, _, rest = module.partition(".")
    room = rest.partition(".")[0]
    return "" if package != "longwave" else room if room in ROOMS else package


@pytest.mark.parametrize("room", ROOMS[:-1])
def test_the_package_links_to_its_rooms(room: str) -> None:
    assert (HOUSE / "longwave" / room).readlink() == Path("..") / room


@pytest.mark.parametrize("folder", ["searches", "benchmarks", "tests"])
def test_what_is_installed_needs_nothing_that_is_not(folder: str) -> None:
    for path in SOURCES:
        assert not {name for name in imported_modules(path) if name.split(".")[0] == folder}, path


def test_nothing_is_imported_but_as_a_part_of_the_package() -> None:
    """Two names of one file would be two modules, and a user's own `lattice.py` may be found."""
    for path in SOURCES:
        assert not {name for name in imported_modules(path) if name.split(".")[0] in ROOMS[:-1]}


SCENE_FOLDERS = ("observed", "description", "starts", "engines", "fits", "")
"""Folders of `scenes/` in the order of their imports; modules above them all come last."""


def test_folders_of_scenes_are_imported_in_their_order() -> None:
    """What an import in a function, or for types alone, asks for counts, too."""
    upward = set()
    for path in sorted((HOUSE / "scenes").rglob("*.py")):
        inner = path.relative_to(HOUSE / "scenes")
        folder = inner.parent.name
        for name in imported_modules(path):
            parts = name.removeprefix("longwave.scenes.").split(".")
            if folder not in SCENE_FOLDERS or parts[0] not in SCENE_FOLDERS or len(parts) != 2:
                continue
            if SCENE_FOLDERS.index(parts[0]) > SCENE_FOLDERS.index(folder):
                upward.add((inner.as_posix(), ".".join(parts)))
    assert not upward


@pytest.mark.parametrize(
    ("room", "other"),
    [
        ("verify/kernel", "longwave.verify.proof"),
    ]
    + [
        ("searches/texts", other)
        for other in ("longwave.verify.proof", "longwave.verify.kernel", "longwave.derive")
    ],
)
def test_a_prover_shares_no_code_with_its_judge(room: str, other: str) -> None:
    for path in (HOUSE / room).rglob("*.py"):
        assert not {name for name in imported_modules(path) if name.startswith(other)}, path


def test_relative_imports_are_resolved() -> None:
    """The direction test would be blind to `from ..verdict import Verdict` if this failed."""
    text = "from ..verdict import Verdict\nfrom . import scene\nimport longwave.solutions.wave\n"
    names = imported_modules(HOUSE / "verify" / "proof" / "imagined.py", text)
    assert {
        "longwave.verify.verdict",
        "longwave.verify.proof.scene",
        "longwave.solutions.wave",
    } <= names


@pytest.mark.parametrize(
    ("imported", "unwanted"),
    [
        (
            "from longwave import derive, solutions, lattice; import longwave.scenes",
            "sympy numpy numba",
        ),
        (
            "from longwave.derive import reduce",
            "numpy scipy numba matplotlib xarray longwave.solutions",
        ),
        (
            "from longwave.solutions import closed_form",
            "numba matplotlib jinja2 longwave.lattice longwave.verify",
        ),
        (
            "from longwave.lattice import integrate",
            "sympy matplotlib xarray longwave.verify longwave.derive.lattice",
        ),
        (
            "from longwave.verify.proof import prove",
            "numba matplotlib xarray longwave.lattice longwave.scenes.engines.lattice_run",
        ),
    ],
)
def test_importing_a_noun_pulls_in_only_what_it_needs(imported: str, unwanted: str) -> None:
    code = f"import sys; {imported}; print(*(set(sys.modules) & set({unwanted.split()!r})))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=HOUSE, check=True
    )
    assert done.stdout.split() == []


def test_the_lattice_knows_neither_symbols_nor_waves() -> None:
    modules = [dotted_name(path) for path in SOURCES if path.is_relative_to(HOUSE / "lattice")]
    test_importing_a_noun_pulls_in_only_what_it_needs(
        f"import {', '.join(modules)}",
        "sympy mpmath matplotlib xarray longwave.derive.lattice longwave.verify",
    )


def modules_imported_first(tree: ast.Module, known: Mapping[str, Path]) -> Iterator[str]:
    """Yield the modules of the house that are imported when this one is: no later, for no types."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            continue
        waiting += ast.iter_child_nodes(node)
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom) and node.module:
            inner = (f"{node.module}.{alias.name}" for alias in node.names)
            yield from (name if name in known else node.module for name in inner)


def circles(graph: Mapping[str, frozenset[str]]) -> set[tuple[str, ...]]:
    """The groups of modules each of which imports, in however many steps, all others of them."""
    reached = {name: set(below) for name, below in graph.items()}
    for middle in graph:  # as Warshall has it
        for below in reached.values():
            if middle in below:
                below |= reached[middle]
    groups = {
        tuple(sorted(other for other in below if name in reached[other]))
        for name, below in reached.items()
    }
    return groups - {()}


def test_modules_import_each_other_in_no_circle() -> None:
    known = {dotted_name(path): path for path in SOURCES if path.name != "__init__.py"}
    graph = {name: imported_modules(path) & (known.keys() - {name}) for name, path in known.items()}
    assert circles(graph) == set()


@cache
def imports() -> Mapping[str, frozenset[str]]:
    """The modules of the house, with those that each of them imports first."""
    known = {dotted_name(path): path for path in SOURCES}
    return {
        name: frozenset(modules_imported_first(tree_of(path), known)) & (known.keys() - {name})
        for name, path in known.items()
    }


def longest_chain(graph: Mapping[str, frozenset[str]]) -> tuple[str, ...]:
    """The longest chain of imports; AssertionError, with its modules, if there is a circle."""
    found: dict[str, tuple[str, ...]] = {}

    def chain(name: str, above: tuple[str, ...]) -> tuple[str, ...]:
        assert name not in above, " -> ".join([*above[above.index(name) :], name])
        if name not in found:
            below = (chain(other, (*above, name)) for other in sorted(graph[name]))
            found[name] = (name, *max(below, key=len, default=()))
        return found[name]

    return max((chain(name, ()) for name in graph), key=len)


def test_imports_form_no_circle_and_no_long_chain() -> None:
    chain = longest_chain(imports())
    assert len(chain) <= LONGEST_OF_PROOFS, " -> ".join(chain)
    rest = {name for name in imports() if not name.startswith("longwave.verify.proof")}
    chain = longest_chain({name: imports()[name] & rest for name in rest})
    assert len(chain) <= LONGEST_CHAIN, " -> ".join(chain)


def test_a_circle_of_imports_is_seen() -> None:
    circle = {"a": frozenset("b"), "b": frozenset("c"), "c": frozenset("b")}
    with pytest.raises(AssertionError, match="b -> c -> b"):
        longest_chain(circle)
    assert circles(circle) == {("b", "c")}


@pytest.mark.parametrize(
    "room",
    [
        "longwave.derive",
        "longwave.solutions",
        "longwave.lattice",
        "longwave.scenes",
        "longwave.verify.proof",
        "longwave",
    ],
)
def test_a_noun_that_is_imported_when_asked_for_has_not_the_name_of_a_module(room: str) -> None:
    """Importing the module would put it in the noun's place."""
    face = import_module(room)
    assert "__getattr__" in vars(face)
    modules = {module.name for module in iter_modules(face.__path__)}
    assert not modules & set(face.__all__)


def lines_of_code(text: str) -> int:
    """The lines that hold more than a comment or a docstring."""
    told = {
        line
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    empty = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
    held = {
        line
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type not in empty | {tokenize.ENDMARKER}
        for line in range(token.start[0], token.end[0] + 1)
    }
    return len(held - told)


def test_no_function_is_longer_than_60_lines() -> None:
    functions = [
        (node.end_lineno - node.lineno, name_of(path), node.name)
        for path in SOURCES
        for node in nodes_of(path)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.end_lineno
    ]
    assert max(functions)[0] < 60, max(functions)


def test_no_text_is_evaluated() -> None:
    """`eval`, `exec`, `sympify` and `parse_expr` run their argument as Python."""
    called = {
        (name_of(path), node.func.id if isinstance(node.func, ast.Name) else node.func.attr)
        for path in SOURCES
        for node in nodes_of(path)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name | ast.Attribute)
    }
    assert not [place for place in called if place[1] in {"eval", "exec", "parse_expr"}]


WITHOUT_SAFE_PATH = {
    "benchmarks/halo_exchange.py": "its script imports those beside it",
    "benchmarks/large_rings.py": "its script imports those beside it",
    "longwave/cli/health.py": "it is shown, and nothing is started",
}
"""Files that name this Python without ``-P`` behind it, each with the reason."""


def unsafe_starts(tree: ast.AST) -> Iterator[int]:
    """Yield the lines that name this Python other than in a list of words with ``-P`` behind it."""
    safe = set[ast.AST]()
    for node in ast.walk(tree):
        if isinstance(node, ast.List | ast.Tuple):
            pairs = zip(node.elts, node.elts[1:], strict=False)
            safe |= {one for one, following in pairs if ast.unparse(following) == "'-P'"}
    named = (node for node in ast.walk(tree) if isinstance(node, ast.Attribute))
    for node in named:
        if node not in safe and ast.unparse(node) == "sys.executable":
            yield node.lineno


def test_python_is_started_without_the_current_folder_in_its_path() -> None:
    """A file there, such as a `numpy.py`, would be imported and run."""
    folders = [*ROOMS, "benchmarks", "searches", "tools", "docs"]
    files = [path for folder in folders for path in sorted((HOUSE / folder).rglob("*.py"))]
    naming = {path for path in files if "sys.executable" in path.read_text(encoding="utf-8")}
    unsafe = {name_of(path) for path in naming if [*unsafe_starts(tree_of(path))]}
    assert unsafe == {*WITHOUT_SAFE_PATH}


def test_a_start_without_the_option_is_seen() -> None:
    text = 'run([sys.executable, "-m", "a"])\nrun([*mpi, sys.executable, "-P", "b"])\n'
    assert sorted(unsafe_starts(ast.parse(text + "run(sys.executable)\n"))) == [1, 3]


def test_kernels_are_compiled_through_the_cache_that_follows_sources() -> None:
    """Numba's own ``cache=True`` serves old machine code after a change in another file."""
    compilers = {f"numba.{name}" for name in ("njit", "jit", "vectorize", "guvectorize", "cfunc")}
    wrong = [
        name_of(path) for path in SOURCES if imported_modules(path) & {*compilers, "numba.np.ufunc"}
    ]
    assert not wrong


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
