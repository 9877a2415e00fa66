"""``longwave run FILE.nc``: run the scene in a run's file again and say whether it has its bits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from longwave.runs.output_checkpoint import OutputCheckpoint
from longwave.runs.repeated_run import compare_runs
from longwave.runs.run_file import load_run, scene_of_run
from longwave.scenes import any_scene
from longwave.support.command_line import fail, interrupted
from longwave.support.console import plain_console, print_lines, progress_bar

if TYPE_CHECKING:
    import xarray as xr

    from longwave.cli.scene_command import RunOptions
    from longwave.scenes.chain.scene import Scene
    from longwave.scenes.lattice_scene import LatticeScene


def repeat_and_print(options: RunOptions, program: str) -> int:
    """Run the scene in a run's file again and tell what differs.

    Exit status 0 for the same bits, 1 for others, 2 for a file that is no finished run, 130 after
    Ctrl-C.
    """
    checkpoint = OutputCheckpoint(options.output)
    try:
        kept = _finished_run(options)
        scene = scene_of_run(kept)
        with checkpoint.kept(scene):
            made = _run_again(scene, options.scene)
    except KeyboardInterrupt:
        return interrupted(program, checkpoint.left(f"{options.scene} is as it was"))
    except (ValueError, OSError) as error:
        return fail(error)
    except MemoryError as error:
        return fail(f"run must fit the memory, got one that does not: {error} (take fewer sites)")
    broken = checkpoint.settle(lambda: made, options.force)
    found = compare_runs(kept, made)
    first, *further = found.lines()
    print_lines(plain_console(), [f"{options.scene}: {first}", *further])
    return broken or (0 if found.is_same else 1)


def _finished_run(options: RunOptions) -> xr.Dataset:
    """The run in the file; ValueError for options that a repetition cannot have."""
    for name in ("tolerance", "engine", "store"):
        given = getattr(options, name)
        if given is not None:
            raise ValueError(
                f"--{name} must not be given with a run, got {given} (it is run as it was)"
            )
    run = load_run(options.scene)
    if "unfinished" in run.attrs:
        raise ValueError(
            f"run must have come to its end to be repeated, got {options.scene}, unfinished: "
            f"{run.attrs['unfinished']} (run its scene)"
        )
    return run


def _run_again(scene: Scene | LatticeScene, source: str) -> xr.Dataset:
    errors = plain_console(stderr=True, soft_wrap=True)
    with progress_bar(scene.name, f"{source} again", errors) as bar:
        return any_scene.run(scene, *bar)
