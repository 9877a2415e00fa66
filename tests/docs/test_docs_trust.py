"""Catches: a place where bytes become objects that docs/trust.md does not name with its guard."""

import ast
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from house import HOUSE, ROOMS

TURNS: dict[str, str] = {
    "ctypes": "CDLL PyDLL cast string_at from_address from_buffer",
    "csv": "reader DictReader",
    "distributed": "Client",
    "h5netcdf": "File",
    "h5py": "File",
    "importlib": "import_module",
    "json": "load loads JSONDecoder",
    "llvmlite.binding": "parse_assembly parse_bitcode load_library_permanently "
    "ObjectFileRef.from_data ObjectFileRef.from_path",
    "longwave.support.plain_data": "plain_value",
    "longwave.support.user_files": "read_toml parse_toml",
    "marshal": "load loads",
    "matplotlib.pyplot": "imread",
    "numpy": "load fromfile frombuffer fromstring memmap loadtxt genfromtxt",
    "panel": "io.server.get_server",
    "pickle": "load loads Unpickler",
    "pint": "UnitRegistry",
    "pkgutil": "resolve_name",
    "runpy": "run_path run_module",
    "shelve": "open",
    "subprocess": "run Popen check_output call",
    "sympy": "sympify parse_expr",
    "tomllib": "load loads",
    "urllib.request": "urlopen",
    "xarray": "open_dataset open_dataarray open_mfdataset open_zarr load_dataset",
    "xml.etree.ElementTree": "parse fromstring",
    "yaml": "load safe_load",
}
"""Functions, by module, that make objects of bytes, text or names from elsewhere."""

METHODS = {"recv", "recv_bytes", "recv_pyobj", "add_object_file", "query_arguments", "find_class"}
"""Names of attributes that do so, whatever they are of."""

BUILTINS = {"eval", "exec", "compile", "__import__"}

ROW = re.compile(r"^\| `(?P<file>[\w/.]+\.py)`: (?P<calls>[^|]+) \| [^|]{5,} \| [^|]{5,} \|$", re.M)


def places(text: str) -> Iterator[str]:
    """What of it a file uses, by full name, once for each place."""
    tree = ast.parse(text)
    names: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {a.asname or a.name: a.name for a in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {a.asname or a.name: f"{node.module}.{a.name}" for a in node.names}
    known = {f"{module}.{name}" for module, found in TURNS.items() for name in found.split()}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr in METHODS:
            yield node.attr
        elif isinstance(node, ast.Name) and node.id in BUILTINS:
            yield node.id
        elif isinstance(node, ast.Attribute | ast.Name):
            first, _, rest = ast.unparse(node).partition(".")
            full = ".".join([names.get(first, first), *([rest] if rest else [])])
            if full in known:
                yield full.removeprefix("longwave.support.")


def found() -> Counter[tuple[str, str]]:
    files = [path for room in ROOMS for path in (HOUSE / room).rglob("*.py")]
    return Counter(
        (str(path.relative_to(HOUSE)), name)
        for path in files
        for name in places(path.read_text(encoding="utf-8"))
    )


def listed(page: str) -> Counter[tuple[str, str]]:
    """The rows of the page's table: files with what they use, and how often unless it is once."""
    return Counter(
        {
            (row["file"], call[1]): int(call[2] or 1)
            for row in ROW.finditer(page)
            for call in re.finditer(r"`([\w.]+)`(?: \((\d+)\))?", row["calls"])
        }
    )


def test_every_place_where_bytes_become_objects_is_on_the_page_with_its_guard() -> None:
    page = (HOUSE / "docs" / "trust.md").read_text(encoding="utf-8")
    assert listed(page) == found()


def test_new_places_are_seen() -> None:
    """By another name, in a function, or handed on without being called."""
    for text, name in (
        ("import pickle as p\np.loads(b'')", "pickle.loads"),
        ("from json import loads as read\nread('')", "json.loads"),
        ("def f():\n    import numpy as np\n    return np.load", "numpy.load"),
        ("import numpy\nnumpy.load('a', allow_pickle=True)", "numpy.load"),
        (
            "from llvmlite import binding as b\nb.ObjectFileRef.from_data(b'')",
            "llvmlite.binding.ObjectFileRef.from_data",
        ),
        ("eval('1')", "eval"),
        ("line.recv()", "recv"),
    ):
        assert list(places(text)) == [name]
    assert list(places("import re\nre.compile('a')\nself.load(1)")) == []


def test_the_page_says_what_is_done_where_a_file_is_named() -> None:
    for path, _ in listed((HOUSE / "docs" / "trust.md").read_text(encoding="utf-8")):
        assert Path(HOUSE / path).is_file()


def test_the_table_of_rules_is_on_the_page() -> None:
    """Catches: a page that leaves the generated table out."""
    page = (HOUSE / "docs" / "trust.md").read_text(encoding="utf-8")
    assert page.count("```{kernel-rules}\n```\n") == 1
