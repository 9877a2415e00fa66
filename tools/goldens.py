"""Digests of what the program gives, to see that a change of the house changes nothing of it.

    python tools/goldens.py write FILE.json [PART ...]
    python tools/goldens.py compare FILE.json [PART ...]

A part is `scenes` (every variable of every shipped scene), `values` (what those are compared by,
with the error estimate of each run), `sweeps` (of one cell of each shipped sweep), `certificates`
(of the catalogue), `library` (the verdicts on published statements), `search` (digests of the
search for wrong verdicts), `derivations` (JSON of every lattice and its envelopes) or `report` (the
sources in TeX but for what took time); without any it is all of them.
All but the search goes through the command line.  `compare` prints what differs, and exits with 1
if anything does. Values differ if they are further apart than the sum of both estimates.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from longwave.scenes.description.scene_file import toml_text

HOUSE = Path(__file__).parents[1]

SEEDS = (1, 2, 3, 4)
STATEMENTS = 400
"""Of the search for wrong verdicts, and how many statements each."""

TIMED = ("costs", "evaluation", "proofs", "published")
"""Parts of the report's names that hold times."""

ROUNDING = 1e-13
"""Share of a variable's largest value by which values without an estimate may differ."""

Golden = Iterator[tuple[str, Any]]


def digest(content: bytes) -> str:
    """Return the first 16 digits of SHA-256."""
    return hashlib.sha256(content).hexdigest()[:16]


def longwave(*argv: str, folder: Path = HOUSE) -> str:
    """Return a command's output, or the error if it fails."""
    command = [sys.executable, "-P", "-m", "longwave", *argv]
    environment = {**os.environ, "PYTHONPATH": str(HOUSE)}
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    return ended.stdout if ended.returncode < 2 else f"{ended.returncode}: {ended.stderr}"


def names(kind: str) -> list[str]:
    """Return the shipped names of a kind."""
    return [row["name"] for row in json.loads(longwave("list", kind, "--json"))]


def of_dataset(name: str, path: Path) -> Golden:
    """Return digests of each variable of a file."""
    if not path.is_file():
        yield name, "no file"
        return
    with xr.open_dataset(path, engine="h5netcdf", decode_timedelta=False) as data:
        for variable, values in sorted(data.variables.items(), key=str):
            if "seconds" in str(variable):
                continue
            yield (
                f"{name}/{variable}",
                f"{dict(values.sizes)} {digest(values.to_numpy().tobytes())}",
            )


def shipped_runs(folder: Path) -> Iterator[tuple[str, Path]]:
    """Run every shipped scene; yield its name and its file, which is not there if it failed."""
    for kind in ("scenes", "lattice-scenes", "bench-scenes"):
        for name in names(kind):
            path = folder / f"{name}.nc"
            longwave("run", name, "--output", str(path))
            yield name, path


def scenes(folder: Path) -> Golden:
    """Return runs of the shipped scenes."""
    for name, path in shipped_runs(folder):
        yield from of_dataset(name, path)


def values(folder: Path) -> Golden:
    """Return variables of the runs of the shipped scenes, with the error of each."""
    for name, path in shipped_runs(folder):
        if not path.is_file():
            yield name, "no file"
            continue
        with xr.open_dataset(path, engine="h5netcdf", decode_timedelta=False) as data:
            error = run_error(data)
            for variable, array in data.data_vars.items():
                if array.dtype.kind == "f" and "seconds" not in str(variable):
                    allowed = error / error_unit(data, str(variable))
                    found = [repr(float(value)) for value in array.to_numpy().ravel()]
                    yield f"{name}/{variable}", {"error": allowed, "values": found}


def run_error(data: xr.Dataset) -> float:
    """Return the estimated error of a run, in its unit; with a stated step, both measured parts.

    Infinite where the run measured none.
    """
    if "error_estimate" in data.attrs:
        return float(data.attrs["error_estimate"])
    parts = [name for name in ("time_step_error", "domain_error") if name in data]
    return sum(float(data[name].max()) for name in parts) if parts else np.inf


def error_unit(data: xr.Dataset, variable: str) -> float:
    """Return a run's unit of error over a variable's: 1, eps**-power, or the wave's size."""
    scene = tomllib.loads(data.attrs["scene"])
    power = int(data.attrs.get("power", 0))
    unit = float(scene.get("eps", 1.0)) ** power
    units = str(data[variable].attrs.get("units", ""))
    if "eps" in units:
        return 1.0
    if variable.startswith("error"):
        sizes = np.abs(data["analytic"] - data["background"]).max("site")
        return float(sizes.min()) / unit
    return 1.0 / unit


