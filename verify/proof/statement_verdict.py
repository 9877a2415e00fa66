"""Decide statements (`verify.proof.statement_text`): every equation proved, or one refuted.

A statement is refuted by a point of the domain at which a ball around the residual of the typed
trees excludes 0.  It is proved by certificates of the typed texts, into which the checker
substitutes the formulas.  SymPy gives only hints.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import chain
from typing import Any

from longwave.derive.algebra.formula_latex import formula_latex, name_latex
from longwave.derive.algebra.formula_tree import Name, Number, mapped, rational
from longwave.solutions.record import LONGEST_FORMULA
from longwave.verify.kernel.function_values import generic_shift
from longwave.verify.subexpressions import abbreviated
from longwave.verify.verdict import Outcome, ProofVerdict, timed

from . import prover
from .certificate_writer import Certificate
from .seams import left_open, sides
from .statement_latex import equations_latex, formulas_latex, scope_latex, statement_latex
from .statement_problem import typed_domains, undefined
from .statement_scope import scope
from .typed_hints import NO_VERDICT, typed_certificate
from .typed_statement import Statement, StatementTrees, tree_of
from .typed_values import TypedValues, failing_values

Progress = Callable[[str], None]

ONE = Number(Fraction(1))
UNSEEN = "an equation fails at a point at which its residual could not be repeated"


@dataclass(frozen=True, repr=False)
class StatementVerdict(ProofVerdict):
    """Verdict on a statement, with the statement in LaTeX and a certificate for each equation.

    ``hint`` says what holds instead of a refuted formula; ``hint_verdict`` is the proof of it.
    """

    statement: str = ""
    hint: str = ""
    certificates: tuple[Mapping[str, Any], ...] = field(default=(), compare=False)
    hint_verdict: StatementVerdict | None = field(default=None, compare=False)

    @property
    def hint_certificates(self) -> tuple[Mapping[str, Any], ...]:
        """Certificates of the statement that the hint proposes."""
        return self.hint_verdict.certificates if self.hint_verdict else ()

    @property
    def html_rows(self) -> dict[str, str]:
        """Rows of the HTML table, with the statement (if short) and the hint."""
        is_short = len(self.statement) <= LONGEST_FORMULA
        equation = rf"$\displaystyle {self.statement}$" if is_short else self.equation
        return super().html_rows | {"equation": equation, "what would hold": self.hint}

    def json(self) -> dict[str, Any]:
        """Return the verdict as plain data."""
        return {
            "name": self.name,
            "verdict": self.outcome.value,
            "sides": self.restriction,
            "reason": self.detail,
            "witness": None if self.witness is None else dict(self.witness),
            "hint": self.hint,
            "seconds": self.seconds,
            "assumptions": list(self.assumptions),
            "singularities": list(self.singularities),
            "statement": self.statement,
            "certificates": [certificate["digest"] for certificate in self.certificates],
            "hint_certificates": [certificate["digest"] for certificate in self.hint_certificates],
        }


@timed
def decide_statement(statement: Statement, progress: Progress = lambda _: None) -> StatementVerdict:
    """Refute a statement at a point or prove its equations; report each step to ``progress``."""
    count, certificates = len(statement.equations), list[Certificate]()
    progress(f"equation 1 of {count}")
    failing = failing_values(statement)
    try:
        while failing is None and len(certificates) < count:
            if certificates:
                progress(f"equation {len(certificates) + 1} of {count}")
            certificates.append(typed_certificate(statement, len(certificates) + 1))
    except NO_VERDICT as error:
        where = f"equation {len(certificates) + 1}: " if count > 1 else ""
        reason = where + (" ".join(str(error).split()) or type(error).__name__)
        failing = failing_values(statement, thorough=True)
    else:
        if failing is None:
            divisor = undefined(statement)
            if divisor is None:
                return proved(statement, certificates)
            words = "divisors must be shown not to be 0, got"
            return undecided(statement, f"{words} {abbreviated(divisor)}")
        reason = UNSEEN
    return (refuted(statement, failing) if failing else None) or undecided(statement, reason)


def proved(statement: Statement, certificates: Sequence[Mapping[str, Any]]) -> StatementVerdict:
    """Return the verdict PROVED on a statement with accepted certificates of its texts."""
    accepted = tuple(map(Certificate, certificates))
    jumps, places = left_open(statement)
    return StatementVerdict(
        **statement_fields(statement) | {"sides": sides(jumps)},
        outcome=Outcome.PROVED,
        detail=f"numerator 0 in {accepted[0].generators} generators, accepted by the checker",
        residual=0.0,
        assumptions=(
            scope(statement).text,
            *united((f"no denominator vanishes identically: see {c.point}",) for c in accepted),
            *(f"holds where the formula is smooth, possibly not so: {line}" for line in places),
        ),
        singularities=places,
        certificate=accepted[0],
        certificates=accepted,
    )


def refuted(statement: Statement, witness: Mapping[str, str]) -> StatementVerdict | None:
    """Return the verdict REFUTED by a point, maybe complex; None if no equation fails there."""
    trees, numbers = witness_trees(statement, statement.trees, witness)
    failing = TypedValues(trees, typed_domains(statement)).failing(numbers)
    if failing is None:
        return None
    number, residual = failing
    where = f"equation {number}: " if len(statement.equations) > 1 else ""
    bounds = {*map(str, statement.domain_symbols)} & witness.keys()  # may not be in the formulas
    names = (statement.trees.names | bounds) - {*statement.functions}
    chosen = {name: f"1/gamma(z + {generic_shift(name)})" for name in statement.functions}
    return StatementVerdict(
        **statement_fields(statement),
        outcome=Outcome.REFUTED,
        detail=f"{where}residual {residual.str(prover.SHOWN_DIGITS)} excludes 0",
        witness={name: str(numbers.get(name, witness[name])) for name in sorted(names)} | chosen,
    )


def witness_trees(
    statement: Statement, trees: StatementTrees, witness: Mapping[str, str]
) -> tuple[StatementTrees, dict[str, Fraction]]:
    """Substitute the complex values of a point into the trees; return them and its other values."""
    complexes = {n: witness[n] for n in statement.complexes if "I" in witness[n]}
    trees = trees.with_values(complexes)
    trees_of_values = map(tree_of, complexes.values())
    real = (mapped(t, lambda n: ONE if n == Name("I") else None) for t in trees_of_values)
    if any(rational(tree) is None for tree in real):
        raise ValueError(f"witness must have numbers for {', '.join(complexes)}, got other values")
    return trees, {name: Fraction(witness[name]) for name in trees.names}


def united(lines: Iterable[Iterable[str]]) -> tuple[str, ...]:
    """Return all lines, without repeats."""
    return tuple(dict.fromkeys(chain.from_iterable(lines)))


def statement_fields(statement: Statement) -> dict[str, Any]:
    """Return the fields of a verdict that describe its statement."""
    return {
        "name": statement.name,
        "equation": "; ".join(map(stated_equation, statement.texts.equations)),
        "method": prover.METHOD,
        "statement": statement_latex(statement),
        "sides": "",
    }


def undecided(statement: Statement, reason: str, seconds: float = 0.0) -> StatementVerdict:
    """Return the verdict UNDECIDED with a reason."""
    fields = statement_fields(statement)
    return StatementVerdict(**fields, outcome=Outcome.UNDECIDED, detail=reason, seconds=seconds)


def stated_equation(text: str) -> str:
    """Return an equation as typed, with its right-hand side."""
    return " ".join(text.split()) + ("" if "=" in text else " = 0")


def verified_sentence(statement: Statement, verdict: StatementVerdict) -> str:
    r"""Return the verdict as a LaTeX sentence; a proof has the digests of its certificates.

    >>> from longwave.verify.proof.statement_text import read_statement
    >>> statement = read_statement("u_x - 1", "u = x")
    >>> print(verified_sentence(statement, decide_statement(statement)))
    We verified (certificate \texttt{...}) that
    \[ u = x \]
    satisfies
    \[ u_{x} - 1 = 0 \]
    for all real $x$ at which it is smooth.
    """
    formulas, equations = formulas_latex(statement), equations_latex(statement)
    if verdict.outcome is Outcome.UNDECIDED:
        return f"% {verdict.name}: UNDECIDED: {verdict.detail}"
    if verdict.outcome is Outcome.REFUTED:
        heading, verb = "We found that", "does not satisfy"
        last = f"at ${', '.join(_values_latex(statement, verdict.witness or {}))}$."
    else:
        digests = ", ".join(rf"\texttt{{{c['digest'][:16]}}}" for c in verdict.certificates)
        restriction = verdict.restriction.replace("_", r"\_").replace("nothing", "with nothing")
        only = f", {restriction}," if restriction else ""
        heading = f"We verified (certificate {digests}) that{only}"
        verb, last = "satisfies", f"{scope_latex(statement)} at which it is smooth."
        if places := _corners_latex(statement, verdict.singularities):
            last = f"{last[:-1]}; nothing is said at {', '.join(places)}."
    return f"{heading}\n\\[ {formulas} \\]\n{verb}\n\\[ {equations} \\]\n{last}"


def _corners_latex(statement: Statement, lines: Sequence[str]) -> list[str]:
    """Return the places of jumps and corners in LaTeX; a line that is no equation as text."""
    equations = []
    for line in lines:
        if place := re.fullmatch(r"jump or corner (?:at the site|at|where) (.*) = (.*)", line):
            try:
                trees = [tree_of(side, statement.functions) for side in place.groups()]
                equations.append(f"${' = '.join(map(formula_latex, trees))}$")
            except ValueError:
                escaped = " = ".join(place.groups()).replace("_", r"\_")
                equations.append(rf"\texttt{{{escaped}}}")
    return equations


def _values_latex(statement: Statement, witness: Mapping[str, str]) -> Iterator[str]:
    """Yield the values of a witness in LaTeX; arbitrary functions as functions of z."""
    for name, text in witness.items():
        if name in statement.functions:
            below = rf"\Gamma\left(z + {generic_shift(name)}\right)"
            yield rf"{name_latex(name)}\left(z\right) = \frac{{1}}{{{below}}}"
        else:
            yield f"{name_latex(name)} = {formula_latex(tree_of(text))}"
