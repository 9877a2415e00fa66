"""What the search for dishonest estimates found: its records, and the rows of their table.

`python -m searches.estimates --output FILE` writes a line for each random scene that it judges.
"""

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from longwave.support.processes import Key
from longwave.support.user_files import read_text

GOOD = 0.1
"""The reference's error, in units of the estimate, that is good enough."""

MOST_BYTES = 100_000_000
"""Bytes of a file of records."""

VERDICTS = ("honest", "dishonest", "undecided", "refused", "false alarm", "no answer")
"""What is said of a scene.

``undecided``: the reference is not good enough. ``refused``: a reason of one line and no estimate.
``false alarm``: the reason is a blow-up that the reference does not have. ``no answer``: anything
else, such as an estimate that is not finite, another exception than ValueError, or no end.
"""


@dataclass(frozen=True)
class Judged:
    """What was found about the scene (seed, index); numbers are NaN where there are none.

    ``own`` is the reference's error, ``seconds`` the processor time of run and reference, ``scene``
    the scene as JSON.
    """

    seed: int
    index: int
    wave: str
    asked: str
    engine: str
    tolerance: float
    verdict: str
    estimate: float
    true: float
    own: float
    reason: str
    seconds: float
    reference_seconds: float
    redrawn: int
    scene: str

    @property
    def ratio(self) -> float:
        """True error in units of the estimate."""
        if self.estimate > 0:
            return self.true / self.estimate
        return math.inf if self.true > 0 else 0.0

    @property
    def told(self) -> bool:
        """Whether the reference is so good that the ratio means something."""
        return self.verdict == "honest" and self.own <= GOOD * self.estimate

    @property
    def kind(self) -> str:
        """The reason without its numbers."""
        return re.sub(r"-?\d[\d.e+-]*", "N", self.reason)[:100]

    @property
    def sound(self) -> bool:
        """Whether nothing speaks against the run."""
        return self.verdict in ("honest", "refused", "undecided")

    def json(self) -> str:
        """One line."""
        return json.dumps(asdict(self))


def judged_scenes(path: Path) -> list[Judged]:
    """The records of a file; ValueError in one line if it holds anything else."""
    try:
        lines = read_text(path, "file", MOST_BYTES).splitlines()
        return [Judged(**json.loads(line)) for line in lines]
    except (OSError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())[:150]
        raise ValueError(
            f"--estimates must be what `python -m searches.estimates --output` wrote, got {path}: "
            f"{reason}"
        ) from None


def judged_findings(path: Path | None) -> dict[Key, Judged]:
    """The records of a file under the keys of a report's findings; of no file none."""
    found = [] if path is None else judged_scenes(path)
    return {("estimate", one.index): one for one in sorted(found, key=lambda one: one.index)}


@dataclass(frozen=True)
class EstimateRow:
    """Counts, and quantiles of true/estimate where that is told, of a wave's or engine's scenes."""

    name: str
    count: int
    verdicts: Mapping[str, int]
    quantiles: Mapping[float, float]
    seconds: float


QUANTILES = (0.05, 0.5, 0.95, 1.0)
"""The quantiles of a row."""


def estimate_rows(found: Iterable[Judged]) -> list[EstimateRow]:
    """One row a wave, one for each engine, asked for and chosen, and one for all scenes."""
    judged = list(found)
    if not judged:
        return []
    waves = sorted({one.wave for one in judged})
    groups = {wave: [one for one in judged if one.wave == wave] for wave in waves}
    for engine in sorted({one.engine for one in judged} - {""}):
        for how, asked in (("by name", engine), ("chosen", "")):
            title = f"{engine}, {how}"
            groups[title] = [j for j in judged if j.engine == engine and j.asked == asked]
    groups["all"] = judged
    return [_row(name, group) for name, group in groups.items()]


def _row(name: str, group: Sequence[Judged]) -> EstimateRow:
    ratios = [one.ratio for one in group if one.verdict == "dishonest" or one.told]
    quantiles = np.quantile(ratios, QUANTILES, method="lower") if ratios else [math.nan] * 4
    return EstimateRow(
        name,
        len(group),
        {verdict: sum(one.verdict == verdict for one in group) for verdict in VERDICTS},
        {share: float(found) for share, found in zip(QUANTILES, quantiles, strict=True)},
        sum(one.seconds + one.reference_seconds for one in group),
    )
