"""Output of the subcommands: consoles, tables, JSON, progress, checks of output files."""

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
from longwave.support.slow_work import Clock, TimeLeft, announce, count_notice, report_time_left
from longwave.support.user_files import printable, shown

PIPE_WIDTH = 120
"""Width of a table, in columns of text, if stdout is not a terminal."""

T = TypeVar("T")
Tell = Callable[[float], None]


def table_console(width: int = PIPE_WIDTH, **look: Any) -> Console:
    """Return the console for tables: as wide as the terminal, or ``width`` in a pipe."""
    console = Console(**look)
    return console if console.is_terminal else Console(width=width, **look)


def tracked(items: Iterable[T], count: int, words: str) -> Iterator[T]:
    """Yield ``items``, with a progress bar labelled ``words`` on stderr if that is a terminal."""
    console = Console(stderr=True)
    if console.is_terminal:
        count_notice()
        items = track(items, words, count, console=console, transient=True)
    yield from items


def finished(items: Iterable[T]) -> tuple[list[T], bool]:
    """Collect items to the end or to Ctrl-C; return them, and whether the end was reached."""
    collected: list[T] = []
    try:
        for item in items:
            collected.append(item)
    except KeyboardInterrupt:
        return collected, False
    return collected, True


def print_results(
    results: Sequence[Any],
    complete: bool,
    show: Callable[[Sequence[Any]], object],
    json_wanted: bool,
    program: str,
    requested: str,
) -> int:
    """Print results by ``show`` or as JSON; return 0, or 130 if they are not ``complete``."""
    if json_wanted:
        print_json([entry.json() for entry in results])
    else:
        show(results)
    return 0 if complete else interrupted(program, f"after {len(results)} of {requested}")


def print_json(data: object) -> None:
    """Print one JSON document; nan and infinite numbers become null.

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
    """Return data as dictionaries, lists, texts and finite numbers; arrays become lists."""
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if hasattr(data, "tolist"):
        return _plain(data.tolist())
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data


def print_lines(console: Console, lines: Iterable[str]) -> None:
    """Print lines literally, without markup or line breaks."""
    for line in lines:
        console.print(line, markup=False, highlight=False, soft_wrap=True)


def plain_console(stderr: bool = False, soft_wrap: bool = False) -> Console:
    """Return a console that prints text literally, such as a scene's title, without markup."""
    return PlainConsole(
        stderr=stderr, soft_wrap=soft_wrap, highlight=False, markup=False, emoji=False
    )


class PlainConsole(Console):
    """Console that escapes control characters, so that no text can steer the terminal."""

    def render_str(self, text: str, *words: Any, **options: Any) -> Text:
        """Return the text with control characters escaped, also in a table's cell."""
        return super().render_str(printable(text), *words, **options)

    def on_broken_pipe(self) -> NoReturn:
        """Raise BrokenPipeError, for the command to handle; Rich would exit the process here."""
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
    """Raise ValueError, before anything is computed, if no file can be written at ``text``.

    ``text`` must end in one of the ``suffixes``, if any are given, and name a file in a writable
    folder, which is no folder or device and none of the files ``read``. Without ``force`` the file
    must not exist. ``option`` is the option's name in errors.
    """
    if text is None:
        return
    path = Path(text)
    if text.endswith("/") or path.is_dir():
        raise ValueError(f"{option} must name a file, got the folder {text} (name {example} in it)")
    if suffixes and path.suffix.lower() not in suffixes:
        raise ValueError(
            f"{option} must end in {' or '.join(suffixes)}, got {shown(path.name)} (such as "
            f"{example})"
        )
    if not path.parent.is_dir():
        raise ValueError(f"{option} must lie in an existing folder, got {text} (create it first)")
    if path.exists() and not path.is_file():
        raise ValueError(
            f"{option} must name a file, got {text}, which is not a file (such as {example})"
        )
    if os.path.realpath(path) in {os.path.realpath(name) for name in read}:
        raise ValueError(
            f"{option} must not be an input file, got {text}, which is read (such as {example})"
        )
    if path.exists() and not force:
        raise ValueError(
            f"{option} must name a new file, got {text}, which exists (--force overwrites it)"
        )
    _check_folder(Path(os.path.realpath(path)).parent, option)


def _check_folder(folder: Path, option: str) -> None:
    """Raise ValueError if a test file cannot be created in the folder."""
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise ValueError(
            f"{option} must lie in a writable folder, got {folder}: {error.strerror} "
            "(name a file elsewhere)"
        ) from None


SUFFIXES = (".png", ".pdf", ".svg")
"""Suffixes of the picture files that can be written."""


def picture_path(output: str | Path) -> Path:
    """Return the path of a picture; raise ValueError if its suffix is not in `SUFFIXES`."""
    path = Path(output) if isinstance(output, str | Path) else None
    if path is None or path.suffix.lower() not in SUFFIXES:
        got = shown(output if path is None else path.name)
        raise ValueError(
            f"output must be a path ending in {', '.join(SUFFIXES)}, got {got} (such as 'run.png')"
        )
    return path


def default_output(source: str, suffix: str = ".png") -> str:
    """Return the file name of a picture in the working folder, made from that of the run or scene.

    >>> default_output("runs/rogue_cn_k_0.5.nc"), default_output("rogue_cn_k_0.5")
    ('rogue_cn_k_0.5.png', 'rogue_cn_k_0.5.png')
    """
    return Path(source).name.removesuffix(".nc").removesuffix(".toml") + suffix


@contextmanager
def progress_bar(
    name: str, work: str, console: Console | None = None, clock: Clock = monotonic
) -> Iterator[tuple[Tell, Tell]]:
    """Show progress with the time left on stderr: a bar, a line, or occasional lines.

    A terminal has a bar, a notebook a line that is rewritten. Yields two callbacks: one for the
    fraction done, one for the expected seconds of ``work``. Long times are announced, and announced
    again when they have doubled; work that checkpoints restore is not counted.
    """
    if in_notebook():
        with ProgressLine(name) as line:
            yield line.left.share, _without_restored(line.left.foresee)
        return
    console = console or plain_console(stderr=True, soft_wrap=True)
    if not console.is_terminal:
        with report_time_left(work, clock) as left:

            def announce_time(seconds: float) -> None:
                left.foresee(seconds)
                announce(work, seconds)

            yield left.share, _without_restored(announce_time)
        return
    left = TimeLeft(clock)
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), _TimeColumn(left))
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(name, total=1.0)

        def announce_and_restart(seconds: float) -> None:
            left.foresee(seconds)
            bar.stop()
            announce(work, seconds)
            bar.start()

        def advance(share: float) -> None:
            count_notice()
            left.share(share)
            bar.update(task, completed=share)

        yield advance, _without_restored(announce_and_restart)


def _without_restored(tell: Tell) -> Tell:
    """Return the callback ``tell`` for seconds without those that checkpoints restore."""
    announcer = Announcer(tell)

    def announce_rest(seconds: float) -> None:
        from longwave.support.checkpoint import stored_seconds  # with NumPy

        announcer(max(0.0, seconds - stored_seconds()))

    return announce_rest


class _TimeColumn(ProgressColumn):
    """Progress column with the fraction done and the time left."""

    def __init__(self, left: TimeLeft) -> None:
        super().__init__()
        self._left = left

    def render(self, _: Task) -> Text:
        """Return the fraction done and the time left."""
        return Text(self._left.words())
