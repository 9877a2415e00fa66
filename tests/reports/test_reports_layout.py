"""The typeset report: results first, tables with numbers and captions, nothing in a margin."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from longwave.reports import build
from longwave.reports.build import TABLES, Findings, all_jobs, source, write_figures, write_source
from longwave.reports.engine import compile_pdf, engine_present
from longwave.reports.latex import render, table, uncertain
from longwave.reports.sections import headlines as section
from longwave.reports.sections.headlines import headline_table, headlines
from longwave.reports.studies.claims import Claim, Ruling
from longwave.reports.studies.effects import EffectCost
from longwave.reports.studies.evaluation_accuracy import Accuracy
from longwave.reports.studies.hard_cases import HardCase
from longwave.reports.studies.lattice_cost import CostPoint, ScalingPoint
from longwave.reports.studies.measured_runs import SPLIT, UncertainNumber, report_scenes, rk4_name
from longwave.reports.studies.proofs import ProofRecord, PublishedVerdict
from longwave.support.processes import Key, run_jobs
from longwave.verify.evidence.mutations import MutationCount, Survivor
from longwave.verify.published import chosen
from longwave.verify.verdict import Outcome
from tests.reports.table_rules import faults_of_floats, faults_of_log, faults_of_tables

RIGHT, WRONG = chosen(["kdv_cnoidal_wave", "kdv_cnoidal_modulus"])
SCALING = [
    ScalingPoint("window", x, x**4, scaled) for x in (10.0, 20.0) for scaled in (False, True)
]

FOUND: dict[Key, Any] = {
    ("proof", "kink"): ProofRecord("kink", "exact", Outcome.PROVED, 0.1, 1000, 0.1, True),
    ("proof", "breather"): ProofRecord(
        "breather", "exact", Outcome.UNDECIDED, 0.1, None, None, None
    ),
    ("mutants", "kink"): MutationCount(
        "kink", 8, (Survivor("term", Outcome.PROVED, "shift"),), 0.1
    ),
    ("library", "KdV"): [
        PublishedVerdict(RIGHT, Outcome.PROVED, 0.1, ("u_{t} = 0",), ("u = k^{2}",)),
        PublishedVerdict(WRONG, Outcome.UNDECIDED, 0.1),
    ],
    ("accuracy", "kink"): Accuracy("kink", 8, (3e-16, 4e-15, 8e-18), "k = 0.5"),
    ("precision", ""): [CostPoint("crest", "rk4", 1e-3, 0.1)],
    ("scaling", ""): SCALING,
    ("rk4", ""): [ScalingPoint("error figure", x, 0.1 + x) for x in (0.25, 0.0)],
    ("windows", ""): [ScalingPoint("window", x, 1 / x) for x in (1024.0, 2048.0)],
    ("hard", "one"): HardCase("what", "how much", 0.5, 0.1),
    ("hard", "two"): HardCase("what", "how much", 0.5, 1.0, "step must be small"),
    ("effect", "a force"): EffectCost(8, 3e-10, 0.8, ((1e-7, 0.02), (1e-11, 0.07))),
    ("struck", ""): (0.2000001, 4.3e-7),
}
"""Results of some jobs, by their keys."""


class Runs:
    """A stand-in for the paper's runs, with different numbers for each name."""

    def relative_error(self, name: str, time: float) -> UncertainNumber:
        return {(SPLIT, 0.0): UncertainNumber(0.10141, 1.4e-5)}[name, time]

    def largest_error(self, name: str) -> tuple[UncertainNumber, float]:
        found = {section.THIRD_ORDER_RUN: (0.18246, 5.4e-5), rk4_name(3): (0.2204, 0.13)}
        return UncertainNumber(*found[name]), 400.0

    def split(self, name: str, time: float) -> dict[str, UncertainNumber]:
        assert (name, time) == (SPLIT, 0.0)
        return {"shift": UncertainNumber(-0.42027, 1.2e-4)}


@pytest.fixture
def found() -> Findings:
    findings = Findings(FOUND, {})
    rulings = (Ruling.CONFIRMED, Ruling.CONFIRMED, Ruling.DEPENDS, Ruling.NOT_CONFIRMED)
    claims = [Claim(str(n), "s", (), ruling, "d") for n, ruling in enumerate(rulings)]
    findings.__dict__.update(runs=Runs(), claims=claims)
    return findings


def test_the_headlines_are_what_the_studies_found(found: Findings) -> None:
    """Catches a typed number, a count of the wrong study and an error of another value."""
    values = {name: (line.value, line.error) for name, line in headlines(found).items()}
    assert values["proved"] == ("1 of 2", "exact")
    assert values["misprints"] == ("7 of 8", "exact")
    assert values["right"] == ("1 of 1", "exact")
    assert values["wrong"] == ("0 of 1", "exact")
    assert values["evaluation"][0] == r"$4.0\times 10^{-15}$"
    assert values["second"] == uncertain(0.10141, 1.4e-5)
    assert values["third"] == uncertain(0.18246, 5.4e-5)
    assert values["rk4"] == uncertain(0.2204, 0.13)
    assert values["shift"] == uncertain(-0.42027, 1.2e-4)
    assert values["claims"] == ("2 of 4", "exact")
    assert values["open"] == ("1 and 1", "exact")
    assert values["hard"] == ("1 of 2", "exact")
    assert values["struck"] == uncertain(0.2000001, 4.3e-7)
    assert "return" not in values
    text = headline_table(headlines(found).values())
    for line in headlines(found).values():
        row = f"{line.quantity} & {line.value} & {line.error} & \\ref{{sec:{line.section}}}"
        assert row in text


