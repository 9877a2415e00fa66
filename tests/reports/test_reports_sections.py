"""Sections: every form, run and order is printed, and the source is balanced LaTeX."""

import re
import shutil
from pathlib import Path

import pytest

from reports import sections
from reports.assemble import source
from reports.engine import compile_pdf, engine_present
from reports.evidence import report_scenes
from reports.figures.paper import ERROR_FIGURES, SNAPSHOT_FIGURES
from solutions import CATALOGUE
from verify.lattice import shipped_scenes
from verify.verdict import Outcome, Verdict

TABLES = dict.fromkeys(("solution_table", "residual_table", "run_table", "claim_table"), "")


@pytest.fixture(scope="module")
def report() -> str:
    return source(TABLES | {"solution_table": sections.solution_table()}, report_scenes())


def test_every_form_has_a_row_and_a_formula(report: str) -> None:
    for form in CATALOGUE:
        assert rf"\hyperref[form:{form.name}]" in report
        assert rf"\label{{form:{form.name}}}" in report


def test_environments_and_braces_balance(report: str) -> None:
    begun = re.findall(r"\\begin\{(\w+\*?)\}", report)
    ended = re.findall(r"\\end\{(\w+\*?)\}", report)
    assert sorted(begun) == sorted(ended)
    plain = re.sub(r"\\[{}]", "", report)
    assert plain.count("{") == plain.count("}")


def test_the_derivation_shows_each_order_and_the_condition() -> None:
    content = sections.derivation()
    assert [order for order, _ in content["orders"]] == [3, 4, 5, 6, 7]
    assert content["conditions"][0][:2] == ("K_{3} = 0", 4)
    assert content["dispersion_agrees"] is True


def test_a_residual_row_shows_the_outcome() -> None:
    proved = Verdict("kink", "defocusing mKdV", "exact", Outcome.PROVED, "", 0.0, seconds=0.5)
    refuted = Verdict(
        "wave_sn", "defocusing mKdV", "residual", Outcome.REFUTED, "", 1e-3, {"xi": "1"}
    )
    text = sections.residual_table([proved, refuted])
    assert r"\texttt{kink} & defocusing mKdV & exact & PROVED & $0$ & 0.50" in text
    assert r"\texttt{wave\_sn}" in text
    assert "REFUTED" in text


def test_every_shipped_scene_is_in_a_figure() -> None:
    shown = {name for figure in SNAPSHOT_FIGURES for name in figure.scenes}
    for figure in ERROR_FIGURES:
        shown |= {name for _, curves in figure.panels for _, name in curves}
    assert shown == set(shipped_scenes())


def test_a_caption_names_the_constants() -> None:
    caption = sections.caption_part(report_scenes()["breather_sn_k_0.7"])
    assert "$k=0.7$" in caption
    assert r"$\alpha=K/2$" in caption
    assert "$K_4=-1$" in caption


@pytest.mark.slow
@pytest.mark.skipif(not engine_present(), reason="no LaTeX engine on this machine")
def test_the_source_compiles_without_overfull_lines(tmp_path: Path, report: str) -> None:
    picture = Path(__file__).parents[2] / "docs" / "rogue_wave.png"
    (tmp_path / "figures").mkdir()
    for figure in (*SNAPSHOT_FIGURES, *ERROR_FIGURES):
        shutil.copy(picture, tmp_path / "figures" / f"{figure.name}.png")
    tex = tmp_path / "longwave.tex"
    tex.write_text(re.sub(r"(figures/\w+)\.pdf", r"\1.png", report), encoding="utf-8")
    assert compile_pdf(tex).read_bytes().startswith(b"%PDF")
    log = tex.with_suffix(".log").read_text(errors="replace")
    assert "undefined" not in log.lower()
    wide = [float(points) for points in re.findall(r"Overfull \\hbox \(([\d.]+)pt", log)]
    assert [points for points in wide if points > 10] == []
