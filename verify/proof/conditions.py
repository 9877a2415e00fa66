"""For which values of its constants does a statement hold?  The answer in cases, each proved.

The coefficients of the residual in independent generators (`residual_system`) are solved by cases
(`case_tree`).  Where a case makes generators dependent, a denominator 0 or changes a function of
parameters, its values are put into the statement and that is solved anew.  What is printed as a
case was then decided by the ordinary prover.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from typing import Any

import sympy as sp

from longwave.derive.algebra.formula_latex import name_latex
from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.verify.verdict import Outcome

from .case_tree import CaseTree, Constants
from .constant_cases import ConstantCase, largest_cases, symbols_of, with_values
from .constant_terms import Terms, as_terms
from .domains import REAL, settled_domains
from .explicit_values import explicit_values
from .problem import equality_problem
from .residual_system import ResidualSystem
from .seams import seams, sides
from .statement_problem import residual_of, with_exponentials
from .statement_verdict import (
    Progress,
    StatementVerdict,
    decide_statement,
    said_of,
    united,
    verified_sentence,
)
from .typed_hints import NO_VERDICT
from .typed_statement import Statement
from .typed_values import typed_values

EXPLORED = 60
"""Most statements that are looked at for one answer."""


@dataclass(frozen=True, repr=False)
class ConditionalVerdict(StatementVerdict):
    """For which values of the constants ``solved`` a statement holds.

    Without anything ``unknown`` there are no others, apart from where one of ``left_out`` holds.
    """

    solved: tuple[str, ...] = ()
    cases: tuple[ConstantCase, ...] = field(default=(), compare=False)
    left_out: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    is_solved: bool = True

    @property
    def complete(self) -> bool:
        """Whether there are no values beside the cases and what is left out."""
        return self.is_solved and not self.unknown

    def json(self) -> dict[str, Any]:
        """Return the record as plain data."""
        return super().json() | {
            "reason": self._answer,
            "solved": list(self.solved),
            "cases": [case.json() for case in self.cases],
            "complete": self.complete,
            "left_out": list(self.left_out),
            "unknown": list(self.unknown),
        }

    def lines(self) -> list[str]:
        """Return the answer in words, several cases on lines of their own."""
        if len(self.cases) < 2:
            return [self._answer]
        texts = [case.text for case in self.cases]
        return [line for line in (self._heading, *texts, self._ending) if line]

    def words(self) -> str:
        """Return the answer on one line."""
        names = ", ".join(self.solved)
        ending = f", {self._ending}" if self._ending else ""
        if not self.cases:
            open_ends = self.unknown or self.left_out
            found = "no value was found" if open_ends else "holds for no value"
            return f"{found} of {names}{ending}"
        always = next((case for case in self.cases if case.proved and case.is_unconditional), None)
        if always is not None:
            return f"holds for all values of {names}{' (trivial)' * always.trivial}"
        return f"{self._heading} {'; or '.join(case.text for case in self.cases)}{ending}"

    @property
    def _answer(self) -> str:
        """The detail without its front, which stands elsewhere."""
        return self.detail.removeprefix(f"{self.restriction}: ")

    @property
    def _heading(self) -> str:
        return "holds if" if self.unknown else "holds if and only if"

    @property
    def _ending(self) -> str:
        if self.unknown:
            return f"others are not excluded ({', '.join(self.unknown)})"
        return f"apart from where {' or '.join(self.left_out)}" if self.left_out else ""


def solve_statement(
    statement: Statement, progress: Progress = lambda _: None
) -> ConditionalVerdict:
    """Return the cases in which a statement holds, solved for what is wanted of it.

    >>> from longwave.verify.proof.statement_text import read_statement
    >>> kdv = read_statement("u_t + 6*u*u_x + u_xxx", "u = a*sech(x - c*t)**2", solve="a, c")
    >>> print(solve_statement(kdv).detail)
    holds if and only if a = 2, c = 4; or a = 0 (trivial)
    """
    start = time.perf_counter()
    found = _solved(statement, progress)
    return replace(found, seconds=time.perf_counter() - start)


def _solved(statement: Statement, progress: Progress) -> ConditionalVerdict:
    search = _Search(statement.wanted)
    progress("the coefficients of the residual")
    try:
        found = search.cases(statement)
    except NO_VERDICT as error:
        return _verdict(statement, search, [], " ".join(str(error).split()))
    progress("the proofs of the cases")
    decided = largest_cases(found)
    cases = [search.in_order(case) for case in decided if not case.refuted]
    search.unknown |= {f"near {case.text}": None for case in decided if case.refuted}
    return _verdict(statement, search, cases)


def conditional_sentence(verdict: ConditionalVerdict) -> str:
    """Return the answer in LaTeX: a sentence on each case, and whether there are others."""
    if verdict.outcome is Outcome.UNDECIDED:
        return f"% {verdict.name}: UNDECIDED: {verdict.detail}"
    names = ", ".join(map(name_latex, verdict.solved))
    apart = ", ".join((*verdict.unknown, *verdict.left_out))
    other, does = ("other ", "does") if verdict.cases else ("", "holds")
    found = "There are no" if verdict.complete else "We found no"
    last = f"{found} {other}values of ${names}$ with which it {does}."
    sentences = [verified_sentence(c.statement, c.verdict) for c in verdict.cases if c.verdict]
    return "\n\n".join([*sentences, last + (f"\n% left out: {apart}" if apart else "")])


# the search


@dataclass
class _Search:
    """The cases of a statement and of those that it becomes."""

    wanted: Sequence[sp.Symbol]
    unknown: dict[str, None] = field(default_factory=dict)
    left_out: dict[str, None] = field(default_factory=dict)

    def cases(self, statement: Statement) -> list[ConstantCase]:
        """Return all cases; raises ValueError where the residual's generators are not known."""
        waiting = [ConstantCase({}, statement)]
        found, further = self._step(waiting[0])
        seen = {self._key(waiting[0])}
        while further:
            case = further.pop(0)
            if self._key(case) in seen:
                continue
            seen.add(self._key(case))
            if len(seen) > EXPLORED:
                self.unknown[f"more than {EXPLORED} special cases"] = None
                break
            try:
                solved, more = self._step(case)
            except NO_VERDICT:
                self.unknown[f"where {case.text.removesuffix(' (not proved)')}"] = None
                continue
            found += solved
            further += more
        return found

    def in_order(self, case: ConstantCase) -> ConstantCase:
        """Return the case with its values in the order in which they were asked for."""
        order = [s for s in self.wanted if s in case.values]
        rest = sorted(case.values.keys() - set(order), key=str)
        return replace(case, values={s: case.values[s] for s in (*order, *rest)})

    @staticmethod
    def _key(case: ConstantCase) -> object:
        formulas = (*case.statement.equations, *case.statement.solutions.values())
        return (formulas, tuple(case.values.items()), case.restrictions)

    def _step(self, case: ConstantCase) -> tuple[list[ConstantCase], list[ConstantCase]]:
        """Cases of one statement, and those that must be looked at anew."""
        system = self._system(case.statement)
        domains = settled_domains(symbols_of(case.statement), case.statement.domains)
        degenerate = [as_terms(entries, system.relations) for entries in system.degenerate]
        constants = Constants(_constants(system, degenerate), system.relations)
        own = [s for s in self.wanted if s in domains]
        others = sorted(set(domains) - {*own, *case.statement.variables}, key=str)
        tree = CaseTree(constants, own, others, domains)
        solved: list[ConstantCase] = []
        further: list[ConstantCase] = []
        for place, polynomials in enumerate((system.polynomials, *degenerate)):
            for branch in tree.branches([constants.polynomial(p) for p in polynomials]):
                is_case = place == 0 and branch.complete
                for values in explicit_values(branch, constants):
                    if values.implicit and not is_case:
                        words = " and ".join(f"{formula_as_text(p)} = 0" for p in values.implicit)
                        self.left_out[words] = None
                        continue
                    new = with_values(case, values)
                    if new is not None:
                        (solved if is_case else further).append(new)
        self.unknown |= system.unknown | tree.unknown
        self.left_out |= dict.fromkeys((*system.left_out, *tree.left_out))
        return solved, further

    def _system(self, statement: Statement) -> ResidualSystem:
        """Return the conditions that the residuals of all equations give."""
        system = ResidualSystem()
        residuals = [with_exponentials(residual_of(statement, e)) for e in statement.equations]
        system.unknown |= dict.fromkeys(_doubts(statement, residuals))
        for residual in residuals:
            if residual == 0:
                continue
            residual, variables, rest = with_phase(residual, statement, self.wanted)
            symbols = residual.free_symbols
            domains = {s: d for s, d in statement.domains.items() if s in symbols}
            try:
                system.add(equality_problem(residual, sp.S.Zero, variables, stated=domains))
            except NO_VERDICT as error:
                words = f"the residual has no known generators: {error}"
                raise ValueError(words) from None
            system.judge_phase(rest, statement.variables)
        return system


