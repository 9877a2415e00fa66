"""Formulas on the page: what is printed is the formula, fits the line and has no nested fractions.

The chain is closed: the LaTeX is read back to the tidied rows, these equal the stated rows as
rational functions, and the stated rows put together are the formula itself.
"""

import re
import shutil
from collections import defaultdict
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
import sympy as sp
from matplotlib.figure import Figure

from longwave.derive.algebra.latex_width import nesting
from longwave.reports.build import TABLES, Findings, source
from longwave.reports.engine import compile_pdf, engine_present
from longwave.reports.formulas.formula import Formula, broken
from longwave.reports.formulas.printing import LINE, is_wide, latex, tidied, width
from longwave.reports.pictures.paper_figures import ERROR_FIGURES, SNAPSHOT_FIGURES
from longwave.reports.pictures.style import TEXT_WIDTH
from longwave.reports.sections import theory
from longwave.reports.sections.headlines import Headline
from longwave.reports.sections.theory import solution_table
from longwave.reports.studies.measured_runs import report_scenes
from longwave.solutions import CATALOGUE, ClosedForm
from longwave.solutions.functions import jacobi_dn, jacobi_sn
from longwave.solutions.symbols import k, tau, xi
from tests.families import family
from tests.reports.latex_reader import Reader


def sn(z: sp.Expr) -> sp.Expr:
    return jacobi_sn(z, k**2)


def dn(z: sp.Expr) -> sp.Expr:
    return jacobi_dn(z, k**2)


forms = pytest.mark.parametrize(
    "form", family(CATALOGUE.of("mKdV"), slow=("rogue_cn", "rational_3"))
)


cached_formula = cache(Formula)


def formula(form: ClosedForm) -> Formula:
    return cached_formula(form.expression)


def is_zero(expression: sp.Expr) -> bool:
    """Decide whether a rational function of symbols, functions and roots vanishes."""
    functions = expression.atoms(sp.Function, sp.exp)
    roots = {node for node in expression.atoms(sp.Pow) if not node.exp.is_Integer}
    rational = expression.xreplace({node: sp.Dummy() for node in functions | roots})
    return sp.expand(sp.fraction(sp.together(rational))[0]) == 0


@forms
def test_named_parts_put_back_give_the_formula(form: ClosedForm) -> None:
    """Catches a part substituted in one row and lost in another."""
    assert formula(form).stated.whole() == form.expression


@forms
def test_a_tidied_row_is_the_row(form: ClosedForm) -> None:
    """Catches a factor or sign lost when fractions are put together."""
    for row in formula(form).stated.rows:
        assert is_zero(tidied(row) - row)


@forms
def test_the_printed_text_reads_back_as_the_rows(form: ClosedForm) -> None:
    """Catches a bracket, sign or factor that the printer drops, and one name for two things."""
    found = formula(form)
    parts = list(found.printed_parts.values())
    symbols = [*form.expression.free_symbols, *(letter for letter, _ in parts)]
    names = {latex(symbol): symbol for symbol in symbols}
    assert len(names) == len(symbols)
    for row in (found.printed_first, *(printed for _, printed in parts)):
        assert is_zero(Reader(" ".join(broken(row)), names).read() - row)


@forms
def test_rows_fit_the_line_without_nested_fractions(form: ClosedForm) -> None:
    found = formula(form)
    for row in (tidied(row) for row in found.stated.rows):
        assert all(width(term) <= LINE for term in sp.Add.make_args(row))
        assert nesting(latex(row)) <= 1


