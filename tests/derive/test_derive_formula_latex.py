"""Formulas in LaTeX: nothing is simplified, and no two formulas have one text."""

import pytest

from longwave.derive.algebra.formula_latex import formula_latex
from longwave.derive.algebra.formula_tree import plain_text
from longwave.verify.proof.text_names import FUNCTIONS
from longwave.verify.proof.typed_statement import tree_of

TEXTS = [
    ("x - (t - 1)", r"x - \left(t - 1\right)"),
    ("x - 4*t", "x - 4 t"),
    ("-(a + b)*c", r"-\left(a + b\right) c"),
    ("a/b*c", r"\frac{a c}{b}"),
    ("a/(b*c)/d", r"\frac{a}{\left(b c\right) d}"),
    ("0/x + 0*tanh(x)", r"\frac{0}{x} + 0 \tanh\left(x\right)"),
    ("2*3*x", r"2 \cdot 3 x"),
    ("ab*a*b", r"\mathrm{ab} a b"),
    ("sin(x)**2 + sin(x**2)", r"\sin^{2}\left(x\right) + \sin\left(x^{2}\right)"),
    ("exp(I*x)**(1/2)", r"\left(\mathrm{e}^{\mathrm{i} x}\right)^{\frac{1}{2}}"),
    ("(-1)**n", r"\left(-1\right)^{n}"),
    ("-1**n", "-1^{n}"),
    ("(x**2)**(1/2)", r"\left(x^{2}\right)^{\frac{1}{2}}"),
    ("abs(conjugate(x))**2", r"\left|\overline{x}\right|^{2}"),
    ("jacobi_sn(x, m)**2", r"\operatorname{sn}^{2}\left(x \mid m\right)"),
]


@pytest.mark.parametrize(("text", "latex"), TEXTS)
def test_a_formula_is_written_as_it_was_typed(text: str, latex: str) -> None:
    assert formula_latex(tree_of(text)) == latex


@pytest.mark.parametrize("text", [text for text, _ in TEXTS])
def test_plain_text_is_read_back_as_an_equal_formula(text: str) -> None:
    tree = tree_of(text)
    again = tree_of(plain_text(tree))
    assert formula_latex(again) == formula_latex(tree)
    assert plain_text(again) == plain_text(tree)


def test_every_function_has_its_own_latex() -> None:
    found = {}
    for name, (_, count) in FUNCTIONS.items():
        arguments = ", ".join("xyz"[:count])
        found[name] = formula_latex(tree_of(f"{name}({arguments})**3"))
        for left, right in (("{", "}"), (r"\left", r"\right")):
            assert found[name].count(left) == found[name].count(right)
    assert len({*found.values()}) == len(found)
