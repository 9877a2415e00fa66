"""Find the values of its constants for which a statement holds, in cases that are proved.

The coefficients of the residual in independent generators (`residual_system`) are solved by cases
(`case_tree`).  If a case makes generators dependent or a denominator 0, or changes a function of
parameters, its values are substituted and the new statement is solved again.  The ordinary prover
then decides each case.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, count
from typing import Any

import sympy as sp

from longwave.derive.algebra.formula_latex import name_latex
from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.verify.verdict import Outcome, timed

from . import statement_verdict as verdicts
from .case_tree import CaseTree, Constants
from .constant_cases import ConstantCase, largest_cases, symbols_of, with_values
from .constant_terms import Terms, as_terms
from .domains import REAL, settled_domains
from .explicit_values import explicit_values
from .problem import equality_problem
from .residual_system import ResidualSystem
from .seams import seams, sides
from .statement_problem import residual_of, with_exponentials
from .statement_verdict import StatementVerdict
from .typed_hints import NO_VERDICT
from .typed_statement import Statement
from .typed_values import typed_values

MOST_STATEMENTS = 60
"""Most statements examined for one answer."""


@dataclass(frozen=True, repr=False)
class ConditionalVerdict(StatementVerdict):
    """Values of the constants ``solved`` for which a statement holds, in ``cases``.

    If ``unknown`` is empty there are no others, except where one of ``left_out`` holds.
    """

    solved: tuple[str, ...] = ()
    cases: tuple[ConstantCase, ...] = field(default=(), compare=False)
    left_out: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    is_solved: bool = True

    @property
    def complete(self) -> bool:
        """Whether the cases, with the conditions left out, cover all values of the constants."""
        return self.is_solved and not self.unknown

    def json(self) -> dict[str, Any]:
        """Return the verdict as plain data."""
        record = super().json() | {"reason": self._answer, "solved": list(self.solved)}
        record |= {"cases": [case.json() for case in self.cases], "complete": self.complete}
        return record | {"left_out": list(self.left_out), "unknown": list(self.unknown)}

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
            opening = "no value was found" if open_ends else "holds for no value"
            return f"{opening} of {names}{ending}"
        always = next((case for case in self.cases if case.proved and case.is_unconditional), None)
        if always is not None:
            return f"holds for all values of {names}{' (trivial)' * always.trivial}"
        return f"{self._heading} {'; or '.join(case.text for case in self.cases)}{ending}"

    @property
    def _answer(self) -> str:
        """The verdict's ``detail`` without the text of `restriction` at its beginning."""
        return self.detail.removeprefix(f"{self.restriction}: ")

    @property
    def _heading(self) -> str:
        return "holds if" if self.unknown else "holds if and only if"

    @property
    def _ending(self) -> str:
        if self.unknown:
            return f"others are not excluded ({', '.join(self.unknown)})"
        return f"apart from where {' or '.join(self.left_out)}" if self.left_out else ""


@timed
def solve_statement(
    statement: Statement, progress: verdicts.Progress = lambda _: None
) -> ConditionalVerdict:
    """Return the cases in which a statement holds, solved for its ``solve_for`` symbols.

    >>> from longwave.verify.proof.statement_text import read_statement
    >>> kdv = read_statement("u_t + 6*u*u_x + u_xxx", "u = a*sech(x - c*t)**2", solve="a, c")
    >>> print(solve_statement(kdv).detail)
    holds if and only if a = 2, c = 4; or a = 0 (trivial)
    """

    search = _Search(statement.solve_for)
    progress("the coefficients of the residual")
    try:
        candidates = search.cases(statement)
    except NO_VERDICT as error:
        return _verdict(statement, search, [], " ".join(str(error).split()))
    progress("the proofs of the cases")
    decided = largest_cases(candidates)
    cases = [search.in_order(case) for case in decided if not case.refuted]
    search.unknown |= {f"near {case.text}": None for case in decided if case.refuted}
    return _verdict(statement, search, cases)


