"""Where a variable or parameter lives: a real interval, from its assumptions and what is stated.

Sampled points cover the whole of the domains: both signs, every size, near the ends; the same for a
seed.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice

import sympy as sp

from solutions.exact import shown
from solutions.parameter import Bound
from solutions.record import ClosedForm


@dataclass(frozen=True)
class Domain:
    """The real numbers between two ends, perhaps without 0 or only its integers.

    An end is a rational number, infinite, or a formula in other symbols (``elliptic_k(k**2)``);
    an infinite end is open.

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
        """Raise TypeError for an end that is no SymPy expression; text is not evaluated."""
        for end in (self.lower, self.upper):
            if not isinstance(end, sp.Expr):
                raise TypeError(
                    f"ends of domains must be SymPy expressions, got {shown(end)} "
                    "(such as sympy.Rational(1, 2))"
                )

    def text(self, symbol: sp.Symbol) -> str:
        """The domain in words, of ``symbol``."""
        left = "" if self.lower == -sp.oo else f"{self.lower} {'<' if self.lower_open else '<='} "
        right = "" if self.upper == sp.oo else f" {'<' if self.upper_open else '<='} {self.upper}"
        kind = "integer" if self.integer else "real"
        words = f"{left}{symbol}{right}" if left or right else f"{symbol} {kind}"
        words += ", integer" if self.integer and (left or right) else ""
        return f"{words}, {symbol} != 0" if self.nonzero else words

    def ends(self, values: Mapping[sp.Symbol, sp.Expr]) -> tuple[sp.Expr, sp.Expr]:
        """Both ends, with ``values`` for the symbols that they contain."""
        if not self.lower.is_Atom or not self.upper.is_Atom:
            return self.lower.xreplace(dict(values)), self.upper.xreplace(dict(values))
        return values.get(self.lower, self.lower), values.get(self.upper, self.upper)

    def contains(self, value: sp.Rational, values: Mapping[sp.Symbol, sp.Expr]) -> bool:
        """Whether ``value`` lies inside, the other symbols having ``values``."""
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
        """The common part; of two ends that cannot be compared, that of ``other``."""
        lower, lower_open = _inner(
            (self.lower, self.lower_open), (other.lower, other.lower_open), side=1
        )
        upper, upper_open = _inner(
            (self.upper, self.upper_open), (other.upper, other.upper_open), side=-1
        )
        nonzero, integer = self.nonzero or other.nonzero, self.integer or other.integer
        return Domain(lower, upper, lower_open, upper_open, nonzero, integer)


REAL = Domain()
POSITIVE = Domain(lower=sp.S.Zero)
NEGATIVE = Domain(upper=sp.S.Zero)

HARMLESS = {"commutative", "extended_real", "hermitian", "imaginary", "finite", "infinite"}
"""What may be assumed of a symbol that is then taken to be real."""

KINDS_OF_INTEGERS = ("even", "odd", "prime", "composite")

Domains = Mapping[sp.Symbol, Domain]
Point = Mapping[sp.Symbol, sp.Rational]
End = tuple[sp.Expr, bool]


def assumed_domain(symbol: sp.Symbol) -> Domain:
    """What SymPy's assumptions say of ``symbol``; without any it is real.

    Raises ValueError for a symbol that is declared complex or not real, and for one of which more
    is assumed than a domain can say.

    >>> assumed_domain(sp.Symbol("q", nonnegative=True)).text("q")
    '0 <= q'
    """
    if symbol.is_real is False or (symbol.assumptions0.get("complex") and symbol.is_real is None):
        raise ValueError(
            f"symbols must be real, got {symbol} that is declared complex or not real "
            "(write it as a + I*b with real a and b)"
        )
    _check_assumptions(symbol)
    low = sp.S.Zero if symbol.is_nonnegative else sp.S.NegativeInfinity
    high = sp.S.Zero if symbol.is_nonpositive else sp.S.Infinity
    excluded = bool(symbol.is_nonzero)
    inside = low == 0 or high == 0
    return Domain(
        low,
        high,
        lower_open=low != 0 or excluded,
        upper_open=high != 0 or excluded,
        nonzero=excluded and not inside,
        integer=bool(symbol.is_integer),
    )


