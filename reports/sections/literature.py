"""Tables of the library of published solutions: a summary, and every formula."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby
from statistics import median

from longwave.reports.formulas.typed import prose_latex
from longwave.reports.latex import Row, escape, scientific, table
from longwave.reports.studies.proofs import PublishedVerdict
from longwave.verify.problem_file import ProblemText
from longwave.verify.verdict import Outcome

NO_TEXT = r"$^*$"
"""LaTeX mark after a source whose text was not available when it was cited."""


def library_counts(verdicts: Sequence[PublishedVerdict]) -> str:
    """Return the table of verdicts on right and wrong statements, and the seconds of a decision."""
    rows = []
    for kind, expect in (("right", Outcome.PROVED), ("wrong", Outcome.REFUTED)):
        of_kind = [verdict for verdict in verdicts if verdict.text.expect == expect]
        counts = Counter(verdict.outcome for verdict in of_kind)
        outcomes = (Outcome.PROVED, Outcome.REFUTED, Outcome.UNDECIDED)
        if of_kind:
            seconds = [verdict.seconds for verdict in of_kind]
            times = scientific(median(seconds)), scientific(max(seconds))
            rows.append([kind, *(str(counts[outcome]) for outcome in outcomes), *times])
    head = ["formulas", "proved", "refuted", "undecided", "median (s)", "slowest (s)"]
    caption = "Verdicts on the published solutions and on their wrong variants."
    return table("library", caption, "lrrrrr", head, rows)


def library_equations(verdicts: Iterable[PublishedVerdict]) -> str:
    """Return the table of equations in the library with their proved and refuted formulas."""
    counts = Counter((v.text.equation_name, v.outcome) for v in verdicts)
    outcomes = (Outcome.PROVED, Outcome.REFUTED)
    names = dict.fromkeys(name for name, _ in counts)
    cells = [[escape(name), *(str(counts[name, o]) for o in outcomes)] for name in names]
    half = -(-len(cells) // 2)
    cells += [[""] * 3] * (2 * half - len(cells))
    rows = [[*left, *right] for left, right in zip(cells[:half], cells[half:], strict=True)]
    head = ["equation", "proved", "refuted"] * 2
    caption = "Equations of the library with their right and wrong formulas."
    return table("equations", caption, "L{54mm}rrL{54mm}rr", head, rows)


def found_misprints(verdicts: Iterable[PublishedVerdict]) -> str:
    """Return the table of misprints: place, formula as printed, verdict and what is wrong."""
    rows: list[Row] = []
    for verdict in verdicts:
        text = verdict.text
        if text.misprint_in:
            rows.append(rf"\textbf{{{escape(text.equation_name)}}}: {escape(text.misprint_in)}")
            rows.append(
                [_mathematics(verdict.formulas), verdict.outcome.lower(), prose_latex(text.note)]
            )
    head = ["formula as printed", "verdict", "what is wrong"]
    caption = (
        "Misprints found: formulas that stand in publications and do not solve their equation."
    )
    return table("found_misprints", caption, "L{88mm}lL{54mm}", head, rows)


def library_conditions(verdicts: Iterable[PublishedVerdict]) -> str:
    """Return the table of conditions noted for right formulas: equation, solution and note."""
    rows = [
        [escape(verdict.text.equation_name), _title(verdict.text), prose_latex(verdict.text.note)]
        for verdict in verdicts
        if verdict.text.expect == Outcome.PROVED and verdict.text.note
    ]
    head = ["equation", "solution", "condition"]
    caption = "Conditions of right formulas beside those in the appendix."
    return table("conditions", caption, "L{40mm}L{38mm}L{72mm}", head, rows)


def library_formulas(verdicts: Sequence[PublishedVerdict]) -> str:
    """Return the LaTeX of all right formulas by equation, with source, verdict, wrong variants."""
    variants: dict[str, list[PublishedVerdict]] = {}
    for verdict in verdicts:
        if verdict.text.variant_of:
            variants.setdefault(verdict.text.variant_of, []).append(verdict)
    right = [verdict for verdict in verdicts if verdict.text.expect == Outcome.PROVED]
    parts = []
    for equation, group in groupby(right, lambda verdict: verdict.text.equation_name):
        current: tuple[str, ...] = ()
        parts.append(rf"\libraryequation{{{escape(equation)}}}")
        for verdict in group:
            if verdict.equations != current:
                current = verdict.equations
                parts.append(rf"\libraryline{{{_mathematics(current)}}}")
            parts.append(_entry(verdict, variants.get(verdict.text.name, [])))
    return "\n".join(parts)


def _entry(verdict: PublishedVerdict, wrong: Sequence[PublishedVerdict]) -> str:
    """Return the LaTeX of a formula with source, domain, verdict and its variants in ``wrong``."""
    text = verdict.text
    publication, semicolon, remark = text.source.partition(";")
    source = escape(publication) + semicolon + prose_latex(remark)
    source += "" if text.looked_up else NO_TEXT
    domain = ", ".join(f"${condition}$" for condition in verdict.conditions)
    formulas = _mathematics(verdict.formulas) + (rf"\quad ({domain})" if domain else "")
    lines = [
        rf"\libraryentry{{{_title(text)}}}{{{verdict.outcome.lower()}}}{{{source}}}",
        rf"\libraryline{{{formulas}}}",
    ]
    if notes := [_variant(variant) for variant in wrong]:
        lines.append(rf"\librarynote{{{'; '.join(notes)}}}")
    return "\n".join(lines)


def _variant(verdict: PublishedVerdict) -> str:
    """Return the note on a wrong variant of a formula, with its verdict unless "refuted"."""
    note = prose_latex(verdict.text.note or verdict.text.name.replace("_", " "))
    printed = r" \textbf{(in print)}" if verdict.text.misprint_in else ""
    outcome = verdict.outcome.lower()
    return note + printed + ("" if outcome == "refuted" else rf" \textbf{{({outcome})}}")


def _mathematics(formulas: Iterable[str]) -> str:
    return ", ".join(rf"$\displaystyle {formula}$" for formula in formulas)


def _title(text: ProblemText) -> str:
    """Return a statement's name without the words and abbreviations that name its equation.

    >>> from longwave.verify.published import chosen
    >>> [_title(text) for text in chosen(["kdv_cnoidal_wave", "burgers_shock"])]
    ['shock', 'cnoidal wave']
    """
    words = re.findall(r"[a-z]+", text.equation_name.lower())
    known = {*words, "".join(word[0] for word in words), "nls"}
    remaining = [word for word in text.name.split("_") if word not in known]
    return escape(" ".join(remaining or text.name.split("_")))
