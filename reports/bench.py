"""`python -m reports.bench`: the studies of cost, one after the other, as tables and figures."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from derive.command_line import announce, called_by, fail, interrupted, run_words
from reports.assemble import write_study_figures, write_study_tables
from reports.work import Studies, studies, study_jobs
from verify.processes import Job, Key, run_jobs

FOLDER = "longwave-bench"


@click.command()
@click.option(
    "--output",
    metavar="FOLDER",
    type=click.Path(path_type=Path),
    default=FOLDER,
    help=f"Where it is written (default {FOLDER}).",
)
@click.option("--short", is_flag=True, help="What `make report` shows, and no more.")
def bench(output: Path, short: bool) -> int:
    """Run every study of cost in a process of its own, nothing beside it."""
    console = Console(highlight=False, markup=False, emoji=False)
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        return fail(f"--output must be a folder that can be written, got {output}: {error}")
    jobs = study_jobs(full=not short)
    announce("the studies", sum(job.weight for job in jobs.values()))
    try:
        return 0 if _measure(jobs, output, console).sound else 1
    except KeyboardInterrupt:
        return interrupted(called_by(), "nothing was written of unfinished studies")


def _measure(jobs: Mapping[Key, Job], output: Path, console: Console) -> Studies:
    """Run the studies with a progress bar, and write and name their tables and figures."""
    columns = TextColumn("{task.description:20}"), BarColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("measuring", total=1.0)
        found = studies(run_jobs(jobs, 1, lambda share: bar.update(task, completed=share)))
        for name, text in write_study_tables(found, output):
            if text:
                console.print(output / "tables" / f"{name}.tex", soft_wrap=True)
        for path in write_study_figures(found, output):
            console.print(path, soft_wrap=True)
    return found


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    return run_words(bench, "python -m reports.bench", argv)


if __name__ == "__main__":
    sys.exit(main())
