"""The search for wrong verdicts on roots and on special values, which mpmath judges.

Each statement says that two formulas are one function on a domain: products of nested roots under
the rules that hold on some branches only, Bessel functions of half an order and of -v, W, Jacobi
functions at the ends of their parameter and beyond 1, conjugates and moduli; some with one sign
wrong.  A formula is drawn as a text together with a function of mpmath, so that the judge shares
nothing with the prover: a statement is false if its sides differ at a drawn point of the domain,
and taken for true if they agree at all of them.  As the prover refutes most false statements before
it tries a proof, the checker is also asked alone: with the proof that is sought for any statement,
and with certificates that are forged, in which one side is said to be the value of the other.

    python -m searches.known_values [--count 1000] [--seed 0] [--undecided]
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from random import Random
from typing import Any

import mpmath

from longwave.verify.kernel import check_certificate
from longwave.verify.kernel.limits import FORMAT, digest
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import decide_statement
from longwave.verify.proof.typed_hints import NO_VERDICT, typed_certificate
from longwave.verify.proof.typed_statement import Statement
from longwave.verify.verdict import Outcome

CONTEXT = mpmath.MPContext()
CONTEXT.dps = 40

POINTS = 60
CLOSE = CONTEXT.mpf(10) ** -25

Point = Mapping[str, Any]

DOMAINS: Mapping[str, tuple[float, float]] = {
    "": (-4, 4),
    "x > 0": (0, 4),
    "x < 0": (-4, 0),
    "-1 < x < 1": (-1, 1),
    "x > 1": (1, 5),
    "x < -1": (-5, -1),
    "x > -1": (-1, 4),
}

PARAMETERS: Mapping[str, tuple[float, float]] = {
    "a: a>0": (0, 3),
    "a: a<0": (-3, 0),
    "a: real": (-3, 3),
    "a: a>1": (1, 4),
    "a: complex": (-3, 3),
}


@dataclass(frozen=True)
class Drawn:
    """A formula as a text and as a function of a point."""

    text: str
    value: Callable[[Point], Any]
    roots: tuple[tuple[str, int], ...] = ()
    """Radicands and degrees of the roots in it, inner ones first."""

    def power(self, p: int, q: int) -> Drawn:
        """Return the principal power to p/q."""
        share = CONTEXT.mpf(p) / q
        roots = (*self.roots, (self.text, q)) if q > 1 else self.roots
        return Drawn(f"({self.text})**({p}/{q})", lambda z: _power(self.value(z), share), roots)

    def __mul__(self, other: Drawn) -> Drawn:
        text, roots = f"({self.text})*({other.text})", self.roots + other.roots
        return Drawn(text, lambda z: self.value(z) * other.value(z), roots)

    def __truediv__(self, other: Drawn) -> Drawn:
        text, roots = f"({self.text})/({other.text})", self.roots + other.roots
        return Drawn(text, lambda z: self.value(z) / other.value(z), roots)

    def __neg__(self) -> Drawn:
        return Drawn(f"-({self.text})", lambda z: -self.value(z), self.roots)


def _power(value: Any, share: Any) -> Any:
    """Return exp(share log value), with the logarithm's cut from above: an imaginary -0 is 0."""
    plain = CONTEXT.mpc(value)
    if abs(plain.imag) < CLOSE * abs(plain):
        plain = CONTEXT.mpc(plain.real, 0)
    return CONTEXT.exp(share * CONTEXT.log(plain))


def named(text: str, function: Callable[[Any, Any], Any]) -> Drawn:
    """Return a text in x and a, with its function of both."""
    return Drawn(text, lambda z: function(z["x"], z["a"]))


BASES: Sequence[Drawn] = [
    named("x", lambda x, _: x),
    named("-x", lambda x, _: -x),
    named("1+x", lambda x, _: 1 + x),
    named("1-x", lambda x, _: 1 - x),
    named("x-1", lambda x, _: x - 1),
    named("a", lambda _, a: a),
    named("a+x", lambda x, a: a + x),
    named("a-x", lambda x, a: a - x),
    named("1+x**2", lambda x, _: 1 + x * x),
    named("2", lambda _, __: CONTEXT.mpf(2)),
    named("x**2", lambda x, _: x * x),
    named("a*x", lambda x, a: a * x),
    named("I*x", lambda x, _: 1j * x),
]


