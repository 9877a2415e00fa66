"""The report's main results, as its first page and its conclusion tell them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from longwave.reports.latex import scientific, table, uncertain
from longwave.reports.studies.bench_laws import mode_return
from longwave.reports.studies.evaluation_accuracy import Accuracy
from longwave.reports.studies.measured_runs import RK4_STEP, SPLIT, MeasuredRuns, rk4_name
from longwave.verify.verdict import Outcome

if TYPE_CHECKING:
    from longwave.reports.studies.claims import Claim


class Found(Protocol):
    """What the jobs of a report found, by kind."""

    @property
    def runs(self) -> MeasuredRuns:
        """The runs of the paper's scenes."""

    @property
    def claims(self) -> list[Claim]:
        """The paper's statements with their verdicts."""

    @property
    def accuracy(self) -> list[Accuracy]:
        """The worst errors of each wave."""

    def of(self, kind: str) -> dict[Any, Any]:
        """The findings of a kind by their subjects."""

    def all(self, kind: str) -> list[Any]:
        """The findings of a kind."""

    def rows(self, kind: str) -> list[Any]:
        """The findings of a kind whose findings are lists."""


@dataclass(frozen=True)
class Headline:
    """A result: its quantity, its value and own error in LaTeX, and the section that tells more."""

    quantity: str
    value: str
    error: str
    section: str


EXACT = "exact"

THIRD = "rational_3_eps_0.05"


def headlines(found: Found) -> dict[str, Headline]:
    """The results that there are, by their names in the conclusion."""
    results = _verdicts(found) | _errors(found) | _counts(found) | _laws(found)
    return {name: Headline(*told) for name, told in results.items()}


def headline_table(results: Iterable[Headline]) -> str:
    """The results with their errors and sections."""
    rows = [
        [told.quantity, told.value, told.error, rf"\ref{{sec:{told.section}}}"] for told in results
    ]
    caption = (
        "Main results. Own error: what time step, domain and sampling may change; a count of "
        "verdicts is exact."
    )
    return table(
        "headlines", caption, "L{98mm}llr", ["result", "value", "own error", "section"], rows
    )


Told = dict[str, tuple[str, str, str, str]]


def _share(holds: Sequence[bool]) -> str:
    return f"{sum(holds)} of {len(holds)}"


def _verdicts(found: Found) -> Told:
    """The counts of verdicts: of closed forms, their misprints, and published formulas."""
    proofs, counts, library = found.all("proof"), found.all("mutants"), found.rows("library")
    refuted = f"{sum(c.refuted for c in counts)} of {sum(c.mutants for c in counts)}"
    right, wrong = (
        [v.outcome is expect for v in library if v.text.expect == expect]
        for expect in (Outcome.PROVED, Outcome.REFUTED)
    )
    printed = [v for v in library if v.text.misprint_in and v.outcome is Outcome.REFUTED]
    proved = [p.outcome.passed and p.accepted is not False for p in proofs]
    words = "closed forms proved for all parameters, certificate checked"
    return {
        "proved": (words, _share(proved), EXACT, "proofs"),
        "misprints": ("misprints of the mKdV forms refuted", refuted, EXACT, "proofs"),
        "right": (
            "published solutions of other equations proved",
            _share(right),
            EXACT,
            "published",
        ),
        "wrong": ("wrong variants of them refuted", _share(wrong), EXACT, "published"),
        "printed": ("formulas in print found wrong", str(len(printed)), EXACT, "published"),
    }


def _errors(found: Found) -> Told:
    """The worst error of evaluation, and the paper's relative error of its lattice's waves."""
    runs = found.runs
    top, rk4 = runs.largest_error(THIRD)[0], runs.largest_error(rk4_name(3))[0]
    worst = max((max(each.errors) for each in found.accuracy), default=0.0)
    norm = r"$L^\infty_\epsilon$, $\epsilon=0.05$:"
    return {
        "evaluation": (
            r"worst error of an evaluated wave, in units of $\max(1,|\mbox{value}|)$",
            scientific(worst),
            "60 digits",
            "evaluation",
        ),
        "second": (
            rf"{norm} $Y_2$ at its peak",
            *uncertain(*runs.relative_error(SPLIT, 0.0)),
            "runs",
        ),
        "third": (rf"{norm} $Y_3$, largest", *uncertain(*top), "runs"),
        "rk4": (rf"the same by RK4 with $\Delta t={RK4_STEP}$", *uncertain(*rk4), "runs"),
        "shift": (
            r"distance of the lattice's crest from that of $Y_2$, in sites",
            *uncertain(*runs.split(SPLIT, 0.0)["shift"]),
            "claims",
        ),
    }


def _counts(found: Found) -> Told:
    """How many statements, scenes, rates and hard cases hold."""
    rulings = Counter(claim.ruling.value for claim in found.claims)
    claims = f"{rulings['confirmed']} of {rulings.total()}"
    open_ = f"{rulings['depends']} and {rulings['not confirmed']}"
    scenes = [scene.kept for kind in ("scene", "bench") for scene in found.all(kind)]
    rates = [rate.reached for rate in found.all("rate")]
    hard = [case.passed for case in found.all("hard")]
    words = "of them depending on a choice, and not confirmed"
    expected = r"rates of convergence with the power of $\epsilon$ that is expected"
    return {
        "claims": ("statements of the paper confirmed", claims, EXACT, "claims"),
        "open": (words, open_, EXACT, "claims"),
        "scenes": ("runs of other lattices within tolerance", _share(scenes), EXACT, "lattices"),
        "rates": (expected, _share(rates), EXACT, "lattices"),
        "hard": ("hard cases within their bound", _share(hard), EXACT, "costs"),
    }


def _laws(found: Found) -> Told:
    """The numbers that are known of chains on a bench."""
    told: Told = {}
    chain = found.of("bench").get("fput_1955")
    if chain is not None and chain.run is not None:
        back = mode_return(chain.run)
        words = "first return of mode 1 of the FPUT chain of 1955, in its periods"
        told["return"] = (words, *uncertain(back.periods, back.reading / 2), "benches")
    for slope, error in found.all("struck"):
        words = "exponent of the speed of struck grains in the velocity ($1/5$ expected)"
        told["struck"] = (words, *uncertain(slope, error), "benches")
    return told
