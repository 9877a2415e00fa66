"""What `longwave doctor` finds: the parts that longwave works with, and what lacks them costs."""

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

VECTORS = {"avx512f": 8, "avx2": 4, "sve": 4, "neon": 2, "sse2": 2}
"""Doubles in a vector by the processor's feature, the widest first."""


@dataclass(frozen=True)
class Finding:
    """One part: what was found of it, its state, and what it costs if it is not good."""

    part: str
    found: str
    state: State = "good"
    cost: str = ""

    def json(self) -> dict[str, Any]:
        """The finding as plain data."""
        return asdict(self)


def examine() -> list[Finding]:
    """Every finding; looking installs nothing."""
    python = f"{platform.python_implementation()} {platform.python_version()}, {sys.executable}"
    return [
        Finding("longwave", metadata.version("longwave")),
        Finding("Python", python),
        *_packages(),
        _cores(),
        _vector(),
        _kernels(),
        _latex(),
        *_extras(),
    ]


def _packages() -> Iterator[Finding]:
    """What longwave requires, each with its version."""
    for text in metadata.requires("longwave") or ():
        if "extra ==" in text.replace(";", "; "):
            continue
        name = _name(text)
        version = installed_version(name)
        if version is None:
            yield Finding(name, "missing", "broken", f"install it: pip install '{text}'")
        else:
            yield Finding(name, version)


def _name(requirement: str) -> str:
    found = re.match(r"[\w.-]+", requirement)
    return found[0] if found else requirement


def _cores() -> Finding:
    count = usable_cores()
    if count == 1:
        cost = "long runs and the report, which use two cores and more, take about twice as long"
        return Finding("cores", "1", "costs", cost)
    return Finding("cores", str(count))


def _vector() -> Finding:
    """The width of the vectors that the lattice's kernels are lowered to (8 doubles are best)."""
    from llvmlite import binding  # type: ignore[import-untyped]

    try:
        features = binding.get_host_cpu_features()
    except RuntimeError:  # LLVM does not know the processor
        features = {}
    name, width = next(
        ((name, width) for name, width in VECTORS.items() if features.get(name)), ("unknown", 1)
    )
    found = f"{width} doubles ({name}), {binding.get_host_cpu_name()}"
    if width == 8:
        return Finding("vectors", found)
    cost = f"the lattice's kernels take each vector of 8 doubles in {8 // width} parts"
    return Finding("vectors", found, "costs", cost)


def _kernels() -> Finding:
    """The folder of the compiled kernels, and whether the waves' machine is there already."""
    part = "compiled kernels"
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        cost = "nothing is compiled, runs take hundreds of times as long: unset NUMBA_DISABLE_JIT"
        return Finding(part, "NUMBA_DISABLE_JIT is set", "costs", cost)
    import warnings

    from longwave.solutions.run import machine
    from longwave.support.compiled.kernel_folder import cache_folder
    from longwave.support.compiled.native_code import SUFFIX

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # that there is no folder, told below
        cache = cache_folder(machine.__name__)
    folder = cache.path
    if cache.refused:
        cost = "what it holds is not used: remove it, or set NUMBA_CACHE_DIR to a folder of yours"
        return Finding(part, cache.refused[0], "costs", cost)
    if folder is None:
        cost = "every process compiles anew: set NUMBA_CACHE_DIR to a folder that can be written"
        return Finding(part, "no folder can be written", "costs", cost)
    if not any(folder.glob(f"*{SUFFIX}")):
        cost = "the first run compiles, once"
        return Finding(part, f"none yet in {folder.parent}", "costs", cost)
    return Finding(part, f"in {folder.parent}, which can be written")


def _latex() -> Finding:
    from longwave.reports.engine import APT_PACKAGES, engine_present

    if engine_present():
        return Finding("LaTeX", "latexmk and pdflatex")
    cost = f"`longwave report` leaves the source: install {' '.join(APT_PACKAGES)}"
    return Finding("LaTeX", "missing", "costs", cost)


def _extras() -> Iterator[Finding]:
    """What extras bring: the page, and the work on longwave itself."""
    for package, extra, lacks, other in (
        ("pytest", "dev", "the tests cannot be run", ", or make test"),
        ("sphinx", "docs", "the site cannot be built", ", or make docs"),
        ("panel", "explore", "`longwave explore` has no page", ""),
        ("pint", "units", "`longwave fit --units` knows no units", ""),
    ):
        version = installed_version(package)
        if version is not None:
            yield Finding(package, version)
        else:
            yield Finding(
                package, "missing", "costs", f"{lacks}: pip install 'longwave[{extra}]'{other}"
            )


def print_findings(findings: Iterable[Finding]) -> None:
    """Print a line for each finding, and one more for what it costs."""
    shown = list(findings)
    width = max(len(finding.part) for finding in shown)
    for finding in shown:
        mark = {"good": " ", "costs": "-", "broken": "!"}[finding.state]
        print(f"{mark} {finding.part:{width}}  {finding.found}")
        if finding.cost:
            print(f"  {'':{width}}  {finding.cost}")
