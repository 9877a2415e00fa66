"""What the report prints of other lattices: their equations, envelopes and closed forms."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy as sp

from longwave.derive import LATTICES, Reduction, envelope
from longwave.derive.normal_form import NORMAL_EQUATIONS
from longwave.derive.output.notation import latex_of, terms
from longwave.derive.symbols import k
from longwave.reports.latex import domain_latex, escape, scientific, table, title_latex
from longwave.reports.studies.lattice_models import (
    ENVELOPES,
    LatticeModel,
    closed_waves,
    lattice_models,
)
from longwave.solutions import CATALOGUE, closed_form
from longwave.support.processes import Job, Key

if TYPE_CHECKING:
    from longwave.reports.studies.evaluation_accuracy import Accuracy
    from longwave.reports.studies.proofs import ProofRecord
    from longwave.verify.verdict import Verdict

PAPERS = "mKdV"
"""The equation whose waves have sections of their own."""


@dataclass(frozen=True)
class ModelRow:
    """One long wave of a lattice, in LaTeX; ``model`` is the lattice in words.

    ``size`` is the power of eps of the strain, ``waves`` are the names of closed forms.
    """

    model: str
    kind: str
    size: int
    equation: str
    speed: str
    needs: str
    waves: tuple[str, ...]


@dataclass(frozen=True)
class EnvelopeRow:
    """The envelope equation of a lattice's carriers: wavenumber and coefficients, in LaTeX."""

    model: str
    wavenumber: str
    coefficients: tuple[str, ...]


def model_jobs() -> dict[Key, Job]:
    """The derivations of the tables, a job a lattice."""
    models: dict[Key, Job] = {
        ("model", place): Job(model_rows, (place,), 0.3) for place, _ in enumerate(lattice_models())
    }
    envelopes: dict[Key, Job] = {
        ("envelope", place): Job(envelope_row, (place,), 0.3) for place, _ in enumerate(ENVELOPES)
    }
    return models | envelopes


def model_rows(place: int) -> list[ModelRow]:
    """The rows of one of `lattice_models`."""
    model = list(lattice_models())[place]
    return [_model_row(model, reduction) for reduction in model.reductions()]


def _model_row(model: LatticeModel, reduction: Reduction) -> ModelRow:
    lattice, scaling = reduction.lattice, reduction.scaling
    title = f"{lattice.title}, {model.case}" if model.case else lattice.title
    used = reduction.pde.latex() + latex_of(reduction.speed_squared)
    equal = [
        *((sp.Symbol(name), value) for name, value in model.values),
        *(pair for pair in lattice.definitions if latex_of(pair[0]) in used),
    ]
    remarks = ", ".join(f"${latex_of(left)} = {latex_of(right)}$" for left, right in equal)
    return ModelRow(
        title_latex(title) + (f": {remarks}" if remarks else ""),
        reduction.pde.kind.replace(" or generalised ", " or "),
        scaling.amplitude + (scaling.space[0].exponent if reduction.is_displacement else 0),
        _equation_latex(reduction),
        latex_of(reduction.speed_squared),
        ", ".join(f"${condition.latex()}$" for condition in reduction.conditions),
        closed_waves(reduction),
    )


def _equation_latex(reduction: Reduction) -> str:
    """The reduced equation with each coefficient as short as it can be written."""
    masses = {symbol for mass in reduction.lattice.masses for symbol in mass.free_symbols}
    text = reduction.pde.latex()
    for part in (reduction.pde.polynomial, reduction.pde.transverse):
        for term in terms(part):
            text = text.replace(latex_of(term.size), shortest(term.size, masses))
    return text


def shortest(value: sp.Expr, symbols: Iterable[sp.Symbol]) -> str:
    """The LaTeX of a factored value, its factors collected by the symbols if that is shorter.

    >>> a, b, m = sp.symbols("a b m")
    >>> shortest(sp.expand(m**2 * (a + b) ** 3 + a * m), [m])
    'a m + m^{2} \\\\left(a + b\\\\right)^{3}'
    """
    chosen = sorted(symbols, key=str)
    collected = value.replace(
        lambda part: part.is_Add, lambda part: sp.collect(sp.expand(part), chosen, sp.factor)
    )
    return min(latex_of(value), latex_of(collected), key=len)


