"""Envelopes of carrier waves in closed form, found without this program.

Each entry returns the differing coefficients as text: none where all are symbolically equal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cache

from sympy import Expr, I, Rational, cancel, cos, limit, pi, sin, sqrt, symbols

from longwave.derive import LATTICES, envelope
from longwave.derive.algebra.rational_functions import RationalFunctions
from longwave.derive.carrier import w, z
from longwave.derive.carrier_envelope import Envelope
from longwave.derive.models.lattices import g2, g3
from longwave.derive.sines import omega
from longwave.derive.symbols import K2, K3, K4, k

s, C, tau = symbols("s C tau", real=True)
HALF = {sin(k / 2): s, cos(k / 2): C}
UNIT = {s: 2 * tau / (1 + tau**2), C: (1 - tau**2) / (1 + tau**2)}
STIFFNESS, SPEED = omega**2 / (4 * s**2), omega / (2 * s)
"""K2 and c of the chain, from omega = 2 c s."""

Q = SPEED * s / STIFFNESS * (2 * K3**2 / STIFFNESS * (1 + 1 / s**2) - 3 * K4)

CHAIN = {
    "v": SPEED * C,
    "p": -SPEED * s / 4,
    "q": Q,
    "mean": -2 * K3 / (STIFFNESS * s**2),
    "second": K3 / STIFFNESS * (C / s) ** 2,
    "a3": -SPEED * C / 24,
    "a1": -Q * C / s,
    "a2": C / SPEED**3 * (K3**2 * (1 + 3 / s**2) - Rational(3, 2) * STIFFNESS * K4),
    "detuning": -omega * K3 / STIFFNESS,
}


@cache
def of(name: str) -> Envelope:
    """Return the envelope of a lattice of the catalogue, at all wavenumbers and constants."""
    return envelope(LATTICES[name])


def vanishes(difference: Expr) -> bool:
    """Return whether a rational function of symbols is 0."""
    field = RationalFunctions(tuple(sorted(difference.free_symbols, key=str)))
    return not field.from_expr(difference)


def unlike(found: Mapping[str, Expr], known: Mapping[str, Expr]) -> Iterator[str]:
    """Yield name and found expression where it differs from the known one in omega, s and C."""
    for name, value in known.items():
        if not vanishes((found[name].subs(HALF) - value).subs(UNIT)):
            yield f"{name}: {found[name]}"


def chain() -> Iterator[str]:
    """Yield the differences for the FPUT chain in its strain."""
    yield from unlike(of("fput_strain").expressions, CHAIN)


def third_order() -> Iterator[str]:
    """Yield the differences in the chain's field at eps^3, in A_1 = -i A_X."""
    part = of("fput_strain").carrier
    A, B, A_X, B_X = (0, 0), (0, 1), (1, 0), (1, 1)
    field, mean = part.parts[0].parts[3], part.means[1]
    expected = K3 / STIFFNESS * C / s**3
    turn = {z: (C + I * s) ** 2, w: I * omega}
    for name, element, known in (
        ("A A_1", field.coefficient(A, A_X), I * expected),
        ("A_1 conj A", mean.coefficient(B, A_X), -I * expected),
        ("A conj A_1", mean.coefficient(A, B_X), I * expected),
    ):
        if cancel((element.as_expr().subs(turn) - known).subs(UNIT)) != 0:
            yield f"{name}: {element}"


def displacement() -> Iterator[str]:
    """The same chain in its displacement: A of the strain is 2 i s exp(i k/2) times its A."""
    powers = {"v": 0, "p": 0, "q": 1, "mean": 1, "a3": 0, "detuning": 0}
    known = {name: CHAIN[name] * (4 * s**2) ** power for name, power in powers.items()}
    found = of("fput").expressions
    yield from unlike(found, known)
    both = 4 * s**2 * (CHAIN["a1"] + CHAIN["a2"]) - 4 * s * C * CHAIN["q"]
    yield from unlike({"a1 + a2": found["a1"] + found["a2"]}, {"a1 + a2": both})


def pinned() -> Iterator[str]:
    """Yield the differences for the Klein-Gordon chain."""
    tie = omega**2 - 4 * K2 * s**2
    v = 2 * K2 * s * C / omega
    M = 3 * tie + 16 * K2 * s**4
    p = (K2 * (1 - 2 * s**2) - v**2) / (2 * omega)
    q = -(3 * g3 - 4 * g2**2 / tie + 2 * g2**2 / M) / (2 * omega)
    known = {
        "v": v,
        "p": p,
        "q": q,
        "mean": -2 * g2 / tie,
        "second": g2 / M,
        "a3": -(2 * K2 * s * C + 6 * v * p) / (6 * omega),
        "a2": -q * v / omega,
        "a1": 2 * q * v / omega - 32 * K2 * g2**2 * s**3 * C / (omega * M**2),
    }
    yield from unlike(of("klein_gordon").expressions, known)


def toda() -> Iterator[str]:
    """Yield the differences for Toda's chain in its strain: q = 1/(2 s), p q = -1/8 at all k."""
    values = {K3: STIFFNESS / 2, K4: STIFFNESS / 6}
    found = {n: v.subs(HALF).subs(values) for n, v in of("fput_strain").expressions.items()}
    product = found["p"] * found["q"] / STIFFNESS
    known = {"q": omega / (4 * s**2), "p q": -Rational(1, 8)}
    yield from unlike({**found, "p q": product}, known)


def zone_boundary() -> Iterator[str]:
    """Yield the differences at k = pi."""
    c = omega / 2
    known = {
        **dict.fromkeys(("v", "second", "a3", "a1", "a2"), 0 * c),
        "p": -c / 4,
        "q": c / c**2 * (4 * K3**2 / c**2 - 3 * K4),
    }
    yield from unlike(envelope(LATTICES["fput_strain"], k=pi).expressions, known)


def long_waves() -> Iterator[str]:
    """At small k the coefficients are those of the KdV and the mKdV equation."""
    q = of("fput_strain").expressions["q"].subs(omega, 2 * sqrt(K2) * sin(k / 2))
    for name, value, known in (
        ("KdV", q * k, 4 * K3**2 / K2 ** Rational(3, 2)),
        ("mKdV", q.subs(K3, 0) / k, -3 * K4 / (2 * sqrt(K2))),
    ):
        if cancel(limit(value, k, 0) - known) != 0:
            yield f"{name}: {value}"


KNOWN: dict[str, Callable[[], list[str]]] = {
    name: (lambda check=check: list(check()))
    for name, check in {
        "fput_strain": chain,
        "fput_strain, third order": third_order,
        "fput": displacement,
        "klein_gordon": pinned,
        "toda": toda,
        "fput_strain at k = pi": zone_boundary,
        "fput_strain at small k": long_waves,
    }.items()
}
