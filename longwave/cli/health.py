"""Checks of `longwave doctor`: the parts that longwave needs, and what each missing one costs."""

from __future__ import annotations

import os
import platform
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from importlib import metadata
from typing import Any, Literal

from longwave.support.compiled.cores import usable_cores
from longwave.support.compiled.source_digest import installed_version

State = Literal["good", "costs", "broken"]

VECTOR_WIDTHS = {"avx512f": 8, "avx2": 4, "sve": 4, "neon": 2, "sse2": 2}
"""Processor feature -> number of doubles in its vector registers, widest first."""


@dataclass(frozen=True)
class Finding:
    """Result of one check: part checked, what was found, state, and the cost unless it is good."""

    part: str
    found: str
    state: State = "good"
    cost: str = ""

    def json(self) -> dict[str, Any]:
        """Return the finding as plain data."""
        return asdict(self)


def examine() -> list[Finding]:
    """Return all findings. Nothing is installed."""
    python = f"{platform.python_implementation()} {platform.python_version()}, {sys.executable}"
    return [
        Finding("longwave", metadata.version("longwave")),
        Finding("Python", python),
        *_packages(),
        _cores(),
        _vector_width(),
        _kernel_cache(),
        _latex(),
        *_extras(),
    ]


def _packages() -> Iterator[Finding]:
    """Yield the installed versions of longwave's dependencies."""
    for text in metadata.requires("longwave") or ():
        if "extra ==" in text.replace(";", "; "):
            continue
        name = re.findall(r"[\w.-]+", text)[0]
        version = installed_version(name)
        if version is None:
            yield Finding(name, "missing", "broken", f"install it: pip install '{text}'")
        else:
            yield Finding(name, version)


def _cores() -> Finding:
    count = usable_cores()
    if count == 1:
        cost = "long runs and the report use several cores; with one they take about twice as long"
        return Finding("cores", "1", "costs", cost)
    return Finding("cores", str(count))


def _vector_width() -> Finding:
    """Return the width of vectors in the lattice's compiled kernels (8 doubles are best)."""
    from llvmlite import binding  # type: ignore[import-untyped]

    try:
        features = binding.get_host_cpu_features()
    except RuntimeError:  # LLVM does not know the processor
        features = {}
    present = ((name, width) for name, width in VECTOR_WIDTHS.items() if features.get(name))
    name, width = next(present, ("unknown", 1))
    description = f"{width} doubles ({name}), {binding.get_host_cpu_name()}"
    if width == 8:
        return Finding("vectors", description)
    cost = f"the lattice's kernels take each vector of 8 doubles in {8 // width} parts"
    return Finding("vectors", description, "costs", cost)


def _kernel_cache() -> Finding:
    """Return a finding: the folder of compiled kernels, and whether it has those of the waves."""
    part = "compiled kernels"
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        cost = "nothing is compiled, runs take hundreds of times as long: unset NUMBA_DISABLE_JIT"
        return Finding(part, "NUMBA_DISABLE_JIT is set", "costs", cost)
    import warnings

    from longwave.solutions.run import machine
    from longwave.support.compiled.kernel_folder import cache_folder
    from longwave.support.compiled.native_code import SUFFIX

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a missing folder is reported below
        cache = cache_folder(machine.__name__)
    folder = cache.path
    if cache.refused:
        cost = "its contents are not used: remove it, or set NUMBA_CACHE_DIR to your own folder"
        return Finding(part, cache.refused[0], "costs", cost)
    if folder is None:
        cost = "every process compiles again: set NUMBA_CACHE_DIR to a writable folder"
        return Finding(part, "no writable folder", "costs", cost)
    if not any(folder.glob(f"*{SUFFIX}")):
        cost = "the first run compiles, once"
        return Finding(part, f"none yet in {folder.parent}", "costs", cost)
    return Finding(part, f"in {folder.parent}, writable")


def _latex() -> Finding:
    from longwave.reports.engine import APT_PACKAGES, engine_present

    if engine_present():
        return Finding("LaTeX", "latexmk and pdflatex")
    cost = f"`longwave report` leaves the source: install {' '.join(APT_PACKAGES)}"
    return Finding("LaTeX", "missing", "costs", cost)


def _extras() -> Iterator[Finding]:
    """Yield the packages of optional extras: the page, units, tests and documentation."""
    for package, extra, consequence, alternative in (
        ("pytest", "dev", "the tests cannot be run", ", or make test"),
        ("sphinx", "docs", "the site cannot be built", ", or make docs"),
        ("panel", "explore", "`longwave explore` has no page", ""),
        ("pint", "units", "`longwave fit --units` knows no units", ""),
    ):
        version = installed_version(package)
        if version is not None:
            yield Finding(package, version)
        else:
            cost = f"{consequence}: pip install 'longwave[{extra}]'{alternative}"
            yield Finding(package, "missing", "costs", cost)


def print_findings(findings: Iterable[Finding]) -> None:
    """Print a line for each finding, and a second one for its cost."""
    findings_list = list(findings)
    width = max(len(finding.part) for finding in findings_list)
    for finding in findings_list:
        mark = {"good": " ", "costs": "-", "broken": "!"}[finding.state]
        print(f"{mark} {finding.part:{width}}  {finding.found}")
        if finding.cost:
            print(f"  {'':{width}}  {finding.cost}")
