"""LaTeX: its own braces survive, text is escaped, numbers keep their digits, signs and powers."""

import math

import jinja2
import pytest
from hypothesis import given
from hypothesis import strategies as st

from longwave.reports.latex import (
    environment,
    escape,
    render,
    scientific,
    table,
    uncertain,
)


def filled(template: str, **content: object) -> str:
    return environment().from_string(template).render(**content)


def test_latex_braces_and_comments_survive() -> None:
    text = r"\frac{a}{b} {{x}} {% keep %} 50\% % comment"
    assert filled(text) == text


def test_values_blocks_and_comments_of_the_template() -> None:
    text = "\\BLOCK{ for n in numbers }\\VAR{n};\\BLOCK{ endfor }\\#{ unseen }"
    assert filled(text, numbers=[1, 2]) == "1;2;"


def test_an_unknown_name_is_an_error() -> None:
    with pytest.raises(jinja2.UndefinedError):
        filled(r"\VAR{nobody}")


@pytest.mark.parametrize("character", list("\\&%$#_{}~^"))
def test_each_special_character_is_escaped(character: str) -> None:
    assert escape(character) != character
    assert escape(character).startswith("\\")


def test_escaping_is_done_once() -> None:
    """Catches escaping in passes, where the backslash of one escape is escaped by the next."""
    assert escape("a_b & {c}") == r"a\_b \& \{c\}"
    assert filled(r"\VAR{text|e}", text="K_2") == r"K\_2"


def test_every_template_parses() -> None:
    templates = environment()
    names = templates.list_templates()
    assert "slips.tex.j2" in names
    for name in names:
        templates.get_template(name)


def test_a_shipped_template_renders() -> None:
    assert r"\section{Slips in print}" in render("slips.tex.j2")


@given(st.floats(min_value=1e-30, max_value=1e30), st.integers(2, 6))
def test_scientific_keeps_the_value(value: float, digits: int) -> None:
    """Catches a lost exponent and a rounded-away digit."""
    text = scientific(value, digits).strip("$").replace(r"\times 10^{", "e").replace("}", "")
    assert float(text.replace(" ", "").replace("\\", "")) == pytest.approx(
        value, rel=0.51 * 10 ** (1 - digits)
    )


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (0.10138, 4e-5, (r"$0.101380$", r"$4.0\times 10^{-5}$")),
        (0.10138, 4.11e-5, (r"$0.101380$", r"$4.2\times 10^{-5}$")),
        (5.25, 0.5, ("$5.25$", "$0.50$")),
        (-3.0, 0.02, ("$-3.000$", "$0.020$")),
        (1.5, 2e-9, ("$1.50000$", r"$2.0\times 10^{-9}$")),
        (2.1, 9.96, ("$2.1$", "$10$")),
        (1234.5678, 25.0, ("$1235$", "$25$")),
        (0.12, 0.0, ("$0.12$", "--")),
        (3.6e-5, 1e-12, (r"$3.60000\times 10^{-5}$", r"$1.0\times 10^{-12}$")),
        (0.0, 1e-9, (r"$0.0\times 10^{-9}$", r"$1.0\times 10^{-9}$")),
        (0.0, 0.0, ("$0$", "--")),
    ],
)
def test_the_error_sets_the_digits_and_is_rounded_up(
    value: float, error: float, shown: tuple[str, str]
) -> None:
    assert uncertain(value, error) == shown


def test_infinite_values_are_words() -> None:
    assert scientific(math.inf) == r"$\mathrm{inf}$"


def test_rows_have_the_columns_of_the_head() -> None:
    text = table("one", "Numbers.", "ll", ["a", "b"], [["1", "2"], ["3", "4"]])
    lines = [line for line in text.splitlines() if " & " in line]
    assert lines == [r"a & b \\", r"a & b \\", r"1 & 2 \\*", r"3 & 4 \\"]
    assert r"\caption{Numbers.}\label{tab:one}" in text
    assert table("one", "Numbers.", "ll", ["a", "b"], []) == ""


def test_no_row_stands_alone_and_no_heading_without_its_rows() -> None:
    """Catches a page that may end with a heading, or begin with the last row of a group."""
    groups = [row for name in "ABC" for row in [f"group {name}", *([name, n] for n in "1234")]]
    text = table("one", "Numbers.", "ll", ["a", "b"], groups)
    rows = text[text.index(r"\endfoot") :].splitlines()[1:-1]
    is_kept_together = [line.endswith("*") for line in rows]
    assert is_kept_together[:5] == is_kept_together[5:10] == [True, True, False, True, False]
    assert is_kept_together[10:15] == [True, True, False, True, False]
    assert sum(r"\multicolumn{2}" in line for line in rows) == 3
