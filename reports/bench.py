"""`python -m longwave.reports.bench`: the studies of cost in turn, as tables and figures."""

import sys
from collections.abc import Sequence
from pathlib import Path

import click

from longwave.support.command_line import called_by, run_words

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
    from longwave.reports.build import write_bench

    return write_bench(output, short, called_by())


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    return run_words(bench, "python -m longwave.reports.bench", argv)


if __name__ == "__main__":
    sys.exit(main())
