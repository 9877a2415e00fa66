"""The closed forms: a table, and a display of each made from its expression."""

from collections.abc import Iterable

import sympy as sp

from reports.environment import escape
from reports.formulas import Formula, equation_latex, latex
from reports.paper import cited
from reports.tables import block
from solutions import CATALOGUE, ClosedForm
from solutions.record import Equation


def solution_table(forms: Iterable[ClosedForm] = CATALOGUE) -> str:
    """The closed forms: name, sign, domains, background, equation of the paper and source."""
    rows = [
        [
            rf"\hyperref[form:{form.name}]{{{escape(form.title)}}}",
            f"${form.equation.s:+d}$",
            ", ".join(domain_latex(parameter.domain) for parameter in form.parameters) or "--",
            "constant" if form.period is None else f"period ${latex(form.period)}$",
            rf"{cited(form.reference.label)} \cite{{{form.reference.citation}}}",
        ]
        for form in forms
    ]
    head = ["solution", "$s$", "parameters", "background", "paper, source"]
    return block("lrlll", head, rows)


def domain_latex(domain: str) -> str:
    r"""Return a parameter's domain as LaTeX; its words are those of the record.

    >>> domain_latex("0 < k < 1"), domain_latex("X_0 real")
    ('$0<k<1$', '$X_{0}$ real')
    """
    words = [_domain_word(word) for word in domain.split()]
    return " ".join(words).replace("$ $", "")


def _domain_word(word: str) -> str:
    """Return one word of a domain: relations and symbols in mathematics."""
    if word in ("real", "positive"):
        return word
    named = {"<": "<", "<=": r"\le", "elliptic_k(k**2)": "K(k)", "2*A": "2A"}
    named |= {letter: rf"\{letter}" for letter in ("alpha", "kappa")}
    letter, _, index = word.partition("_")
    plain = f"{letter}_{{{index}}}" if index else word
    return f"${named.get(word, plain)}$"


def formulas(forms: Iterable[ClosedForm] = CATALOGUE) -> list[dict[str, str]]:
    """Every closed form as a display made from its expression, with its background."""
    return [
        {
            "name": form.name,
            "title": form.title[0].upper() + form.title[1:],
            "paper": cited(form.reference.label),
            "citation": form.reference.citation,
            "display": Formula(form.expression).latex("U"),
            "left": latex(form.far_fields.left),
            "right": latex(form.far_fields.right),
            "equation": form.equation.name,
        }
        for form in forms
    ]


def equations(forms: Iterable[ClosedForm] = CATALOGUE) -> list[tuple[str, str]]:
    """The equations that the forms solve: name and LaTeX, each once."""
    return sorted({(form.equation.name, _equation(form.equation)) for form in forms})


def _equation(equation: Equation) -> str:
    unknown = sp.Function("U")(equation.xi, equation.tau)
    return equation_latex(equation.residual(unknown), unknown, equation.tau)