@pytest.fixture
def report(monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the report's source, with formulas that are built once for all tests."""
    monkeypatch.setattr(theory, "Formula", cached_formula)
    tables = dict.fromkeys(TABLES, "") | {"solution_table": solution_table()}
    found = Findings({}, report_scenes())
    nothing = Headline("nothing", "0", "exact", "sec:conclusion")
    found.__dict__["headlines"] = defaultdict(lambda: nothing)
    return source(tables, found, full=False)


@pytest.mark.slow
def test_the_source_has_every_form_and_is_balanced(report: str) -> None:
    for form in CATALOGUE.of("mKdV"):
        assert rf"\hyperref[form:{form.name}]" in report
        assert rf"\label{{form:{form.name}}}" in report
    begun = re.findall(r"\\begin\{(\w+\*?)\}", report)
    ended = re.findall(r"\\end\{(\w+\*?)\}", report)
    assert sorted(begun) == sorted(ended)
    plain = re.sub(r"\\[{}]", "", report)
    assert plain.count("{") == plain.count("}")


@pytest.mark.slow
def test_a_parameter_called_like_a_part_is_told_from_it() -> None:
    """Catches a part P where the formula has a parameter P."""
    x, taken = sp.symbols("x P", real=True)
    terms = [(x + taken + 123456789 * n) ** 2 * sp.sin(x * taken + 11 * n) for n in range(9)]
    found = Formula(sp.Add(*terms) / (taken + sp.Add(*terms) ** 2))
    printed = [latex(letter) for letter, _ in found.printed_parts.values()]
    assert printed
    assert "P" not in printed
    assert found.stated.whole() == sp.Add(*terms) / (taken + sp.Add(*terms) ** 2)


@pytest.mark.parametrize("pair", [(sp.sin, sp.cos), (sp.sinh, sp.cosh), (sn, dn)])
@pytest.mark.parametrize("phase", [k * tau - xi, (1 - k) * tau - xi, (k - 2) * tau - xi])
def test_a_phase_that_runs_left_keeps_the_sign(
    pair: tuple[Callable[[sp.Expr], sp.Expr], ...], phase: sp.Expr
) -> None:
    """Catches an odd function of the phase taken for an even one."""
    odd, even = pair
    expression = odd(phase) + even(phase) ** 2
    found = Formula(expression)
    assert len(found.stated.parts) == 1
    assert found.stated.whole() == expression


@pytest.mark.slow
def test_arguments_and_the_modulus_have_names_of_their_own() -> None:
    [form] = [form for form in CATALOGUE if form.name == "rogue_cn"]
    printed = {latex(letter) for letter, _ in formula(form).printed_parts.values()}
    assert {r"\phi", "k'", r"\mathrm{cn}", "D"} <= printed


def test_a_name_stands_for_one_part_only() -> None:
    x = sp.Symbol("x", real=True)
    wide = sum((x + 17) ** n * (x**2 + 11) ** (n + 1) * sp.sin(x**n + 5) for n in range(2, 12))
    found = Formula(wide)
    assert len(set(found.stated.parts.values())) == len(found.stated.parts)
    assert found.stated.whole() == wide


def test_a_broken_sum_has_signs_between_its_lines() -> None:
    """Catches a minus sign lost, or a plus doubled, where the line is broken."""
    x = sp.Symbol("x")
    polynomial = sp.Add(*((-1) ** n * 123456789 * x**n for n in range(30)))
    first, *rest = broken(polynomial)
    assert rest
    assert all(line.startswith(("+ ", "- ", "-")) for line in rest)
    signs = " ".join([first, *rest]).replace("+ -", "BAD")
    assert "BAD" not in signs
    assert signs.count("123456789") == 30
    assert signs.count("+") + signs.count("-") in (29, 30)


def test_a_short_formula_is_left_alone() -> None:
    x = sp.Symbol("x")
    assert Formula(x**2 + 1).stated.rows == [x**2 + 1]
    assert not is_wide(x**2 + 1)


@pytest.mark.slow
@pytest.mark.skipif(not engine_present(), reason="no LaTeX engine on this machine")
def test_the_source_compiles_without_overfull_lines(tmp_path: Path, report: str) -> None:
    picture = tmp_path / "picture.png"
    Figure((TEXT_WIDTH, 2.0)).savefig(picture, dpi=72)
    (tmp_path / "figures").mkdir()
    names = [figure.name for figure in (*SNAPSHOT_FIGURES, *ERROR_FIGURES)]
    names += ["evaluation_costs", "work_precision", "cost_scaling", "modulation"]
    for name in (*names, "lattice_rogues", "lattice_peregrines", "lattice_rates"):
        shutil.copy(picture, tmp_path / "figures" / f"{name}.png")
    tex = tmp_path / "longwave.tex"
    tex.write_text(re.sub(r"(figures/\w+)\.pdf", r"\1.png", report), encoding="utf-8")
    assert compile_pdf(tex).read_bytes().startswith(b"%PDF")
    log = tex.with_suffix(".log").read_text(errors="replace")
    missing = re.findall(r"(?:Reference|Citation) `([^']+)'", log)
    assert [name for name in missing if not name.startswith("tab:")] == []  # tables are empty here
    wide = [float(points) for points in re.findall(r"Overfull \\hbox \(([\d.]+)pt", log)]
    assert [points for points in wide if points > 5] == []
