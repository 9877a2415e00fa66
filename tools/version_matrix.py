"""Tests with the oldest and the newest versions that `pyproject.toml` allows, a row a job.

``oldest`` takes the lower bound of every requirement and of Python, ``newest`` what pip finds on
the newest Python here.  Each job installs a copy of the tracked files into a virtual environment
of its own and runs `TESTS` there; a second call keeps the environment.  The exit status is 1 unless
all passed.

    python tools/version_matrix.py [--folder /tmp/longwave-versions] [--job oldest] [--limit 300]
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

TESTS = (
    *("tests/derive", "tests/lattice", "tests/runs", "tests/longwave", "tests/solutions"),
    *("tests/scenes", "tests/reports/test_reports_figures.py"),
    "tests/longwave/cli",
)
"""In this order until time is up: what touches each of the dependencies."""

TOOLS = ("pytest", "pytest-xdist", "hypothesis")
"""What the tests need of the extra `dev`."""

COMPANIONS = ("pyparsing<3.3",)
"""What the oldest versions need of packages that we do not name: Matplotlib 3.9 calls a name that
pyparsing 3.3 warns of."""

EXTRAS = ("cluster", "explore", "units")

SHOWN = (
    *("numpy", "scipy", "numba", "xarray", "h5netcdf", "matplotlib", "sympy", "python-flint"),
    *("ducc0", "click", "rich", "jinja2", "distributed", "panel", "pint"),
)
"""Packages whose versions stand in a row."""


@dataclass(frozen=True)
class Row:
    """Result of a job; ``failed`` are the tests that did not pass, by name."""

    job: str
    python: str
    versions: str
    passed: int
    failed: tuple[str, ...]
    seconds: float
    remark: str = ""

    @property
    def good(self) -> bool:
        """Whether tests ran and none failed."""
        return self.passed > 0 and not self.failed and not self.remark.startswith("no ")

    def __str__(self) -> str:
        tests = f"{self.passed} passed, {len(self.failed)} failed, {self.seconds:.0f} s"
        rows = [f"{self.job} (Python {self.python}): {tests}{self.remark and '; ' + self.remark}"]
        rows += [f"    {self.versions}", *(f"    FAILED {name}" for name in self.failed)]
        return "\n".join(rows)


def requirements() -> tuple[str, list[str]]:
    """Return the oldest Python, and all requirements of package, extras and tests."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    tools = [text for text in extras["dev"] if re.split(r"[<>=\[]", text)[0] in TOOLS]
    needed = [*project["dependencies"], *tools, *(text for e in EXTRAS for text in extras[e])]
    return project["requires-python"].removeprefix(">="), needed


def lowest(needed: list[str]) -> list[str]:
    """Return ``name==version`` of each requirement that has a lower bound.

    >>> lowest(["sympy>=1.14,<1.15", "llvmlite"])
    ['sympy==1.14']
    """
    found = (re.match(r"([\w.-]+)>=([\w.]+)", text) for text in needed)
    return [f"{match[1]}=={match[2]}" for match in found if match]


def pythons() -> dict[tuple[int, ...], str]:
    """Return the interpreters here, by version: those on the path, and those of pyenv."""
    folders = [Path(text) for text in os.get_exec_path()]
    folders += sorted((Path.home() / ".pyenv" / "versions").glob("*/bin"))
    found: dict[tuple[int, ...], str] = {}
    for folder in folders:
        for path in folder.glob("python3.*"):
            match = re.fullmatch(r"python3\.(\d+)", path.name)
            if match and _runs(path):
                found[3, int(match[1])] = str(path)
    return found


def _runs(python: Path) -> bool:
    """Return whether it is an interpreter and no pointer to one that is not chosen."""
    return subprocess.run([python, "-P", "-c", "import venv"], capture_output=True).returncode == 0


def run_job(job: str, folder: Path, limit: float) -> Row:
    """Make the environment of a job and run the tests in it, for so many seconds at most."""
    oldest, needed = requirements()
    here = pythons()
    version = tuple(map(int, oldest.split("."))) if job == "oldest" else max(here)
    if version not in here:
        return Row(job, ".".join(map(str, version)), "", 0, (), 0.0, "no such Python here")
    tree, venv = folder / job / "tree", folder / job / "venv"
    copy_tree(tree)
    folder.joinpath(job, "constraints.txt").write_text(
        "\n".join([*lowest(needed), *COMPANIONS] if job == "oldest" else []), encoding="utf-8"
    )
    if not (venv / "installed").exists():
        fault = install(here[version], tree, venv)
        if fault:
            return Row(job, ".".join(map(str, version)), "", 0, (), 0.0, f"no install: {fault}")
    return tested(job, tree, venv / "bin" / "python", limit)


def copy_tree(tree: Path) -> None:
    """Copy the tracked files as they are now."""
    shutil.rmtree(tree, ignore_errors=True)
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True
    )
    for name in listed.stdout.rstrip("\0").split("\0"):
        if (ROOT / name).exists():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, tree / name, follow_symlinks=False)  # rooms are links


