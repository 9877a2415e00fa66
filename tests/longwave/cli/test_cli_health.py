"""`longwave doctor`: missing parts are found, with their cost."""

import json
import os
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

import pytest
from llvmlite import binding  # type: ignore[import-untyped]

import longwave.reports.engine
from longwave.__main__ import main
from longwave.cli import health
from longwave.support.compiled import kernel_folder
from longwave.support.compiled.kernel_folder import CacheFolder

Output = pytest.CaptureFixture[str]


def found(part: str) -> health.Finding:
    (finding,) = (finding for finding in health.examine() if finding.part == part)
    return finding


def test_every_part_is_in_the_text_and_in_the_json(capsys: Output) -> None:
    assert main(["doctor", "--json"]) == 0
    findings = json.loads(capsys.readouterr().out)
    parts = [finding["part"] for finding in findings]
    assert {"Python", "sympy", "numba", "cores", "vectors", "compiled kernels", "LaTeX"} <= {*parts}
    assert all(finding["cost"] or finding["state"] == "good" for finding in findings)
    assert main(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line[2:].split("  ")[0] for line in lines if line[2] != " "] == parts


def test_a_missing_package_is_broken(monkeypatch: pytest.MonkeyPatch, capsys: Output) -> None:
    monkeypatch.setattr(metadata, "requires", lambda _: ["no-such-thing>=2", 'x; extra == "dev"'])
    assert found("no-such-thing").state == "broken"
    assert main(["doctor"]) == 1
    assert "pip install 'no-such-thing>=2'" in capsys.readouterr().out


def raising(error: Exception) -> Callable[[], object]:
    def fail() -> object:
        raise error

    return fail


@pytest.mark.parametrize(
    ("features", "parts"),
    [
        (lambda: {"avx512f": True, "avx2": True, "sse2": True}, None),
        (lambda: {"avx512f": False, "avx2": True, "sse2": True}, "in 2 parts"),
        (lambda: {"sse2": True}, "in 4 parts"),
        (raising(RuntimeError("unknown")), "in 8 parts"),
    ],
)
def test_narrow_vectors_cost(
    monkeypatch: pytest.MonkeyPatch, features: Callable[[], object], parts: str | None
) -> None:
    monkeypatch.setattr(binding, "get_host_cpu_features", features)
    finding = found("vectors")
    assert finding.state == ("good" if parts is None else "costs")
    assert (parts or "") in finding.cost


def test_one_core_costs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {3}, raising=False)
    assert found("cores").state == "costs"


def test_a_missing_kernel_cache_has_a_cost(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(kernel_folder, "cache_folder", lambda *_: CacheFolder(None))
    assert "NUMBA_CACHE_DIR" in found("compiled kernels").cost
    monkeypatch.setattr(kernel_folder, "cache_folder", lambda *_: CacheFolder(tmp_path))
    assert "the first run compiles" in found("compiled kernels").cost
    (tmp_path / "kernel.object").touch()
    assert found("compiled kernels").state == "good"
    refused = CacheFolder(tmp_path, refused=("a cache folder must be private to the user",))
    monkeypatch.setattr(kernel_folder, "cache_folder", lambda *_: refused)
    assert "private to the user" in found("compiled kernels").found
    assert "remove it" in found("compiled kernels").cost
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    assert "unset NUMBA_DISABLE_JIT" in found("compiled kernels").cost


def test_without_latex_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(longwave.reports.engine, "engine_present", lambda: False)
    assert "install latexmk" in found("LaTeX").cost