def _doubts(statement: Statement, residuals: Sequence[sp.Expr]) -> Iterator[str]:
    """Yield reasons why values may be more than those with which the coefficients vanish.

    A polynomial may vanish at all of finitely many sites without being 0.
    """
    if reason := typed_values(statement).difference(residuals):
        yield reason
    for variable in statement.variables:
        domain = statement.domains.get(variable, REAL)
        if domain.integer and domain.lower != -sp.oo and domain.upper != sp.oo:
            yield f"{variable} takes finitely many values"


def _constants(system: ResidualSystem, degenerate: Sequence[Sequence[Terms]]) -> set[sp.Expr]:
    relations = [terms for _, terms in system.relations.values()]
    entries = [entry for entries in degenerate for entry in entries]
    everything = [*system.polynomials, *relations, *entries]
    found = {g for terms in everything for monomial in terms for g, _ in monomial}
    found |= system.relations.keys()
    return found | {s for g in found for s in g.free_symbols}


def with_phase(
    residual: sp.Expr, statement: Statement, kept: Sequence[sp.Symbol]
) -> tuple[sp.Expr, tuple[sp.Symbol, ...], sp.Expr]:
    """An argument ``b*n + d`` as one variable in place of n and d, if that removes a variable.

    What holds for all values of a free constant d, not among ``kept``, and all n holds for all
    values of the argument, so that the shifts of a lattice are sums of the argument and a constant.
    Returns the residual, its variables, and b*n where one was replaced.
    """
    moving = residual.free_symbols & set(statement.variables)
    arguments = {sp.expand(f.args[0]) for f in residual.atoms(sp.Function)}
    for phase in sorted(residual.free_symbols - {*kept, *statement.variables}, key=str):
        is_any_number = phase.is_nonnegative is None and phase.is_nonpositive is None
        if phase in statement.domains or not (phase.is_real and is_any_number):
            continue
        for argument in sorted(arguments, key=lambda z: (z.count_ops(), str(z))):
            slope = argument.coeff(phase, 1)
            rest = argument - slope * phase
            if not slope.is_Rational or slope == 0 or phase in rest.free_symbols:
                continue
            taken = {symbol.name for symbol in residual.free_symbols}
            fresh = next(name for n in count() if (name := "phase" + "_" * n) not in taken)
            variable = sp.Symbol(fresh, real=True)
            image = _expanded(residual.xreplace({phase: (variable - rest) / slope}))
            left = [v for v in statement.variables if v in image.free_symbols]
            if len(left) < len(moving):
                return image, (variable, *left), rest
    return residual, statement.variables, sp.S.Zero


