"""Catches: a stated limit that a formula, a file or a command exceeds without an error."""

import re
from collections.abc import Iterator
from pathlib import Path

import click
import h5py
import numpy as np
import pytest
import xarray as xr

from longwave.cli.command_tree import longwave
from longwave.runs import save_run
from tests.longwave.cli.watched_command import Ended, watched

LARGE = "x+(x+K1+K2+K3+K4+K5+K6)**30"
NESTED = "exp(" * 38 + "A*x" + ")" * 38
TERMS = "x+t+" + "+".join(f"k{number}" for number in range(1, 14))

TIME, MEMORY = 2.0, 320e6
"""The limits that are stated."""

LATE, BESIDE = 2.0, 2e8
"""Seconds and bytes that a command may take beyond its limits."""

BUSY = 60.0
"""Seconds more on a busy machine."""

OF_EACH = {"explore"}
"""Commands whose limits are those of each run, and are compared with estimates."""


SCENE = """lattice = "lattice.toml"
wave = "kdv_soliton"
eps = 0.1
slow_times = [0, 1]
half_width = 8
tolerance = 1e-3
constants = {K1 = 1, K2 = 1, K3 = 1, K4 = 1, K5 = 1, K6 = 1}
parameters = {kappa = 1}
"""


def write_inputs(folder: Path) -> None:
    """Write the hostile texts that the commands read."""
    for name, force in (("lattice", LARGE), ("nested", NESTED)):
        springs = f'[[spring]]\nbetween = ["u[n]", "u[n+1]"]\nforce = "{force}"\n'
        (folder / f"{name}.toml").write_text(f'fields = ["u"]\n{springs}')
    rows = "".join(f"{x / 10},{x / 10 + x**2 / 500}\n" for x in range(1, 9))
    (folder / "points.csv").write_text(f"stretch,force\n{rows}")
    (folder / "scene.toml").write_text(SCENE)
    (folder / "sweep.toml").write_text(f"[scene]\n{SCENE}[grid]\neps = [0.1, 0.2]\n")
    (folder / "small.toml").write_text('scene = "toda_soliton"\n[grid]\neps = [0.1, 0.2]\n')
    solution = "+".join(f"sqrt({TERMS}+{number})" for number in range(40))
    (folder / "problems.toml").write_text(
        f'[[problem]]\nequation = "u_t + u*u_x"\nsolution = "u = {solution}"\n'
    )


TOO_LONG = {
    "derive": "derive nested.toml",
    "prove": "prove problems.toml --limit 1000",
    "library": "library",
    "verify": "verify",
    "verify recheck": "verify recheck",
    "verify mutations": "verify mutations",
    "verify accuracy": "verify accuracy",
    "fit": f"fit points.csv --law {LARGE}",
    "run": "run scene.toml",
    "wave": "wave fput_strain --set K2=1,K3=0,K4=1 --near soliton --every-eps-to 3/10",
    "orbit": "orbit toda --set a=1,b=1 --sites 60 --energy 9",
    "sweep": "sweep sweep.toml",
    "plot": "plot scene.toml",
    "animate": "animate scene.toml",
    "report": "report",
    "converge": "converge scene.toml",
}
"""Texts and works that take more than the time that is stated, by command."""

TOO_LARGE = {
    "derive": ("derive", "longwave.derive.output.printout:print_derivation"),
    "prove": ("prove problems.toml", "longwave.cli.statements:answer"),
    "library": ("library kdv_one_soliton", "longwave.cli.statements:answer"),
    "verify": ("verify --only kink", "longwave.cli.verdicts:prove_all"),
    "verify recheck": ("verify recheck --only kink", "longwave.cli.recheck:written_out"),
    "verify mutations": ("verify mutations --only kink", "longwave.cli.verdicts:count_mutants"),
    "verify accuracy": (
        "verify accuracy --only kink --jobs 1",
        "longwave.reports.studies.evaluation_accuracy:measure_accuracy",
    ),
    "fit": ("fit points.csv", "longwave.cli.fit:fit_points"),
    "run": ("run toda_soliton", "longwave.cli.scene_command:_run_with_bar"),
    "wave": (
        "wave alpha_fput --set K2=1,K3=1 --speed 21/20",
        "longwave.cli.wave_command:exact_wave",
    ),
    "orbit": (
        "orbit alpha_fput --set K2=1,K3=1 --sites 2 --energy 1/50",
        "longwave.cli.orbit_command:exact_orbit",
    ),
    "sweep": ("sweep small.toml --processes 1", "longwave.runs.sweep_cells:run_cell"),
    "plot": ("plot toda_soliton", "longwave.reports.pictures.plotting:plot"),
    "animate": ("animate toda_soliton", "longwave.reports.pictures.animation:animate"),
    "report": ("report", "longwave.reports.build:write_report"),
    "converge": ("converge toda_soliton", "longwave.cli.converge:measured_convergence"),
}
"""Works that need little, and the function of each, here or in a worker, that takes all memory."""