def conditional_sentence(verdict: ConditionalVerdict) -> str:
    """Return the answer in LaTeX: a sentence for each case, and whether there are other cases."""
    if verdict.outcome is Outcome.UNDECIDED:
        return f"% {verdict.name}: UNDECIDED: {verdict.detail}"
    names = ", ".join(map(name_latex, verdict.solved))
    exceptions = ", ".join((*verdict.unknown, *verdict.left_out))
    other, does = ("other ", "does") if verdict.cases else ("", "holds")
    opening = "There are no" if verdict.complete else "We found no"
    last = f"{opening} {other}values of ${names}$ with which it {does}."
    sentences = [
        verdicts.verified_sentence(c.statement, c.verdict) for c in verdict.cases if c.verdict
    ]
    return "\n\n".join([*sentences, last + (f"\n% left out: {exceptions}" if exceptions else "")])


@dataclass
class _Search:
    """Search for the cases of a statement and of the special statements that arise from it."""

    solve_for: Sequence[sp.Symbol]
    unknown: dict[str, None] = field(default_factory=dict)
    left_out: dict[str, None] = field(default_factory=dict)

    def cases(self, statement: Statement) -> list[ConstantCase]:
        """Return all cases; raises ValueError if the residual's generators are not known."""
        waiting = [ConstantCase({}, statement)]
        results, further = self._step(waiting[0])
        visited = {self._key(waiting[0])}
        while further:
            case = further.pop(0)
            if self._key(case) in visited:
                continue
            visited.add(self._key(case))
            if len(visited) > MOST_STATEMENTS:
                self.unknown[f"more than {MOST_STATEMENTS} special cases"] = None
                break
            try:
                solved, more = self._step(case)
            except NO_VERDICT:
                self.unknown[f"where {case.text.removesuffix(' (not proved)')}"] = None
                continue
            results += solved
            further += more
        return results

    def in_order(self, case: ConstantCase) -> ConstantCase:
        """Return ``case`` with its values sorted in the order of the ``solve_for`` symbols."""
        order = [s for s in self.solve_for if s in case.values]
        rest = sorted(case.values.keys() - set(order), key=str)
        return replace(case, values={s: case.values[s] for s in (*order, *rest)})

    @staticmethod
    def _key(case: ConstantCase) -> object:
        formulas = (*case.statement.equations, *case.statement.solutions.values())
        return (formulas, tuple(case.values.items()), case.restrictions)

    def _step(self, case: ConstantCase) -> tuple[list[ConstantCase], list[ConstantCase]]:
        """Return the cases of one statement, and the special statements to solve next."""
        system = self._system(case.statement)
        domains = settled_domains(symbols_of(case.statement), case.statement.domains)
        degenerate = [as_terms(entries, system.relations) for entries in system.degenerate]
        constants = Constants(_constants(system, degenerate), system.relations)
        own = [s for s in self.solve_for if s in domains]
        others = sorted(set(domains) - {*own, *case.statement.variables}, key=str)
        tree = CaseTree(constants, own, others, domains)
        solved, further = list[ConstantCase](), list[ConstantCase]()
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
        """Return the conditions under which the residuals of all equations vanish."""
        system = ResidualSystem()
        residuals = [with_exponentials(residual_of(statement, e)) for e in statement.equations]
        system.unknown |= dict.fromkeys(_doubts(statement, residuals))
        for residual in residuals:
            if residual == 0:
                continue
            residual, variables, rest = with_phase(residual, statement, self.solve_for)
            symbols = residual.free_symbols
            domains = {s: d for s, d in statement.domains.items() if s in symbols}
            try:
                system.add(equality_problem(residual, sp.S.Zero, variables, stated=domains))
            except NO_VERDICT as error:
                raise ValueError(f"the residual has no known generators: {error}") from None
            system.judge_phase(rest, statement.variables)
        return system


