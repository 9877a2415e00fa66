"""What the subcommands share: consoles, progress, files to be written, Ctrl-C between two items."""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import Any, NoReturn, TypeVar

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, track
from rich.text import Text

from longwave.support.interruption import interrupted
from longwave.support.progress_line import ProgressLine, in_notebook
from longwave.support.request_limits import Announcer
from longwave.support.slow_work import Clock, TimeLeft, announce, count_notice, time_told
from longwave.support.user_files import printable, shown

PIPE_WIDTH = 120
"""Columns of a table where stdout is no terminal."""

T = TypeVar("T")
Tell = Callable[[float], None]


def table_console(width: int = PIPE_WIDTH, **look: Any) -> Console:
    """The console for tables: as wide as the terminal, and wide enough for one row in a pipe."""
    console = Console(**look)
    return console if console.is_terminal else Console(width=width, **look)


def tracked(items: Iterable[T], count: int, words: str) -> Iterator[T]:
    """``items`` as they come, with a progress bar on stderr if that is a terminal."""
    console = Console(stderr=True)
    if console.is_terminal:
        count_notice()
        items = track(items, words, count, console=console, transient=True)
    yield from items


def finished(items: Iterable[T]) -> tuple[list[T], bool]:
    """The items that came until the end or until Ctrl-C, and whether it was the end."""
    found: list[T] = []
    try:
        for item in items:
            found.append(item)
    except KeyboardInterrupt:
        return found, False
    return found, True


def print_found(
    found: Sequence[Any],
    complete: bool,
    show: Callable[[Sequence[Any]], object],
    json_wanted: bool,
    program: str,
    asked: str,
) -> int:
    """Print what `finished` gives as ``show`` does, or as JSON; return the exit status.

    That is 0, or 130 where ``program`` was interrupted before all that was ``asked``.
    """
    if json_wanted:
        print_json([entry.json() for entry in found])
    else:
        show(found)
    return 0 if complete else interrupted(program, f"after {len(found)} of {asked}")


def print_json(data: object) -> None:
    """Print one JSON document; what is no number, or infinite, is null.

    >>> print_json({"error": float("nan"), "times": (0, 1.5)})
    {
      "error": null,
      "times": [
        0,
        1.5
      ]
    }
    """
    print(json.dumps(_plain(data), indent=2, allow_nan=False))


def _plain(data: Any) -> Any:
    """Tables, lists, texts and finite numbers; arrays are lists."""
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if hasattr(data, "tolist"):
        return _plain(data.tolist())
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data


def print_lines(console: Console, lines: Iterable[str]) -> None:
    """Print lines as they are, without markup and without breaking them."""
    for line in lines:
        console.print(line, markup=False, highlight=False, soft_wrap=True)


def plain_console(stderr: bool = False, soft_wrap: bool = False) -> Console:
    """A console that prints text as it is: a scene's title and name are no markup."""
    return PlainConsole(
        stderr=stderr, soft_wrap=soft_wrap, highlight=False, markup=False, emoji=False
    )


class PlainConsole(Console):
    """One on which texts of a file cannot steer the terminal: such signs are written out."""

    def render_str(self, text: str, *words: Any, **options: Any) -> Text:
        """The text of what is printed, or of a table's cell."""
        return super().render_str(printable(text), *words, **options)

    def on_broken_pipe(self) -> NoReturn:
        """Leave it to the command that the reader of the output has gone: Rich would exit here."""
        raise BrokenPipeError


