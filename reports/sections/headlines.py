"""Results of the report's jobs, and the main ones, for its first page and its conclusion."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, groupby
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from longwave.reports.latex import scientific, table, uncertain
from longwave.reports.studies.bench_laws import mode_return
from longwave.reports.studies.evaluation_accuracy import Accuracy, worst_of
from longwave.reports.studies.long_runs import LongRun, long_runs
from longwave.reports.studies.measured_runs import RK4_STEP, SPLIT, MeasuredRuns, rk4_name
from longwave.verify.verdict import Outcome

if TYPE_CHECKING:
    from longwave.reports.studies.claims import Claim
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
"""Kind of job -> test whether its result is as it should be; other kinds are not tested."""


@dataclass(frozen=True)
class Findings:
    """Results of a report's jobs, keyed by (kind, subject), and the paper's ``scenes`` by name."""

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
        from longwave.reports.studies.claims import all_claims

        return all_claims(self.runs)

    @cached_property
    def headlines(self) -> dict[str, Headline]:
        """Main results of the report."""
        return headlines(self)

    @property
    def sound(self) -> bool:
        """Whether all results pass the test in `SUCCEEDED`, and long runs are within tolerance."""
        judged = (SUCCEEDED[key[0]](v) for key, v in self.results.items() if key[0] in SUCCEEDED)
        return all(judged) and all(long.within_tolerance for long in self.long_runs.values())


@dataclass(frozen=True)
class Headline:
    """One main result: quantity, value and error in LaTeX, and the section with the details."""

    quantity: str
    value: str
    error: str
    section: str


EXACT = "exact"
"""Table entry for the error of a result that is a count."""

THIRD_ORDER_RUN = "rational_3_eps_0.05"
"""Name of the run of Y_3 whose largest error is reported as a main result."""


def headlines(findings: Findings) -> dict[str, Headline]:
    """Return the main results that are available, keyed by the names used in the conclusion."""
    results = _verdicts(findings) | _errors(findings) | _counts(findings) | _laws(findings)
    return {name: Headline(*fields) for name, fields in results.items()}


def headline_table(results: Iterable[Headline]) -> str:
    """Return the table of main results with their numerical errors and sections."""
    rows = [[r.quantity, r.value, r.error, rf"\ref{{sec:{r.section}}}"] for r in results]
    caption = (
        "Main results. Own error: estimated error by time step, domain and sampling; a count of "
        "verdicts is exact."
    )
    head = ["result", "value", "own error", "section"]
    return table("headlines", caption, "L{98mm}llr", head, rows)


HeadlineFields = dict[str, tuple[str, str, str, str]]


def _count(holds: Sequence[bool]) -> str:
    """Return a text with the number of conditions that hold, such as "3 of 4"."""
    return f"{sum(holds)} of {len(holds)}"


def _verdicts(findings: Findings) -> HeadlineFields:
    """Return counts of verdicts on closed forms, their misprints and published formulas."""
    proofs, counts = findings.all("proof"), findings.all("mutants")
    library = findings.rows("library")
    refuted = f"{sum(c.refuted for c in counts)} of {sum(c.mutants for c in counts)}"
    right, wrong = (
        [v.outcome is expect for v in library if v.text.expect == expect]
        for expect in (Outcome.PROVED, Outcome.REFUTED)
    )
    printed = [v for v in library if v.text.misprint_in and v.outcome is Outcome.REFUTED]
    proved = [p.outcome.passed and p.accepted is not False for p in proofs]
    words = "closed forms proved for all parameters, certificate checked"
    others = "published solutions of other equations proved"
    return {
        "proved": (words, _count(proved), EXACT, "proofs"),
        "misprints": ("misprints of the mKdV forms refuted", refuted, EXACT, "proofs"),
        "right": (others, _count(right), EXACT, "published"),
        "wrong": ("wrong variants of them refuted", _count(wrong), EXACT, "published"),
        "printed": ("formulas in print found wrong", str(len(printed)), EXACT, "published"),
    }


def _errors(findings: Findings) -> HeadlineFields:
    """Return the worst evaluation error, and relative errors of the paper's lattice runs."""
    runs = findings.runs
    third_order, rk4 = runs.largest_error(THIRD_ORDER_RUN)[0], runs.largest_error(rk4_name(3))[0]
    worst = max((max(each.errors) for each in findings.accuracy), default=0.0)
    norm = r"$L^\infty_\epsilon$, $\epsilon=0.05$:"
    evaluation = r"worst error of an evaluated wave, in units of $\max(1,|\mbox{value}|)$"
    second, shift = runs.relative_error(SPLIT, 0.0), runs.split(SPLIT, 0.0)["shift"]
    distance = r"distance of the lattice's crest from that of $Y_2$, in sites"
    return {
        "evaluation": (evaluation, scientific(worst), "60 digits", "evaluation"),
        "second": (rf"{norm} $Y_2$ at its peak", *uncertain(*second), "runs"),
        "third": (rf"{norm} $Y_3$, largest", *uncertain(*third_order), "runs"),
        "rk4": (rf"the same by RK4 with $\Delta t={RK4_STEP}$", *uncertain(*rk4), "runs"),
        "shift": (distance, *uncertain(*shift), "claims"),
    }


def _counts(findings: Findings) -> HeadlineFields:
    """Return counts of confirmed statements, and of scenes, rates and cases within their bounds."""
    rulings = Counter(claim.ruling.value for claim in findings.claims)
    claims = f"{rulings['confirmed']} of {rulings.total()}"
    not_confirmed = f"{rulings['depends']} and {rulings['not confirmed']}"
    scenes = [scene.within_tolerance for kind in ("scene", "bench") for scene in findings.all(kind)]
    rates = [rate.reached for rate in findings.all("rate")]
    hard = [case.passed for case in findings.all("hard")]
    words = "of them depending on a choice, and not confirmed"
    expected = r"rates of convergence with the power of $\epsilon$ that is expected"
    return {
        "claims": ("statements of the paper confirmed", claims, EXACT, "claims"),
        "open": (words, not_confirmed, EXACT, "claims"),
        "scenes": ("runs of other lattices within tolerance", _count(scenes), EXACT, "lattices"),
        "rates": (expected, _count(rates), EXACT, "lattices"),
        "hard": ("hard cases within their bound", _count(hard), EXACT, "costs"),
    }


def _laws(findings: Findings) -> HeadlineFields:
    """Return the measured values of known quantities of chains on a bench."""
    results: HeadlineFields = {}
    bench = findings.of("bench").get("fput_1955")
    if bench is not None and bench.run is not None:
        back = mode_return(bench.run)
        words = "first return of mode 1 of the FPUT chain of 1955, in its periods"
        results["return"] = (words, *uncertain(back.periods, back.reading / 2), "benches")
    for slope, error in findings.all("struck"):
        words = "exponent of the speed of struck grains in the velocity ($1/5$ expected)"
        results["struck"] = (words, *uncertain(slope, error), "benches")
    return results
