"""Restrictions on constants in addition to their domains: reduce them, or write them as domains."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from longwave.derive.algebra.formula_printing import formula_as_text

from .domain_signs import DomainSigns
from .domains import REAL, Domain, Domains, in_order
from .explicit_values import tidy
from .factors import factors_of
from .typed_statement import Statement

SIMPLIFICATION_PASSES = 3
"""Passes in which restrictions simplify each other."""

LONGEST_SIGNED = 60
"""Most operations of a formula whose sign is sought from the ends of the domains."""


@dataclass(frozen=True)
class Restriction:
    """Condition on ``value`` by its ``relation``: >, >= or != 0, or "real" or "integer"."""

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
        """Return whether the restriction holds; ``value`` must be a number."""
        value, is_real = self.value, bool(self.value.is_real)
        known = {"!=": value != 0, "integer": bool(value.is_integer), "real": is_real}
        if self.relation in known:
            return known[self.relation]
        return is_real and bool(value > 0 if self.relation == ">" else value >= 0)


def realities(value: sp.Expr) -> Iterator[Restriction]:
    """Yield the restrictions that make a value real: radicands of even roots are nonnegative."""
    yield Restriction(value, "real")
    below = factors_of(sp.denom(sp.together(value)))[1]
    for power in _roots_in(value):
        base = tidy(power.base)
        is_below = any(factor in below for factor in factors_of(sp.numer(base))[1])
        yield Restriction(base, ">" if power.exp.is_negative or is_below else ">=")


def _roots_in(value: sp.Expr) -> list[sp.Expr]:
    """Return the roots of even degree whose radicand contains a symbol."""
    powers = (p for p in value.atoms(sp.Pow) if p.exp.is_Rational and p.free_symbols)
    return sorted((p for p in powers if p.exp.q % 2 == 0), key=sp.default_sort_key)


def domain_restrictions(domain: Domain, value: sp.Expr) -> Iterator[Restriction]:
    """Yield the restrictions under which a symbol's value is in its domain."""
    if domain.lower != -sp.oo:
        yield Restriction(tidy(value - domain.lower), ">" if domain.lower_open else ">=")
    if domain.upper != sp.oo:
        yield Restriction(tidy(domain.upper - value), ">" if domain.upper_open else ">=")
    if domain.nonzero:
        yield Restriction(value, "!=")
    if domain.integer:
        yield Restriction(value, "integer")


class KnownSigns:
    """Signs of formulas, from the domains and from restrictions taken to hold."""

    def __init__(self, domains: Domains) -> None:
        self._signs = DomainSigns(domains)
        self._positive: set[sp.Expr] = set()
        self._images, distances = _in_distances(domains)
        self._inner = DomainSigns(distances)

    def take(self, restriction: Restriction) -> None:
        """Take a restriction to hold; for a single factor this fixes the factor's sign."""
        number, factors = factors_of(restriction.value)
        if restriction.relation == ">" and [power for _, power in factors] == [1]:
            self._positive.add(factors[0][0] * sp.sign(number))

    def is_positive(self, value: sp.Expr) -> bool:
        """Return whether a formula is shown to be positive."""
        known = value in self._positive or self._signs.is_positive(value)
        return known or any(map(self._inner.is_positive, self._from_ends(value)))

    def is_nonnegative(self, value: sp.Expr) -> bool:
        """Return whether a formula is shown to be at least 0."""
        known = value in self._positive or self._signs.is_nonnegative(value)
        return known or any(map(self._inner.is_nonnegative, self._from_ends(value)))

    def is_nonzero(self, value: sp.Expr) -> bool:
        """Return whether a formula is shown to be nowhere 0."""
        return self._signs.is_nonzero(value) or any(map(self.is_positive, (value, -value)))

    def implies(self, restriction: Restriction) -> bool:
        """Return whether a restriction is shown to hold."""
        value, relation = restriction.value, restriction.relation
        if relation in ("real", "integer"):
            return self._signs.is_real(value) if relation == "real" else bool(value.is_integer)
        checks = {">": self.is_positive, ">=": self.is_nonnegative, "!=": self.is_nonzero}
        return checks[relation](value)

    def excludes(self, restriction: Restriction) -> bool:
        """Return whether a restriction is shown to hold nowhere."""
        if restriction.relation == ">":
            return self.is_nonnegative(-restriction.value)
        return restriction.relation == ">=" and self.is_positive(-restriction.value)

    def _from_ends(self, value: sp.Expr) -> Iterator[sp.Expr]:
        """Yield a polynomial rewritten in the distances of its symbols from the ends of domains."""
        symbols = value.free_symbols
        if value.count_ops() > LONGEST_SIGNED or not value.is_polynomial(*symbols):
            return
        image = value
        for symbol, distance in self._images.items():
            image = image.xreplace({symbol: distance})
        above, below = sp.fraction(sp.together(image))
        if image != value and self._inner.is_positive(below):
            yield sp.expand(above)


def _in_distances(domains: Domains) -> tuple[dict[sp.Symbol, sp.Expr], dict[sp.Symbol, Domain]]:
    """Return each symbol in terms of its distance from an end, and the distances' domains.

    A symbol comes before those in its ends.  Between two ends the symbol is at the fraction
    p/(1 + p) of the way, with p as its distance.
    """
    images, distances = dict[sp.Symbol, sp.Expr](), dict[sp.Symbol, Domain]()
    for symbol in reversed(in_order(domains)):
        domain, distance = domains[symbol], sp.Dummy("distance", real=True)
        is_closed = domain.upper != sp.oo and not domain.upper_open
        if is_closed or (domain.lower == -sp.oo and domain.upper == sp.oo):
            distances[symbol] = domain
            continue
        is_open = domain.upper_open if domain.lower == -sp.oo else domain.lower_open
        if domain.upper == sp.oo:
            images[symbol] = domain.lower + distance
        elif domain.lower == -sp.oo:
            images[symbol] = domain.upper - distance
        else:
            fraction = distance / (1 + distance)
            images[symbol] = domain.lower + (domain.upper - domain.lower) * fraction
        distances[distance] = Domain(lower=sp.S.Zero, lower_open=is_open)
    return images, distances


