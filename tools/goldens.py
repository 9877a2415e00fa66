"""Digests of what the program gives, to see that a change of the house changes nothing of it.

    python tools/goldens.py write FILE.json [PART ...]
    python tools/goldens.py compare FILE.json [PART ...]

A part is `scenes` (every variable of every shipped scene), `sweeps` (of one cell of each shipped
sweep), `certificates` (of the catalogue), `library` (the verdicts on published statements),
`search` (digests of the search for wrong verdicts), `derivations` (JSON of every lattice and its
envelopes) or `report` (the sources in TeX but for what took time); without any it is all of them.
All but the search goes through the command line.  `compare` prints what differs, and exits with 1
if anything does.
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

import xarray as xr

from longwave.scenes.scene_file import toml_text

HOUSE = Path(__file__).parents[1]

SEEDS = (1, 2, 3, 4)
STATEMENTS = 400
"""Of the search for wrong verdicts, and how many statements each."""

TIMED = ("costs", "evaluation", "proofs", "published")
"""Parts of the report's names that hold times."""

Golden = Iterator[tuple[str, str]]


def digest(content: bytes) -> str:
    """The first 16 digits of SHA-256."""
    return hashlib.sha256(content).hexdigest()[:16]


def longwave(*argv: str, folder: Path = HOUSE) -> str:
    """What a command prints; what is wrong instead, if it fails."""
    command = [sys.executable, "-m", "longwave", *argv]
    environment = {**os.environ, "PYTHONPATH": str(HOUSE)}
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    return ended.stdout if ended.returncode < 2 else f"{ended.returncode}: {ended.stderr}"


def names(kind: str) -> list[str]:
    """What is shipped of a kind."""
    return [row["name"] for row in json.loads(longwave("list", kind, "--json"))]


def of_dataset(name: str, path: Path) -> Golden:
    """Each variable of a file."""
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


def scenes(folder: Path) -> Golden:
    """Runs of the shipped scenes."""
    for kind in ("scenes", "lattice-scenes", "bench-scenes"):
        for name in names(kind):
            path = folder / f"{name}.nc"
            longwave("run", name, "--output", str(path))
            yield from of_dataset(name, path)


def sweeps(folder: Path) -> Golden:
    """Sweeps of the first value of each field."""
    for name in names("sweeps"):
        (shipped,) = HOUSE.rglob(f"sweeps/{name}.toml")
        sweep = tomllib.loads(shipped.read_text())
        cell = sweep | {part: first_values(sweep[part]) for part in sweep.keys() & {"list", "grid"}}
        (folder / f"{name}.toml").write_text(toml_text(cell))
        words = (f"{name}.toml", "--processes", "1", "--output", f"{name}.nc")
        longwave("sweep", *words, folder=folder)
        yield from of_dataset(name, folder / f"{name}.nc")


def first_values(swept: Any) -> Any:
    """The first value of a field alone, and so of each field in a table of them."""
    if isinstance(swept, list):
        return swept[:1]
    if "from" in swept:
        return [swept["from"]]
    return {field: first_values(inner) for field, inner in swept.items()}


def certificates(folder: Path) -> Golden:
    """Of each closed form."""
    for name in names("waves"):
        path = folder / f"{name}.json"
        longwave("verify", "--only", name, "--output", str(path))
        yield name, digest(path.read_bytes()) if path.is_file() else "no certificate"


def library(folder: Path) -> Golden:
    """The verdicts."""
    for row in json.loads(longwave("library", "--json")):
        yield row["name"], row["verdict"]


def search(folder: Path) -> Golden:
    """The digests by seed."""
    for seed in SEEDS:
        argv = ["--count", str(STATEMENTS), "--seed", str(seed), "--kind", "all", "--workers", "1"]
        command = [sys.executable, "-m", "searches.verdicts", *argv]
        environment = {**os.environ, "PYTHONPATH": str(HOUSE)}
        ended = subprocess.run(command, env=environment, capture_output=True, text=True)
        found = [line for line in ended.stdout.splitlines() if line.startswith("digest ")]
        yield str(seed), " ".join(found) or ended.stderr[-500:]


def derivations(folder: Path) -> Golden:
    """JSON of each lattice, of its long waves, and with numbers of its envelope."""
    for row in json.loads(longwave("list", "lattices", "--json")):
        name = row["name"]
        numbers = ",".join(f"{c}={i + 1}" for i, c in enumerate(row["constants"]))
        envelope = ["--set", numbers, "--envelope", "k=1"] if numbers else ["--envelope", "k=1"]
        for argv in ([name, "--json"], ["check", name], [name, *envelope, "--json"]):
            yield " ".join(argv), digest(longwave("derive", *argv).encode())


def report(folder: Path) -> Golden:
    """TeX by file."""
    longwave("report", "--output", str(folder / "report"))
    for path in sorted((folder / "report").rglob("*.tex")):
        if not any(word in path.stem for word in TIMED):
            yield path.name, digest(path.read_bytes())


PARTS: dict[str, Callable[[Path], Golden]] = {
    function.__name__: function
    for function in (scenes, sweeps, certificates, library, search, derivations, report)
}


def main(mode: str, path: str, *parts: str) -> int:
    """Write digests, or compare with those written."""
    kept = json.loads(Path(path).read_text()) if Path(path).is_file() else {}
    differ = 0
    for part in parts or PARTS:
        with tempfile.TemporaryDirectory() as folder:
            found = dict(PARTS[part](Path(folder)))
        if mode == "write":
            kept[part] = found
            Path(path).write_text(json.dumps(kept, indent=1))
            print(f"{part}: {len(found)} digests", flush=True)
            continue
        before = kept.get(part, {})
        changed = [name for name in {**before, **found} if before.get(name) != found.get(name)]
        for name in changed:
            print(f"{part} {name}: {before.get(name)} -> {found.get(name)}")
        print(f"{part}: {len(changed)} of {len({**before, **found})} differ", flush=True)
        differ += len(changed)
    return int(differ > 0)


if __name__ == "__main__":
    if len(sys.argv) < 3 or sys.argv[1] not in ("write", "compare") or {*sys.argv[3:]} - {*PARTS}:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
