"""Values of constants put into a statement: what the domains say of them, and the verdict."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.verify.verdict import Outcome

from .domain_signs import DomainSigns
from .domains import REAL, Domain, settled_domains
from .explicit_values import Explicit, Values, tidy
from .statement_verdict import StatementVerdict, decide_statement
from .typed_statement import Statement, typed_case

ALL = "all values"
"""The case without conditions."""

UNDEFINED = (sp.zoo, sp.nan, sp.oo, -sp.oo)


@dataclass(frozen=True)
class Restriction:
    """``value`` is > 0, >= 0 or != 0, or (``relation`` is a word) it is real or an integer."""

    value: sp.Expr
    relation: str = ">"

    @property
    def text(self) -> str:
        """The restriction in words."""
        if self.relation in ("real", "integer"):
            return f"{formula_as_text(self.value)} is {self.relation}"
        if self.value.could_extract_minus_sign():
            return f"{formula_as_text(-self.value)} {self.relation.replace('>', '<')} 0"
        return f"{formula_as_text(self.value)} {self.relation} 0"

    def holds(self) -> bool:
        """Whether a number meets it."""
        match self.relation:
            case "!=":
                return bool(self.value != 0)
            case "integer":
                return bool(self.value.is_integer)
            case "real":
                return bool(self.value.is_real)
        real = bool(self.value.is_real)
        return real and bool(self.value > 0 if self.relation == ">" else self.value >= 0)


@dataclass(frozen=True)
class ConstantCase:
    """Values of constants with which a ``statement`` holds, and the ``verdict`` on that.

    ``restrictions`` must hold beside the domains; ``implicit`` are polynomials that must vanish.
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
        """Whether the prover has accepted it."""
        return self.verdict is not None and self.verdict.outcome is Outcome.PROVED

    @property
    def refuted(self) -> bool:
        """Whether it is wrong somewhere on its domains."""
        return self.verdict is not None and self.verdict.outcome is Outcome.REFUTED

    @property
    def text(self) -> str:
        """The case in words."""
        parts = [f"{s} = {formula_as_text(value)}" for s, value in self.values.items()]
        parts += [f"{formula_as_text(polynomial)} = 0" for polynomial in self.implicit]
        where = " and ".join(restriction.text for restriction in self.restrictions)
        notes = [*["trivial"] * self.trivial, *["not proved"] * (not self.proved)]
        words = ", ".join(parts) or ALL
        words += f" where {where}" if where else ""
        return words + (f" ({', '.join(notes)})" if notes else "")

    def json(self) -> dict[str, Any]:
        """The record as plain data."""
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


# values put into a statement


def with_values(case: ConstantCase, more: Explicit) -> ConstantCase | None:
    """The case with further values; None where these leave the domains or a formula undefined."""
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
            given += [
                *_reality(value),
                *_restrictions(replace(domain, lower=lower, upper=upper), value),
            ]
            continue
        if lower.is_number and upper.is_number and lower >= upper:
            return None
        if symbol in old.domains:
            domains[symbol] = replace(domain, lower=lower, upper=upper)
    statement = _put_into(old, values, domains)
    if statement is None:
        return None
    restrictions = _needed(given, statement)
    if restrictions is None:
        return None
    return ConstantCase(known, statement, restrictions, (*case.implicit, *more.implicit))


def symbols_of(statement: Statement) -> set[sp.Symbol]:
    """The variables and parameters of a statement."""
    formulas = (*statement.equations, *statement.solutions.values())
    found = {s for formula in formulas for s in formula.free_symbols}
    return found | {s for domain in statement.domains.values() for s in domain.symbols}


def _put_into(
    statement: Statement, values: Values, domains: Mapping[sp.Symbol, Domain]
) -> Statement | None:
    """The statement with values for symbols; None where a formula is not defined."""
    solutions = {u: f.xreplace(values) for u, f in statement.solutions.items()}
    equations = tuple(e.xreplace(values) for e in statement.equations)
    divisors = tuple(d.xreplace(values) for d in statement.divisors)
    if any(f.has(*UNDEFINED) for f in (*solutions.values(), *equations, *divisors)):
        return None
    if any(divisor == 0 for divisor in divisors):
        return None
    written = {symbol.name: formula_as_text(value) for symbol, value in values.items()}
    made = Statement(statement.name, equations, solutions, domains, divisors)
    if statement.texts is None or statement.trees is None:
        return made
    texts, trees = typed_case(statement.texts, statement.trees, written)
    return replace(made, texts=texts, trees=trees)


