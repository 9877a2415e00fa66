"""Catches: a limit that is stated, and that a formula or a file goes past in silence."""

import os
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from longwave.runs import save_run

HOUSE = Path(__file__).parents[3]

LARGE = "x+(x+K1+K2+K3+K4+K5+K6)**30"
NESTED = "exp(" * 38 + "A*x" + ")" * 38
BESIDE, LATE = 2e8, 2.0
"""Bytes and seconds that a command may take beyond its limits."""


def _lattice(force: str, folder: Path) -> str:
    path = folder / "lattice.toml"
    springs = f'fields = ["u"]\n[[spring]]\nbetween = ["u[n]", "u[n+1]"]\nforce = "{force}"\n'
    path.write_text(springs)
    return str(path)


def _points(folder: Path) -> str:
    path = folder / "points.csv"
    path.write_text("".join(f"{x / 10},{x / 10 + x**2 / 500}\n" for x in range(1, 9)))
    return str(path)


def _run(*arguments: str) -> tuple[int, str, float]:
    """Exit status, stderr and seconds of a command."""
    begin = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-m", "longwave", *arguments],
        env={**os.environ, "PYTHONPATH": str(HOUSE)},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    return done.returncode, _without_notices(done.stderr), time.monotonic() - begin


def _without_notices(said: str) -> str:
    """What a command says on stderr, but for how long it has been at work on a busy machine."""
    lines = said.splitlines(keepends=True)
    return "".join(line for line in lines if "(Ctrl-C stops it)" not in line)


@pytest.mark.slow
@pytest.mark.parametrize("force", [LARGE, NESTED], ids=["a high power", "nested exponentials"])
@pytest.mark.parametrize("command", ["derive", "fit"])
def test_a_formula_that_does_not_end_is_ended(command: str, force: str, tmp_path: Path) -> None:
    """Within two seconds of the limit, of which half a one is Python's start."""
    if command == "derive":
        arguments = ["derive", _lattice(force, tmp_path)]
    else:
        arguments = ["fit", _points(tmp_path), "--law", force]
    status, said, seconds = _run(*arguments, "--max-time", "3s")
    assert status == 2, said
    assert said.count("\n") == 1
    if "must end within" in said:
        assert said.startswith(f"error: longwave {command} must end within 3 s")
        assert seconds < 3.0 + LATE + 60.0  # another minute where the machine is busy
    else:
        assert said.startswith("error: ")


@pytest.mark.slow
def test_time_ends_a_command_as_ctrl_c_does_and_says_why(tmp_path: Path) -> None:
    status, said, _ = _run("derive", _lattice(LARGE, tmp_path), "--max-time", "2s")
    assert (status, said) == (
        2,
        "error: longwave derive must end within 2 s and had not (take less, or raise --max-time)\n",
    )


@pytest.mark.slow
def test_a_file_of_fill_values_is_read_within_the_memory_that_is_stated(tmp_path: Path) -> None:
    path, sites = tmp_path / "run.nc", 40_000_000
    run = xr.Dataset({"strain": (("time", "site"), np.zeros((2, 4)))}, {"site": np.arange(4)})
    save_run(run, path)
    with h5py.File(path, "r+") as file:
        attributes = dict(file["strain"].attrs)
        for name, shape in (("strain", (2, sites)), ("site", (sites,))):
            kept = {key: file[name].attrs[key] for key in ("_Netcdf4Dimid",) if key in attributes}
            kind = file[name].dtype
            del file[name]
            made = file.create_dataset(name, shape, kind, chunks=(*shape[:-1], 10**5), fillvalue=1)
            made.attrs.update(kept)
        file["site"].make_scale("site")
        file["strain"].dims[0].attach_scale(file["time"])
        file["strain"].dims[1].attach_scale(file["site"])
        noise = np.random.default_rng(1).integers(0, 255, 2_000_000, dtype="u1")
        file.create_dataset("pad", data=noise)
    code = (
        "import sys; from longwave.__main__ import main\n"
        "from searches.peak_memory import peak_bytes\n"
        "status = main()\n"
        "print(peak_bytes()); sys.exit(status)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, "plot", str(path), "--output", str(tmp_path / "a.png"),
         "--max-memory", "200M"],
        env={**os.environ, "PYTHONPATH": str(HOUSE)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2, done.stdout + done.stderr
    said = _without_notices(done.stderr)
    assert said.count("\n") == 1
    assert "memory" in said
    assert int(done.stdout.split()[-1]) < 200e6 + BESIDE
