"""`python -m reports`: run the shipped scenes and write the report as a PDF."""

import argparse
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from derive.command_line import OneLineParser, fail, interrupted
from reports.assemble import STUDY_FIGURES, STUDY_TABLES, TABLES, write_figures, write_source
from reports.engine import CompileError, EngineMissingError, compile_pdf, ensure_engine
from reports.figures.paper import ERROR_FIGURES, SNAPSHOT_FIGURES
from reports.work import find
from verify.studies.measured_runs import report_scenes

FOLDER = Path("longwave-report")
"""Where the report is written: in the working folder, not where the package is."""


@dataclass
class Options:
    """Where the report is written, whether in full, and by how many processes."""

    output: Path
    full: bool
    workers: int


def main(argv: Sequence[str] | None = None) -> int:
    """Build the report; return 0, 1 if a check, a run or LaTeX failed, 2 for bad input."""
    given = parse(argv)
    return write_report(Options(given.output, given.full, given.workers), "python -m reports")


def write_report(options: Options, program: str) -> int:
    """As `main`, for options that are read; ``program`` is what Ctrl-C is told by."""
    console = Console(highlight=False, markup=False, emoji=False)
    try:
        options.output.mkdir(parents=True, exist_ok=True)
        tex, sound = build(options, console)
        ensure_engine(console.print)
        pdf = compile_pdf(tex)
    except KeyboardInterrupt:
        return interrupted(program, f"what was written is in {shown(options.output)}")
    except (ValueError, OSError) as error:
        return fail(error)
    except (EngineMissingError, CompileError) as error:
        fail(error)
        return 1
    console.print(shown(pdf), soft_wrap=True)
    return 0 if sound else 1


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = OneLineParser(
        prog="python -m reports",
        description="Derive, check, run the scenes, and write it all as a PDF.",
    )
    parser.add_argument(
        "--output", type=Path, default=FOLDER, metavar="FOLDER", help=f"default: {FOLDER}"
    )
    parser.add_argument(
        "--full", action="store_true", help="take the long scenes and the full studies as well"
    )
    parser.add_argument(
        "--workers", type=int, default=os.cpu_count() or 1, metavar="N", help="processes to use"
    )
    return parser.parse_args(argv)


def build(options: Options, console: Console) -> tuple[Path, bool]:
    """Write figures, tables and source below the folder.

    Returns the source's path, and whether every form stands and every run came to its end.
    """
    scenes = report_scenes()
    bar = Progress(
        TextColumn("{task.description:20}"), BarColumn(), TimeElapsedColumn(), console=console
    )
    with bar:
        working = bar.add_task("proving and running", total=1.0)
        found = find(
            scenes,
            options.full,
            options.workers,
            lambda share: bar.update(working, completed=share),
        )
        drawing = bar.add_task(
            "drawing", total=len(SNAPSHOT_FIGURES) + len(ERROR_FIGURES) + STUDY_FIGURES
        )
        for _ in write_figures(found, options.output):
            bar.advance(drawing)
        wrote = advance(bar, "writing", len(TABLES) + len(STUDY_TABLES))
        tex = write_source(found, options.output, options.full, wrote)
    return tex, found.sound


def advance(bar: Progress, name: str, total: int) -> "Step":
    """Return a function that advances a new bar of that name by one."""
    return Step(bar, bar.add_task(name, total=total))


class Step:
    """Advances one bar by one each time it is called."""

    def __init__(self, bar: Progress, task: TaskID) -> None:
        self.bar = bar
        self.task = task

    def __call__(self) -> None:
        """Advance."""
        self.bar.advance(self.task)


def shown(path: Path) -> str:
    """Return the path relative to the working directory where it lies below it."""
    with suppress(ValueError):
        return str(path.resolve().relative_to(Path.cwd()))
    return str(path)


if __name__ == "__main__":
    sys.exit(main())
