"""Catches: a first run that waits for numba, and a shipped text that is not the kernel's."""

import os
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from house import HOUSE, ROOMS
from longwave.lattice.spectral import evolution
from longwave.solutions.run import machine
from longwave.support.compiled import (
    kernel_writer,
    native_code,
    shipped_kernels,
    source_digest,
)
from longwave.support.compiled.jit import Kernel, njit
from longwave.support.compiled.kernel_writer import write_kernels
from longwave.support.compiled.shipped_kernels import shipped_text
from longwave.support.sealed_file import write_sealed
from tests.support.compiled.cache_places import caches_in

SCALE = machine.__name__, "_scale_row", 0
FORCE = evolution.__name__, "_residual_force", 0
"""A kernel whose operations are rounded one by one, and one whose products may be contracted."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of shipped texts, with the two kernels."""
    for name, packed in map(kernel_writer._packed, (SCALE, FORCE)):
        write_sealed(tmp_path / name, packed)
    monkeypatch.setattr(shipped_kernels, "FOLDER", tmp_path)
    return tmp_path


def texts() -> tuple[str | None, str | None]:
    """Return the texts found for the two kernels."""
    scale, force = machine._scale_row, evolution._residual_force
    return (
        shipped_text(machine.__name__, scale.key(scale.examples[0])),
        shipped_text(evolution.__name__, force.key(force.examples[0])),
    )


def test_every_cached_kernel_declares_examples() -> None:
    """A kernel without examples is not shipped; the scan for modules must see it."""
    scanned = kernel_writer.modules_with_kernels()
    for room in ROOMS:
        for path in (HOUSE / room).rglob("*.py"):
            if "cache=True" not in path.read_text(encoding="utf-8") or path.name == "jit.py":
                continue
            relative = path.relative_to(HOUSE).with_suffix("")
            name = ".".join(("longwave", *relative.parts))
            for kernel in vars(import_module(name)).values():
                if isinstance(kernel, Kernel) and kernel._cached and kernel.__module__ == name:
                    assert kernel.examples, f"{name}.{kernel.py_func.__name__}"
                    assert name in scanned


def test_a_kernel_without_cache_has_no_examples() -> None:
    with pytest.raises(ValueError, match="cache must be True"):
        njit(examples=[(1.0,)])(lambda x: x)


def test_texts_equal_those_of_numba(folder: Path) -> None:
    for text in texts():
        assert text is not None
        assert "define" in text
        assert native_code._compiled(text)


