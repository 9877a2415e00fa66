"""The axioms in numbers: what the checker derives lies in the balls of what it stands for."""

import random
from collections.abc import Iterator

import pytest
from flint import acb, arb, ctx, fmpq

from longwave.verify.kernel.axioms import FUNCTIONS
from longwave.verify.kernel.bounds import Interval, of_constant
from longwave.verify.kernel.field import Field, Hints
from longwave.verify.kernel.inverse_rules import PRINCIPAL
from longwave.verify.kernel.node_balls import BITS, Balls
from longwave.verify.kernel.nodes import Nodes
from longwave.verify.kernel.reading import Scope, axiom, formula
from longwave.verify.kernel.statement import Substitution
from longwave.verify.kernel.table import RULES

INVERSE = [name for name in PRINCIPAL if FUNCTIONS[name].definition]
UNARY = ("sin", "cos", "tanh", "sech", "cosh", "exp", "Abs", "sinh", "atan")


def numbers(draw: random.Random) -> fmpq:
    return fmpq(draw.randint(-40, 40), draw.randint(1, 9))


@pytest.mark.parametrize("name", INVERSE)
def test_an_inverse_function_is_its_definition_off_the_cuts(name: str) -> None:
    draw = random.Random(1)
    for _ in range(60):
        nodes = Nodes()
        x, y = (nodes.add("symbol", letter, "real") for letter in "xy")
        f = nodes.add("Add", x, nodes.add("Mul", nodes.add("I"), y))
        point = {x: numbers(draw) / 4, y: numbers(draw) / 7}
        if point[y] == 0:
            continue
        own, defined = nodes.add(name, f), axiom(nodes, FUNCTIONS[name].definition, z=f)
        with ctx.workprec(BITS):
            balls = Balls(nodes, point)
            gap = balls.ball(own) - balls.ball(defined)
            assert gap.contains(0)
            assert gap.rad() < 1e-60


@pytest.mark.parametrize("name", INVERSE)
def test_an_inverse_function_is_its_definition_where_it_is_real(name: str) -> None:
    low, high = FUNCTIONS[name].between
    for share in (fmpq(1, 7), fmpq(1, 2), fmpq(8, 9)):
        nodes = Nodes()
        x = nodes.add("symbol", "x", "real")
        end = fmpq(9) if high is None else high
        value = share * end + (1 - share) * (fmpq(-9) if low is None else low)
        balls = Balls(nodes, {x: value})
        own, defined = nodes.add(name, x), axiom(nodes, FUNCTIONS[name].definition, z=x)
        with ctx.workprec(BITS):
            assert (balls.ball(own) - balls.ball(defined)).contains(0)
            assert balls.ball(own).imag.contains(0)


def grown(nodes: Nodes, leaves: list[int], draw: random.Random, depth: int) -> int:
    """A random real formula."""
    if depth == 0:
        return draw.choice([*leaves, nodes.add("number", numbers(draw))])
    kind = draw.randrange(5)
    parts = [grown(nodes, leaves, draw, depth - 1) for _ in range(2)]
    if kind == 0:
        return nodes.add("Add", *parts)
    if kind == 1:
        return nodes.add("Mul", *parts)
    if kind == 2:
        return nodes.add("Pow", parts[0], fmpq(draw.choice((2, 3, 4, -1, -2))))
    if kind == 3:
        half = draw.choice((fmpq(1, 2), fmpq(-1, 2), fmpq(3, 2)))
        return nodes.add("Pow", nodes.add("Pow", parts[0], fmpq(2)), half)
    return nodes.add(draw.choice(UNARY), parts[0])


def domains(nodes: Nodes, draw: random.Random) -> Iterator[tuple[int, fmpq, fmpq, bool]]:
    for letter in "xyz":
        low = numbers(draw)
        high = low + fmpq(draw.randint(1, 30), draw.randint(1, 9))
        yield nodes.add("symbol", letter, "real"), low, high, draw.random() < 0.5


