"""What each section of the report prints, gathered from the objects of the other rooms."""

from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from typing import Any

import sympy as sp

from derive import dispersion_relation, initial_velocity_latex, mkdv_reduction, reduce
from derive.dispersion import agrees_with_reduction
from reports.claims import all_claims
from reports.environment import escape
from reports.evidence import Evidence
from reports.figures.paper import ERROR_FIGURES, SNAPSHOT_FIGURES
from reports.formulas import Formula
from reports.tables import scientific, table
from solutions import CATALOGUE, ClosedForm, closed_form
from verify.lattice import Scene
from verify.verdict import Verdict

DERIVATION_ORDERS = 7
"""Highest power of eps shown: two beyond the mKdV equation."""


def derivation() -> dict[str, Any]:
    """The reduction order by order, its coefficients, the dispersion relation, the velocity."""
    shown = reduce(mkdv_reduction().lattice, mkdv_reduction().scaling, orders=DERIVATION_ORDERS)
    relation = dispersion_relation(shown.lattice)
    coefficients, form = shown.coefficients(), shown.normal_form()
    return {
        "force": sp.latex(shown.lattice.bonds[0].force),
        "orders": [(order, equation.latex()) for order, equation in shown.orders.items()],
        "sound": sp.latex(shown.sound_condition),
        "conditions": [
            (condition.latex(), condition.order, condition.equation.latex())
            for condition in shown.conditions
        ],
        "pde": shown.pde.latex(),
        "remainders": [shown.latex_remainder(order) for order in shown.remainders],
        "corrections": [shown.latex_correction(power) for power in shown.corrections],
        "coefficients": [
            (name, sp.latex(getattr(coefficients, name)))
            for name in ("c", "nonlinear", "dispersive")
        ],
        "normal_form": [(name, sp.latex(getattr(form, name))) for name in ("a", "b", "s")],
        "dispersion": relation.latex(),
        "dispersion_agrees": agrees_with_reduction(shown.lattice, shown),
        "velocity": initial_velocity_latex(),
    }


def solution_table(forms: Iterable[ClosedForm] = CATALOGUE) -> str:
    """The closed forms: name, equation, parameters with domains, background, where printed."""
    rows = [
        [
            rf"\hyperref[form:{form.name}]{{{escape(form.title)}}}",
            escape(form.equation.name),
            "; ".join(domain_latex(parameter.domain) for parameter in form.parameters) or "none",
            "constant" if form.period is None else f"period ${sp.latex(form.period)}$",
            rf"\texttt{{{escape(form.reference.label)}}}",
        ]
        for form in forms
    ]
    head = ["solution", "equation", "parameters", "background", "in the paper"]
    return table("L{36mm}L{20mm}L{30mm}L{24mm}L{34mm}", head, rows)


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
            "label": form.reference.label,
            "citation": form.reference.citation,
            "display": Formula(form.expression).latex("U"),
            "left": sp.latex(form.far_fields.left),
            "right": sp.latex(form.far_fields.right),
            "equation": form.equation.name,
        }
        for form in forms
    ]


def equations(forms: Iterable[ClosedForm] = CATALOGUE) -> list[tuple[str, str]]:
    """The equations that the forms solve: name and LaTeX, each once."""
    return sorted({(form.equation.name, form.equation.latex()) for form in forms})


def residual_table(verdicts: Iterable[Verdict]) -> str:
    """The verdicts: solution, method, outcome, residual, seconds."""
    rows = [
        [
            rf"\texttt{{{escape(verdict.name)}}}",
            escape(verdict.equation),
            escape(verdict.method),
            escape(verdict.outcome.value),
            "--" if verdict.residual is None else scientific(verdict.residual),
            f"{verdict.seconds:.2f}",
        ]
        for verdict in verdicts
    ]
    head = ["solution", "equation", "method", "verdict", "residual", "seconds"]
    return table("llL{32mm}lrr", head, rows)


def run_table(evidence: Evidence) -> str:
    """The runs: scheme, step, sites, and at each snapshot the errors and what they are made of."""
    rows = [row for name in evidence.runs for row in _run_rows(evidence, name)]
    head = [
        "$t$",
        r"$L^\infty_\epsilon$",
        "over far field",
        r"step$\,/\,\epsilon$",
        r"domain$\,/\,\epsilon$",
    ]
    return table("rllll", head, rows)


def _run_rows(evidence: Evidence, name: str) -> list[list[str]]:
    """Return the rows of one run, its description across the table first."""
    run = evidence.runs[name]
    columns = ("error_far_field", "time_step_error", "domain_error")
    rows = [[rf"\multicolumn{{5}}{{l}}{{{_description(name, evidence.scenes[name])}}}"]]
    for time in run["time"].values:
        at = run.sel(time=time)
        measures = [scientific(float(at[key])) if key in run else "--" for key in columns]
        error = evidence.relative_error(name, float(time)).latex()
        rows.append([rf"\nopagebreak ${time:g}$", error, *measures])
    return rows


def _description(name: str, scene: Scene) -> str:
    """Return name, scheme, step and domain of a scene in words."""
    words = (
        f"{scene.scheme}, dt = {scene.step:g}, {scene.domain} of {scene.sites} sites, "
        f"{2 * scene.compared + 1} compared"
    )
    return rf"\rule{{0pt}}{{3ex}}\texttt{{{escape(name)}}}: {escape(words)}"


def claim_table(evidence: Evidence) -> str:
    """The paper's statements with measured numbers, verdicts and what they depend on."""
    rows = [
        [claim.statement, claim.measured, claim.verdict, claim.depends_on]
        for claim in all_claims(evidence)
    ]
    head = ["the paper says", "measured here", "verdict", "depends on"]
    return table("L{42mm}L{60mm}L{18mm}L{28mm}", head, rows, gap="1ex")


def figure_entries(scenes: Mapping[str, Scene]) -> list[dict[str, Any]]:
    """The figures: file, caption from the scenes, label in the paper."""
    snapshots = [
        {
            "name": figure.name,
            "label": figure.label,
            "scenes": [caption_part(scenes[name]) for name in figure.scenes],
        }
        for figure in SNAPSHOT_FIGURES
    ]
    errors: Sequence[dict[str, Any]] = [
        {"name": figure.name, "label": figure.label, "scenes": []} for figure in ERROR_FIGURES
    ]
    return [*snapshots, *errors]


def caption_part(scene: Scene) -> str:
    """Return the scene's wave, constants and parameters as LaTeX, and the time it starts from."""
    given = [("K_2", scene.K2), ("K_4", scene.K4), (r"\epsilon", scene.eps), ("t_0", scene.t0)]
    named = {"alpha": r"\alpha"}
    parameters = [(named.get(name, name), value) for name, value in scene.parameters]
    values = ", ".join(
        f"${name}={value if isinstance(value, str) else f'{value:g}'}$"
        for name, value in [*parameters, *given]
    )
    return f"{escape(closed_form(scene.wave).title)} ({values})"


def package_version() -> str:
    """Return the version of the installed distribution."""
    return version("longwave")
