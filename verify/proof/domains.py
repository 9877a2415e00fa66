"""Domains of variables and parameters: real intervals from SymPy assumptions and stated bounds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import sympy as sp

from longwave.support.user_files import shown


@dataclass(frozen=True)
class Domain:
    """Real interval between two ends, optionally without 0 or restricted to integers.

    An end is rational, infinite (and open), or a formula in other symbols (``elliptic_k(k**2)``).

    >>> k = sp.Symbol("k")
    >>> Domain(sp.S.Zero, sp.S.One, upper_open=False).text(k)
    '0 < k <= 1'
    >>> Domain().text(k), Domain(nonzero=True, integer=True).text(k)
    ('k real', 'k integer, k != 0')
    """

    lower: sp.Expr = sp.S.NegativeInfinity
    upper: sp.Expr = sp.S.Infinity
    lower_open: bool = True
    upper_open: bool = True
    nonzero: bool = False
    integer: bool = False

    def __post_init__(self) -> None:
        """Raise TypeError for an end that is not a SymPy expression; text is not evaluated."""
        for end in (self.lower, self.upper):
            if not isinstance(end, sp.Expr):
                got = f"{shown(end)} (such as sympy.Rational(1, 2))"
                raise TypeError(f"ends of domains must be SymPy expressions, got {got}")

    def text(self, symbol: sp.Symbol) -> str:
        """Return the domain of ``symbol`` in words."""
        words, kind = self.chain(str(symbol)), "integer" if self.integer else "real"
        if words == str(symbol):
            words += f" {kind}"
        elif self.integer:
            words += ", integer"
        return f"{words}, {symbol} != 0" if self.nonzero else words

    def chain(
        self, name: str, text: Callable[[sp.Expr], str] = str, signs: tuple[str, str] = ("<", "<=")
    ) -> str:
        """Return the inequalities of ``name``, such as ``0 < k <= 1``.

        ``text`` writes the ends, and ``signs`` are those for open and for closed ends."""
        below, above = (signs[not is_open] for is_open in (self.lower_open, self.upper_open))
        left = "" if self.lower == -sp.oo else f"{text(self.lower)} {below} "
        right = "" if self.upper == sp.oo else f" {above} {text(self.upper)}"
        return f"{left}{name}{right}"

    def ends(self, values: Mapping[sp.Symbol, sp.Expr]) -> tuple[sp.Expr, sp.Expr]:
        """Return both ends, with ``values`` substituted for their symbols."""
        return _end_at(self.lower, values), _end_at(self.upper, values)

    def contains(self, value: sp.Rational, values: Mapping[sp.Symbol, sp.Expr]) -> bool:
        """Return whether the domain contains ``value`` if the other symbols have ``values``."""
        lower, upper = self.ends(values)
        above = lower == -sp.oo or (value > lower if self.lower_open else value >= lower)
        below = upper == sp.oo or (value < upper if self.upper_open else value <= upper)
        whole = value.is_Integer or not self.integer
        return bool(above and below and whole and not (self.nonzero and value == 0))

    @property
    def symbols(self) -> set[sp.Symbol]:
        """The symbols that the ends contain."""
        return set(self.lower.free_symbols | self.upper.free_symbols)

    def __and__(self, other: Domain) -> Domain:
        """Return the intersection; raises ValueError for two ends that cannot be compared."""
        lows = (self.lower, self.lower_open), (other.lower, other.lower_open)
        highs = (self.upper, self.upper_open), (other.upper, other.upper_open)
        (lower, lower_open), (upper, upper_open) = _inner(*lows, side=1), _inner(*highs, side=-1)
        nonzero, integer = self.nonzero or other.nonzero, self.integer or other.integer
        return Domain(lower, upper, lower_open, upper_open, nonzero, integer)


END_DIGITS = 60
"""Digits to which a bound of an interval is evaluated numerically if it contains roots."""

REAL = Domain()

HARMLESS = {"commutative", "extended_real", "hermitian", "imaginary", "finite", "infinite"}
"""Assumptions that a symbol not declared real may have and still be taken as real."""

KINDS_OF_INTEGERS = ("even", "odd", "prime", "composite")

Domains = Mapping[sp.Symbol, Domain]
Point = Mapping[sp.Symbol, sp.Rational]


def assumed_domain(symbol: sp.Symbol) -> Domain:
    """Return the domain from a symbol's assumptions; ValueError if a domain cannot express them.

    >>> assumed_domain(sp.Symbol("q", nonnegative=True)).text("q")
    '0 <= q'
    """
    if symbol.is_real is False or (symbol.assumptions0.get("complex") and symbol.is_real is None):
        got = f"{symbol} that is declared complex or not real"
        raise ValueError(f"symbols must be real, got {got} (write it as a + I*b with real a and b)")
    _check_assumptions(symbol)
    low = sp.S.Zero if symbol.is_nonnegative else sp.S.NegativeInfinity
    high = sp.S.Zero if symbol.is_nonpositive else sp.S.Infinity
    excluded = bool(symbol.is_nonzero)
    opens = low != 0 or excluded, high != 0 or excluded
    return Domain(low, high, *opens, excluded and 0 not in (low, high), bool(symbol.is_integer))


def settled_domains(
    symbols: Iterable[sp.Symbol], stated: Mapping[sp.Symbol, Domain | sp.Interval]
) -> dict[sp.Symbol, Domain]:
    """Return the domain of each symbol: its assumed and its stated domain, intersected.

    Raises TypeError for anything but symbols, and ValueError for two symbols of one name, ends
    that cannot be compared or that depend on each other, and a domain without an inner point.
    """
    if not isinstance(stated, Mapping):
        got = f"{shown(stated)} ({{x: sympy.Interval.open(0, 1)}})"
        raise TypeError(f"domains must map symbols to intervals, got {got}")
    everything = set(symbols)
    for symbol in (*everything, *stated):
        if not isinstance(symbol, sp.Symbol):
            raise TypeError(f"symbols must be sympy.Symbol, got {shown(symbol)} (make it one)")
    intervals = {symbol: as_domain(domain) for symbol, domain in stated.items()}
    for symbol in list(everything):
        everything |= intervals[symbol].symbols if symbol in intervals else set()
    domains = {symbol: assumed_domain(symbol) for symbol in sorted(everything, key=str)}
    names = [symbol.name for symbol in domains]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"symbols must differ in name, got two called {name} (rename one)")
    by_name = {symbol.name: symbol for symbol in domains}
    for symbol, domain in intervals.items():
        own = by_name.get(symbol.name)
        if own is not None:
            domains[own] = domains[own] & assumed_domain(symbol) & domain
    for symbol, domain in domains.items():
        _check_inner_point(symbol, domain)
    in_order(domains)
    return domains


def as_domain(domain: Domain | sp.Interval) -> Domain:
    """Return a `Domain` or a SymPy interval as a `Domain`.

    >>> as_domain(sp.Interval.open(0, 1)).text("k")
    '0 < k < 1'
    """
    if isinstance(domain, Domain):
        return domain
    if isinstance(domain, sp.Interval):
        return Domain(domain.start, domain.end, bool(domain.left_open), bool(domain.right_open))
    got = f"{shown(domain)} (such as sympy.Interval.open(0, 1))"
    raise ValueError(f"domains must be intervals, got {got}")


def in_order(domains: Domains) -> list[sp.Symbol]:
    """Return the symbols, each after those in the ends of its domain; ValueError for a cycle."""
    ordered: list[sp.Symbol] = []
    waiting = list(domains)
    while waiting:
        ready = [s for s in waiting if not domains[s].symbols & set(waiting)]
        if not ready:
            raise ValueError(f"ends must not depend on each other, got those of {waiting}")
        ordered += ready
        waiting = [s for s in waiting if s not in ready]
    return ordered


def _check_assumptions(symbol: sp.Symbol) -> None:
    """Raise ValueError for assumptions on ``symbol`` that sampled values would violate."""
    assumed = dict(symbol.assumptions0)
    if symbol.is_real is None:
        beyond = sorted(assumed.keys() - HARMLESS)
    else:
        counted = symbol.is_integer and symbol.is_positive
        beyond = [k for k in KINDS_OF_INTEGERS if assumed.get(k) or (counted and k in assumed)]
    if beyond:
        got = f"{symbol} with {beyond[0]} = {assumed[beyond[0]]}"
        remedy = "write an even one as 2*n, an extended one as positive"
        raise ValueError(f"symbols must be real, integer or of one sign, got {got} ({remedy})")


def _end_at(end: sp.Expr, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Return an end of a domain for these values; with roots it is rounded (SymPy is slow)."""
    if end.is_Atom:
        return values.get(end, end)
    if any(not power.exp.is_Integer for power in end.atoms(sp.Pow)):
        return sp.N(end, END_DIGITS, subs=dict(values))
    return end.xreplace(dict(values))


def _inner(
    left: tuple[sp.Expr, bool], right: tuple[sp.Expr, bool], side: int
) -> tuple[sp.Expr, bool]:
    """Return the tighter of two ends on one side; of equal ends the open one."""
    if left[0] == right[0]:
        return left[0], left[1] or right[1]
    infinite = sp.oo, -sp.oo
    if left[0] in infinite or right[0] in infinite:
        return right if left[0] in infinite else left
    closer = side * (left[0] - right[0])
    if closer.is_nonnegative is None and closer.is_nonpositive is None:
        got = f"{left[0]} and {right[0]} (state one of them as a bound of the other symbol)"
        raise ValueError(f"ends of a domain on one side must be comparable, got {got}")
    return left if closer.is_positive else right


def _check_inner_point(symbol: sp.Symbol, domain: Domain) -> None:
    for end in (domain.lower, domain.upper):
        if not (end.is_extended_real or end.free_symbols):
            got = f"{end} for {symbol} (take a rational number inside)"
            raise ValueError(f"ends of domains must be real or infinite, got {got}")
    if domain.symbols:
        return
    if not domain.lower < domain.upper:
        got = f"{domain.text(symbol)} (put the value in place of {symbol})"
        raise ValueError(f"domains must hold more than one point, got {got}")