def needed(given: Sequence[Restriction], domains: Domains) -> tuple[Restriction, ...] | None:
    """Return the restrictions not implied by the domains or each other; None if contradictory.

    A root is taken as nonnegative; its radicand must have a restriction of its own.

    >>> c, k = sp.symbols("c k")
    >>> known = {c: Domain(lower=sp.S.Zero), k: REAL}
    >>> [r.text for r in needed([Restriction(sp.sqrt(c) * (c - k)), Restriction(c)], known)]
    ['c - k > 0']
    """
    for _ in range(SIMPLIFICATION_PASSES):
        reduced = _once(given, domains)
        if reduced is None or reduced == tuple(given):
            return reduced
        given = sorted(reduced, key=lambda r: len(factors_of(r.value)[1]))
    return tuple(given)


def _once(given: Sequence[Restriction], domains: Domains) -> tuple[Restriction, ...] | None:
    """Return the restrictions, each simplified by the domains and by the earlier ones."""
    powers = sorted({p for r in given for p in _roots_in(r.value)}, key=sp.default_sort_key)
    roots = {p: sp.Dummy("root", real=True) for p in powers}
    signs = DomainSigns(domains)
    known = KnownSigns({**domains, **{roots[p]: _values_of(p, signs) for p in powers}})
    back, bases = {name: p for p, name in roots.items()}, {n: p.base for p, n in roots.items()}
    remaining: dict[Restriction, None] = {}
    waiting = list(given)
    while waiting:
        first = waiting.pop(0)
        for r in _simplified(Restriction(first.value.xreplace(roots), first.relation), known):
            if r.value.is_number:
                if not r.holds():
                    return None
            elif r.value in bases:
                waiting.append(Restriction(tidy(bases[r.value]), r.relation))
            elif known.excludes(r):
                return None
            elif not known.implies(r):
                remaining[Restriction(r.value.xreplace(back), r.relation)] = None
                known.take(r)
    strict = {r.value for r in remaining if r.relation == ">"}
    if any(-value in strict for value in strict):
        return None
    return tuple(r for r in remaining if r.relation == ">" or r.value not in strict)


def _values_of(root: sp.Expr, signs: DomainSigns) -> Domain:
    """Return the domain of a real root; 0 is excluded in a denominator or for a positive base."""
    is_positive = root.exp.is_negative or signs.is_positive(root.base)
    return Domain(lower=sp.S.Zero, lower_open=bool(is_positive))


def _simplified(restriction: Restriction, known: KnownSigns) -> Iterator[Restriction]:
    """Yield the restriction without squares and known signs; ValueError if a factor must be 0."""
    relation = restriction.relation
    if restriction.value.is_number or relation in ("real", "integer"):
        yield restriction
        return
    number, factors = factors_of(restriction.value)
    rest, squares = sp.sign(number), list[sp.Expr]()
    for factor, power in factors:
        if known.is_positive(factor) or (power % 2 == 0 and known.is_nonzero(factor)):
            continue
        if known.is_positive(-factor):
            rest *= (-1) ** power
        elif power % 2 == 0 or relation == "!=":
            if not known.is_nonzero(factor):
                if relation == ">=" and power > 0:
                    squares.append(factor)
                else:
                    yield Restriction(factor, "!=")
        elif relation == ">" and known.is_nonnegative(factor):
            yield Restriction(factor, ">")
        else:
            rest *= factor
    if squares and rest.is_negative:
        raise ValueError(f"values are real only where {squares[0]} = 0")
    if rest.is_number or relation != "!=":
        nonnegative = sp.Mul(*(factor**2 for factor in squares)) if rest.free_symbols else 1
        yield Restriction(sp.expand(nonnegative * rest), relation)


def restricted(statement: Statement, restrictions: Sequence[Restriction]) -> Statement | None:
    """Write the restrictions as domains of the statement; None if domains cannot express them.

    >>> from .statement_text import read_statement
    >>> statement = read_statement("u_t - c*u_x", "u = exp(sqrt(c)*(x + c*t))")
    >>> c = next(s for s in statement.equations[0].free_symbols if s.name == "c")
    >>> restricted(statement, [Restriction(c - 1)]).domains[c].text("c")
    '1 < c'
    """
    domains, texts = dict(statement.domains), statement.texts
    for restriction in restrictions:
        bound = _bound(restriction, DomainSigns(domains))
        if bound is None:
            return None
        symbol, domain = bound
        try:
            domains[symbol] = domains.get(symbol, REAL) & domain
        except ValueError:  # two ends that cannot be compared
            return None
        stated = domain.chain(symbol.name, formula_as_text)
        if stated != symbol.name:
            texts = replace(texts, parameters=(*texts.parameters, f"{symbol.name}: {stated}"))
    return replace(statement, domains=domains, texts=texts) if restrictions else None


def _bound(restriction: Restriction, signs: DomainSigns) -> tuple[sp.Symbol, Domain] | None:
    """Return a symbol that a restriction bounds, and its open domain; None if there is none."""
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
    """Return the zero in ``symbol`` of a linear factor; None if it is not known to have one."""
    if sp.degree(factor, symbol) != 1 or not signs.is_nonzero(factor.coeff(symbol, 1)):
        return None
    return tidy(-factor.coeff(symbol, 0) / factor.coeff(symbol, 1))