def sweeps(folder: Path) -> Golden:
    """Return sweeps of the first value of each field."""
    for name in names("sweeps"):
        (shipped,) = HOUSE.rglob(f"sweeps/{name}.toml")
        sweep = tomllib.loads(shipped.read_text())
        cell = sweep | {part: first_values(sweep[part]) for part in sweep.keys() & {"list", "grid"}}
        (folder / f"{name}.toml").write_text(toml_text(cell))
        words = (f"{name}.toml", "--processes", "1", "--output", f"{name}.nc")
        longwave("sweep", *words, folder=folder)
        yield from of_dataset(name, folder / f"{name}.nc")


def first_values(swept: Any) -> Any:
    """Return the first value of a field alone, and so of each field in a table of them."""
    if isinstance(swept, list):
        return swept[:1]
    if "from" in swept:
        return [swept["from"]]
    return {field: first_values(inner) for field, inner in swept.items()}


def certificates(folder: Path) -> Golden:
    """Return the certificate of each closed form."""
    for name in names("waves"):
        path = folder / f"{name}.json"
        longwave("verify", "--only", name, "--output", str(path))
        yield name, digest(path.read_bytes()) if path.is_file() else "no certificate"


def library(folder: Path) -> Golden:
    """Return the verdicts."""
    for row in json.loads(longwave("library", "--json")):
        yield row["name"], row["verdict"]


def search(folder: Path) -> Golden:
    """Return the digests by seed."""
    for seed in SEEDS:
        argv = ["--count", str(STATEMENTS), "--seed", str(seed), "--kind", "all", "--workers", "1"]
        command = [sys.executable, "-P", "-m", "searches.verdicts", *argv]
        environment = {**os.environ, "PYTHONPATH": str(HOUSE)}
        ended = subprocess.run(command, env=environment, capture_output=True, text=True)
        found = [line for line in ended.stdout.splitlines() if line.startswith("digest ")]
        yield str(seed), " ".join(found) or ended.stderr[-500:]


def derivations(folder: Path) -> Golden:
    """Return JSON of each lattice, of its long waves, and with numbers of its envelope."""
    for row in json.loads(longwave("list", "lattices", "--json")):
        name = row["name"]
        numbers = ",".join(f"{c}={i + 1}" for i, c in enumerate(row["constants"]))
        envelope = ["--set", numbers, "--envelope", "k=1"] if numbers else ["--envelope", "k=1"]
        for argv in ([name, "--json"], ["check", name], [name, *envelope, "--json"]):
            yield " ".join(argv), digest(longwave("derive", *argv).encode())


def report(folder: Path) -> Golden:
    """Return the report's TeX by file."""
    longwave("report", "--output", str(folder / "report"))
    for path in sorted((folder / "report").rglob("*.tex")):
        if not any(word in path.stem for word in TIMED):
            yield path.name, digest(path.read_bytes())


PARTS: dict[str, Callable[[Path], Golden]] = {
    function.__name__: function
    for function in (scenes, values, sweeps, certificates, library, search, derivations, report)
}


def differs(before: Any, after: Any) -> str:
    """Return how two results differ; "" if they do not, or by no more than their errors."""
    if not (isinstance(before, dict) and isinstance(after, dict)):
        return "" if before == after else f"{before} -> {after}"
    old, new = (np.array(each["values"], float) for each in (before, after))
    if old.shape != new.shape:
        return f"{old.size} values -> {new.size}"
    allowed = before["error"] + after["error"]
    allowed += ROUNDING * np.max(np.abs(old), initial=0.0, where=np.isfinite(old))
    distance = np.where(np.isnan(old) & np.isnan(new), 0.0, np.abs(old - new))
    largest = float(np.max(distance, initial=0.0))
    return "" if largest <= allowed else f"{largest:.3g} apart, {allowed:.3g} allowed"


def main(mode: str, path: str, *parts: str) -> int:
    """Write digests, or compare with those written."""
    stored = json.loads(Path(path).read_text()) if Path(path).is_file() else {}
    differ = 0
    for part in parts or PARTS:
        with tempfile.TemporaryDirectory() as folder:
            found = dict(PARTS[part](Path(folder)))
        if mode == "write":
            stored[part] = found
            Path(path).write_text(json.dumps(stored, indent=1))
            print(f"{part}: {len(found)} digests", flush=True)
            continue
        before = stored.get(part, {})
        changed = 0
        for name in {**before, **found}:
            if difference := differs(before.get(name), found.get(name)):
                print(f"{part} {name}: {difference}")
                changed += 1
        print(f"{part}: {changed} of {len({**before, **found})} differ", flush=True)
        differ += changed
    return int(differ > 0)


if __name__ == "__main__":
    if len(sys.argv) < 3 or sys.argv[1] not in ("write", "compare") or {*sys.argv[3:]} - {*PARTS}:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