def settled_domains(
    symbols: Iterable[sp.Symbol], stated: Mapping[sp.Symbol, Domain | sp.Interval]
) -> dict[sp.Symbol, Domain]:
    """The domain of each symbol: what is assumed and what is stated, both.

    Raises TypeError for what is no symbol, ValueError for two symbols of one name, a stated
    domain of a symbol that is not among them or occurs in a cycle of ends, and for a domain
    without an inner point.
    """
    everything = set(symbols)
    for symbol in (*everything, *stated):
        if not isinstance(symbol, sp.Symbol):
            raise TypeError(f"symbols must be sympy.Symbol, got {shown(symbol)} (make it one)")
    intervals = {symbol: as_domain(domain) for symbol, domain in stated.items()}
    for symbol in list(everything):
        everything |= intervals[symbol].symbols if symbol in intervals else set()
    found = {symbol: assumed_domain(symbol) for symbol in sorted(everything, key=str)}
    names = [symbol.name for symbol in found]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"symbols must differ in name, got two called {name} (rename one)")
    by_name = {symbol.name: symbol for symbol in found}
    for symbol, domain in intervals.items():
        own = by_name.get(symbol.name)
        if own is not None:
            found[own] = found[own] & assumed_domain(symbol) & domain
    for symbol, domain in found.items():
        _check_inner_point(symbol, domain)
    in_order(found)
    return found


def as_domain(domain: Domain | sp.Interval) -> Domain:
    """A domain given as one, or as SymPy's interval.

    >>> as_domain(sp.Interval.open(0, 1)).text("k")
    '0 < k < 1'
    """
    if isinstance(domain, Domain):
        return domain
    if isinstance(domain, sp.Interval):
        return Domain(domain.start, domain.end, bool(domain.left_open), bool(domain.right_open))
    raise ValueError(
        f"domains must be intervals, got {shown(domain)} (such as sympy.Interval.open(0, 1))"
    )


def form_domains(form: ClosedForm) -> dict[sp.Symbol, Domain]:
    """The domains of the parameters of a closed form, from its record.

    >>> from solutions import closed_form
    >>> {str(s): d.text(s) for s, d in form_domains(closed_form("wave_cn")).items()}
    {'k': '0 < k < 1'}
    """
    return {
        parameter.symbol: _between(parameter.lower, parameter.upper)
        for parameter in form.parameters
    }


def in_order(domains: Domains) -> list[sp.Symbol]:
    """The symbols, each after those that its ends contain; raises ValueError for a cycle."""
    ordered: list[sp.Symbol] = []
    waiting = list(domains)
    while waiting:
        ready = [s for s in waiting if not domains[s].symbols & set(waiting)]
        if not ready:
            raise ValueError(f"ends must not depend on each other, got those of {waiting}")
        ordered += ready
        waiting = [s for s in waiting if s not in ready]
    return ordered


def _between(lower: Bound | None, upper: Bound | None) -> Domain:
    return Domain(
        -sp.oo if lower is None else lower.value,
        sp.oo if upper is None else upper.value,
        lower is None or lower.is_open,
        upper is None or upper.is_open,
    )


def _check_assumptions(symbol: sp.Symbol) -> None:
    """Raise ValueError where samples would leave what is assumed of ``symbol``."""
    assumed = dict(symbol.assumptions0)
    if symbol.is_real is None:
        beyond = sorted(assumed.keys() - HARMLESS)
    else:
        counted = symbol.is_integer and symbol.is_positive
        beyond = [k for k in KINDS_OF_INTEGERS if assumed.get(k) or (counted and k in assumed)]
    if beyond:
        raise ValueError(
            f"symbols must be real, integer or of one sign, got {symbol} with {beyond[0]} = "
            f"{assumed[beyond[0]]} (write an even one as 2*n, an extended one as positive)"
        )


def _inner(left: End, right: End, side: int) -> End:
    """The end further inside; of equal ones the open one."""
    if left[0] == right[0]:
        return left[0], left[1] or right[1]
    if left[0] in (sp.oo, -sp.oo):
        return right
    if right[0] in (sp.oo, -sp.oo):
        return left
    closer = side * (left[0] - right[0])
    return left if closer.is_positive else right


def _check_inner_point(symbol: sp.Symbol, domain: Domain) -> None:
    for end in (domain.lower, domain.upper):
        if not (end.is_Rational or end in (sp.oo, -sp.oo) or end.free_symbols):
            raise ValueError(
                f"ends of domains must be rational or infinite, got {end} for {symbol} "
                "(take a rational number inside)"
            )
    if domain.symbols:
        return
    if not domain.lower < domain.upper:
        raise ValueError(
            f"domains must hold more than one point, got {domain.text(symbol)} "
            f"(put the value in place of {symbol})"
        )


