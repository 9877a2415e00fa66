"""How far from true the runs' estimates are, over random scenes."""

from collections import Counter
from collections.abc import Sequence

from reports.environment import escape
from reports.sections.evaluation import duration
from reports.tables import scientific, table
from verify.studies.estimates import QUANTILES, VERDICTS, EstimateRow, Judged, rows


def estimate_table(judged: Sequence[Judged]) -> str:
    """Counts of verdicts and quantiles of true/estimate by wave and engine; "" without scenes."""
    if not judged:
        return ""
    shares = ["largest" if q == 1.0 else "median" if q == 0.5 else rf"{q:.0%}" for q in QUANTILES]
    head = ["", "scenes", *VERDICTS, *map(escape, shares), "time"]
    columns = "l" + "r" * (len(head) - 1)
    return table(columns, head, map(_row, rows(judged)))


def _row(found: EstimateRow) -> list[str]:
    quantiles = ["--" if q != q else scientific(q) for q in found.quantiles]
    counts = [str(count) if count else "--" for count in found.verdicts]
    return [escape(found.name), str(found.count), *counts, *quantiles, duration(found.seconds)]


def reason_table(judged: Sequence[Judged]) -> str:
    """The reasons for which scenes were refused, without their numbers, and how often."""
    counts = Counter(found.kind for found in judged if found.reason)
    cells = [[str(count), escape(kind)] for kind, count in counts.most_common()]
    return table("rL{120mm}", ["scenes", "reason"], cells) if cells else ""
