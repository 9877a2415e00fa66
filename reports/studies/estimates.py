"""Records of the search for dishonest error estimates, and the rows of their table.

`python -m searches.estimates --output FILE` writes one line for each random scene.
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

MAX_REFERENCE_ERROR = 0.1
"""Largest error of a reference run, relative to the estimate, for which the ratio is reliable."""

MAX_BYTES = 100_000_000
"""Largest accepted file of records, in bytes."""

VERDICTS = ("honest", "dishonest", "undecided", "refused", "false alarm", "no answer")
"""Possible verdicts on a random scene's error estimate.

``honest``: the true error is within the estimate. ``dishonest``: it is not. ``undecided``: the
reference is not accurate enough. ``refused``: no estimate but a reason in one line.
``false alarm``: a blow-up is reported that the reference does not have. ``no answer``: anything
else, such as an estimate that is not finite, an exception other than ValueError, or a run that does
not end.
"""


@dataclass(frozen=True)
class Judged:
    """Record of the random scene (seed, index); numbers are NaN if they do not exist.

    ``asked`` is the requested engine, ``own`` the reference's error, ``seconds`` the processor time
    of run and reference, ``scene`` the scene as JSON.
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
        """True error divided by its estimate."""
        if self.estimate > 0:
            return self.true / self.estimate
        return math.inf if self.true > 0 else 0.0

    @property
    def is_reliable(self) -> bool:
        """Whether the verdict is "honest" and the reference accurate enough for the ratio."""
        return self.verdict == "honest" and self.own <= MAX_REFERENCE_ERROR * self.estimate

    @property
    def kind(self) -> str:
        """Reason with each number replaced by N, so that equal reasons can be grouped."""
        return re.sub(r"-?\d[\d.e+-]*", "N", self.reason)[:100]

    @property
    def sound(self) -> bool:
        """Whether the verdict shows no fault of the code: honest, refused or undecided."""
        return self.verdict in ("honest", "refused", "undecided")

    def json(self) -> str:
        """Return the record as one line of JSON."""
        return json.dumps(asdict(self))


def judged_scenes(path: Path) -> list[Judged]:
    """Read the records of a file. Raises ValueError, in one line, if it holds anything else."""
    try:
        lines = read_text(path, "file", MAX_BYTES).splitlines()
        return [Judged(**json.loads(line)) for line in lines]
    except (OSError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())[:150]
        raise ValueError(
            "--estimates must be a file written by `python -m searches.estimates --output`, got "
            f"{path}: {reason}"
        ) from None


def judged_findings(path: Path | None) -> dict[Key, Judged]:
    """Return a file's records under the keys of a report's findings; empty without a file."""
    records = [] if path is None else judged_scenes(path)
    by_index = sorted(records, key=lambda record: record.index)
    return {("estimate", record.index): record for record in by_index}


@dataclass(frozen=True)
class EstimateRow:
    """Counts of verdicts, and quantiles of reliable ratios, for the scenes of a wave or engine."""

    name: str
    count: int
    verdicts: Mapping[str, int]
    quantiles: Mapping[float, float]
    seconds: float


QUANTILES = (0.05, 0.5, 0.95, 1.0)
"""Probabilities of the quantiles of true error over estimate; 1.0 gives the largest."""


def estimate_rows(found: Iterable[Judged]) -> list[EstimateRow]:
    """Return a row for each wave, for each engine (requested or chosen), and for all scenes."""
    judged = list(found)
    if not judged:
        return []
    waves = sorted({scene.wave for scene in judged})
    groups = {wave: [scene for scene in judged if scene.wave == wave] for wave in waves}
    for engine in sorted({scene.engine for scene in judged} - {""}):
        of_engine = [scene for scene in judged if scene.engine == engine]
        for selection, requested in (("by name", engine), ("chosen", "")):
            chosen = [scene for scene in of_engine if scene.asked == requested]
            groups[f"{engine}, {selection}"] = chosen
    groups["all"] = judged
    return [_row(name, group) for name, group in groups.items()]


def _row(name: str, group: Sequence[Judged]) -> EstimateRow:
    ratios = [scene.ratio for scene in group if scene.verdict == "dishonest" or scene.is_reliable]
    quantiles = np.quantile(ratios, QUANTILES, method="lower") if ratios else [math.nan] * 4
    return EstimateRow(
        name,
        len(group),
        {verdict: sum(scene.verdict == verdict for scene in group) for verdict in VERDICTS},
        {share: float(value) for share, value in zip(QUANTILES, quantiles, strict=True)},
        sum(scene.seconds + scene.reference_seconds for scene in group),
    )