def test_the_conclusion_repeats_the_headlines_and_no_number_of_its_own(found: Findings) -> None:
    text = render("conclusion.tex.j2", headlines=headlines(found))
    for name in ("proved", "misprints", "right", "wrong", "second", "third", "rk4", "shift"):
        assert headlines(found)[name].value in text
    nothing = {name: section.Headline("", "", "", "") for name in headlines(found)}
    bare = re.sub(r"Y_\d|RK4|rk4|epsilon=0.05", "", render("conclusion.tex.j2", headlines=nothing))
    assert re.findall(r"\d+", bare) == []


def tables_of(found: Findings) -> dict[str, str]:
    """Return the tables that need no run of a lattice."""
    skipped = ("run_table", "claim_table", "headline_table", "cost_table")
    return {name: make(found) for name, make in TABLES.items() if name not in skipped}


def test_every_table_has_number_caption_rules_and_mathematics(found: Findings) -> None:
    tex = "\n".join(tables_of(found).values())
    assert faults_of_tables(tex) == []
    assert tex.count(r"\begin{longtable}") > 12


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        (r"\caption{Hard cases.}", "", "hard: no caption"),
        (r"\midrule", r"\hline", "hard: no booktabs"),
        ("how much", "k**2", "hard: program syntax **"),
        ("$0.50$", r"$0.50 \pm 0.10$", "hard: an error in the column of values"),
        ("longtable", "tabular", "a table without a number"),
        (r"\label{tab:hard}", r"\label{tab:hard}\ref{tab:soft}", "no tab:soft"),
    ],
)
def test_the_rules_of_tables_find_violations(
    found: Findings, old: str, new: str, fault: str
) -> None:
    text = TABLES["hard_case_table"](found)
    assert faults_of_tables(text) == []
    assert fault in faults_of_tables(text.replace(old, new))


def test_the_results_stand_before_everything_else_with_version_and_date(
    found: Findings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    monkeypatch.setattr(build.theory, "formulas", list)
    names = re.findall(r"\\VAR\{(\w+)\}", all_templates())
    content = {name: "" for name in names if name in TABLES} | tables_of(found)
    content["headline_table"] = headline_table(headlines(found).values())
    findings = Findings(FOUND, report_scenes())
    findings.__dict__["headlines"] = headlines(found)
    findings.__dict__["runs"] = Findings({}, report_scenes()).runs
    tex = source(content, findings, full=False)
    order = (r"\date{2 January 1970}", r"\maketitle", r"\label{tab:headlines}", r"\section{")
    places = [tex.index(part) for part in order]
    assert places == sorted(places)
    assert (
        tex.index(r"\section{Conclusion}") < tex.index("thebibliography") < tex.index(r"\appendix")
    )
    assert tex.index(r"\appendix") < tex.index(r"\section{The library of published solutions}")
    assert faults_of_floats(tex) == []
    assert len(faults_of_floats(tex.replace("[htbp]", "[h!]"))) > 5


def all_templates() -> str:
    folder = Path(build.__file__).parent / "templates"
    return "\n".join(path.read_text(encoding="utf-8") for path in sorted(folder.iterdir()))


def test_every_table_is_printed_and_none_is_asked_for_that_is_not() -> None:
    """Catches a table that is made and stands nowhere."""
    text = all_templates()
    assert [name for name in TABLES if rf"\VAR{{{name}}}" not in text] == []


def test_no_riddles_in_the_text() -> None:
    words = ("becomes of", "gone on with", "what is what", "number behind", "last number but")
    assert [word for word in words if word in all_templates()] == []


LATEX = pytest.mark.skipif(not engine_present(), reason="no LaTeX engine on this machine")


@LATEX
@pytest.mark.slow
def test_the_whole_report_has_tables_in_order_and_nothing_in_the_margin(tmp_path: Path) -> None:
    """The report itself, of about four minutes on two cores."""
    scenes = report_scenes()
    done: Mapping[Key, Any] = run_jobs(all_jobs(scenes, False), 2, lambda _: None)
    check_report(Findings(done, scenes), tmp_path)


def check_report(found: Findings, folder: Path) -> None:
    """Write and typeset the report of some findings, and check it by the rules above."""
    for _ in write_figures(build.report_figures(found), folder):
        pass
    path = write_source(found, folder, False, lambda: None)
    tex = path.read_text(encoding="utf-8")
    assert faults_of_tables(tex) == []
    assert faults_of_floats(tex) == []
    top = found.runs.relative_error(SPLIT, 0.0)
    assert " & ".join(uncertain(*top)) in tex[: tex.index(r"\section{")]
    compile_pdf(path)
    assert faults_of_log(path.with_suffix(".log").read_text(errors="replace")) == []


@LATEX
@pytest.mark.slow
def test_a_line_beyond_the_margin_is_found(tmp_path: Path) -> None:
    wide = table("wide", "Wide.", "l", ["one"], [[r"\rule{200mm}{1ex}"]])
    packages = r"\documentclass{article}\usepackage{booktabs,longtable}"
    tex = tmp_path / "wide.tex"
    body = rf"{packages}\begin{{document}}{wide} \ref{{tab:none}}\end{{document}}"
    tex.write_text(body, encoding="utf-8")
    compile_pdf(tex)
    log = tex.with_suffix(".log").read_text(errors="replace")
    assert len(faults_of_log(log)) >= 2
