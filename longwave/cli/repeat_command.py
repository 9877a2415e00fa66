"""``longwave run FILE.nc``: run the scene in a run's file again and say whether it has its bits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from longwave.runs.output_checkpoint import OutputCheckpoint
from longwave.runs.repeated_run import compare_runs
from longwave.runs.run_file import load_run, scene_of_run
from longwave.support.command_line import fail, interrupted
from longwave.support.console import plain_console, print_lines, progress_bar

if TYPE_CHECKING:
    import xarray as xr

    from longwave.scenes.scene import Scene


def repeat_and_print(
    source: str, program: str, output: str | None, force: bool, changed: Mapping[str, object]
) -> int:
    """Run the scene in a run's file again and tell what differs.

    Nothing can be ``changed``: all of these options must be None. Exit status 0 for the same bits,
    1 for others, 2 for a file that is no finished run, 130 after Ctrl-C.
    """
    checkpoint = OutputCheckpoint(output)
    try:
        kept = _finished_run(source, changed)
        scene = scene_of_run(kept)
        with checkpoint.kept(scene):
            made = _run_again(scene, source)
    except KeyboardInterrupt:
        return interrupted(program, checkpoint.left(f"{source} is as it was"))
    except (ValueError, OSError) as error:
        return fail(error)
    except MemoryError as error:
        return fail(f"run must fit the memory, got one that does not: {error} (take fewer sites)")
    broken = checkpoint.settle(lambda: made, force)
    found = compare_runs(kept, made)
    first, *further = found.lines()
    print_lines(plain_console(), [f"{source}: {first}", *further])
    return broken or (0 if found.is_same else 1)


def _finished_run(source: str, changed: Mapping[str, object]) -> xr.Dataset:
    """The run in the file; ValueError for options that a repetition cannot have."""
    for name, given in changed.items():
        if given is not None:
            raise ValueError(
                f"--{name} must not be given with a run, got {given} (it is run as it was)"
            )
    run = load_run(source)
    if "unfinished" in run.attrs:
        raise ValueError(
            f"run must have come to its end to be repeated, got {source}, unfinished: "
            f"{run.attrs['unfinished']} (run its scene)"
        )
    return run


def _run_again(scene: Scene, source: str) -> xr.Dataset:
    errors = plain_console(stderr=True, soft_wrap=True)
    with progress_bar(scene.name, f"{source} again", errors) as bar:
        return scene.run(*bar)
