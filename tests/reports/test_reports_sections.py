"""Sections: every run and order is printed, and users' texts are escaped."""

from dataclasses import replace

import pytest

from longwave.reports.latex import mathematics
from longwave.reports.paper import SOURCES, cited
from longwave.reports.pictures.paper_figures import ERROR_FIGURES, SNAPSHOT_FIGURES
from longwave.reports.sections.costs import accuracy_table
from longwave.reports.sections.runs import caption_part, claim_table
from longwave.reports.sections.theory import (
    derivation,
    equations,
    mutation_table,
    proof_table,
    survivor_table,
)
from longwave.reports.studies.claims import Claim, Measurement, Ruling
from longwave.reports.studies.evaluation_accuracy import Accuracy
from longwave.reports.studies.measured_runs import report_scenes
from longwave.reports.studies.proofs import ProofRecord
from longwave.scenes.description.named_scenes import shipped_scenes
from longwave.solutions import CATALOGUE
from longwave.verify.evidence.mutations import MutationCount, Survivor
from longwave.verify.verdict import Outcome, Verdict


def test_the_derivation_shows_each_order_and_the_condition() -> None:
    content = derivation()
    assert [order for order, _ in content["orders"]] == [3, 4, 5, 6, 7]
    assert content["conditions"][0][:2] == ("K_{3} = 0", 4)
    assert content["dispersion_agrees"] is True


def proof(outcome: Outcome, accepted: bool | None) -> ProofRecord:
    size = None if accepted is None else 1700
    seconds = None if accepted is None else 0.25
    return ProofRecord("kink", "differential algebra", outcome, 0.5, size, seconds, accepted)


def test_a_proof_row_shows_verdict_certificate_times_and_residual() -> None:
    residual = Verdict("kink", "defocusing mKdV", "mpmath", Outcome.CHECKED, "", 1e-3)
    text = proof_table([proof(Outcome.PROVED, True)], {"kink": residual})
    cells = ["kink", "proved", "A", "1.7", "0.50", "0.25", "accepted", "$0.0010$"]
    assert " & ".join(cells) in text
    assert "REJECTED" in proof_table([proof(Outcome.PROVED, False)], {})
    bare = proof_table([proof(Outcome.UNDECIDED, None)], {})
    assert "undecided & A & -- & 0.50 & -- & -- & --" in bare


def test_misprints_are_counted_and_survivors_listed() -> None:
    """Catches a survivor counted as refuted."""
    survivors = (
        Survivor("term x_1: dropped", Outcome.PROVED, "constant"),
        Survivor("term y: sign flipped", Outcome.UNDECIDED, "too hard"),
    )
    counts = [MutationCount("kink", 10, survivors, 1.0), MutationCount("soliton_sech", 5, (), 0.5)]
    text = mutation_table(counts)
    assert "kink & 10 & 8 & 1 & 1 & 1.0" in text
    assert "all solutions & 15 & 13 & 1 & 1 & 1.5" in text
    listed = survivor_table(counts)
    assert "$x_1$ & dropped & constant & proved" in listed
    assert "$y$ & sign flipped & too hard & undecided" in listed


def test_the_same_misprint_of_several_forms_is_one_row() -> None:
    """Catches a reason or a verdict merged away, and Python text on the page."""
    shift = [
        Survivor(f"term X_0: {change}", Outcome.PROVED, "another value of X_0")
        for change in ("coefficient times 101/100", "sign flipped", "dropped")
    ]
    sign = Survivor("term A*sech(A*(... + 1)): sign flipped", Outcome.PROVED, "symmetry U to -U")
    late = Survivor("term 2*(x/... + 1)/(1 + ...): sign flipped", Outcome.UNDECIDED, "too hard")
    counts = [
        MutationCount("kink", 5, (*shift, sign), 1.0),
        MutationCount("breather", 5, (*shift, late), 1.0),
    ]
    listed = survivor_table(counts)
    rows = [line for line in listed.splitlines() if line.startswith(("$", "the fraction"))]
    assert rows == [
        r"$X_0$ & 1 \% more, sign flipped, dropped & another value of $X_0$ & proved & "
        r"kink, breather \\*",
        r"$A \mathrm{sech}(\cdots)$ & sign flipped & symmetry $U\to-U$ & proved & kink \\*",
        r"the fraction & sign flipped & too hard & undecided & breather \\",
    ]