def _reality(value: sp.Expr) -> Iterator[Restriction]:
    """What makes a value real: no root of even degree of what is negative."""
    yield Restriction(value, "real")
    below = sp.factor_list(sp.denom(sp.together(value)))[1]
    for power in _roots_in(value):
        base = tidy(power.base)
        is_below = any(factor in below for factor in sp.factor_list(sp.numer(base))[1])
        yield Restriction(base, ">" if power.exp.is_negative or is_below else ">=")


def _roots_in(value: sp.Expr) -> list[sp.Expr]:
    """The roots of even degree of formulas."""
    powers = (p for p in value.atoms(sp.Pow) if p.exp.is_Rational and p.free_symbols)
    return sorted((p for p in powers if p.exp.q % 2 == 0), key=sp.default_sort_key)


def _restrictions(domain: Domain, value: sp.Expr) -> Iterator[Restriction]:
    """What a domain says of a value in the place of its symbol."""
    if domain.lower != -sp.oo:
        yield Restriction(tidy(value - domain.lower), ">" if domain.lower_open else ">=")
    if domain.upper != sp.oo:
        yield Restriction(tidy(domain.upper - value), ">" if domain.upper_open else ">=")
    if domain.nonzero:
        yield Restriction(value, "!=")
    if domain.integer:
        yield Restriction(value, "integer")


def _needed(given: Sequence[Restriction], statement: Statement) -> tuple[Restriction, ...] | None:
    """The restrictions that the domains do not imply; None if they exclude one.

    What stands under a root is a restriction of its own, so that the root is not negative.
    """
    powers = {p for r in given for p in _roots_in(r.value)}
    roots = {p: sp.Dummy("root") for p in sorted(powers, key=sp.default_sort_key)}
    domains = dict(settled_domains(symbols_of(statement), statement.domains))
    domains |= {
        name: Domain(lower=sp.S.Zero, lower_open=bool(p.exp.is_negative))
        for p, name in roots.items()
    }
    signs = DomainSigns(domains)
    bases = {name: p.base for p, name in roots.items()}
    kept: dict[Restriction, None] = {}
    waiting = list(given)
    while waiting:
        first = waiting.pop(0)
        for r in _simplified(Restriction(first.value.xreplace(roots), first.relation), signs):
            if r.value.is_number:
                if not r.holds():
                    return None
            elif r.value in bases:
                waiting.append(Restriction(tidy(bases[r.value]), r.relation))
            elif not _is_implied(r, signs):
                excluded = r.relation in (">", ">=") and signs.is_positive(-r.value)
                if excluded or (r.relation == ">" and signs.is_nonpositive(r.value)):
                    return None
                back = {name: p for p, name in roots.items()}
                kept[Restriction(r.value.xreplace(back), r.relation)] = None
    strict = {r.value for r in kept if r.relation == ">"}
    if any(-value in strict for value in strict):
        return None
    return tuple(r for r in kept if r.relation == ">" or r.value not in strict)


def _is_implied(restriction: Restriction, signs: DomainSigns) -> bool:
    match restriction.relation:
        case ">":
            return signs.is_positive(restriction.value)
        case ">=":
            return signs.is_nonnegative(restriction.value)
        case "!=":
            return signs.is_nonzero(restriction.value)
        case "real":
            return signs.is_real(restriction.value)
    return bool(restriction.value.is_integer)


def _simplified(restriction: Restriction, signs: DomainSigns) -> Iterator[Restriction]:
    """The restriction without factors of known sign and without squares.

    Raises ValueError where it holds only at the zeros of a square.
    """
    relation = restriction.relation
    if restriction.value.is_number or relation in ("real", "integer"):
        yield restriction
        return
    above, below = sp.fraction(sp.together(restriction.value))
    rest, squares = sp.S.One, list[sp.Expr]()
    for side, part in ((1, above), (-1, below)):
        number, factors = sp.factor_list(part)
        rest *= sp.sign(number)
        for factor, power in factors:
            if signs.is_positive(factor) or (power % 2 == 0 and signs.is_nonzero(factor)):
                continue
            if signs.is_positive(-factor):
                rest *= (-1) ** power
            elif power % 2 and relation != "!=":
                rest *= factor
            elif not signs.is_nonzero(factor):
                squares.append(factor)
                if relation != ">=" or side < 0:
                    yield Restriction(factor, "!=")
    if relation == ">=" and squares and rest.is_negative:
        raise ValueError(f"values are real only where {squares[0]} = 0")
    if rest.is_number or relation != "!=":
        yield Restriction(sp.expand(rest), relation)


# the verdicts