def _expanded(expression: sp.Expr) -> sp.Expr:
    """Return the expression with the arguments of functions multiplied out."""
    return expression.replace(
        lambda node: isinstance(node, sp.Function),
        lambda node: node.func(*map(sp.expand, node.args)),
    )


# the verdicts


def _verdict(
    statement: Statement, search: _Search, cases: Sequence[ConstantCase], reason: str = ""
) -> ConditionalVerdict:
    """Return the answer; with a reason there is none."""
    verdicts = [case.verdict for case in cases if case.verdict]
    certificates = tuple(c for verdict in verdicts for c in verdict.certificates)
    outcome, witness = Outcome.UNDECIDED, None
    if certificates and all(case.proved or case.trivial for case in cases):
        outcome = Outcome.PROVED
    elif not (cases or reason or search.unknown or search.left_out):
        whole = decide_statement(statement)
        if whole.outcome is Outcome.REFUTED:
            outcome, witness = whole.outcome, whole.witness
    found = ConditionalVerdict(
        **said_of(statement) | {"sides": sides(seams(statement))},
        outcome=outcome,
        detail=reason or "solved",
        witness=witness,
        assumptions=united(verdict.assumptions for verdict in verdicts),
        singularities=united(verdict.singularities for verdict in verdicts),
        certificate=certificates[0] if certificates else None,
        certificates=certificates,
        solved=tuple(map(str, search.wanted)),
        cases=tuple(cases),
        left_out=tuple(search.left_out),
        unknown=tuple(search.unknown),
        is_solved=not reason,
    )
    front = f"{found.restriction}: " if found.restriction else ""
    return found if reason else replace(found, detail=front + found.words())