def test_a_shipped_kernel_runs_without_numba(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    row = np.array([[3.0], [0.0], [0.0]])
    monkeypatch.setattr(machine._scale_row, "_entries", {})
    monkeypatch.setattr(Kernel, "text", None)
    for _ in caches_in(tmp_path, monkeypatch):
        machine._scale_row(row, (2.0, 0.0))
    assert row[0, 0] == 6.0


def other_version(patch: pytest.MonkeyPatch) -> None:
    shipped_kernels.kernel_digest.cache_clear()
    patch.setattr(source_digest, "installed_version", lambda package: f"other {package}")


def other_source(patch: pytest.MonkeyPatch) -> None:
    shipped_kernels.kernel_digest.cache_clear()
    patch.setattr(source_digest, "_text_digest", lambda path: b"other")


def other_layout(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(shipped_kernels, "computers", lambda: ("other here", "other"))


@pytest.mark.parametrize(
    "change",
    [
        other_version,
        other_source,
        other_layout,
        lambda patch: patch.setenv("NUMBA_OPT", "1"),
        lambda patch: patch.setattr(shipped_kernels, "are_older", lambda sources: False),
        lambda patch: patch.setattr(shipped_kernels, "FOLDER", Path("nowhere")),
    ],
)
def test_texts_for_other_settings_are_not_used(
    folder: Path, monkeypatch: pytest.MonkeyPatch, change: Callable[[pytest.MonkeyPatch], None]
) -> None:
    """Another compiler, source, architecture or setting; a source that has just been edited."""
    change(monkeypatch)
    assert texts() == (None, None)
    shipped_kernels.kernel_digest.cache_clear()


def test_contracted_products_are_for_one_processor(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Numba vectorises for the processor, which changes bits if products may be contracted."""
    monkeypatch.setattr(native_code, "processor", lambda: "another one")
    scale, force = texts()
    assert scale is not None
    assert force is None


def test_damage_costs_a_compilation(folder: Path) -> None:
    for path in folder.iterdir():
        path.write_bytes(path.read_bytes()[:-300])
    assert texts() == (None, None)


def test_a_link_is_not_followed(folder: Path, tmp_path: Path) -> None:
    for path in [*folder.iterdir()]:
        path.symlink_to(path.rename(tmp_path / f"moved {path.name}"))
    assert texts() == (None, None)


def build(built: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Run the build step on a folder; return its warnings and messages."""
    pytest.importorskip("setuptools")
    from setuptools import Distribution

    from tools.build_kernels import BuildWithKernels

    said: list[str] = []
    step = BuildWithKernels(Distribution({"name": "longwave"}))
    step.build_lib = str(built)
    monkeypatch.setattr(step, "warn", said.append)
    monkeypatch.setattr(step, "announce", lambda text, level: said.append(text))
    step.write_kernels()
    [text] = said
    return text


def test_a_build_without_numba_continues_with_a_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The imported module stands for a package that numba cannot compile."""
    package = tmp_path / "longwave"
    package.mkdir()
    (package / "__init__.py").write_text("raise ImportError('No module named numba')")
    text = build(tmp_path, monkeypatch)
    assert text.startswith("no compiled kernels in the package, the first run makes them")
    assert text.endswith("ImportError: No module named numba")
    monkeypatch.setattr(sys, "executable", str(tmp_path / "nowhere"))
    assert "No such file" in build(tmp_path, monkeypatch)


def test_a_kernel_that_cannot_be_compiled_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_writer, "_tasks", lambda: iter([SCALE, (SCALE[0], "_run", 99)]))
    with pytest.raises(IndexError):
        write_kernels(tmp_path / "texts")
    assert not (tmp_path / "texts").exists()


RUN = """
import sys
from pathlib import Path
from longwave.support.compiled import jit, shipped_kernels

shipped_kernels.FOLDER = Path(sys.argv[1])

def refuse(kernel, arguments):
    raise SystemExit(f"{kernel.__module__}: no shipped text of {kernel.key(arguments)}")

jit.Kernel.text = refuse
import longwave
for name in sys.argv[2:]:
    longwave.run(name)
assert "numba" not in sys.modules
"""

SCENES = "rogue_cn_k_0.5", "rational_2_eps_0.05", "toda_soliton", "dimer_peregrine", "driven_chain"


@pytest.mark.slow
def test_all_kernels_of_shipped_scenes_are_shipped(tmp_path: Path) -> None:
    """One process each, without a cache: a second run could get machine code of the first."""
    count = write_kernels(tmp_path / "shipped")
    files = [*(tmp_path / "shipped").iterdir()]
    assert len(files) == count
    assert sum(path.stat().st_size for path in files) < 320_000
    for name in SCENES:
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / name)}
        done = subprocess.run(
            [sys.executable, "-c", RUN, str(tmp_path / "shipped"), name],
            capture_output=True,
            text=True,
            cwd=HOUSE,
            env=environment,
            check=False,
        )
        assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_texts_are_reproducible(tmp_path: Path) -> None:
    """Names in a text count earlier compilations, so each text is written in its own process."""
    for name in ("one", "two"):
        write_kernels(tmp_path / name)
    one, two = (
        {path.name: path.read_bytes() for path in (tmp_path / name).iterdir()}
        for name in ("one", "two")
    )
    assert one == two


VALUES = """
import hashlib
import numpy as np
import longwave
equation = longwave.mkdv_normal_form(K2=1, K4=1)
wave = longwave.Wave(longwave.closed_form("rogue_cn"), equation, k=0.5)
x, t = np.random.default_rng(0).standard_normal((2, 3000)) * 30.0
values = wave(x, t)
print(hashlib.sha256(np.stack([*values]).tobytes()).hexdigest())
"""


@pytest.mark.slow
def test_vectors_of_another_processor_change_no_bit_of_a_wave(tmp_path: Path) -> None:
    """So the text of a kernel whose operations are rounded one by one serves all processors."""
    found = set()
    for processor in ("", "generic"):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / f"of {processor}")}
        if processor:
            environment |= {"NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": ""}
        done = subprocess.run(
            [sys.executable, "-c", VALUES],
            capture_output=True,
            text=True,
            cwd=HOUSE,
            env=environment,
            check=True,
        )
        found.add(done.stdout)
    assert len(found) == 1