def install(python: str, tree: Path, venv: Path) -> str:
    """Make the environment; returns what is wrong, or nothing."""
    shutil.rmtree(venv, ignore_errors=True)
    subprocess.run([python, "-P", "-m", "venv", venv], check=True)
    tools = [text for text in requirements()[1] if re.split(r"[<>=]", text)[0] in TOOLS]
    words = ["-P", "-m", "pip", "install", "-q", "-c", "constraints.txt", "--only-binary", ":all:"]
    words += ["-e", f"tree[{','.join(EXTRAS)}]", *tools]
    done = subprocess.run(
        [venv / "bin" / "python", *words], cwd=venv.parent, capture_output=True, text=True
    )
    if done.returncode:
        return " ".join(done.stderr.split())[-600:]
    (venv / "installed").touch()
    return ""


def tested(job: str, tree: Path, python: Path, limit: float) -> Row:
    """Run the tests, each group until time is up."""
    failed: list[str] = []
    passed, begun, remark = 0, time.monotonic(), ""
    settings = {**os.environ, "PYTHONPATH": str(tree)}
    for group in TESTS:
        left = limit - (time.monotonic() - begun)
        words = [python, "-P", "-m", "pytest", "-q", "-rfE", "-p", "no:cacheprovider", group]
        try:
            if left <= 0:
                raise subprocess.TimeoutExpired(words, limit)
            done = subprocess.run(
                words, cwd=tree, env=settings, capture_output=True, text=True, timeout=left
            )
        except subprocess.TimeoutExpired:
            remark = f"stopped after {limit:g} s in {group}"
            break
        names = re.findall(r"^(?:FAILED|ERROR) (.*)$", done.stdout, re.MULTILINE)
        failed += [name[:200] for name in names]
        count = re.search(r"(\d+) passed", done.stdout)
        passed += int(count[1]) if count else 0
        if done.returncode and not names:
            failed.append(f"{group}: {' '.join((done.stdout + done.stderr).split())[-300:]}")
    seconds = time.monotonic() - begun
    version = _said(python, "import platform; print(platform.python_version())")
    code = f"from importlib.metadata import version\nfor p in {SHOWN!r}: print(p, version(p))"
    versions = ", ".join(_said(python, code).splitlines())
    return Row(job, version, versions, passed, tuple(failed), seconds, remark)


def _said(python: Path, code: str) -> str:
    words = [python, "-P", "-c", code]
    return subprocess.run(words, capture_output=True, text=True).stdout.strip()


def main() -> int:
    """Run the jobs and print a row each; 1 unless all passed."""
    parser = argparse.ArgumentParser(description="Tests with oldest and newest versions.")
    parser.add_argument("--folder", type=Path, default=Path("/tmp/longwave-versions"))
    parser.add_argument("--job", action="append", choices=["oldest", "newest"])
    parser.add_argument("--limit", type=float, default=300.0, help="seconds for a job's tests")
    options = parser.parse_args()
    good = True
    for job in options.job or ("oldest", "newest"):
        row = run_job(job, options.folder.resolve(), options.limit)
        print(row, flush=True)
        good = good and row.good
    return int(not good)


if __name__ == "__main__":
    sys.exit(main())