def _doubts(statement: Statement, residuals: Sequence[sp.Expr]) -> Iterator[str]:
    """Yield reasons why a statement may hold with nonzero coefficients, e.g. on few sites."""
    if reason := typed_values(statement).difference(residuals):
        yield reason
    for variable in statement.variables:
        domain = statement.domains.get(variable, REAL)
        if domain.integer and domain.lower != -sp.oo and domain.upper != sp.oo:
            yield f"{variable} takes finitely many values"


def _constants(system: ResidualSystem, degenerate: Sequence[Sequence[Terms]]) -> set[sp.Expr]:
    relations = [terms for _, terms in system.relations.values()]
    everything = chain(system.polynomials, relations, *degenerate)
    constants = {g for terms in everything for monomial in terms for g, _ in monomial}
    constants |= system.relations.keys()
    return constants | {s for g in constants for s in g.free_symbols}


def with_phase(
    residual: sp.Expr, statement: Statement, fixed: Sequence[sp.Symbol]
) -> tuple[sp.Expr, tuple[sp.Symbol, ...], sp.Expr]:
    """Replace ``b*n + d``, for a variable n and an arbitrary constant d, by a new variable.

    This is done only if d is not ``fixed`` and n disappears from the residual.  A residual that
    is 0 for all n and d is 0 for all values of ``b*n + d``.
    Returns the residual, its variables, and b*n; 0 instead of b*n if nothing was replaced.
    """
    moving = residual.free_symbols & set(statement.variables)
    arguments = {sp.expand(f.args[0]) for f in residual.atoms(sp.Function)}
    for phase in sorted(residual.free_symbols - {*fixed, *statement.variables}, key=str):
        is_any_number = phase.is_nonnegative is None and phase.is_nonpositive is None
        if phase in statement.domains or not (phase.is_real and is_any_number):
            continue
        for argument in sorted(arguments, key=lambda z: (z.count_ops(), str(z))):
            slope = argument.coeff(phase, 1)
            rest = argument - slope * phase
            if not slope.is_Rational or slope == 0 or phase in rest.free_symbols:
                continue
            names = {symbol.name for symbol in residual.free_symbols}
            fresh = next(name for n in count() if (name := "phase" + "_" * n) not in names)
            variable = sp.Symbol(fresh, real=True)
            image = residual.xreplace({phase: (variable - rest) / slope})
            image = image.replace(
                lambda node: isinstance(node, sp.Function),
                lambda node: node.func(*map(sp.expand, node.args)),
            )
            left = [v for v in statement.variables if v in image.free_symbols]
            if len(left) < len(moving):
                return image, (variable, *left), rest
    return residual, statement.variables, sp.S.Zero


def _verdict(
    statement: Statement, search: _Search, cases: Sequence[ConstantCase], reason: str = ""
) -> ConditionalVerdict:
    """Build the verdict from the cases; with a ``reason`` it is UNDECIDED."""
    proofs = [case.verdict for case in cases if case.verdict]
    certificates = tuple(c for proof in proofs for c in proof.certificates)
    outcome, witness = Outcome.UNDECIDED, None
    if certificates and all(case.proved or case.trivial for case in cases):
        outcome = Outcome.PROVED
    elif not (cases or reason or search.unknown or search.left_out):
        whole = verdicts.decide_statement(statement)
        if whole.outcome is Outcome.REFUTED:
            outcome, witness = whole.outcome, whole.witness
    answer = ConditionalVerdict(
        **verdicts.statement_fields(statement) | {"sides": sides(seams(statement))},
        outcome=outcome,
        detail=reason or "solved",
        witness=witness,
        assumptions=verdicts.united(proof.assumptions for proof in proofs),
        singularities=verdicts.united(proof.singularities for proof in proofs),
        certificate=certificates[0] if certificates else None,
        certificates=certificates,
        solved=tuple(map(str, search.solve_for)),
        cases=tuple(cases),
        left_out=tuple(search.left_out),
        unknown=tuple(search.unknown),
        is_solved=not reason,
    )
    front = f"{answer.restriction}: " if answer.restriction else ""
    return answer if reason else replace(answer, detail=front + answer.words())
