"""Templates: LaTeX's own braces and comments survive, text is escaped, unknown names stop."""

import jinja2
import pytest

from reports.latex import environment, escape, render


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
    made = environment()
    for name in made.list_templates():
        made.get_template(name)


def test_a_shipped_template_renders() -> None:
    assert r"\section{Slips in print}" in render("slips.tex.j2")
