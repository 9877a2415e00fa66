"""Building the report: the work, the figures, the source, the PDF."""

from contextlib import suppress
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from derive.command_line import fail, interrupted
from reports.assemble import STUDY_FIGURES, STUDY_TABLES, TABLES, write_figures, write_source
from reports.engine import CompileError, EngineMissingError, compile_pdf, ensure_engine
from reports.figures.paper_figures import ERROR_FIGURES, SNAPSHOT_FIGURES
from reports.work import find
from verify.studies.measured_runs import report_scenes


def write_report(output: Path, full: bool, workers: int, program: str) -> int:
    """Build the report in a folder; ``program`` is what Ctrl-C is told by.

    Returns 0, 1 if a check, a run or LaTeX failed, 2 for bad input, 130 after Ctrl-C.
    """
    console = Console(highlight=False, markup=False, emoji=False)
    try:
        output.mkdir(parents=True, exist_ok=True)
        tex, sound = build(output, full, workers, console)
        ensure_engine(console.print)
        pdf = compile_pdf(tex)
    except KeyboardInterrupt:
        return interrupted(program, f"what was written is in {shown(output)}")
    except (ValueError, OSError) as error:
        return fail(error)
    except (EngineMissingError, CompileError) as error:
        fail(error)
        return 1
    console.print(shown(pdf), soft_wrap=True)
    return 0 if sound else 1


def build(output: Path, full: bool, workers: int, console: Console) -> tuple[Path, bool]:
    """Write figures, tables and source below the folder.

    Returns the source's path, and whether every form stands and every run came to its end.
    """
    figures = len(SNAPSHOT_FIGURES) + len(ERROR_FIGURES) + STUDY_FIGURES
    columns = TextColumn("{task.description:20}"), BarColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console) as bar:
        working = bar.add_task("proving and running", total=1.0)
        found = find(
            report_scenes(), full, workers, lambda share: bar.update(working, completed=share)
        )
        drawing = bar.add_task("drawing", total=figures)
        for _ in write_figures(found, output):
            bar.advance(drawing)
        writing = bar.add_task("writing", total=len(TABLES) + len(STUDY_TABLES))
        tex = write_source(found, output, full, partial(bar.advance, writing))
    return tex, found.sound


def shown(path: Path) -> str:
    """Return the path relative to the working directory where it lies below it."""
    with suppress(ValueError):
        return str(path.resolve().relative_to(Path.cwd()))
    return str(path)
