"""Tables and formulas of the derivation, closed forms, proofs and misprints."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import sympy as sp

from longwave.derive import dispersion_relation, initial_velocity_latex, mkdv_reduction, reduce
from longwave.derive.algebra.formula_printing import latex_of
from longwave.derive.dispersion import agrees_with_reduction
from longwave.reports.formulas.formula import Formula
from longwave.reports.formulas.printing import equation_latex, latex
from longwave.reports.latex import DASH, domain_latex, escape, greek, scientific, table
from longwave.reports.paper import cited
from longwave.reports.studies.proofs import ProofRecord
from longwave.solutions import CATALOGUE, ClosedForm, closed_form
from longwave.solutions.equation import Equation
from longwave.verify.evidence.mutations import MutationCount, Survivor
from longwave.verify.verdict import Verdict

PAPER_FORMS = CATALOGUE.of("mKdV")
"""The closed forms of the paper's equation."""

DERIVATION_ORDERS = 7
"""Highest power of eps to which the derivation is shown, two above that of the mKdV equation."""


def derivation() -> dict[str, Any]:
    """Return the template's data on the reduction: orders, coefficients, dispersion, velocity."""
    reduction = reduce(mkdv_reduction().lattice, mkdv_reduction().scaling, orders=DERIVATION_ORDERS)
    relation = dispersion_relation(reduction.lattice)
    coefficients, form = reduction.coefficients(), reduction.normal_form()
    return {
        "force": latex_of(reduction.lattice.bonds[0].force),
        "orders": [(order, equation.latex()) for order, equation in reduction.orders.items()],
        "sound": latex_of(reduction.sound_condition),
        "conditions": [
            (condition.latex(), condition.order, condition.equation.latex())
            for condition in reduction.conditions
        ],
        "pde": reduction.pde.latex(),
        "remainders": [reduction.latex_remainder(order) for order in reduction.remainders],
        "corrections": [reduction.latex_correction(power) for power in reduction.corrections],
        "coefficient_table": coefficient_table(
            (name, latex_of(getattr(coefficients, name))) for name in COEFFICIENT_WORDS
        ),
        "normal_form": [(name, latex_of(getattr(form, name))) for name in ("a", "b", "s")],
        "dispersion": relation.latex(),
        "dispersion_agrees": agrees_with_reduction(reduction.lattice, reduction),
        "velocity": initial_velocity_latex(),
    }


def solution_table(forms: Iterable[ClosedForm] = PAPER_FORMS) -> str:
    """Return the table of closed forms: sign, domains, background, paper's equation and source."""
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
    caption = "The closed forms of the mKdV equation and where they come from."
    return table("solutions", caption, "lrlll", head, rows)


def coefficient_table(coefficients: Iterable[tuple[str, str]]) -> str:
    """Return the table of the reduced equation's coefficients from (name, LaTeX) pairs."""
    rows = [[COEFFICIENT_WORDS[name], f"${value}$"] for name, value in coefficients]
    caption = "Coefficients of the reduced equation, in units of the springs and masses."
    return table("coefficients", caption, "ll", ["coefficient", "value"], rows, gap="1ex")


def formulas(forms: Iterable[ClosedForm] = PAPER_FORMS) -> list[dict[str, str]]:
    """Return every closed form's display, far fields and citation as template data."""
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


def equations(forms: Iterable[ClosedForm] = PAPER_FORMS) -> list[tuple[str, str]]:
    """Return name and LaTeX of each equation that the forms solve, without duplicates."""
    return sorted({(form.equation.name, _equation(form.equation)) for form in forms})


def _equation(equation: Equation) -> str:
    unknown = sp.Function("U")(equation.xi, equation.tau)
    return equation_latex(equation.residual(unknown), unknown, equation.tau)


COEFFICIENT_WORDS = {
    "c": "sound speed $c$",
    "nonlinear": "coefficient of $Y^2Y_X$",
    "dispersive": "coefficient of $Y_{XXX}$",
}
"""Name of a coefficient of the reduction -> its printed name."""

METHODS = {"differential algebra": "A", "exact at more points than the degree": "P"}
"""Method of proof -> its letter in the proof table; the text above the table explains it."""

_OUTERMOST = re.compile(r"\((?:[^()]|\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\))*\)")
"""Pattern of a bracket with up to three levels of nested brackets."""

MAX_PART_CHARACTERS = 20
"""Number of characters up to which a misprinted part of a formula is printed in full."""


