"""The library of published solutions: verdicts, variants and misprints, formulas as mathematics."""

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from longwave.reports.engine import compile_pdf, engine_present
from longwave.reports.formulas.typed import statement_parts
from longwave.reports.sections.literature import (
    found_misprints,
    library_conditions,
    library_counts,
    library_equations,
    library_formulas,
)
from longwave.reports.studies.proofs import PublishedVerdict, library_jobs
from longwave.verify.problem_file import ProblemText
from longwave.verify.published import chosen, published
from longwave.verify.verdict import Outcome
from tests.reports.table_rules import SYNTAX, faults_of_log


@cache
def verdict(text: ProblemText) -> PublishedVerdict:
    """Return the verdict that the library expects, without deciding anything."""
    parts = statement_parts(text.problem().statement)
    return PublishedVerdict(text, Outcome(text.expect), 0.25, *parts)


def as_expected(names: Sequence[str] = ()) -> list[PublishedVerdict]:
    return [verdict(text) for text in chosen(names)]


def test_an_entry_has_equation_formula_domain_verdict_variants_and_source() -> None:
    right, wrong = as_expected(["kdv_cnoidal_wave", "kdv_cnoidal_modulus"])
    text = library_formulas([right, wrong])
    assert r"\libraryequation{Korteweg-de Vries}" in text
    assert r"$\displaystyle u_{t} + 6 u u_{x} + u_{xxx} = 0$" in text
    assert r"\libraryentry{cnoidal wave}{proved}{D. J. Korteweg" in text
    assert "(1895) 422$^*$}" in text
    assert r"\operatorname{cn}^{2}" in text
    assert r"($k > 0$, $0 < m < 1$)" in text
    assert r"\librarynote{the modulus taken for the parameter $m$ of $\mathrm{cn}$}" in text
    undecided = replace(wrong, outcome=Outcome.UNDECIDED)
    assert r"of $\mathrm{cn}$ \textbf{(undecided)}" in library_formulas([right, undecided])


def test_verdicts_are_counted_by_what_was_expected() -> None:
    """Catches a wrong statement that is proved counted among the right ones."""
    right, wrong = as_expected(["kdv_cnoidal_wave", "kdv_cnoidal_modulus"])
    assert "right & 1 & 0 & 0 & $0.25$ & $0.25$" in library_counts([right, wrong])
    text = library_counts([right, replace(wrong, outcome=Outcome.PROVED)])
    assert "right & 1 & 0 & 0" in text
    assert "wrong & 1 & 0 & 0" in text
    assert "Korteweg-de Vries & 1 & 1 &" in library_equations([right, wrong])


def test_every_misprint_and_every_note_of_a_right_statement_is_shown() -> None:
    names = [text.name for text in published() if text.misprint_in]
    names += [text.name for text in published() if text.note and text.expect == Outcome.PROVED]
    found = as_expected(names)
    misprints, conditions = found_misprints(found), library_conditions(found)
    assert misprints.count("& refuted &") == sum(bool(text.misprint_in) for text in published())
    assert r"\textbf{Toda lattice}: a question on the Toda lattice" in misprints
    assert r"$\sinh(t)$ for $\sinh(k) t$" in misprints
    assert "only the weak form ties them" in conditions


def test_no_formula_is_in_program_syntax() -> None:
    """Catches a formula, a domain or a note that is printed as it is typed."""
    kdv = [text.name for text in published() if text.equation_name == "Korteweg-de Vries"]
    hard = ["ablowitz_ladik_two_solitons", "manakov_rogue_wave", "nls_akhmediev_breather"]
    wrong = [text.name for text in published() if text.variant_of in hard]
    found = as_expected([*kdv, *hard, *wrong])
    for make in (library_formulas, found_misprints, library_conditions):
        assert SYNTAX.search(make(found)) is None
    assert SYNTAX.search("2*k**2*sech(k*x)")


def test_each_statement_has_its_job() -> None:
    jobs = library_jobs()
    found = jobs["library", "thin film"].run(lambda _: None)
    assert all(verdict.expected for verdict in found)
    assert all(verdict.formulas and verdict.equations for verdict in found)
    assert {name for _, name in jobs} == {text.equation_name for text in published()}


@pytest.mark.slow
@pytest.mark.skipif(not engine_present(), reason="no LaTeX engine on this machine")
def test_the_library_compiles_without_a_formula_beyond_the_margin(tmp_path: Path) -> None:
    found = as_expected()
    assert SYNTAX.search(library_formulas(found)) is None
    tables = (library_counts, found_misprints, library_conditions, library_equations)
    body = "\n".join([*(make(found) for make in tables), library_formulas(found)])
    template = Path("reports/templates/report.tex.j2").read_text(encoding="utf-8")
    head = re.sub(r"%%.*\n|\\VAR\{\w+\}", "", template.partition(r"\begin{document}")[0])
    tex = tmp_path / "library.tex"
    lines = [head, r"\begin{document}", r"\footnotesize", body, r"\end{document}"]
    tex.write_text("\n".join(lines), encoding="utf-8")
    assert compile_pdf(tex).read_bytes().startswith(b"%PDF")
    assert faults_of_log(tex.with_suffix(".log").read_text(errors="replace")) == []
