"""The report's studies of cost and hard cases, with nothing beside them: tables and figures.

    python benchmarks/studies.py [--output longwave-bench] [--short]

``--short`` takes what ``make report`` shows and no more. Exit status 1 if a study fails.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from longwave.reports.build import (
    STUDY_TABLES,
    Findings,
    bars,
    study_figures,
    study_jobs,
    write_figures,
    write_tables,
)
from longwave.support.console import plain_console
from longwave.support.processes import run_jobs


def main(words: Sequence[str] | None = None) -> int:
    """Run every study in a process of its own, one after the other; print what was written."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("longwave-bench"))
    parser.add_argument("--short", action="store_true")
    options = parser.parse_args(words)
    console = plain_console()
    with bars(console) as bar:
        task = bar.add_task("measuring", total=1.0)
        jobs = study_jobs(full=not options.short)
        found = Findings(run_jobs(jobs, 1, lambda share: bar.update(task, completed=share)), {})
        for name, text in write_tables(STUDY_TABLES, found, options.output):
            if text:
                console.print(options.output / "tables" / f"{name}.tex", soft_wrap=True)
        for path in write_figures(study_figures(found), options.output):
            console.print(path, soft_wrap=True)
    return 0 if found.sound else 1


if __name__ == "__main__":
    sys.exit(main())
