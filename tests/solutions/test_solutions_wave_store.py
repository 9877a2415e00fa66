"""Catches: a cached wave that differs from a new one, or comes from other sources."""

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from house import HOUSE, ROOMS
from longwave.derive import mkdv_normal_form
from longwave.solutions import Wave, closed_form, data_store, kept_data, kept_wave
from longwave.support.compiled import source_digest
from longwave.support.compiled.kernel_folder import CacheFolder
from longwave.support.compiled.source_digest import all_sources, text_digest

SITES = np.linspace(-4000.0, 4000.0, 301)
WAVES: dict[str, dict[str, float]] = {
    "rogue_cn": {"k": 0.5},
    "rational_2": {},
    "kink": {"A": 1.2},
    "soliton_dn": {"k": 0.999},
}


def build_wave(name: str) -> Wave:
    form = closed_form(name)
    return Wave(form, mkdv_normal_form(1, form.equation.s), **WAVES[name])


def values(wave: Any) -> Iterator[Any]:
    """Return all values of a wave that a lattice uses."""
    for eps in (0.05, np.float64(0.05), 1):
        yield from wave.at(SITES, -1000.0, eps)
        yield from wave.background_at(SITES, 7.0, eps)
        yield from wave.far_field_at(SITES, 7.0, eps, "right")
    yield from wave(SITES, 0.1)
    yield from wave.pairs_at(SITES, 3.0, 0.05)
    yield from (wave.phase_zeros(3.0, 0.05), [wave.wavelength], [wave.constant_background])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(data_store, "cache_folder", lambda *_: CacheFolder(tmp_path))
    return tmp_path


@pytest.mark.parametrize("name", WAVES)
def test_a_cached_wave_equals_a_new_one(name: str, folder: Path) -> None:
    """Bit for bit; the second wave is not built at all."""
    exact = build_wave(name)
    kept_wave(__name__, name, lambda: exact)
    first = kept_wave(__name__, name, lambda: exact)
    assert all(np.array_equal(a, b) for a, b in zip(values(first), values(exact), strict=True))
    parts = {path.suffix for path in folder.iterdir()} - {".data"}  # the programs
    assert parts == {".numbers", ".wave", ".background", ".right"}

    def never() -> Wave:
        raise AssertionError

    second = kept_wave(__name__, name, never)
    assert all(np.array_equal(a, b) for a, b in zip(values(second), values(exact), strict=True))
    assert second.numbers == exact.numbers
    with pytest.raises(AssertionError):
        second.mp(0, 0)
    assert first.mp(0, 0) == exact.mp(0, 0)
    assert repr(first) == repr(exact)


def test_a_damaged_file_is_replaced(folder: Path) -> None:
    """One bit, wherever it is: of a number, of the code, of a length."""
    exact = build_wave("soliton_dn")
    expected = exact.at(SITES, 0.0, 0.05).Y
    kept_wave(__name__, "wave", lambda: exact).at(SITES, 0.0, 0.05)
    path = next(folder.glob("*.wave"))
    whole = path.read_bytes()
    for place in np.linspace(40, len(whole) - 1, 60).astype(int):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 16]) + whole[place + 1 :])
        again = kept_wave(__name__, "wave", lambda: exact)
        assert np.array_equal(again.at(SITES, 0.0, 0.05).Y, expected)