def test_the_worst_point_is_rounded_and_named_in_mathematics() -> None:
    """Catches sixteen digits, a name in Python, and 1 - 1e-12 rounded to 1."""
    worst = "k = 1 - 1e-12, alpha = 3.357e-08, tau_5 = 0.333333 n = 160149996.8, t = -80000000"
    text = accuracy_table([Accuracy("kink", 8, (3.24e-16, 4.1e-15, 8e-18), worst)])
    assert "kink & 8 & 3.2 & 41 & 0.08 & " in text
    where = r"$k=1-10^{-12}$, $\alpha=3.36\times 10^{-8}$, $\tau_{5}=0.333$"
    assert rf"{where} & $1.6\times 10^{{8}}$ & $-8\times 10^{{7}}$ \\" in text


def test_equations_have_subscripts_in_the_usual_order() -> None:
    labels = dict(equations())
    assert labels["focusing mKdV"] == r"U_{\tau} + 6 U^{2} U_{\xi} + U_{\xi \xi \xi} = 0"
    assert labels["defocusing mKdV"] == r"U_{\tau} - 6 U^{2} U_{\xi} + U_{\xi \xi \xi} = 0"


def test_every_reference_is_in_the_paper_and_has_a_source() -> None:
    """Catches a label that was not in the paper, and a source without a bibliography entry."""
    for form in CATALOGUE.of("mKdV"):
        assert cited(form.reference.label)
        assert form.reference.citation in SOURCES
    with pytest.raises(ValueError, match="got 'no such label'"):
        cited("no such label")
    with pytest.raises(ValueError, match="got ''"):
        cited("")


def test_a_claim_row_shows_number_error_verdict_and_reading() -> None:
    numbers = (Measurement("$eps=0.05$, largest", 0.1014, 0.00004), Measurement("$Y_2$", 5.0))
    claim = Claim("one", "not above 20 %", numbers, Ruling.DEPENDS, "$alpha$")
    text = claim_table([claim])
    assert r"not above 20 \%" in text
    assert r"$\epsilon=0.05$, largest & $0.101400$ & $4.0\times 10^{-5}$ \\*" in text
    assert r"$Y_2$ & $5$ & -- \\" in text
    assert r"\textbf{depends}. \emph{Rests on} $\alpha$." in text


def test_equal_measurements_of_several_cases_are_one_line() -> None:
    """Catches cases lost, and cases with other numbers merged."""
    numbers = [Measurement(f"$k={k}$: at the origin", 3.0) for k in (0.1, 0.3)]
    numbers.append(Measurement("$k=0.5$: at the origin", 2.0))
    text = claim_table([Claim("one", "s", tuple(numbers), Ruling.CONFIRMED, "d")])
    assert r"$k=0.1$, $k=0.3$: at the origin & $3$ & --" in text
    assert r"$k=0.5$: at the origin & $2$ & --" in text


def test_only_mathematics_is_translated() -> None:
    """Catches a word of the text taken for a symbol."""
    assert mathematics("alpha of $alpha <= 1$") == r"alpha of $\alpha \le  1$"


def test_every_shipped_scene_is_in_a_figure() -> None:
    drawn = {name for figure in SNAPSHOT_FIGURES for name in figure.scenes}
    for figure in ERROR_FIGURES:
        drawn |= {name for _, curves in figure.panels for _, name in curves}
    assert drawn == set(shipped_scenes())


def test_a_caption_names_the_constants() -> None:
    caption = caption_part(report_scenes()["breather_sn_k_0.7"])
    assert "$k=0.7$" in caption
    assert r"$\alpha=K/2$" in caption
    assert "$K_{4}=-1$" in caption


def test_a_parameter_that_is_text_is_no_latex() -> None:
    scene = replace(report_scenes()["rogue_cn_k_0.5"], parameters=(("k", r"50% of $K_2 \x"),))
    assert r"$k=50\% of \$K\_2 \textbackslash{}x$" in caption_part(scene)