def roots(draw: Random) -> tuple[Drawn, Drawn]:
    """Return roots of products, quotients, powers and roots, and what may be the same."""
    f, g = draw.sample(BASES, 2)
    p, q, r = draw.choice((1, 1, 1, 2, 3)), draw.choice((2, 2, 3, 4)), draw.choice((2, 2, 3))
    rule = draw.randrange(8)
    if rule == 0:
        return f.power(1, q) * g.power(1, q), (f * g).power(1, q)
    if rule == 1:
        return f.power(1, q) / g.power(1, q), (f / g).power(1, q)
    if rule == 2:
        return f.power(p, q).power(1, r), f.power(p, q * r)
    if rule == 3:
        return f.power(r, 1).power(1, q), f.power(r, q)
    if rule == 4:
        return f.power(-1, q), f.power(-1, 1).power(1, q)
    if rule == 5:
        size = Drawn(f"abs({f.text})", lambda z: abs(f.value(z)))
        return f.power(2, 1).power(1, 2), draw.choice((f, -f, size))
    if rule == 6:
        return f.power(1, 2 * q).power(2, 1), f.power(1, q)
    whole = f.power(1, 2) * g.power(1, 4)
    return whole.power(2, 1), f * g.power(1, 2)


def bessel(draw: Random) -> tuple[Drawn, Drawn]:
    """Return orders of half an odd number and of either sign."""
    name = draw.choice("jyik")
    function = getattr(CONTEXT, f"bessel{name}")
    n = draw.choice((-3, -1, 1, 3))
    scale = draw.choice((1, 2))
    z = named(f"{scale}*x", lambda x, _: scale * x)

    def of(text: str, order: Callable[[Point], Any]) -> Drawn:
        full = f"bessel_{name}({text}, {z.text})"
        return Drawn(full, lambda p: function(order(p), CONTEXT.mpc(z.value(p))))

    if draw.random() < 0.35:
        return of("-a", lambda p: -p["a"]), of("a", lambda p: p["a"])
    parts = {
        "j": ("cos", "sin"), "y": ("sin", "-cos"), "i": ("cosh", "sinh"), "k": ("exp", "exp"),
    }[name]  # fmt: skip
    word = parts[int(n > 0)] if draw.random() < 0.8 else draw.choice(("sin", "-cos", "cosh"))
    side, plain = (-1 if word[0] == "-" else 1), word.lstrip("-")
    inner = "-" if plain == "exp" else ""
    factor = "pi/2*" if plain == "exp" else ""
    weight = CONTEXT.pi / 2 if plain == "exp" else 1
    order = 1 if abs(n) == 1 else 3
    tail, more = ("", lambda _: 1)
    if order == 3 and name == "k":
        tail, more = f"*(1 + 1/({z.text}))", lambda w: 1 + 1 / w

    def value(p: Point) -> Any:
        w = CONTEXT.mpc(z.value(p))
        root = _power(w, CONTEXT.mpf(1) / 2) * CONTEXT.sqrt(CONTEXT.pi / 2)
        argument = -w if inner else w
        return side * weight * getattr(CONTEXT, plain)(argument) * more(w) / root

    text = f"{word[: len(word) - len(plain)]}sqrt(2)/(sqrt(pi)*sqrt({z.text}))"
    text += f"*{factor}{plain}({inner}({z.text})){tail}"
    half = CONTEXT.mpf(n) / 2
    return of(f"{n}/2", lambda _: half), Drawn(text, value)


def lambert(draw: Random) -> tuple[Drawn, Drawn]:
    """Return W of z exp(z)."""
    z = draw.choice([BASES[0], BASES[1], BASES[2], BASES[4], BASES[10], BASES[5]])
    left = Drawn(
        f"lambert_w(({z.text})*exp({z.text}))",
        lambda p: CONTEXT.lambertw(z.value(p) * CONTEXT.exp(z.value(p))),
    )
    return left, z


