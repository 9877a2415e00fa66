"""Formulas on the page: parts put back restore the formula, lines fit, sums keep their signs."""

import pytest
import sympy as sp

from reports.formulas import LINE, Formula, broken, width
from solutions import CATALOGUE, ClosedForm


@pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)
def test_named_parts_put_back_give_the_formula(form: ClosedForm) -> None:
    """Catches a part substituted in one row and lost in another."""
    assert Formula(form.expression).whole() == form.expression


@pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)
def test_every_row_is_a_sum_or_fits_the_line(form: ClosedForm) -> None:
    for row in Formula(form.expression).rows:
        terms = row.as_ordered_terms() if row.is_Add else [row]
        assert all(width(term) <= LINE for term in terms)


def test_a_name_stands_for_one_part_only() -> None:
    x = sp.Symbol("x", real=True)
    wide = sum((x + 17) ** n * (x**2 + 11) ** (n + 1) * sp.sin(x**n + 5) for n in range(2, 12))
    formula = Formula(wide)
    assert len(set(formula.names)) == len(formula.names) == len(formula.rows) - 1
    assert len(set(formula.rows)) == len(formula.rows)
    assert formula.whole() == wide


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
    assert Formula(x**2 + 1).rows == [x**2 + 1]