def test_bounds_hold_at_random_points_of_random_formulas() -> None:
    draw, narrow = random.Random(5), 0
    for _ in range(400):
        nodes, positive, ends = Nodes(), {}, []
        for symbol, low, high, weak in domains(nodes, draw):
            minus = nodes.add("Mul", nodes.rational(-1), symbol)
            above = nodes.add("Add", symbol, nodes.add("number", -low))
            below = nodes.add("Add", minus, nodes.add("number", high))
            positive |= {above: weak, below: weak}
            ends.append((symbol, low, high))
        field = Field(nodes, len(ends), [], positive, Hints({}, {}), RULES)
        for symbol, _, _ in ends:
            field.register(symbol)
        signs = field.signs
        formula = grown(nodes, [symbol for symbol, _, _ in ends], draw, 3)
        found = signs.interval(formula)
        narrow += found != Interval()
        for share in (fmpq(1, 10**9), fmpq(1, 3), fmpq(1, 2), 1 - fmpq(1, 10**9)):
            shares = [share if draw.random() < 0.7 else 1 - share for _ in ends]
            point = {s: a + r * (b - a) for (s, a, b), r in zip(ends, shares, strict=True)}
            ball = Balls(nodes, point).ball(formula)
            if not ball.is_finite():
                continue
            with ctx.workprec(BITS):
                assert not contradicted(found, ball.real), (nodes.all[formula], found, ball)
                assert not (found.is_positive and ball.real <= 0)
                assert not ((-found).is_positive and ball.real >= 0)
    assert narrow > 150


def contradicted(found: Interval, value: arb) -> bool:
    """Whether a ball lies outside of an interval."""
    below = found.low is not None and (value < arb(found.low))
    above = found.high is not None and (value > arb(found.high))
    return bool(below or above)


def test_open_ends_are_kept_through_products_and_powers() -> None:
    one, half = Interval(fmpq(0), fmpq(1), True, True), Interval(fmpq(-1), fmpq(1), False, True)
    assert one * one == one
    assert half.power(2) == Interval(fmpq(0), fmpq(1))
    assert (one.inverse().low, one.inverse().low_open, one.inverse().high) == (1, True, None)
    assert (one + Interval(fmpq(-1), fmpq(-1))).is_positive is False
    assert Interval(fmpq(0), fmpq(1)) * one == Interval(fmpq(0), fmpq(1), False, True)
    assert half.inverse() == Interval()
    assert half.power(22) == Interval(fmpq(0))
    assert of_constant(arb("inf")) == Interval()
    assert of_constant(arb(2)) == Interval(fmpq(2), fmpq(2))
    assert (one * half) == Interval(fmpq(-1), fmpq(1), True, True)


def read(text: str, domain: list[str]) -> Interval:
    """Where a formula in the real symbol s lies on a domain."""
    scope = Scope(Nodes())
    gaps = {formula(scope, gap.removesuffix("=")): gap.endswith("=") for gap in domain}
    field = Field(scope.nodes, 1, [], gaps, Hints({}, {}), RULES)
    field.register(formula(scope, "s"))
    return field.signs.interval(formula(scope, text))


@pytest.mark.parametrize(
    ("gap", "expected"),
    [
        ("s", Interval(fmpq(0), None, True)),
        ("-s=", Interval(None, fmpq(0))),
        ("s + 3", Interval(fmpq(-3), None, True)),
        ("3 - s", Interval(None, fmpq(3), False, True)),
        ("6 - 2*s", Interval(None, fmpq(3), False, True)),
        ("s - s", Interval()),
        ("s**2", Interval()),
        ("(-1)*(-1)*s", Interval(fmpq(0), None, True)),  # was read as s < 0
        ("s*(-1)*(-1)*(-1)", Interval(None, fmpq(0), False, True)),
    ],
)
def test_what_an_inequality_says_of_a_symbol(gap: str, expected: Interval) -> None:
    assert read("s", [gap]) == expected


def test_a_shifted_formula_has_the_values_of_the_formula_at_the_shifted_place() -> None:
    draw = random.Random(3)
    for _ in range(60):
        nodes = Nodes()
        n, t = nodes.add("symbol", "n", "integer"), nodes.add("symbol", "t", "real")
        formula = grown(nodes, [n, t], draw, 3)
        put = Substitution(nodes, [n, t], [formula])
        for step in (-2, 0, 1, 3):
            node = put(nodes.add("sin", nodes.add("unknown", 0, (step, 0))))
            here = {n: fmpq(2), t: fmpq(5, 7)}
            there = {n: fmpq(2 + step), t: fmpq(5, 7)}
            value = Balls(nodes, here).ball(node)
            expected = Balls(nodes, there).ball(formula)
            if expected.is_finite():
                assert (value - expected.sin()).contains(0)
                assert value.overlaps(acb(expected.sin()))
