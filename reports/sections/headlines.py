"""Main results of the report, printed on its first page and in its conclusion."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from longwave.reports.latex import scientific, table, uncertain
from longwave.reports.studies.bench_laws import mode_return
from longwave.reports.studies.measured_runs import RK4_STEP, SPLIT, rk4_name
from longwave.verify.verdict import Outcome

if TYPE_CHECKING:
    from longwave.reports.findings import Findings


@dataclass(frozen=True)
class Headline:
    """One main result: quantity, value and own error in LaTeX, and the section with the details."""

    quantity: str
    value: str
    error: str
    section: str


EXACT = "exact"
"""Entry for the own error of a count."""

THIRD_ORDER_RUN = "rational_3_eps_0.05"
"""Name of the run whose largest error is a main result."""


def headlines(findings: Findings) -> dict[str, Headline]:
    """Return the main results that are available, keyed by the names used in the conclusion."""
    results = _verdicts(findings) | _errors(findings) | _counts(findings) | _laws(findings)
    return {name: Headline(*fields) for name, fields in results.items()}


def headline_table(results: Iterable[Headline]) -> str:
    """Return the table of main results with their own errors and sections."""
    rows = [[r.quantity, r.value, r.error, rf"\ref{{sec:{r.section}}}"] for r in results]
    caption = (
        "Main results. Own error: estimated error by time step, domain and sampling; a count of "
        "verdicts is exact."
    )
    head = ["result", "value", "own error", "section"]
    return table("headlines", caption, "L{98mm}llr", head, rows)


HeadlineFields = dict[str, tuple[str, str, str, str]]


def _count(holds: Sequence[bool]) -> str:
    """Return how many conditions hold, such as "3 of 4"."""
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
    chain = findings.of("bench").get("fput_1955")
    if chain is not None and chain.run is not None:
        back = mode_return(chain.run)
        words = "first return of mode 1 of the FPUT chain of 1955, in its periods"
        results["return"] = (words, *uncertain(back.periods, back.reading / 2), "benches")
    for slope, error in findings.all("struck"):
        words = "exponent of the speed of struck grains in the velocity ($1/5$ expected)"
        results["struck"] = (words, *uncertain(slope, error), "benches")
    return results