def largest_cases(cases: Sequence[ConstantCase]) -> list[ConstantCase]:
    """The cases with the prover's verdicts; none that lies in another one that is proved."""
    kept: list[ConstantCase] = []
    for case in sorted(cases, key=lambda c: len(c.values) + len(c.implicit)):
        if not any(_lies_in(case, other) for other in kept):
            kept.append(_decided(case))
    return sorted(kept, key=lambda case: (case.trivial, not case.proved))


def _lies_in(case: ConstantCase, other: ConstantCase) -> bool:
    """Whether the values of a case satisfy those of another one, which is proved."""
    if not other.proved or not set(other.restrictions) <= set(case.restrictions):
        return False
    zeros = [s - value for s, value in other.values.items()]
    zeros += [p for p in other.implicit if p not in case.implicit]
    return all(sp.simplify(zero.xreplace(case.values)) == 0 for zero in zeros)


def _decided(case: ConstantCase) -> ConstantCase:
    """The case with the prover's verdict, with restrictions as domains where they can be."""
    statement = case.statement
    moving = set(statement.variables)
    is_constant = all(not f.free_symbols & moving for f in statement.solutions.values())
    kept = [e for e in statement.equations if e != 0]
    case = replace(case, trivial=is_constant or len(kept) < len(statement.equations))
    explicit = _explicit(statement, case.implicit)
    if explicit is None or not kept:
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
    """The statement with what makes the polynomials 0, where each is linear in a parameter."""
    for place, polynomial in enumerate(implicit):
        for s in sorted(polynomial.free_symbols, key=str):
            slope = polynomial.coeff(s, 1) if sp.degree(polynomial, s) == 1 else sp.S.Zero
            if slope.is_Rational and slope != 0:
                values = {s: sp.expand(s - polynomial / slope)}
                domains = {q: d for q, d in statement.domains.items() if not {q, *d.symbols} & {s}}
                found = _put_into(statement, values, domains)
                rest = [sp.numer(sp.together(p.xreplace(values))) for p in implicit[place + 1 :]]
                return found and _explicit(found, [p for p in map(sp.expand, rest) if p != 0])
        return None
    return statement


def restricted(statement: Statement, restrictions: Sequence[Restriction]) -> Statement | None:
    """The statement on domains that say what the restrictions say; None where these cannot.

    >>> from .statement_text import read_statement
    >>> statement = read_statement("u_t - c*u_x", "u = exp(sqrt(c)*(x + c*t))")
    >>> c = next(s for s in symbols_of(statement) if s.name == "c")
    >>> restricted(statement, [Restriction(c - 1)]).domains[c].text("c")
    '1 < c'
    """
    domains, texts = dict(statement.domains), statement.texts
    for restriction in restrictions:
        bound = _bound(restriction, DomainSigns(domains))
        if bound is None:
            return None
        symbol, domain = bound
        domains[symbol] = domains.get(symbol, REAL) & domain
        stated = domain.chain(symbol.name, formula_as_text)
        if texts is not None and stated != symbol.name:
            texts = replace(texts, parameters=(*texts.parameters, f"{symbol.name}: {stated}"))
    return replace(statement, domains=domains, texts=texts) if restrictions else None


def _bound(restriction: Restriction, signs: DomainSigns) -> tuple[sp.Symbol, Domain] | None:
    """A symbol that a restriction bounds, and where it is then; ends are left out."""
    if restriction.relation == "!=" and restriction.value.is_Symbol:
        return restriction.value, Domain(nonzero=True)
    if restriction.relation not in (">", ">="):
        return None
    above, below = sp.fraction(sp.together(restriction.value))
    value = sp.expand(above if signs.is_positive(below) else above * below)
    for s in sorted(value.free_symbols, key=str):
        if not value.is_polynomial(s):
            continue
        ends = [_end(s, factor, signs) for factor, n in sp.factor_list(value, s)[1] if n % 2]
        if sp.degree(value, s) == 1 and ends[0] is not None:
            slope = value.coeff(s, 1)
            if signs.is_positive(slope):
                return s, Domain(lower=ends[0])
            if signs.is_positive(-slope):
                return s, Domain(upper=ends[0])
        lead = value.coeff(s, 2)
        if sp.degree(value, s) == 2 and len(ends) == 2 and signs.is_positive(-lead):
            for low, high in (ends, ends[::-1]):
                if low is not None and high is not None and signs.is_positive(high - low):
                    return s, Domain(lower=low, upper=high)
    return None


def _end(symbol: sp.Symbol, factor: sp.Expr, signs: DomainSigns) -> sp.Expr | None:
    """Where a linear factor is 0."""
    if sp.degree(factor, symbol) != 1 or not signs.is_nonzero(factor.coeff(symbol, 1)):
        return None
    return tidy(-factor.coeff(symbol, 0) / factor.coeff(symbol, 1))
