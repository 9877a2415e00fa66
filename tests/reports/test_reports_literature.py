"""The chapter on published solutions: verdicts, refuted variants, misprints, and its LaTeX."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from longwave.reports.engine import compile_pdf, engine_present
from longwave.reports.sections.literature import (
    found_misprints,
    library_conditions,
    library_counts,
    library_table,
)
from longwave.reports.studies.proofs import PublishedVerdict, library_jobs
from longwave.verify.published import chosen, published
from longwave.verify.verdict import Outcome


def as_expected(names: Sequence[str] = ()) -> list[PublishedVerdict]:
    """Verdicts as the library expects them; nothing is decided."""
    return [PublishedVerdict(text, Outcome(text.expect), 0.25) for text in chosen(names)]


def test_a_row_has_the_verdict_the_refuted_variants_and_the_source() -> None:
    found = as_expected(["kdv_cnoidal_wave", "kdv_cnoidal_modulus"])
    text = library_table(found)
    assert r"\textbf{Korteweg-de Vries}" in text
    assert "& PROVED & k: k>0; m: 0<m<1 & 1/1 & D. J. Korteweg" in text
    assert "(1895) 422$^*$ " in text
    undecided = [found[0], replace(found[1], outcome=Outcome.UNDECIDED)]
    assert "& 0/1 &" in library_table(undecided)


def test_verdicts_are_counted_by_what_was_expected() -> None:
    """Catches a wrong statement that is proved counted among the right ones."""
    right, wrong = as_expected(["kdv_cnoidal_wave", "kdv_cnoidal_modulus"])
    assert "right & 1 & 0 & 0" in library_counts([right, wrong])
    text = library_counts([right, replace(wrong, outcome=Outcome.PROVED)])
    assert "right & 1 & 0 & 0" in text
    assert "wrong & 1 & 0 & 0" in text
    assert "median 0.250 s, slowest 0.2 s" in text


def test_every_misprint_and_every_note_of_a_right_statement_is_shown() -> None:
    found = as_expected()
    misprints, conditions = found_misprints(found), library_conditions(found)
    assert r"\texttt{toronto\_\allowbreak{}kdv\_\allowbreak{}soliton}" in misprints
    assert misprints.count(r"\texttt") == sum(bool(text.misprint_in) for text in published())
    assert "only the weak form ties them" in conditions
    assert r"kdv\_\allowbreak{}soliton\_\allowbreak{}speed" not in conditions


def test_each_statement_has_its_job() -> None:
    jobs = library_jobs()
    found = jobs["library", "thin film"].run(lambda _: None)
    assert all(verdict.expected for verdict in found)
    assert {name for _, name in jobs} == {text.equation_name for text in published()}


@pytest.mark.slow
@pytest.mark.skipif(not engine_present(), reason="no LaTeX engine on this machine")
def test_the_chapter_compiles(tmp_path: Path) -> None:
    found = as_expected()
    tables = [make(found) for make in (library_table, found_misprints, library_conditions)]
    page = r"\documentclass{article}\usepackage[a4paper,margin=22mm]{geometry}"
    head = page + r"\usepackage[T1]{fontenc}\usepackage{lmodern,booktabs,longtable,array}"
    column = r"\newcolumntype{L}[1]{>{\raggedright\arraybackslash}p{#1}}"
    body = "\n".join([library_counts(found), *tables])
    tex = tmp_path / "chapter.tex"
    begin, end = r"\begin{document}\footnotesize", r"\end{document}"
    tex.write_text("\n".join([head, column, begin, body, end]), encoding="utf-8")
    assert compile_pdf(tex).read_bytes().startswith(b"%PDF")
    log = tex.with_suffix(".log").read_text(errors="replace")
    wide = [float(points) for points in re.findall(r"Overfull \\hbox \(([\d.]+)pt", log)]
    assert [points for points in wide if points > 5] == []