def jacobi(draw: Random) -> tuple[Drawn, Drawn]:
    """Return Jacobi functions at the ends of their parameter, and integrals there."""
    kind, m = draw.choice(("sn", "cn", "dn")), draw.choice((0, 1))
    right = {
        ("sn", 0): "sin", ("cn", 0): "cos", ("sn", 1): "tanh", ("cn", 1): "sech",
        ("dn", 1): "sech", ("dn", 0): "",
    }[kind, m if draw.random() < 0.7 else 1 - m]  # fmt: skip
    z = draw.choice([BASES[0], BASES[2], BASES[6], BASES[11]])
    text = str(m) if draw.random() < 0.5 else f"{m} + a - a"
    left = Drawn(
        f"jacobi_{kind}({z.text}, {text})",
        lambda p: CONTEXT.ellipfun(kind, z.value(p), m=CONTEXT.mpf(m)),
    )
    if not right:
        return left, named("1", lambda _, __: CONTEXT.mpf(1))
    return left, Drawn(f"{right}({z.text})", lambda p: getattr(CONTEXT, right)(z.value(p)))


def conjugates(draw: Random) -> tuple[Drawn, Drawn]:
    """Return conjugates, moduli and parts of a parameter that may be complex."""
    conj = CONTEXT.conj
    known = [
        named("abs(a)**2", lambda _, a: abs(a) ** 2),
        named("a*conjugate(a)", lambda _, a: a * conj(a)),
        named("re(a)**2 + im(a)**2", lambda _, a: a.real**2 + a.imag**2),
        named("a**2", lambda _, a: a * a),
        named("conjugate(a)**2", lambda _, a: conj(a) ** 2),
        named("abs(a**2)", lambda _, a: abs(a * a)),
        named("conjugate(a*exp(I*x))*a*exp(I*x)", lambda _, a: a * conj(a)),
        named("re(a)**2 - im(a)**2", lambda _, a: a.real**2 - a.imag**2),
        named("re(a**2)", lambda _, a: (a * a).real),
        named("a**2/sign(a)**2", lambda _, a: abs(a) ** 2),
    ]
    left, right = draw.sample(known, 2)
    return left, right


KINDS: Sequence[Callable[[Random], tuple[Drawn, Drawn]]] = (
    roots, roots, bessel, lambert, jacobi, conjugates,
)  # fmt: skip


