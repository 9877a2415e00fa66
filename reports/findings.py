"""Results of a report's jobs, by kind, and whether they are as they should be."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, groupby
from operator import attrgetter
from typing import Any

from longwave.reports.studies.claims import Claim, all_claims
from longwave.reports.studies.evaluation_accuracy import Accuracy, worst_of
from longwave.reports.studies.long_runs import LongRun, long_runs
from longwave.reports.studies.measured_runs import MeasuredRuns
from longwave.scenes.description.scene import Scene
from longwave.support.processes import Key

SUCCEEDED: Mapping[str, Callable[[Any], bool]] = {
    "run": lambda run: not run.attrs["blow_up"],
    "proof": lambda record: record.outcome.passed and record.accepted is not False,
    "mutants": lambda count: count.undecided == 0,
    "library": lambda verdicts: all(verdict.expected for verdict in verdicts),
    "scene": lambda scene: scene.within_tolerance,
    "rate": lambda rate: rate.reached,
    "hard": lambda case: case.passed,
    "estimate": lambda judged: judged.sound,
}
"""Whether the result of a job is as it should be, by kind; other kinds are only reported."""


@dataclass(frozen=True)
class Findings:
    """Results of the jobs, keyed by (kind, subject), and the ``scenes`` of the paper's runs."""

    results: Mapping[Key, Any]
    scenes: Mapping[str, Scene]

    def of(self, kind: str) -> dict[Any, Any]:
        """Return the results of one kind, keyed by subject; empty for a kind without jobs."""
        return {key[1]: value for key, value in self.results.items() if key[0] == kind}

    def all(self, kind: str) -> list[Any]:
        """Return the results of one kind as a list."""
        return list(self.of(kind).values())

    def rows(self, kind: str) -> list[Any]:
        """Return the concatenated results of a kind whose jobs return lists."""
        return list(chain.from_iterable(self.all(kind)))

    @cached_property
    def runs(self) -> MeasuredRuns:
        """Runs of the paper's scenes."""
        return MeasuredRuns(self.of("run"), self.scenes)

    @cached_property
    def long_runs(self) -> dict[str, LongRun]:
        """Long runs on the spectral ring with their reference runs."""
        return long_runs(self.results)

    @cached_property
    def accuracy(self) -> list[Accuracy]:
        """Worst evaluation errors of each wave."""
        cases = groupby(self.all("accuracy"), attrgetter("name"))
        return [worst_of(group) for _, group in cases]

    @cached_property
    def claims(self) -> list[Claim]:
        """Statements of the paper with their verdicts."""
        return all_claims(self.runs)

    @property
    def sound(self) -> bool:
        """Whether every result in `SUCCEEDED` and every long run is as it should be."""
        judged = (SUCCEEDED[key[0]](v) for key, v in self.results.items() if key[0] in SUCCEEDED)
        return all(judged) and all(long.within_tolerance for long in self.long_runs.values())
