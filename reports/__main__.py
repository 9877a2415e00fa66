"""Command `python -m reports`, the same as `longwave report`; the work is imported when it runs."""

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from longwave.support import command_line

FOLDER = "longwave-report"
"""Default output folder of the report, relative to the working directory."""


@click.command(epilog=command_line.example("longwave report --output report"))
@click.option(
    "--output",
    metavar="FOLDER",
    type=click.Path(path_type=Path),
    default=FOLDER,
    help=f"Folder of the report (default {FOLDER}).",
)
@command_line.force_option
@click.option("--full", is_flag=True, help="Take the long scenes and the full studies as well.")
@click.option(
    "--estimates",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="Table what python -m searches.estimates --output FILE found.",
)
@click.option("--workers", type=int, metavar="N", help="Processes to use (default all cores).")
@command_line.limit_options
def report(
    output: Path, force: bool, full: bool, estimates: Path | None, workers: int | None
) -> int:
    """Derive, check and run everything, and write it as a PDF.

    It goes to the folder longwave-report in the working folder.
    """
    from longwave.reports.build import write_report

    processes = os.cpu_count() or 1 if workers is None else workers
    options: dict[str, Any] = {"force": force, "full": full, "estimates": estimates}
    return write_report(output, command_line.command_name(), workers=processes, **options)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    return command_line.run_words(report, "python -m reports", argv)


if __name__ == "__main__":
    sys.exit(main())