def test_the_oldest_files_are_deleted(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[int] = []
    monkeypatch.setattr(data_store, "MAX_FILES", 3)
    monkeypatch.setattr(data_store, "SPARE_FILES", 1)
    counts = []
    for number in range(8):
        kept_data(__name__, str(number), lambda: [1.0])
        counts.append(len(list(folder.iterdir())))
    assert counts == [1, 2, 3, 4, 3, 4, 3, 4]
    kept_data(__name__, "0", lambda: calls.append(1) or [1.0])
    kept_data(__name__, "7", lambda: calls.append(1) or [1.0])
    assert calls == [1]


def test_data_are_computed_once(folder: Path) -> None:
    calls: list[int] = []
    for _ in range(3):
        assert kept_data(__name__, "data", lambda: calls.append(1) or [1.5]) == [1.5]
    assert calls == [1]


def test_nothing_is_kept_of_what_the_files_do_not_say(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(source_digest, "runs_as_written", lambda _: False)
    assert kept_data(__name__, "data", lambda: [1.5]) == [1.5]
    assert not list(folder.iterdir())


def test_every_file_that_makes_a_wave_is_in_the_key() -> None:
    """The closed forms, the normal form's derivation, the compiler; and the text of each counts."""
    files = dict(
        all_sources(("longwave.scenes.starts.moving_wave", "longwave.solutions.forms.rogue_cn"))
    )
    for module in (
        "longwave.derive.models.mkdv",
        "longwave.derive.multiscale",
        "longwave.derive.algebra.exact_numbers",
        "longwave.solutions.wave",
        "longwave.solutions.record",
        "longwave.solutions.forms.rogue_cn",
        "longwave.solutions.functions.jacobi",
        "longwave.solutions.compile.lowering",
        "longwave.solutions.run.program",
        "longwave.solutions.functions.multiprecision",
    ):
        assert module in files, module


def test_another_text_is_another_key(tmp_path: Path) -> None:
    path = tmp_path / "form.py"
    path.write_text("x = 1\n")
    before = text_digest((("form", path),))
    source_digest._text_digest.cache_clear()
    text_digest.cache_clear()
    path.write_text("x = 2\n")
    assert text_digest((("form", path),)) != before
    text_digest.cache_clear()
    source_digest._text_digest.cache_clear()


STALE = """
import os, sys, time
from pathlib import Path
from longwave.support.compiled.source_digest import are_older, runs_as_written

def forget():
    are_older.cache_clear()
    runs_as_written.cache_clear()

from longwave import derive
lazy_exports = sys.modules["longwave.support.lazy_exports"]
path = Path("old.py")
path.write_text("value = 1\\n")
os.utime(path, (1e9, 1e9))
lazy_exports.BEGUN = time.time() + 10.0
import old
assert runs_as_written((("old", path.resolve()),))
path.write_text("value = 2\\n")
os.utime(path, (1e9, 1e9))
del sys.modules["old"]
import old
forget()
print(old.value, runs_as_written((("old", path.resolve()),)))
lazy_exports.BEGUN = 0.0
path.write_text("value = 1\\n")
forget()
print(runs_as_written((("old", path.resolve()),)))
"""


def test_old_byte_code_and_young_files_are_detected(tmp_path: Path) -> None:
    """Python runs old byte code where a change keeps time and size."""
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path += [{str(HOUSE)!r}]\n{STALE}"],
        env={name: value for name, value in os.environ.items() if not name.startswith("PYTHON")},
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["1", "False", "False"]


WARM = """
import sys
from longwave.__main__ import main
status = main(sys.argv[1:])
heavy = {"sympy", "numba", "xarray", "pandas", "scipy", "matplotlib"}
print("imported:", *sorted(heavy & set(sys.modules)), file=sys.stderr)
sys.exit(status)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "engine"),
    [
        (["rogue_cn_k_0.5_long", "--tolerance", "1e-2"], "spectral"),
        (["toda_soliton", "--tolerance", "1e-2"], "stencil"),
    ],
)
def test_a_warm_run_imports_nothing_heavy_and_prints_the_same(
    words: list[str], engine: str
) -> None:
    line = [sys.executable, "-c", WARM, "run", *words]
    runs = [
        subprocess.run(line, capture_output=True, text=True, cwd=HOUSE, check=True)
        for _ in range(2)
    ]
    tables = [run.stdout.partition(engine)[0] for run in runs]
    assert tables[0] == tables[1]
    assert runs[1].stderr.split() == ["imported:"]


@pytest.mark.slow
def test_a_picture_of_a_warm_run_imports_matplotlib_and_nothing_else_heavy(tmp_path: Path) -> None:
    """Catches: a data set made for a picture, which reads names and values alone."""
    words = ["plot", "rogue_cn_k_0.5", "--force", "--output", str(tmp_path / "rogue.png")]
    line = [sys.executable, "-c", WARM, *words]
    runs = [subprocess.run(line, capture_output=True, text=True, cwd=HOUSE) for _ in range(2)]
    assert [run.returncode for run in runs] == [0, 0], runs[1].stderr
    assert runs[1].stderr.split() == ["imported:", "matplotlib"]


def test_the_imports_of_a_file_are_read_as_python_reads_them() -> None:
    """Without Python's parser; every file of the house."""

    def imported(body: list[Any]) -> Iterator[tuple[str, str]]:
        for node in body:
            if isinstance(node, ast.Import):
                yield from ((alias.name, "") for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                stem = "." * node.level + (node.module or "")
                yield from ((stem, alias.name) for alias in node.names)
            for inner in ("body", "orelse", "finalbody", "handlers", "cases"):
                yield from imported(getattr(node, inner, []))

    for room in ROOMS:
        for path in (HOUSE / room).rglob("*.py"):
            found = source_digest._imports(path)
            assert sorted(found) == sorted(imported(ast.parse(path.read_bytes()).body)), path


def test_without_a_folder_the_wave_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(data_store, "cache_folder", lambda *_: CacheFolder(None))
    exact = build_wave("kink")
    assert kept_wave(__name__, "kink", lambda: exact) is exact
    assert kept_data(__name__, "data", lambda: [1.5]) == [1.5]