def limited_commands(command: click.Command = longwave, above: str = "") -> Iterator[str]:
    """Return the words of all commands that have limits as options."""
    if any({"--max-time", "--max-memory"} & {*parameter.opts} for parameter in command.params):
        yield above
    if isinstance(command, click.Group):
        for name, inner in command.commands.items():
            yield from limited_commands(inner, f"{above} {name}".strip())


def test_every_command_that_has_limits_is_tested() -> None:
    """Catches: a new command with limits and without an input that exceeds them."""
    assert {*limited_commands()} - OF_EACH == {*TOO_LONG} == {*TOO_LARGE}


NOTICES = re.compile(r".*\(Ctrl-C stops it\)|measuring \w+|not installed: .*")
"""Lines that tell what a command is at."""


def without_notices(message: str) -> list[str]:
    """Return the lines on stderr that are errors."""
    return [line for line in message.splitlines() if not NOTICES.fullmatch(line)]


BEFOREHAND = f"must take at most {TIME:g} s, got about"
"""What is said where a command knows at once that its work takes longer."""


def check_ended(command: str, ended: Ended, line: str, *others: str) -> None:
    """Check that a command ended with one line that names the limit, and left no process."""
    message = without_notices(ended.errors)
    assert (ended.status, len(message)) == (2, 1), ended
    assert message[0].startswith(f"error: longwave {command} {line}") or any(
        other in message[0] for other in others
    )
    assert not ended.left


@pytest.mark.slow
@pytest.mark.parametrize("command", TOO_LONG)
def test_a_command_ends_within_its_time(command: str, tmp_path: Path) -> None:
    write_inputs(tmp_path)
    ended = watched([*TOO_LONG[command].split(), "--max-time", f"{TIME}s"], tmp_path)
    check_ended(command, ended, f"must end within {TIME:g} s and had not", BEFOREHAND)
    assert ended.seconds < TIME + LATE + BUSY


@pytest.mark.slow
@pytest.mark.parametrize("command", TOO_LARGE)
def test_a_command_ends_within_its_memory(command: str, tmp_path: Path) -> None:
    write_inputs(tmp_path)
    words, function = TOO_LARGE[command]
    limit = [*words.split(), "--max-memory", f"{MEMORY / 1e6:.0f}M"]
    ended = watched(limit, tmp_path, f"memory {function}")
    check_ended(command, ended, "must fit 320 MB and did not (take less, or raise --max-memory)")
    assert ended.memory < MEMORY + BESIDE


@pytest.mark.slow
def test_compiled_code_that_does_not_end_is_ended(tmp_path: Path) -> None:
    """Compiled code holds the GIL, so that nothing in its process can stop it."""
    words, function = TOO_LARGE["derive"]
    seconds = 2.0 * TIME  # in which it is reached
    ended = watched([*words.split(), "--max-time", f"{seconds}s"], tmp_path, f"time {function}")
    check_ended("derive", ended, f"must end within {seconds:g} s and had not")
    assert ended.seconds < seconds + LATE + BUSY


def write_fill_values(path: Path, sites: int) -> None:
    """Write the file of a run that is small on the disk and large in memory."""
    run = xr.Dataset({"strain": (("time", "site"), np.zeros((2, 4)))}, {"site": np.arange(4)})
    save_run(run, path)
    with h5py.File(path, "r+") as file:
        attributes = dict(file["strain"].attrs)
        for name, shape in (("strain", (2, sites)), ("site", (sites,))):
            saved = {key: file[name].attrs[key] for key in ("_Netcdf4Dimid",) if key in attributes}
            kind = file[name].dtype
            del file[name]
            result = file.create_dataset(
                name, shape, kind, chunks=(*shape[:-1], 10**5), fillvalue=1
            )
            result.attrs.update(saved)
        file["site"].make_scale("site")
        file["strain"].dims[0].attach_scale(file["time"])
        file["strain"].dims[1].attach_scale(file["site"])
        noise = np.random.default_rng(1).integers(0, 255, 2_000_000, dtype="u1")
        file.create_dataset("pad", data=noise)


@pytest.mark.slow
@pytest.mark.parametrize("command", ["plot", "run"])
def test_a_file_of_fill_values_is_read_within_the_memory_that_is_stated(
    command: str, tmp_path: Path
) -> None:
    write_fill_values(tmp_path / "run.nc", 40_000_000)
    ended = watched([command, "run.nc", "--max-memory", "320M"], tmp_path)
    message = without_notices(ended.errors)
    assert (ended.status, len(message)) == (2, 1), ended
    assert "memory" in message[0]
    assert ended.memory < MEMORY + BESIDE
