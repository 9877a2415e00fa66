"""Substitute values of constants into a statement, restrict its domains, and decide it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.verify.verdict import Outcome

from .domains import Domain, settled_domains
from .explicit_values import Explicit, Values, tidy
from .restrictions import Restriction, domain_restrictions, needed, realities, restricted
from .statement_verdict import StatementVerdict, decide_statement
from .typed_statement import Statement, typed_case

ALL = "all values"
"""The case without conditions."""

UNDEFINED = (sp.zoo, sp.nan, sp.oo, -sp.oo)


@dataclass(frozen=True)
class ConstantCase:
    """Values of constants for which a ``statement`` holds, and the ``verdict`` on it.

    ``restrictions`` must hold in addition to the domains; ``implicit`` polynomials must vanish.
    A ``trivial`` case makes all unknowns constants, or an equation empty.
    """

    values: Values
    statement: Statement
    restrictions: tuple[Restriction, ...] = ()
    implicit: tuple[sp.Expr, ...] = ()
    trivial: bool = False
    verdict: StatementVerdict | None = None

    @property
    def proved(self) -> bool:
        """Whether the prover has proved the case."""
        return self.verdict is not None and self.verdict.outcome is Outcome.PROVED

    @property
    def refuted(self) -> bool:
        """Whether the case is false somewhere on its domains."""
        return self.verdict is not None and self.verdict.outcome is Outcome.REFUTED

    @property
    def is_unconditional(self) -> bool:
        """Whether the case has no conditions beyond the domains."""
        return not (self.values or self.implicit or self.restrictions)

    @property
    def text(self) -> str:
        """The case in words."""
        parts = [f"{s} = {formula_as_text(value)}" for s, value in self.values.items()]
        parts += [f"{formula_as_text(polynomial)} = 0" for polynomial in self.implicit]
        where = " and ".join(restriction.text for restriction in self.restrictions)
        notes = [*["trivial"] * self.trivial, *["not proved"] * (not self.proved)]
        words = " where ".join(part for part in (", ".join(parts), where) if part) or ALL
        return words + (f" ({', '.join(notes)})" if notes else "")

    def json(self) -> dict[str, Any]:
        """Return the case as plain data."""
        verdict = self.verdict
        return {
            "values": {str(s): formula_as_text(value) for s, value in self.values.items()},
            "where": [restriction.text for restriction in self.restrictions],
            "unsolved": [formula_as_text(polynomial) for polynomial in self.implicit],
            "trivial": self.trivial,
            "verdict": (verdict.outcome if verdict else Outcome.UNDECIDED).value,
            "assumptions": list(verdict.assumptions) if verdict else [],
            "certificates": [c["digest"] for c in verdict.certificates] if verdict else [],
        }


def with_values(case: ConstantCase, more: Explicit) -> ConstantCase | None:
    """Add values to a case; None if they leave the domains or make a formula undefined."""
    old, values = case.statement, more.values
    known = {s: tidy(v.xreplace(values)) for s, v in case.values.items()} | values
    given = [Restriction(r.value.xreplace(values), r.relation) for r in case.restrictions]
    if any(v.has(*UNDEFINED) for v in (*known.values(), *(r.value for r in given))):
        return None
    domains: dict[sp.Symbol, Domain] = {}
    for symbol, domain in settled_domains(symbols_of(old), old.domains).items():
        value = values.get(symbol, symbol)
        lower, upper = domain.lower.xreplace(values), domain.upper.xreplace(values)
        if value != symbol or symbol in lower.free_symbols | upper.free_symbols:
            moved = replace(domain, lower=lower, upper=upper)
            given += [*realities(value), *domain_restrictions(moved, value)]
            continue
        if lower.is_number and upper.is_number and lower >= upper:
            return None
        if symbol in old.domains:
            domains[symbol] = replace(domain, lower=lower, upper=upper)
    statement = _put_into(old, values, domains)
    if statement is None:
        return None
    restrictions = needed(given, settled_domains(symbols_of(statement), statement.domains))
    if restrictions is None:
        return None
    return ConstantCase(known, statement, restrictions, (*case.implicit, *more.implicit))


def symbols_of(statement: Statement) -> set[sp.Symbol]:
    """Return the variables and parameters of a statement."""
    formulas = (*statement.equations, *statement.solutions.values())
    return {s for f in formulas for s in f.free_symbols} | statement.domain_symbols


def _put_into(
    statement: Statement, values: Values, domains: Mapping[sp.Symbol, Domain]
) -> Statement | None:
    """Substitute values for symbols in a statement; None if a formula is undefined."""
    image = statement.with_values(values)
    if any(f.has(*UNDEFINED) for f in image.expressions) or 0 in image.divisors:
        return None
    written = {symbol.name: formula_as_text(value) for symbol, value in values.items()}
    texts, trees = typed_case(statement.texts, statement.trees, written)
    known = image.equations, image.solutions, domains, image.divisors
    return Statement(statement.name, *known, texts=texts, trees=trees)


def largest_cases(cases: Sequence[ConstantCase]) -> list[ConstantCase]:
    """Decide the cases, and return all except those contained in another, proved case."""
    decided: list[ConstantCase] = []
    for case in sorted(cases, key=lambda c: len(c.values) + len(c.implicit)):
        same = any(_conditions(case) == _conditions(other) for other in decided)
        if not same and not any(_lies_in(case, other) for other in decided):
            decided.append(_decided(case))
    return sorted(decided, key=lambda case: (case.trivial, not case.proved))


def _conditions(case: ConstantCase) -> tuple[Values, set[Restriction], set[sp.Expr]]:
    """Return the conditions of a case: values, restrictions and implicit polynomials."""
    return case.values, {*case.restrictions}, {*case.implicit}


def _lies_in(case: ConstantCase, other: ConstantCase) -> bool:
    """Return whether the values of a case satisfy the conditions of another, proved case."""
    if not other.proved or not set(other.restrictions) <= set(case.restrictions):
        return False
    zeros = [s - value for s, value in other.values.items()]
    zeros += [p for p in other.implicit if p not in case.implicit]
    return all(sp.simplify(zero.xreplace(case.values)) == 0 for zero in zeros)


def _decided(case: ConstantCase) -> ConstantCase:
    """Decide a case; its restrictions become domains of the statement if possible."""
    statement = case.statement
    moving = set(statement.variables)
    is_constant = all(not f.free_symbols & moving for f in statement.solutions.values())
    nonempty = [e for e in statement.equations if e != 0]
    case = replace(case, trivial=is_constant or len(nonempty) < len(statement.equations))
    explicit = _explicit(statement, case.implicit)
    if explicit is None or not nonempty:
        return case
    statement = explicit
    tried = restricted(statement, case.restrictions)
    if tried is not None:
        verdict = decide_statement(tried)
        if verdict.outcome is not Outcome.UNDECIDED:
            return replace(case, statement=tried, verdict=verdict)
    verdict = decide_statement(statement)
    if verdict.outcome is not Outcome.REFUTED or not case.restrictions:
        return replace(case, statement=statement, verdict=verdict)
    return case


def _explicit(statement: Statement, implicit: Sequence[sp.Expr]) -> Statement | None:
    """Solve each implicit polynomial for a parameter in which it is linear, and substitute."""
    for place, polynomial in enumerate(implicit):
        for s in sorted(polynomial.free_symbols, key=str):
            slope = polynomial.coeff(s, 1) if sp.degree(polynomial, s) == 1 else sp.S.Zero
            if slope.is_Rational and slope != 0:
                values = {s: sp.expand(s - polynomial / slope)}
                domains = {q: d for q, d in statement.domains.items() if not {q, *d.symbols} & {s}}
                solved = _put_into(statement, values, domains)
                rest = [sp.numer(sp.together(p.xreplace(values))) for p in implicit[place + 1 :]]
                return solved and _explicit(solved, [p for p in map(sp.expand, rest) if p != 0])
        return None
    return statement