def model_table(rows: Iterable[ModelRow]) -> str:
    """Each lattice once, in words across the table, with its long waves below."""
    lines, last = [], ""
    for found in rows:
        if found.model != last:
            lines.append([rf"\multicolumn{{4}}{{L{{160mm}}}}{{\rule{{0pt}}{{3ex}}{found.model}}}"])
            last = found.model
        size = rf"$\epsilon^{{{found.size}}}$" if found.size > 1 else r"$\epsilon$"
        speed = rf"\newline\rule{{0pt}}{{2.7ex}}$c^{{2}} = {found.speed}$"
        needs = f"; needs {found.needs}" if found.needs else ""
        lines.append(
            [
                rf"\nopagebreak\rule{{0pt}}{{2.7ex}}{escape(found.kind)}",
                size,
                f"${found.equation}${speed}{needs}",
                wave_names(found.waves),
            ]
        )
    head = ["kind", "size", "equation, speed, condition", "closed waves"]
    return table("L{19mm}lL{101mm}L{25mm}", head, lines)


def wave_names(names: Sequence[str]) -> str:
    """The waves without the name of their equation; those of the paper's by their number.

    >>> wave_names(["kp_line_soliton", "kp_lump"]), wave_names([])
    ('line soliton, lump', 'none')
    """
    if not names:
        return "none"
    equation = CATALOGUE.equation(names[0])
    if equation == PAPERS:
        return rf"the {len(names)} of section~\ref{{sec:solutions}}"
    prefix = equation.lower().replace(" ", "_")
    words = [name.removeprefix(f"{prefix}_").replace("_", " ") for name in names]
    return escape(", ".join(words))


COEFFICIENTS = ("v", "p", "q")
"""What a row of envelopes shows."""


def envelope_row(place: int) -> EnvelopeRow:
    """The row of one of `ENVELOPES`, with s and C for sine and cosine of k/2."""
    name, wavenumber = ENVELOPES[place]
    found = envelope(LATTICES[name], k=wavenumber)
    short = {sp.sin(k / 2): sp.Symbol("s"), sp.cos(k / 2): sp.Symbol("C")}
    return EnvelopeRow(
        title_latex(found.lattice.title),
        "$k$" if wavenumber is None else f"${latex_of(wavenumber)}$",
        tuple(latex_of(found.expressions[part].subs(short)) for part in COEFFICIENTS),
    )


def envelope_table(rows: Iterable[EnvelopeRow]) -> str:
    """Lattice, wavenumber, group velocity, p and q."""
    lines = [
        [
            found.model,
            found.wavenumber,
            *(rf"$\displaystyle {text}$" for text in found.coefficients),
        ]
        for found in rows
    ]
    head = ["lattice", "at", *(f"${name}$" for name in COEFFICIENTS)]
    return table("L{44mm}llll", head, lines, gap="0.8ex")


FURTHER_FORMS = tuple(name for name in CATALOGUE.names if CATALOGUE.equation(name) != PAPERS)
"""The closed forms of other equations than the paper's."""


def normal_equations() -> list[tuple[str, str]]:
    """Names and LaTeX of the normal forms that they solve, in their order."""
    names = dict.fromkeys(map(CATALOGUE.equation, FURTHER_FORMS))
    return [(name, NORMAL_EQUATIONS[name].latex) for name in names]


def form_table(
    proofs: Iterable[ProofRecord], residuals: Mapping[str, Verdict], accuracy: Iterable[Accuracy]
) -> str:
    """The further closed forms: equation, domains, verdict, residual and worst error."""
    proved = {record.name: record for record in proofs}
    worst = {found.name: max(found.errors) for found in accuracy}
    rows = []
    for form in map(closed_form, FURTHER_FORMS):
        record, residual = proved.get(form.name), residuals.get(form.name)
        rows.append(
            [
                escape(form.equation.name),
                escape(form.title),
                ", ".join(domain_latex(parameter.domain) for parameter in form.parameters) or "--",
                "--" if record is None else escape(record.outcome.value),
                _number(residual.residual if residual else None),
                _number(worst.get(form.name)),
            ]
        )
    head = ["equation", "solution", "parameters", "verdict", "residual", "worst error"]
    return table("L{25mm}L{38mm}L{36mm}lll", head, rows)


def _number(value: float | None) -> str:
    return "--" if value is None else scientific(value)
