"""Tables of other lattices: equations, envelopes and closed forms."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from operator import itemgetter

import sympy as sp

from longwave.derive import LATTICES, Reduction, envelope
from longwave.derive.algebra.formula_printing import latex_of
from longwave.derive.normal_form import NORMAL_EQUATIONS
from longwave.derive.output.notation import terms
from longwave.derive.symbols import k
from longwave.reports.latex import DASH, Row, domain_latex, escape, scientific, table, title_latex
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

PAPER_EQUATION = "mKdV"
"""Name of the paper's equation, whose closed forms have sections of their own."""


def model_jobs() -> dict[Key, Job]:
    """Return the jobs that derive the rows of the tables, one for each lattice."""
    models, envelopes = range(len(list(lattice_models()))), range(len(ENVELOPES))
    jobs: dict[Key, Job] = {("model", index): Job(model_rows, (index,), 0.3) for index in models}
    return jobs | {("envelope", index): Job(envelope_row, (index,), 0.3) for index in envelopes}


def model_rows(index: int) -> list[tuple[str, list[str]]]:
    """Return the rows (lattice in words, LaTeX cells) of `lattice_models` number ``index``."""
    model = list(lattice_models())[index]
    return [(_model(model, reduction), _cells(reduction)) for reduction in model.reductions()]


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
    """Return a row's cells: kind, power of eps, equation, speed, conditions, closed forms."""
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
    """Return the LaTeX of the reduced equation, each coefficient in its shortest form."""
    masses = {symbol for mass in reduction.lattice.masses for symbol in mass.free_symbols}
    text = reduction.pde.latex()
    for part in (reduction.pde.polynomial, reduction.pde.transverse):
        for term in terms(part):
            text = text.replace(latex_of(term.size), shortest(term.size, masses))
    return text


def shortest(value: sp.Expr, symbols: Iterable[sp.Symbol]) -> str:
    """Return a value's LaTeX, with its sums collected in powers of the symbols if that is shorter.

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
    """Return the table of long waves, each lattice once as a heading across the columns."""
    lines: list[Row] = []
    for model, group in groupby(rows, itemgetter(0)):
        lines.append(model)
        lines += [cells for _, cells in group]
    head = ["kind", "size", "equation, speed, condition", "closed waves"]
    caption = "Long waves of other lattices: equation, speed of sound and the condition it needs."
    return table("models", caption, "L{19mm}lL{101mm}L{25mm}", head, lines)


def wave_names(names: Sequence[str]) -> str:
    """Return the names of waves without their equation's name; mKdV waves only as a count.

    >>> wave_names(["kp_line_soliton", "kp_lump"]), wave_names([])
    ('line soliton, lump', 'none')
    """
    if not names:
        return "none"
    equation = CATALOGUE.equation(names[0])
    if equation == PAPER_EQUATION:
        return rf"the {len(names)} of section~\ref{{sec:solutions}}"
    prefix = equation.lower().replace(" ", "_")
    words = [name.removeprefix(f"{prefix}_").replace("_", " ") for name in names]
    return escape(", ".join(words))


COEFFICIENTS = ("v", "p", "q")
"""Columns for each envelope: group velocity v and the NLS coefficients p and q."""


def envelope_row(index: int) -> list[str]:
    """Return one of `ENVELOPES` as a row in LaTeX; s and C are the sine and cosine of k/2."""
    name, wavenumber = ENVELOPES[index]
    result = envelope(LATTICES[name], k=wavenumber)
    short = {sp.sin(k / 2): sp.Symbol("s"), sp.cos(k / 2): sp.Symbol("C")}
    parts = (latex_of(result.expressions[part].subs(short)) for part in COEFFICIENTS)
    return [
        title_latex(result.lattice.title),
        "$k$" if wavenumber is None else f"${latex_of(wavenumber)}$",
        *(rf"$\displaystyle {text}$" for text in parts),
    ]


def envelope_table(rows: Iterable[list[str]]) -> str:
    """Return the table of envelopes from its rows."""
    head = ["lattice", "at", *(f"${name}$" for name in COEFFICIENTS)]
    caption = "Envelopes: group velocity, dispersion $p$ and nonlinearity $q$."
    return table("envelopes", caption, "L{44mm}llll", head, rows, gap="0.8ex")


FURTHER_FORMS = tuple(
    name for name in CATALOGUE.names if CATALOGUE.equation(name) != PAPER_EQUATION
)
"""Names of the closed forms that solve other equations than the paper's."""


def normal_equations() -> list[tuple[str, str]]:
    """Return (name, LaTeX) of the normal forms that `FURTHER_FORMS` solve, in catalogue order."""
    names = dict.fromkeys(map(CATALOGUE.equation, FURTHER_FORMS))
    return [(name, NORMAL_EQUATIONS[name].latex) for name in names]


def form_table(
    proofs: Iterable[ProofRecord], residuals: Mapping[str, Verdict], accuracy: Iterable[Accuracy]
) -> str:
    """Return the table of further closed forms: domains, verdict, residual and worst error."""
    proved = {record.name: record for record in proofs}
    worst = {accuracy_record.name: max(accuracy_record.errors) for accuracy_record in accuracy}
    rows = []
    for form in map(closed_form, FURTHER_FORMS):
        record, residual = proved.get(form.name), residuals.get(form.name)
        domains = ", ".join(domain_latex(parameter.domain) for parameter in form.parameters)
        verdict = DASH if record is None else record.outcome.value.lower()
        numbers = residual.residual if residual else None, worst.get(form.name)
        texts = escape(form.equation.name), escape(form.title), domains or DASH, verdict
        rows.append([*texts, *(DASH if n is None else scientific(n) for n in numbers)])
    head = ["equation", "solution", "parameters", "verdict", "residual", "worst error"]
    caption = "Closed forms of other equations: verdict, residual and worst error of evaluation."
    return table("forms", caption, "L{25mm}L{38mm}L{36mm}lll", head, rows)
