"""What the report prints of the library of published solutions: verdicts, conditions, misprints."""

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby
from statistics import median

from longwave.reports.latex import block, escape, table
from longwave.reports.studies.proofs import PublishedVerdict
from longwave.verify.problem_file import ProblemText
from longwave.verify.verdict import Outcome

NO_TEXT = r"$^*$"
"""Behind a source of which no text was at hand."""


def library_counts(found: Sequence[PublishedVerdict]) -> str:
    """How many statements are right and wrong, how many verdicts are as expected, the seconds."""
    counts = Counter((verdict.text.expect, verdict.outcome) for verdict in found)
    seconds = [verdict.seconds for verdict in found]
    outcomes = (Outcome.PROVED, Outcome.REFUTED, Outcome.UNDECIDED)
    rows = [
        [kind, *(str(counts[expect, outcome]) for outcome in outcomes)]
        for kind, expect in (("right", Outcome.PROVED), ("wrong", Outcome.REFUTED))
    ]
    last = f"median {median(seconds):.3f} s, slowest {max(seconds):.1f} s" if seconds else ""
    head = ["statements", *(outcome.value for outcome in outcomes)]
    return f"{block('lrrr', head, rows)}\n{last}"


def library_table(found: Iterable[PublishedVerdict]) -> str:
    """The right statements by equation: verdict, domains, refuted wrong variants, source."""
    verdicts = list(found)
    refuted = Counter(v.text.variant_of for v in verdicts if v.outcome is Outcome.REFUTED)
    wrong = Counter(v.text.variant_of for v in verdicts if v.text.expect == Outcome.REFUTED)
    rows = []
    right = [verdict for verdict in verdicts if verdict.text.expect == Outcome.PROVED]
    for equation, group in groupby(right, lambda verdict: verdict.text.equation_name):
        heading = rf"\multicolumn{{5}}{{l}}{{\textbf{{{escape(equation)}}}}} \\* "
        for verdict in group:
            text = verdict.text
            source = escape(text.source) + ("" if text.looked_up else NO_TEXT)
            domains = escape("; ".join(filter(None, (text.parameters, text.domain))))
            counts = f"{refuted[text.name]}/{wrong[text.name]}"
            outcome = escape(verdict.outcome.value)
            rows.append([f"{heading}{_name(text)}", outcome, domains, counts, source])
            heading = ""
    head = ["statement", "verdict", "parameters; domain", "wrong", "source"]
    return table("L{42mm}lL{32mm}rL{48mm}", head, rows)


def found_misprints(found: Iterable[PublishedVerdict]) -> str:
    """The formulas that were found wrong in print: name, verdict, publication, what is wrong."""
    rows = [
        [
            _name(verdict.text),
            escape(verdict.outcome.value),
            escape(verdict.text.misprint_in),
            escape(verdict.text.note),
        ]
        for verdict in found
        if verdict.text.misprint_in
    ]
    head = ["statement", "verdict", "publication", "what is wrong"]
    return table("L{32mm}lL{46mm}L{50mm}", head, rows)


def library_conditions(found: Iterable[PublishedVerdict]) -> str:
    """What is to be known of right statements: name and note."""
    rows = [
        [_name(verdict.text), escape(verdict.text.note)]
        for verdict in found
        if verdict.text.expect == Outcome.PROVED and verdict.text.note
    ]
    return table("L{52mm}L{100mm}", ["statement", "to be known"], rows)


def _name(text: ProblemText) -> str:
    words = escape(text.name).replace(r"\_", r"\_\allowbreak{}")
    return rf"\texttt{{{words}}}"
