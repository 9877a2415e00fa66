"""What the report prints of the library of published solutions: a summary, and every formula."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby
from statistics import median

from longwave.reports.formulas.typed import conditions_latex, prose_latex
from longwave.reports.latex import Row, escape, scientific, table
from longwave.reports.studies.proofs import PublishedVerdict
from longwave.verify.problem_file import ProblemText
from longwave.verify.verdict import Outcome

NO_TEXT = r"$^*$"
"""Behind a source of which no text was at hand."""


def library_counts(found: Sequence[PublishedVerdict]) -> str:
    """How many right and wrong statements have each verdict, and the seconds of a decision."""
    rows = []
    for kind, expect in (("right", Outcome.PROVED), ("wrong", Outcome.REFUTED)):
        mine = [verdict for verdict in found if verdict.text.expect == expect]
        counts = Counter(verdict.outcome for verdict in mine)
        outcomes = (Outcome.PROVED, Outcome.REFUTED, Outcome.UNDECIDED)
        if mine:
            seconds = [verdict.seconds for verdict in mine]
            times = [scientific(median(seconds)), scientific(max(seconds))]
            rows.append([kind, *(str(counts[outcome]) for outcome in outcomes), *times])
    head = ["formulas", "proved", "refuted", "undecided", "median (s)", "slowest (s)"]
    caption = "Verdicts on the published solutions and on their wrong variants."
    return table("library", caption, "lrrrrr", head, rows)


def library_equations(found: Iterable[PublishedVerdict]) -> str:
    """The equations of the library, each with how many of its formulas are proved and refuted."""
    counts = Counter((v.text.equation_name, v.outcome) for v in found)
    names = list(dict.fromkeys(name for name, _ in counts))
    cells = [
        [escape(name), *(str(counts[name, o]) for o in (Outcome.PROVED, Outcome.REFUTED))]
        for name in names
    ]
    half = -(-len(cells) // 2)
    cells += [[""] * 3] * (2 * half - len(cells))
    rows = [[*left, *right] for left, right in zip(cells[:half], cells[half:], strict=True)]
    head = ["equation", "proved", "refuted"] * 2
    caption = "Equations of the library with their right and wrong formulas."
    return table("equations", caption, "L{54mm}rrL{54mm}rr", head, rows)


def found_misprints(found: Iterable[PublishedVerdict]) -> str:
    """The formulas that were found wrong in print: where, as printed, verdict, what is wrong."""
    rows: list[Row] = []
    for verdict in found:
        text = verdict.text
        if text.misprint_in:
            rows.append(rf"\textbf{{{escape(text.equation_name)}}}: {escape(text.misprint_in)}")
            rows.append([_formulas(verdict), verdict.outcome.lower(), prose_latex(text.note)])
    head = ["formula as printed", "verdict", "what is wrong"]
    caption = (
        "Misprints found: formulas that stand in publications and do not solve their equation."
    )
    return table("found_misprints", caption, "L{88mm}lL{54mm}", head, rows)


def library_conditions(found: Iterable[PublishedVerdict]) -> str:
    """The remarks on right formulas: equation, name and note."""
    rows = [
        [escape(verdict.text.equation_name), _title(verdict.text), prose_latex(verdict.text.note)]
        for verdict in found
        if verdict.text.expect == Outcome.PROVED and verdict.text.note
    ]
    head = ["equation", "solution", "condition"]
    caption = "Conditions of right formulas beside those in the appendix."
    return table("conditions", caption, "L{40mm}L{38mm}L{72mm}", head, rows)


def library_formulas(found: Sequence[PublishedVerdict]) -> str:
    """Every right formula by equation: title, source, formula, domain, verdict, wrong variants."""
    variants: dict[str, list[PublishedVerdict]] = {}
    for verdict in found:
        if verdict.text.variant_of:
            variants.setdefault(verdict.text.variant_of, []).append(verdict)
    right = [verdict for verdict in found if verdict.text.expect == Outcome.PROVED]
    parts = []
    for equation, group in groupby(right, lambda verdict: verdict.text.equation_name):
        shown: tuple[str, ...] = ()
        parts.append(rf"\libraryequation{{{escape(equation)}}}")
        for verdict in group:
            if verdict.equations != shown:
                shown = verdict.equations
                parts.append(rf"\libraryline{{{_mathematics(shown)}}}")
            parts.append(_entry(verdict, variants.get(verdict.text.name, [])))
    return "\n".join(parts)


def _entry(verdict: PublishedVerdict, wrong: Sequence[PublishedVerdict]) -> str:
    """One formula with what is to be said of it."""
    text = verdict.text
    publication, semicolon, remark = text.source.partition(";")
    source = escape(publication) + semicolon + prose_latex(remark)
    source += "" if text.looked_up else NO_TEXT
    domain = conditions_latex(text.parameters, text.domain)
    formulas = _formulas(verdict) + (rf"\quad ({domain})" if domain else "")
    lines = [
        rf"\libraryentry{{{_title(text)}}}{{{verdict.outcome.lower()}}}{{{source}}}",
        rf"\libraryline{{{formulas}}}",
    ]
    if notes := [_variant(variant) for variant in wrong]:
        lines.append(rf"\librarynote{{{'; '.join(notes)}}}")
    return "\n".join(lines)


def _variant(verdict: PublishedVerdict) -> str:
    """A wrong variant by its note; the verdict is said where it is not that it is refuted."""
    note = prose_latex(verdict.text.note or verdict.text.name.replace("_", " "))
    printed = r" \textbf{(in print)}" if verdict.text.misprint_in else ""
    other = (
        "" if verdict.outcome is Outcome.REFUTED else rf" \textbf{{({verdict.outcome.lower()})}}"
    )
    return note + printed + other


def _formulas(verdict: PublishedVerdict) -> str:
    return _mathematics(verdict.formulas)


def _mathematics(formulas: Iterable[str]) -> str:
    return ", ".join(rf"$\displaystyle {formula}$" for formula in formulas)


def _title(text: ProblemText) -> str:
    """A statement's name without the words and the initials of its equation.

    >>> from longwave.verify.published import chosen
    >>> [_title(text) for text in chosen(["kdv_cnoidal_wave", "burgers_shock"])]
    ['shock', 'cnoidal wave']
    """
    words = re.findall(r"[a-z]+", text.equation_name.lower())
    known = {*words, "".join(word[0] for word in words), "nls"}
    kept = [word for word in text.name.split("_") if word not in known]
    return escape(" ".join(kept or text.name.split("_")))