DENOMINATORS = (1009, 2147483647, 65537, 1009)
"""Primes, so that no drawn value is a common fraction, and no one multiple of all is whole."""

SIZES = (1, 1, 1, 4, 4, sp.Rational(1, 30), 30, sp.Rational(1, 1000), 1000)
"""Scales of what is drawn from a domain without end; most are moderate, where balls stay narrow."""

MARGINS = (sp.Rational(1, 20),) * 3 + (sp.Rational(1, 1000), sp.Rational(1, 10**6))
"""Shares of a bounded domain that are left out at its ends."""

SLIVER, EVERY = sp.Rational(1, 10**31), 4
"""Every so manieth point lies that near to an end of one symbol's domain."""

REJECTIONS = 1000
"""Points in a row outside the domains, after which these are taken to be empty."""

SIGN_PATTERNS = 5
"""Symbols whose signs are combined in all ways before they are drawn."""


def sample(domains: Domains, count: int, seed: int = 0) -> tuple[Point, ...]:
    """``count`` points of the domains; the first ones combine the signs that the symbols can have.

    The first point has moderate values; the signs come before the sizes.
    """
    return tuple(islice(points(domains, seed), count))


def points(domains: Domains, seed: int = 0) -> Iterator[Point]:
    """Points of the domains without end; raises ValueError if none is found in them."""
    draw = random.Random(seed)
    ordered = in_order(domains)
    signed = [s for s in ordered if _has_both_signs(domains[s])][:SIGN_PATTERNS]
    number = rejected = 0
    while rejected < REJECTIONS:
        signs = {s: -1 if number >> place & 1 else 1 for place, s in enumerate(signed)}
        early = number < 2 ** len(signed)
        point: dict[sp.Symbol, sp.Rational] = {}
        edges = ordered if not early and number % EVERY == 0 else []
        edge = edges[number // EVERY % len(edges)] if edges else None
        for symbol in ordered:
            size = sp.S.One if early else draw.choice(SIZES)
            margin = MARGINS[0] if early else draw.choice(MARGINS)
            sign = signs.get(symbol, 1) if early else draw.choice((1, -1))
            if symbol == edge:
                size, margin, sign = SLIVER, SLIVER, 1
            point[symbol] = _value(domains[symbol], point, size * sign, margin, draw)
        number += 1
        if all(domains[s].contains(value, point) for s, value in point.items()):
            rejected = 0
            yield point
        else:
            rejected += 1
    words = ", ".join(domain.text(symbol) for symbol, domain in domains.items())
    raise ValueError(f"domains must hold rational points, got {words} (none was found)")


def _has_both_signs(domain: Domain) -> bool:
    return bool(domain.lower == -sp.oo and (domain.upper == sp.oo or domain.upper.is_positive)) or (
        bool(domain.upper == sp.oo and domain.lower.is_negative)
    )


def _value(
    domain: Domain,
    known: Mapping[sp.Symbol, sp.Rational],
    size: sp.Rational,
    margin: sp.Rational,
    draw: random.Random,
) -> sp.Rational:
    """A value of the domain: a share of a bounded one, a length from the end of another."""
    lower, upper = (_rational(end) for end in domain.ends(known))
    prime = draw.choice(DENOMINATORS)
    share = sp.Rational(draw.randint(1, prime - 1), prime)
    if lower is None:
        value = size * share if upper is None else upper - _length(-upper, size) * share
    elif upper is None:
        value = lower + _length(lower, size) * share
    else:
        edge = margin * (upper - lower)
        value = lower + edge + (upper - lower - 2 * edge) * share
        if margin < MARGINS[0]:
            near = edge * (1 + share)
            value = draw.choice((value, lower + near, upper - near))
    if not domain.integer:
        return sp.Rational(value)
    return sp.Integer(draw.randint(-9, 9) + int(value) if abs(value) <= 9 else int(value))


def _length(end: sp.Rational, size: sp.Rational) -> sp.Rational:
    """How far to go from an end; twice as far as 0 where that is inside and for both signs."""
    return abs(size) if size > 0 or end >= 0 else -2 * end


def _rational(end: sp.Expr) -> sp.Rational | None:
    """A rational number close to a finite end; the margin covers the difference.

    Raises ValueError for an end that is not real.
    """
    if end in (sp.oo, -sp.oo):
        return None
    if end.is_Rational:
        return end
    number = sp.N(end, 20)
    if not number.is_Float:
        raise ValueError(
            f"ends of domains must be real, got {end} (state where what it contains makes it so)"
        )
    return sp.Rational(str(number))
