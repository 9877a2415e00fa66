"""Programs on disk: same numbers, never stale, and optional."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import sympy as sp

from longwave.solutions import Wave, closed_form, data_store
from longwave.solutions.compile.compiler import cached_program
from longwave.solutions.symbols import tau, xi
from longwave.support.compiled.kernel_folder import CacheFolder
from longwave.support.sealed_file import read_sealed

NAMES = ["rogue_cn", "breather_sn", "two_soliton", "kink"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(data_store, "cache_folder", lambda *_: CacheFolder(tmp_path))
    return tmp_path


def values(name: str, normal_forms: Any, **changes: Any) -> list[list[float]]:
    form = replace(closed_form(name), **changes) if changes else closed_form(name)
    given = {"k": 0.6, "alpha": 0.8, "A": 1.1, "A_1": 1.5, "A_2": 0.7}
    known = {p.name: given[p.name] for p in form.parameters if p.name in given}
    wave = Wave(form, normal_forms[form.equation.s], **known)
    return [part.tolist() for part in wave([-1.0, 0.3, 70.0], 0.2)]


@pytest.mark.parametrize("name", NAMES)
def test_a_cached_program_gives_the_same_numbers(
    name: str, folder: Path, normal_forms: Any
) -> None:
    first = values(name, normal_forms)
    assert len(list(folder.iterdir())) == 1
    assert values(name, normal_forms) == first


def test_a_cached_program_needs_no_expression(folder: Path, normal_forms: Any) -> None:
    values("kink", normal_forms)
    form = closed_form("kink")

    def never() -> list[sp.Expr]:
        raise AssertionError("the expression was made")

    cached_program(form, "wave", never, tuple(p.symbol for p in form.parameters))


def test_another_formula_under_the_same_name_has_its_own_program(
    folder: Path, normal_forms: Any
) -> None:
    """A form that was changed has no source in the catalogue: its formula is the key."""
    own = values("kink", normal_forms)
    other = values("kink", normal_forms, expression=sp.tanh(xi) + tau)
    assert other != own
    assert values("kink", normal_forms, expression=sp.tanh(xi) - tau) not in (own, other)
    assert len(list(folder.iterdir())) == 3


def test_a_damaged_program_is_written_anew(folder: Path, normal_forms: Any) -> None:
    first = values("kink", normal_forms)
    (path,) = folder.iterdir()
    for text in ("", "{}", "[1]", '{"calls": 1}'):
        path.write_text(text)
        assert values("kink", normal_forms) == first
    assert read_sealed(path) is not None


def test_without_a_folder_it_runs(monkeypatch: pytest.MonkeyPatch, normal_forms: Any) -> None:
    first = values("kink", normal_forms)
    monkeypatch.setattr(data_store, "cache_folder", lambda *_: CacheFolder(None))
    assert values("kink", normal_forms) == first
    nowhere = CacheFolder(Path("/dev/null/nowhere"))
    monkeypatch.setattr(data_store, "cache_folder", lambda *_: nowhere)
    assert values("kink", normal_forms) == first
