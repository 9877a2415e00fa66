"""``python -m verify run SCENE``: run a scene file or a shipped scene."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import xarray as xr
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from derive.command_line import announce, fail, interrupted
from verify.comparison.restart import save_run
from verify.comparison.run import run
from verify.comparison.scene import (
    Scene,
    load_scene,
    with_tolerance,
)
from verify.comparison.scene_families import rational_family_scenes
from verify.comparison.summary import print_summary
from verify.comparison.trust import trust_attributes
from verify.comparison.unfinished import UnfinishedRun

Tell = Callable[[float], None]


@dataclass
class Options:
    """Which scene, with what in the place of what it says, and where the run is written."""

    scene: str = ""
    tolerance: float | None = None
    engine: str | None = None
    output: str | None = None


def run_and_print(options: Options, program: str) -> int:
    """Run one scene, print its errors and its cost, and write it if asked.

    Exit status 0, 1 if the run blew up, 2 for bad input, told in one line, and 130 after Ctrl-C,
    which ``program`` tells: what was recorded until then is printed and written, too. More than
    10 s are announced.
    """
    errors = plain_console(stderr=True, soft_wrap=True)
    try:
        check_output(options.output)
        scene = _changed(find_scene(options.scene), options.tolerance, options.engine)
        trust = trust_attributes(scene)
        dataset = _run_with_bar(scene, errors).assign_attrs(trust)
        _give(dataset, scene, options.output)
    except UnfinishedRun as stop:
        kept = stop.run.assign_attrs(trust)
        try:
            _give(kept, scene, options.output)
        except OSError as error:
            return fail(error)
        where = f" in {options.output}" if options.output else ""
        return interrupted(program, f"{kept.sizes['time']} snapshots are kept{where}")
    except KeyboardInterrupt:
        return interrupted(program, "nothing was recorded yet")
    except (ValueError, OSError) as error:
        return fail(error)
    except MemoryError as error:
        return fail(f"sites must fit the memory, got a scene that does not: {error} (take fewer)")
    return 1 if dataset.attrs["blow_up"] else 0


def _give(dataset: xr.Dataset, scene: Scene, output: str | None) -> None:
    """Write a run if asked, and print its summary; raises OSError if it cannot be written."""
    if output is not None:
        save_run(dataset, output)
    print_summary(dataset, scene, plain_console())


def plain_console(stderr: bool = False, soft_wrap: bool = False) -> Console:
    """A console that prints text as it is: a scene's title and name are no markup."""
    return Console(stderr=stderr, soft_wrap=soft_wrap, highlight=False, markup=False, emoji=False)


def check_output(text: str | None, example: str = "run.nc") -> None:
    """Raise ValueError before anything is computed if ``text`` can be no file's path."""
    if text is None:
        return
    if text.endswith("/") or Path(text).is_dir():
        raise ValueError(
            f"--output must name a file, got the folder {text} (such as {example} in it)"
        )
    if not Path(text).parent.is_dir():
        raise ValueError(f"--output must lie in an existing folder, got {text} (make it first)")


def find_scene(text: str) -> Scene:
    """The scene in a TOML file, or the shipped one or member of a family of that name.

    Raises ValueError for a file that cannot be read and a name that is none.
    """
    if text.endswith(".toml") or Path(text).is_file():
        return Scene.from_toml(text)
    family = rational_family_scenes()
    return family[text] if text in family else load_scene(text)


def _changed(scene: Scene, tolerance: float | None, engine: str | None) -> Scene:
    """The scene with what the command line says in the place of what the file says."""
    if tolerance is not None:
        scene = with_tolerance(scene, tolerance)
    return scene if engine is None else replace(scene, engine=engine)


def _run_with_bar(scene: Scene, console: Console) -> xr.Dataset:
    wanted = "" if scene.tolerance is None else f" to {scene.tolerance:g}"
    with progress_bar(scene.name, f"{scene.name}{wanted}", console) as (advance, tell):
        return run(scene, advance, tell)


@contextmanager
def progress_bar(name: str, work: str, console: Console) -> Iterator[tuple[Tell, Tell]]:
    """A bar, where the console is a terminal, as `run` takes it.

    Yields what the share done is told to, and what the seconds of long ``work`` are told to.
    """
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeRemainingColumn())
    hidden = not console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=hidden) as bar:
        task = bar.add_task(name, total=1.0)

        def tell(seconds: float) -> None:
            bar.stop()
            announce(work, seconds)
            bar.start()

        yield lambda share: bar.update(task, completed=share), tell