def check_output(
    text: str | None,
    example: str = "run.nc",
    *,
    suffixes: Sequence[str] = (),
    force: bool = False,
    option: str = "--output",
    read: Sequence[str | Path] = (),
) -> None:
    """Raise ValueError before anything is computed if no file can be written at ``text``.

    It must end in one of the ``suffixes``, if there are any, lie in a folder that can be written,
    be no folder or device, and none of what is ``read``; without ``force`` it must not be there
    yet. ``option`` names it.
    """
    if text is None:
        return
    path = Path(text)
    if text.endswith("/") or path.is_dir():
        raise ValueError(
            f"{option} must name a file, got the folder {text} (such as {example} in it)"
        )
    if suffixes and path.suffix.lower() not in suffixes:
        raise ValueError(
            f"{option} must end in {' or '.join(suffixes)}, got {shown(path.name)} (such as "
            f"{example})"
        )
    if not path.parent.is_dir():
        raise ValueError(f"{option} must lie in an existing folder, got {text} (make it first)")
    if path.exists() and not path.is_file():
        raise ValueError(
            f"{option} must name a file, got {text}, which is none (such as {example})"
        )
    if os.path.realpath(path) in {os.path.realpath(name) for name in read}:
        raise ValueError(
            f"{option} must be a file of its own, got {text}, which is read (such as {example})"
        )
    if path.exists() and not force:
        raise ValueError(
            f"{option} must name a new file, got {text}, which is there (--force overwrites it)"
        )
    _check_folder(Path(os.path.realpath(path)).parent, option)


def _check_folder(folder: Path, option: str) -> None:
    """Raise ValueError if no file can be made in the folder: whether one can, only that says."""
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise ValueError(
            f"{option} must lie in a folder that can be written, got {folder}: {error.strerror} "
            "(name a file elsewhere)"
        ) from None


SUFFIXES = (".png", ".pdf", ".svg")
"""Of pictures."""


def picture_path(output: str | Path) -> Path:
    """The path of a picture; ValueError for a suffix that cannot be drawn."""
    path = Path(output) if isinstance(output, str | Path) else None
    if path is None or path.suffix.lower() not in SUFFIXES:
        got = shown(output if path is None else path.name)
        raise ValueError(
            f"output must be a path ending in {', '.join(SUFFIXES)}, got {got} (such as 'run.png')"
        )
    return path


def default_output(source: str, suffix: str = ".png") -> str:
    """The picture's file in the working folder, named after the run or scene.

    >>> default_output("runs/rogue_cn_k_0.5.nc"), default_output("rogue_cn_k_0.5")
    ('rogue_cn_k_0.5.png', 'rogue_cn_k_0.5.png')
    """
    return Path(source).name.removesuffix(".nc").removesuffix(".toml") + suffix


@contextmanager
def progress_bar(
    name: str,
    work: str,
    console: Console | None = None,
    clock: Clock = monotonic,
) -> Iterator[tuple[Tell, Tell]]:
    """Progress on the standard error with the time left, as `run` takes it.

    In a terminal it is a bar, in a notebook a line, and elsewhere a line now and then.

    Yields what the share done is told to, and what the seconds of ``work`` are told to: many are
    announced, and again where they have doubled, without what a checkpoint holds of them.
    """
    if in_notebook():
        with ProgressLine(name) as line:
            yield line.left.share, _of_what_is_left(line.left.foresee)
        return
    console = console or plain_console(stderr=True, soft_wrap=True)
    if not console.is_terminal:
        with time_told(work, clock) as left:

            def say(seconds: float) -> None:
                left.foresee(seconds)
                announce(work, seconds)

            yield left.share, _of_what_is_left(say)
        return
    left = TimeLeft(clock)
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), _TimeColumn(left))
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(name, total=1.0)

        def tell(seconds: float) -> None:
            left.foresee(seconds)
            bar.stop()
            announce(work, seconds)
            bar.start()

        def advance(share: float) -> None:
            count_notice()
            left.share(share)
            bar.update(task, completed=share)

        yield advance, _of_what_is_left(tell)


def _of_what_is_left(tell: Tell) -> Tell:
    """Passes on the seconds that are expected, without those that a checkpoint spares."""
    announcer = Announcer(tell)

    def told(seconds: float) -> None:
        from longwave.support.checkpoint import kept_seconds  # with NumPy

        announcer(max(0.0, seconds - kept_seconds()))

    return told


class _TimeColumn(ProgressColumn):
    """The time left beside a bar."""

    def __init__(self, left: TimeLeft) -> None:
        super().__init__()
        self._left = left

    def render(self, _: Task) -> Text:
        """The share and the time."""
        return Text(self._left.words())
