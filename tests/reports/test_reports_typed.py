"""Formulas of texts as LaTeX: brackets where they are needed, wide parts in one line, sentences."""

import pytest

from longwave.derive.algebra.formula_text import FormulaError
from longwave.reports.formulas.typed import (
    prose_latex,
    statement_parts,
    typed_text_latex,
)
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.published import chosen

LONG = " + ".join(f"a*x**{n}" for n in range(2, 16))


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a - (b - c)", "a - (b - c)"),
        ("a + (b + c)", "a + (b + c)"),
        ("-(a + b)", "-(a + b)"),
        ("(a + b)*c", "(a + b) c"),
        ("a/b/c", r"\frac{a}{b c}"),
        ("a/(b*c)", r"\frac{a}{b c}"),
        ("a/b*c", r"\frac{a c}{b}"),
        ("a*2", r"a \cdot 2"),
        ("2*3**(1/2)", r"2 \cdot 3^{\tfrac{1}{2}}"),
        ("(-1)**n", "(-1)^{n}"),
        ("(a*b)**2", "(a b)^{2}"),
        ("a**b**c", "a^{b^{c}}"),
        ("sin(x)**2", r"\sin^{2}(x)"),
        ("1/u_xx", r"\frac{1}{u_{xx}}"),
        ("diff(u**2, x, x)", "(u^{2})_{xx}"),
        ("exp(-I*omega*t)", r"\mathrm{e}^{-\mathrm{i} \omega t}"),
        ("jacobi_sn(b, m)", r"\operatorname{sn}(b \mid m)"),
        ("jacobi_sn(b, k**2)", r"\operatorname{sn}(b \mid k^{2})"),
        ("abs(u)**2", r"\left|u\right|^{2}"),
        ("conjugate(u)", r"\overline{u}"),
        ("bessel_j(1, x)", r"\operatorname{J}_{1}(x)"),
        ("K2*w0", "K_{2} w_{0}"),
    ],
)
def test_a_formula_means_what_was_typed(text: str, shown: str) -> None:
    """Catches a bracket that is lost, and a factor that moves under the fraction."""
    assert typed_text_latex(text) == shown


def test_a_wide_formula_can_be_broken_into_lines() -> None:
    assert r"\frac" not in typed_text_latex(f"({LONG})/b")
    assert typed_text_latex(f"b/({LONG})").startswith(r"b \Big/ ")
    assert typed_text_latex(f"exp({LONG})").startswith(r"\exp(")
    assert r"\sqrt" not in typed_text_latex(f"sqrt({LONG})")


def test_a_statement_has_equations_solutions_and_names_for_parts() -> None:
    (text,) = chosen(["ablowitz_ladik_two_solitons"])
    equations, solutions, conditions = statement_parts(text.problem().statement)
    assert equations[0].startswith(r"\mathrm{i} u_{n, t}")
    assert equations[0].endswith(" = 0")
    assert [formula.partition(" = ")[0] for formula in solutions] == ["u_{n}", "p"]
    assert conditions
    parameters = "k: k>0; p = sinh(k)**2; j: integer, j>=1; b: b != 0"
    statement = read_statement("u_x - p*k*j*b", "u = x*p*k*j*b", parameters, "x < 1/2")
    expected = ("k > 0", r"j \in \mathbb{Z}", r"j \ge 1", r"b \ne 0", r"x < \frac{1}{2}")
    assert statement_parts(statement)[2] == expected


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a**2 for a in one of 4 places", r"$a^{2}$ for a in one of 4 places"),
        ("right at c = -1, and 2 a t for 4 a t", "right at $c = -1$, and $2 a t$ for $4 a t$"),
        ("the Cole-Hopf factor; sin*cos", "the Cole-Hopf factor; sin cos"),
        ("50 % of u_xx", r"50 \% of $u_{xx}$"),
        ("5/sqrt(6): a speed", r"$\frac{5}{\sqrt{6}}$: a speed"),
        ("carrier k = pi/2", r"carrier $k = \frac{\pi}{2}$"),
        ("- sinh**2", r"- $\mathrm{sinh}^{2}$"),
    ],
)
def test_a_sentence_has_its_formulas_set_and_its_words_left(text: str, shown: str) -> None:
    """Catches a word read as a product, and a formula that is left as typed."""
    assert prose_latex(text) == shown


def test_an_invalid_formula_is_an_error() -> None:
    with pytest.raises(FormulaError, match="formula"):
        typed_text_latex("a +")