def proof_table(records: Iterable[ProofRecord], residuals: Mapping[str, Verdict]) -> str:
    """Return the table of proofs: verdict, method, certificate, times and numerical residual.

    The residual is computed by mpmath, independently of the proof; a dash if there is none.
    """
    rows = [
        [
            form_title(record.name),
            record.outcome.value.lower(),
            METHODS.get(record.method, escape(record.method)),
            DASH if (size := record.certificate_bytes) is None else f"{size / 1000:.1f}",
            f"{record.prove_seconds:.2f}",
            DASH if record.check_seconds is None else f"{record.check_seconds:.2f}",
            {None: DASH, True: "accepted", False: "REJECTED"}[record.accepted],
            _residual(residuals.get(record.name)),
        ]
        for record in records
    ]
    head = [
        *("solution", "verdict", "method", "size (kB)"),
        *("proof (s)", "check (s)", "checker", "residual"),
    ]
    caption = (
        "Proofs: size of the certificate, time of the proof and of the check by the separate "
        "checker, and the relative residual in mpmath at 100 digits."
    )
    return table("proofs", caption, "L{48mm}llrrrll", head, rows)


def form_title(name: str) -> str:
    """Return the title of the closed form of that name, in LaTeX."""
    return escape(closed_form(name).title)


def mutation_table(counts: Iterable[MutationCount]) -> str:
    """Return the table of misprints: refuted, proved and undecided counts by form, and the time."""
    rows, totals = [], np.zeros(5)
    for count in counts:
        numbers = (count.mutants, count.refuted, count.proved, count.undecided)
        rows.append([form_title(count.name), *map(str, numbers), f"{count.seconds:.1f}"])
        totals += (*numbers, count.seconds)
    rows.append(["all solutions", *(f"{total:.0f}" for total in totals[:4]), f"{totals[4]:.1f}"])
    head = ["solution", "misprints", "refuted", "proved", "undecided", "time (s)"]
    caption = "Misprinted formulas by the verdict on them."
    return table("misprints", caption, "lrrrrr", head, rows)


def survivor_table(counts: Iterable[MutationCount]) -> str:
    """Return the table of misprints not refuted, equal changes with equal reasons in one row."""
    changes_by_part: dict[tuple[str, str, str, str], list[str]] = {}
    for count in counts:
        for survivor in count.survivors:
            part, change = _part_and_change(survivor.description)
            key = (count.name, part, _reason(survivor), survivor.outcome.value)
            changes_by_part.setdefault(key, []).append(change)
    merged: dict[tuple[str, str, str], list[tuple[str, str]]] = {}
    for (name, part, reason, verdict), changes in changes_by_part.items():
        merged.setdefault((", ".join(changes), reason, verdict), []).append((name, part))
    rows = []
    for (change, reason, verdict), misprints in merged.items():
        parts = ", ".join(dict.fromkeys(part for _, part in misprints))
        titles = ", ".join(dict.fromkeys(form_title(name) for name, _ in misprints))
        rows.append([parts, change, reason, verdict.lower(), titles])
    head = ["part", "change", "reason", "verdict", "solutions"]
    caption = "Misprints that are not refuted, and the reason: these solve the equation as well."
    return table("survivors", caption, "L{35mm}L{22mm}L{25mm}L{16mm}L{46mm}", head, rows)


def _part_and_change(description: str) -> tuple[str, str]:
    """Split the description of a misprint into the changed part and the change, in LaTeX.

    Deeply nested brackets in the part are printed as dots.
    """
    words, _, change = description.rpartition(": ")
    text = words.partition(" ")[2]
    change = escape(change.replace("coefficient times 101/100", "1 % more"))
    if "..." not in text and len(text) <= MAX_PART_CHARACTERS:
        return f"${_mathematics(text)}$", change
    outer = _OUTERMOST.sub(r"(\\cdots)", text)
    if "/" in outer:
        return "the fraction", change
    return f"${_mathematics(outer)}$", change


def _mathematics(text: str) -> str:
    r"""Return the LaTeX of a short part of a formula, which is given as SymPy prints it.

    >>> _mathematics("-6*tau + xi"), _mathematics("k*jacobi_sn(\\cdots)")
    ('-6 \\tau + \\xi', 'k \\mathrm{sn}(\\cdots)')
    """
    text = text.replace("sqrt(\\cdots)", "\\sqrt{\\cdots}").replace("jacobi_", "")
    text = re.sub(r"(?<!\\)\b([a-z]{2,})\(", r"\\mathrm{\1}(", greek(text))
    return text.replace("**", "^").replace("*", " ")


def _reason(survivor: Survivor) -> str:
    """Return the reason why a misprinted form is still a solution, with symbols in LaTeX."""
    signs = survivor.reason.replace("U to -U", "$U\\to-U$")
    return re.sub(r"another value of (\w+)", r"another value of $\1$", signs)


def _residual(verdict: Verdict | None) -> str:
    return DASH if verdict is None or verdict.residual is None else scientific(verdict.residual)
