"""Verdicts on statements (`verify.proof.statement_text`): every equation proved, or one refuted.

An equation in one unknown and its derivatives goes to `prove` as it is, any other with a
certificate into which the checker puts the formulas.  What neither can take is decided as the
equality of its residual with 0: the formulas are put in and differentiated by SymPy.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import chain
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from longwave.derive.algebra.formula_latex import formula_latex, name_latex
from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.derive.algebra.formula_tree import FormulaTree, Name, Number, mapped, rational
from longwave.solutions.record import LONGEST_FORMULA
from longwave.verify.kernel.check import check_certificate
from longwave.verify.kernel.function_values import generic_shift
from longwave.verify.subexpressions import abbreviated, distinct_nodes
from longwave.verify.verdict import Outcome, ProofVerdict

from . import prover
from .balls import ball_value
from .certificate_writer import Certificate, as_data
from .problem import solution_problem
from .samples import sample
from .seams import left_open, sides
from .statement_latex import equations_latex, formulas_latex, scope_latex, statement_latex
from .statement_problem import (
    all_domains,
    residual_of,
    statement_problem,
    typed_domains,
    undefined,
    with_exponentials,
)
from .statement_scope import scope
from .typed_balls import TextPoint
from .typed_hints import typed_proof, with_conjugates
from .typed_statement import Statement, StatementTrees, tree_of
from .typed_values import TypedValues, failing_values, typed_values

Progress = Callable[[str], None]

NO_VERDICT = (
    *(ValueError, TypeError, RecursionError, NotImplementedError, OverflowError),
    sp.PolynomialError,
)
"""What a way that decides nothing ends with; exponents past 64 bits overflow in FLINT."""

DRAWN = 40
"""Points that are drawn for what a witness leaves free."""

UNSEEN = "what was typed was not seen to fail where what SymPy makes of it does"

NO_PROOF: dict[str, Any] = {"certificate": None, "residual": None, "assumptions": ()}

WITNESS_BITS = (160, 640)


@dataclass(frozen=True, repr=False)
class StatementVerdict(ProofVerdict):
    """The verdict on a statement: ``statement`` is what was read, in LaTeX.

    ``certificates`` has one for each equation of a proof; ``hint`` says what holds in the place of
    a refuted formula, and where ``hint_verdict``, the proof of it, leaves that open.
    """

    statement: str = ""
    hint: str = ""
    certificates: tuple[Mapping[str, Any], ...] = field(default=(), compare=False)
    hint_verdict: StatementVerdict | None = field(default=None, compare=False)

    @property
    def hint_certificates(self) -> tuple[Mapping[str, Any], ...]:
        """The certificates of what holds in the place of a refuted formula."""
        return self.hint_verdict.certificates if self.hint_verdict else ()

    @property
    def told(self) -> dict[str, str]:
        """The same, the statement in the place of its equations, and what would hold."""
        is_short = len(self.statement) <= LONGEST_FORMULA
        shown = rf"$\displaystyle {self.statement}$" if is_short else self.equation
        return super().told | {"equation": shown, "what would hold": self.hint}

    def json(self) -> dict[str, Any]:
        """The record as plain data."""
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
            "hint_certificates": [found["digest"] for found in self.hint_certificates],
        }


def decide_statement(statement: Statement, progress: Progress = lambda _: None) -> StatementVerdict:
    """The verdict on a statement; ``progress`` is told what is done next."""
    start = time.perf_counter()
    found = _decided(statement, progress)
    return replace(found, seconds=time.perf_counter() - start)


def _decided(statement: Statement, progress: Progress) -> StatementVerdict:
    verdicts: list[ProofVerdict] = []
    count = len(statement.equations)
    typed = typed_values(statement)
    assert typed is not None
    for number, equation in enumerate(statement.equations, 1):
        progress(f"equation {number} of {count}")
        verdict = _decide_equation(statement, equation)
        verdicts.append(_as_typed(statement, number, verdict, typed))
        if verdicts[-1].outcome is Outcome.REFUTED:
            break
    found = _together(statement, verdicts)
    if found.outcome is Outcome.REFUTED:
        return found
    if statement.complexes and found.outcome is Outcome.UNDECIDED:
        failing = failing_values(statement)
    else:
        failing = _shown(typed.failure())
    if failing is not None:
        return refuted(statement, failing) or found
    divisor = undefined(statement) if found.outcome is Outcome.PROVED else None
    if divisor is not None:
        return undecided(
            statement, f"divisors must be shown not to be 0, got {abbreviated(divisor)}"
        )
    return found


def _shown(point: TextPoint | None) -> dict[str, str] | None:
    return None if point is None else {name: str(value) for name, value in point.items()}


def _as_typed(
    statement: Statement, number: int, verdict: ProofVerdict, typed: TypedValues
) -> ProofVerdict:
    """The verdict on one equation as it was typed, from that on what SymPy makes of it.

    A proof has a certificate of the texts that the checker accepts; a refutation has a point at
    which a ball around the residual of what was typed excludes 0.
    """
    if verdict.outcome is Outcome.REFUTED:
        witness = {name: Fraction(value) for name, value in (verdict.witness or {}).items()}
        if typed.fails_at(witness):
            return verdict
        failing = _shown(typed.failure())
        if failing is not None:
            return replace(verdict, witness=failing)
        verdict = replace(verdict, outcome=Outcome.UNDECIDED, detail=UNSEEN, witness=None)
    assert statement.texts is not None
    certificate = verdict.certificate
    if isinstance(certificate, Certificate):
        one = replace(statement.texts, equations=statement.texts.equations[number - 1 : number])
        proof = with_conjugates(certificate["proof"], statement.complexes)
        restated = certificate.changed(statement=as_data(one), proof=proof)
        with suppress(*NO_VERDICT):
            check_certificate(restated)
            return replace(verdict, certificate=restated)
    try:
        found = typed_proof(statement, number)
    except NO_VERDICT as error:
        proved = verdict.outcome is Outcome.PROVED  # by SymPy's reading alone
        words = " ".join((str(error) if proved else verdict.detail or str(error)).split())
        return replace(verdict, outcome=Outcome.UNDECIDED, detail=words, **NO_PROOF)
    return found


def _together(statement: Statement, found: Sequence[ProofVerdict]) -> StatementVerdict:
    """The verdict on all equations: the refuted or undecided one, else the proofs together."""
    worst = {Outcome.REFUTED: 0, Outcome.UNDECIDED: 1, Outcome.PROVED: 2}
    place = min(range(len(found)), key=lambda i: worst[found[i].outcome])
    chosen = found[place]
    if chosen.outcome is Outcome.PROVED:
        return proved(statement, [v.certificate for v in found if v.certificate])
    where = f"equation {place + 1}: " if len(statement.equations) > 1 else ""
    if chosen.outcome is Outcome.REFUTED:
        return refuted(statement, chosen.witness or {}) or undecided(statement, where + UNSEEN)
    return undecided(statement, where + " ".join(chosen.detail.split()))


def proved(statement: Statement, certificates: Sequence[Mapping[str, Any]]) -> StatementVerdict:
    """The verdict on a statement with accepted certificates of its texts."""
    found = tuple(map(Certificate, certificates))
    jumps, places = left_open(statement)
    return StatementVerdict(
        **said_of(statement) | {"sides": sides(jumps)},
        outcome=Outcome.PROVED,
        detail=f"numerator 0 in {found[0].generators} generators, accepted by the checker",
        residual=0.0,
        assumptions=(
            scope(statement).text,
            *united((f"no denominator vanishes identically: see {c.point}",) for c in found),
            *(f"holds where the formula is smooth, possibly not so: {line}" for line in places),
        ),
        singularities=places,
        certificate=found[0],
        certificates=found,
    )


def refuted(statement: Statement, witness: Mapping[str, str]) -> StatementVerdict | None:
    """The verdict on a statement at a point of its domain; None where no equation is seen to fail.

    Complex values, which no number is, are put into the trees.
    """
    assert statement.trees is not None
    trees, numbers = witness_trees(statement, statement.trees, witness)
    failing = TypedValues(trees, typed_domains(statement)).failing(numbers)
    if failing is None:
        return None
    number, residual = failing
    where = f"equation {number}: " if len(statement.equations) > 1 else ""
    ends = (s for domain in statement.domains.values() for s in domain.symbols)
    bounds = {*map(str, ends)} & witness.keys()  # parameters that the formulas need not contain
    names = (statement.trees.names | bounds) - {*statement.functions}
    chosen = {name: f"1/gamma(z + {generic_shift(name)})" for name in statement.functions}
    return StatementVerdict(
        **said_of(statement),
        outcome=Outcome.REFUTED,
        detail=f"{where}residual {residual.str(prover.SHOWN_DIGITS)} excludes 0",
        witness={name: str(numbers.get(name, witness[name])) for name in sorted(names)} | chosen,
    )


def witness_trees(
    statement: Statement, trees: StatementTrees, witness: Mapping[str, str]
) -> tuple[StatementTrees, dict[str, Fraction]]:
    """The trees with the complex values of a point put in, and the values that are numbers."""
    complexes = {n: witness[n] for n in statement.complexes if "I" in witness[n]}
    made = trees.with_values(complexes)
    if any(rational(mapped(tree_of(text), _without_unit)) is None for text in complexes.values()):
        raise ValueError(f"witness must have numbers for {', '.join(complexes)}, got other values")
    return made, {name: Fraction(witness[name]) for name in made.names}


def _without_unit(node: FormulaTree) -> FormulaTree | None:
    return Number(Fraction(1)) if node == Name("I") else None


def united(lines: Iterable[Iterable[str]]) -> tuple[str, ...]:
    """All lines, each once."""
    return tuple(dict.fromkeys(chain.from_iterable(lines)))


def said_of(statement: Statement) -> dict[str, Any]:
    """What a verdict on a statement says of it."""
    assert statement.texts is not None
    return {
        "name": statement.name,
        "equation": "; ".join(map(stated_equation, statement.texts.equations)),
        "method": prover.METHOD,
        "statement": statement_latex(statement),
        "sides": "",
    }


def undecided(statement: Statement, reason: str, seconds: float = 0.0) -> StatementVerdict:
    """The verdict that there is none, for a reason."""
    told = said_of(statement)
    return StatementVerdict(**told, outcome=Outcome.UNDECIDED, detail=reason, seconds=seconds)


def stated_equation(text: str) -> str:
    """An equation as it was typed, with its right-hand side."""
    return " ".join(text.split()) + ("" if "=" in text else " = 0")


def equation_text(equation: sp.Expr) -> str:
    """An equation in the grammar."""
    return f"{formula_as_text(equation)} = 0"


def _decide_equation(statement: Statement, equation: sp.Expr) -> ProofVerdict:
    """The verdict on one equation, in the first way that decides.

    Why a way cannot take the equation is a reason only where no way can.
    """
    reasons, unfit = list[str](), list[str]()
    for way in (_as_it_is, _by_substitution, _by_residual):
        try:
            verdict = way(statement, equation)
        except NO_VERDICT as error:
            unfit.append(" ".join(str(error).split()) or type(error).__name__)
            continue
        if verdict.outcome is not Outcome.UNDECIDED:
            return verdict
        reasons.append(" ".join(verdict.detail.split()))
    reason = "; then: ".join(dict.fromkeys(reasons[:2] or unfit[-1:]))
    return ProofVerdict(
        statement.name, equation_text(equation), prover.METHOD, Outcome.UNDECIDED, reason
    )


def _completed(statement: Statement, equation: sp.Expr, verdict: ProofVerdict) -> ProofVerdict:
    """The verdict, a refutation with values of the symbols that were gone before it."""
    if verdict.outcome is not Outcome.REFUTED:
        return verdict
    domains = all_domains(statement, *statement.equations)
    witness = dict(verdict.witness or {})
    known = {
        symbol: sp.Rational(witness[str(symbol)]) for symbol in domains if str(symbol) in witness
    }
    for point in sample(domains, DRAWN):
        whole = {**point, **known}
        if all(domain.contains(whole[symbol], whole) for symbol, domain in domains.items()):
            coordinates = {str(symbol): str(value) for symbol, value in whole.items()}
            return replace(verdict, witness=coordinates)
    return verdict


def _as_it_is(statement: Statement, equation: sp.Expr) -> ProofVerdict:
    unknowns = equation.atoms(AppliedUndef)
    if len(unknowns) != 1 or not unknowns <= statement.solutions.keys():
        raise ValueError("equations with several unknowns or sites are decided by their residual")
    (unknown,) = unknowns
    formula = statement.solutions[unknown]
    verdict = prover.prove(equation, formula, name=statement.name, domains=statement.domains)
    if verdict.outcome is Outcome.UNDECIDED:  # raises where it is no polynomial: no reason
        solution_problem(equation, formula, stated=statement.domains).terms()
    return _completed(statement, equation, verdict)


def _by_substitution(statement: Statement, equation: sp.Expr) -> ProofVerdict:
    """By a certificate that has the equation as it stands, for the checker to put in."""
    problem = statement_problem(statement, equation)
    verdict = _completed(statement, equation, prover.decide(problem, time.perf_counter()))
    if verdict.outcome is Outcome.REFUTED:
        _check_defined_at(verdict.witness or {}, problem.expressions)
    return verdict


def _by_residual(statement: Statement, equation: sp.Expr) -> ProofVerdict:
    """The verdict on residual = 0.

    Raises ValueError where the formulas, or the powers and functions of the equation, are not shown
    to be defined: what is not may have cancelled in the residual.
    """
    nodes = [n for n in distinct_nodes(equation) if n.is_Pow or n.is_Function]
    parts = [f for u, f in statement.solutions.items() if equation.has(u.func)]
    parts += [residual_of(statement, node) for node in nodes]
    residual, *parts = map(with_exponentials, (residual_of(statement, equation), *parts))
    parts = [part for part in dict.fromkeys(parts) if not part.is_polynomial()]
    verdict = _equal(statement, residual, sp.S.Zero, equation_text(equation))
    verdict = _completed(statement, equation, verdict)
    if verdict.outcome is Outcome.REFUTED:
        _check_defined_at(verdict.witness or {}, parts)
    if verdict.outcome is not Outcome.PROVED:
        return verdict
    for part in parts:
        defined = _equal(statement, part, part, "a formula = itself")
        if defined.outcome is not Outcome.PROVED:
            raise ValueError(f"formulas must be shown to be defined: {defined.detail}")
    return verdict


def _equal(statement: Statement, left: sp.Expr, right: sp.Expr, said: str) -> ProofVerdict:
    return prover.prove_equal(
        left,
        right,
        statement.variables,
        name=statement.name,
        equation_name=said,
        domains=statement.domains,
    )


def _check_defined_at(witness: Mapping[str, str], parts: Sequence[sp.Expr]) -> None:
    """Raise ValueError unless each of the formulas has a finite value at the point."""
    for part in parts:
        point = {symbol: sp.Rational(witness[str(symbol)]) for symbol in part.free_symbols}
        with suppress(ZeroDivisionError):
            if any(ball_value(part, point, bits).is_finite() for bits in WITNESS_BITS):
                continue
        raise ValueError(f"formulas must be defined at a witness, got {abbreviated(part)} at none")


def verified_sentence(statement: Statement, verdict: StatementVerdict) -> str:
    r"""The verdict as a sentence in LaTeX, a proof with the digests of its certificates.

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
    """Return the places of jumps and corners, where formulas have values, as equations in LaTeX.

    A place that is shown with dots, or in no formula's words, stays as it is.
    """
    found = []
    for line in lines:
        if place := re.fullmatch(r"jump or corner (?:at the site|at|where) (.*) = (.*)", line):
            try:
                trees = [tree_of(side, statement.functions) for side in place.groups()]
                found.append(f"${' = '.join(map(formula_latex, trees))}$")
            except ValueError:
                escaped = " = ".join(place.groups()).replace("_", r"\_")
                found.append(rf"\texttt{{{escaped}}}")
    return found


def _values_latex(statement: Statement, witness: Mapping[str, str]) -> Iterator[str]:
    """The values of a point, and the functions of one argument z at it."""
    for name, text in witness.items():
        if name in statement.functions:
            below = rf"\Gamma\left(z + {generic_shift(name)}\right)"
            yield rf"{name_latex(name)}\left(z\right) = \frac{{1}}{{{below}}}"
        else:
            yield f"{name_latex(name)} = {formula_latex(tree_of(text))}"