@dataclass(frozen=True)
class KnownValue:
    """A statement, with the points of its domain."""

    kind: str
    left: Drawn
    right: Drawn
    parameter: str
    domain: str

    def points(self, draw: Random) -> list[Point]:
        """Return points of the domain."""
        found: list[Point] = []
        for _ in range(POINTS):
            ends = DOMAINS[self.domain], PARAMETERS[self.parameter]
            x, a = (CONTEXT.mpf(draw.uniform(*pair)) for pair in ends)
            turned = self.parameter.endswith("complex")
            imaginary = CONTEXT.mpf(draw.uniform(-3, 3)) if turned and draw.random() < 0.5 else 0
            found.append({"x": x, "a": CONTEXT.mpc(a, imaginary)})
        return found

    def is_true(self, draw: Random) -> bool:
        """Return whether the sides agree at all points at which both have values."""
        for point in self.points(draw):
            with suppress(ZeroDivisionError, ValueError, CONTEXT.NoConvergence):
                left, right = self.left.value(point), self.right.value(point)
                if abs(left - right) > CLOSE * (1 + abs(left)):
                    return False
        return True

    def statement(self) -> Statement:
        """Return the statement in text."""
        texts = self.left.text + self.right.text
        return read_statement(
            f"u - ({self.right.text})",
            f"u = {self.left.text} + 0*x",
            self.parameter if re.search(r"\ba\b", texts) else "",
            self.domain,
        )

    def is_accepted(self, statement: Statement) -> bool:
        """Return whether the checker accepts it in a way that looks for no point."""
        with suppress(*NO_VERDICT):
            typed_certificate(statement, 1)
            return True
        for data in (self.forged(self.left, self.right), self.forged(self.right, self.left)):
            with suppress(ValueError):
                check_certificate(data)
                return True
        return False

    def forged(self, root: Drawn, value: Drawn) -> dict[str, Any]:
        """Return a certificate that states that ``root``, which is no generator, is ``value``."""
        generators, values = ["x", "a", "I", "exp(x)"], [(root.text, value.text)]
        if self.parameter.endswith("complex"):
            generators.insert(2, "conjugate(a)")
        roots = dict.fromkeys((*value.roots, *root.roots[:-1]))
        for base in dict.fromkeys(base for base, _ in roots):
            degrees = [degree for other, degree in roots if other == base]
            finest = f"({base})**(1/{lcm(*degrees)})"
            generators.append(finest)
            values += [
                (f"({base})**(1/{n})", f"({finest})**{lcm(*degrees) // n}")
                for n in degrees
                if n != lcm(*degrees)
            ]
        formulas = [*generators, *(text for pair in values for text in pair)]
        first = len(generators)
        low, high = DOMAINS[self.domain]
        point = [[0, str(Fraction(low + high) / 2 + Fraction(1, 7))]]
        point += [[1, str(Fraction(sum(PARAMETERS[self.parameter])) / 2 + Fraction(1, 9))]]
        body: dict[str, Any] = {"format": FORMAT, "name": "forged"}
        body["statement"] = {
            "variables": ["x"],
            "equations": [f"u - ({value.text})"],
            "solutions": [f"u = {root.text} + 0*x"],
            "parameters": [self.parameter],
            "domain": [self.domain] if self.domain else [],
        }
        body["proof"] = {
            "formulas": formulas,
            "generators": [["atom", place] for place in range(first)],
            "values": [[first + 2 * n, first + 2 * n + 1] for n in range(len(values))],
            "signs": [],
            "parts": [],
            "point": point,
        }
        return {**body, "digest": digest(body)}


def statement_of(draw: Random) -> KnownValue:
    """Return a random statement."""
    kind = draw.choice(KINDS)
    left, right = kind(draw)
    if draw.random() < 0.15:
        right = -right
    parameter, domain = draw.choice([*PARAMETERS]), draw.choice([*DOMAINS])
    return KnownValue(kind.__name__, left, right, parameter, domain)


def search(count: int, seed: int) -> tuple[Counter[tuple[str, str, str]], list[str], list[str]]:
    """Return verdicts by kind and truth, lines for wrong ones, and lines for open true ones."""
    counts, wrong, left_open = Counter[tuple[str, str, str]](), list[str](), list[str]()
    for number in range(count):
        draw = Random(f"known values {seed} {number}")
        drawn = statement_of(draw)
        true = drawn.is_true(draw)
        try:
            statement = drawn.statement()
            verdict = decide_statement(statement)
        except ValueError as error:
            counts[drawn.kind, "refused", str(error)[:40]] += 1
            continue
        outcome, detail = verdict.outcome, verdict.detail
        counts[drawn.kind, "true" if true else "false", outcome.value] += 1
        text = f"u = {drawn.left.text}, u - ({drawn.right.text}), {drawn.parameter}"
        line = f"{seed} {number}: {outcome.value} {text}, {drawn.domain}: {detail}"
        if outcome is (Outcome.REFUTED if true else Outcome.PROVED):
            wrong.append(line)
        if true and outcome is Outcome.UNDECIDED:
            left_open.append(line)
        accepted = drawn.is_accepted(statement)
        counts[drawn.kind, "true" if true else "false", f"checker {accepted}"] += 1
        if accepted and not true:
            wrong.append(f"ACCEPTED {line}")
    return counts, wrong, left_open


def main() -> int:
    """Print the counts and every wrong verdict; 1 if there is any."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--undecided", action="store_true")
    options = parser.parse_args()
    counts, wrong, left_open = search(options.count, options.seed)
    for (kind, truth, outcome), number in sorted(counts.items()):
        print(f"{kind:12} {truth:8} {outcome:12} {number}")
    print(f"{options.count} statements, {len(wrong)} wrong verdicts", *wrong, sep="\n")
    if options.undecided:
        print(*left_open, sep="\n")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
