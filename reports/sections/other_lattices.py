"""What the report prints of other lattices: their equations, envelopes and closed forms."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from operator import itemgetter

import sympy as sp

from longwave.derive import LATTICES, Reduction, envelope
from longwave.derive.normal_form import NORMAL_EQUATIONS
from longwave.derive.output.notation import latex_of, terms
from longwave.derive.symbols import k
from longwave.reports.latex import Row, domain_latex, escape, scientific, table, title_latex
from longwave.reports.studies.evaluation_accuracy import Accuracy
from longwave.reports.studies.lattice_models import (
    ENVELOPES,
    LatticeModel,
    closed_waves,
    lattice_models,
)
from longwave.reports.studies.proofs import ProofRecord
from longwave.solutions import CATALOGUE, closed_form
from longwave.support.processes import Job, Key
from longwave.verify.verdict import Verdict

PAPERS = "mKdV"
"""The equation whose waves have sections of their own."""


def model_jobs() -> dict[Key, Job]:
    """The derivations of the tables, a job a lattice."""
    kinds = (("model", model_rows, lattice_models()), ("envelope", envelope_row, ENVELOPES))
    return {
        (kind, place): Job(rows, (place,), 0.3)
        for kind, rows, cases in kinds
        for place, _ in enumerate(cases)
    }


def model_rows(place: int) -> list[tuple[str, list[str]]]:
    """The long waves of one of `lattice_models`: the lattice in words, and cells, all in LaTeX."""
    model = list(lattice_models())[place]
    return [(_model(model, found), _cells(found)) for found in model.reductions()]


def _model(model: LatticeModel, reduction: Reduction) -> str:
    lattice = reduction.lattice
    title = f"{lattice.title}, {model.case}" if model.case else lattice.title
    used = reduction.pde.latex() + latex_of(reduction.speed_squared)
    equal = [
        *((sp.Symbol(name), value) for name, value in model.values),
        *(pair for pair in lattice.definitions if latex_of(pair[0]) in used),
    ]
    remarks = ", ".join(f"${latex_of(left)} = {latex_of(right)}$" for left, right in equal)
    return title_latex(title) + (f": {remarks}" if remarks else "")


def _cells(reduction: Reduction) -> list[str]:
    """Kind, power of eps of the strain, equation with speed and conditions, closed forms."""
    scaling, kind = reduction.scaling, reduction.pde.kind.replace(" or generalised ", " or ")
    size = scaling.amplitude + (scaling.space[0].exponent if reduction.is_displacement else 0)
    speed = rf"\newline\rule{{0pt}}{{2.7ex}}$c^{{2}} = {latex_of(reduction.speed_squared)}$"
    needs = ", ".join(f"${condition.latex()}$" for condition in reduction.conditions)
    return [
        rf"\rule{{0pt}}{{2.7ex}}{escape(kind)}",
        rf"$\epsilon^{{{size}}}$" if size > 1 else r"$\epsilon$",
        f"${_equation_latex(reduction)}${speed}" + (f"; needs {needs}" if needs else ""),
        wave_names(closed_waves(reduction)),
    ]


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


def model_table(rows: Iterable[tuple[str, list[str]]]) -> str:
    """Each lattice once, in words across the table, with its long waves below."""
    lines: list[Row] = []
    for model, group in groupby(rows, itemgetter(0)):
        lines.append(model)
        lines += [cells for _, cells in group]
    head = ["kind", "size", "equation, speed, condition", "closed waves"]
    caption = "Long waves of other lattices: equation, speed of sound and the condition it needs."
    return table("models", caption, "L{19mm}lL{101mm}L{25mm}", head, lines)


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


def envelope_row(place: int) -> list[str]:
    """Lattice, wavenumber, group velocity, p and q of one of `ENVELOPES`, in LaTeX.

    The letters s and C are sine and cosine of k/2.
    """
    name, wavenumber = ENVELOPES[place]
    found = envelope(LATTICES[name], k=wavenumber)
    short = {sp.sin(k / 2): sp.Symbol("s"), sp.cos(k / 2): sp.Symbol("C")}
    parts = (latex_of(found.expressions[part].subs(short)) for part in COEFFICIENTS)
    return [
        title_latex(found.lattice.title),
        "$k$" if wavenumber is None else f"${latex_of(wavenumber)}$",
        *(rf"$\displaystyle {text}$" for text in parts),
    ]


def envelope_table(rows: Iterable[list[str]]) -> str:
    """The table of each `envelope_row`."""
    head = ["lattice", "at", *(f"${name}$" for name in COEFFICIENTS)]
    caption = "Envelopes: group velocity, dispersion $p$ and nonlinearity $q$."
    return table("envelopes", caption, "L{44mm}llll", head, rows, gap="0.8ex")


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
                "--" if record is None else record.outcome.value.lower(),
                _number(residual.residual if residual else None),
                _number(worst.get(form.name)),
            ]
        )
    head = ["equation", "solution", "parameters", "verdict", "residual", "worst error"]
    caption = "Closed forms of other equations: verdict, residual and worst error of evaluation."
    return table("forms", caption, "L{25mm}L{38mm}L{36mm}lll", head, rows)


def _number(value: float | None) -> str:
    return "--" if value is None else scientific(value)
