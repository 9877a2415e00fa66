"""Balls of functions against mpmath, and on the other branches of roots and absolute values."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import pytest
from flint import acb, arb, ctx, fmpq

from longwave.verify.kernel import CertificateError, function_values
from longwave.verify.kernel.function_values import generic_shift, jet_ball, weierstrass
from longwave.verify.kernel.node_balls import BITS, Balls, value_at
from longwave.verify.kernel.nodes import Nodes
from longwave.verify.kernel.reading import Scope, formula
from longwave.verify.kernel.ring import Ring

X, Y, V = fmpq(7, 10), fmpq(-3, 8), fmpq(2, 5)
M = mpmath.mpf

FUNCTIONS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "exp(x + I*y)": lambda x, y, v: mpmath.exp(x + 1j * y),
    "log(I*y)": lambda x, y, v: mpmath.log(1j * y),
    "(I*y)**(-2/3)": lambda x, y, v: (1j * y) ** (-M(2) / 3),
    "y**x": lambda x, y, v: mpmath.power(y, x),
    "abs(x + I*y)": lambda x, y, v: abs(x + 1j * y),
    "sign(x + I*y)": lambda x, y, v: mpmath.sign(x + 1j * y),
    "re((x + I*y)**2)": lambda x, y, v: x**2 - y**2,
    "im((x + I*y)**2)": lambda x, y, v: 2 * x * y,
    "conjugate((x + I*y)**2)": lambda x, y, v: (x - 1j * y) ** 2,
    "x*y - pi": lambda x, y, v: x * y - mpmath.pi,
    "(-1)**(3 + 2)": lambda x, y, v: M(-1),
    "erf(x + I*y)": lambda x, y, v: mpmath.erf(x + 1j * y),
    "airy_ai(x)": lambda x, y, v: mpmath.airyai(x),
    "airy_ai_prime(x)": lambda x, y, v: mpmath.airyai(x, derivative=1),
    "airy_bi(x)": lambda x, y, v: mpmath.airybi(x),
    "airy_bi_prime(x)": lambda x, y, v: mpmath.airybi(x, derivative=1),
    "lambert_w(x)": lambda x, y, v: mpmath.lambertw(x),
    "bessel_j(v, x)": lambda x, y, v: mpmath.besselj(v, x),
    "bessel_y(v, x)": lambda x, y, v: mpmath.bessely(v, x),
    "bessel_i(v, x)": lambda x, y, v: mpmath.besseli(v, x),
    "bessel_k(v, x)": lambda x, y, v: mpmath.besselk(v, x),
    "jacobi_theta_1(x, v)": lambda x, y, v: mpmath.jtheta(1, x, v),
    "jacobi_theta_2'(x, v)": lambda x, y, v: mpmath.jtheta(2, x, v, 1),
    "jacobi_theta_3''(x, v)": lambda x, y, v: mpmath.jtheta(3, x, v, 2),
    "jacobi_theta_4(x + I*y, v)": lambda x, y, v: mpmath.jtheta(4, x + 1j * y, v),
    "jacobi_sn(x, v)": lambda x, y, v: mpmath.ellipfun("sn", x, m=v),
    "jacobi_cn(x, v)": lambda x, y, v: mpmath.ellipfun("cn", x, m=v),
    "jacobi_dn(x, y)": lambda x, y, v: mpmath.ellipfun("dn", x, m=y),
    "elliptic_k(v)": lambda x, y, v: mpmath.ellipk(v),
    "elliptic_e(y)": lambda x, y, v: mpmath.ellipe(y),
    "asin(x) + acos(x)": lambda x, y, v: mpmath.pi / 2,
    "atan(x) - asinh(x)": lambda x, y, v: mpmath.atan(x) - mpmath.asinh(x),
}


def read(text: str) -> tuple[Scope, int]:
    scope = Scope(Nodes())
    for letter in "xyv":
        scope.node(letter)
    return scope, formula(scope, text)


@pytest.mark.parametrize("text", FUNCTIONS)
def test_a_ball_is_around_the_value(text: str) -> None:
    scope, node = read(text)
    point = {scope.node(letter): value for letter, value in zip("xyv", (X, Y, V), strict=True)}
    with mpmath.workdps(40):
        numbers = (M(int(value.p)) / int(value.q) for value in (X, Y, V))
        expected = mpmath.mpc(FUNCTIONS[text](*numbers))
        parts = [mpmath.nstr(part, 38, min_fixed=0, max_fixed=0) for part in (
            expected.real, expected.imag
        )]  # fmt: skip
    ball = Balls(scope.nodes, point).ball(node)
    with ctx.workprec(BITS):
        assert ball.rad() < 1e-60
        assert abs(ball - acb(*map(arb, parts))).upper() < 1e-30


@pytest.mark.parametrize("value", [fmpq(-8), fmpq(3), fmpq(-1, 7)])
@pytest.mark.parametrize(("root", "degree"), [("x**(1/3)", 3), ("sqrt(x)", 2), ("x**(4/5)", 5)])
def test_the_branches_of_a_root_are_all_roots(value: fmpq, root: str, degree: int) -> None:
    scope, node = read(root)
    x, power = scope.node("x"), int(scope.nodes.all[node][2].p)
    found = []
    for k in range(degree):
        turned = Balls(scope.nodes, {x: value}, {node: fmpq(k, degree)}, lambda inner: inner)
        found.append(turned.ball(node))
    with ctx.workprec(BITS):
        for one in found:
            assert one.rad() < 1e-60
            assert abs(one**degree - acb(arb(value)) ** power).upper() < 1e-60
        gaps = [abs(a - b) for i, a in enumerate(found) for b in found[:i]]
        assert min(float(gap.lower()) for gap in gaps) > 0.1
        principal = Balls(scope.nodes, {x: value}).ball(node)
        assert any(one.overlaps(principal) for one in found)


def test_conjugates_and_parts_are_continued_by_their_formulas() -> None:
    """For z = x + i y the conjugate is x - i y, whatever a root in it has for a branch."""
    scope, z = read("sqrt(x) + I*x")
    nodes = scope.nodes
    mirrored, root = formula(scope, "sqrt(x) - I*x"), formula(scope, "sqrt(x)")
    point = {scope.node("x"): fmpq(4)}
    with ctx.workprec(BITS):
        size = acb(20).sqrt()
        plain_values = {"re": 2, "im": 4, "conjugate": acb(2, -4), "Abs": size}
        turned = {"re": -2, "im": 4, "conjugate": acb(-2, -4), "Abs": size}
        for name, value in plain_values.items():
            node = nodes.add(name, z)
            plain = Balls(nodes, point).ball(node)
            one = Balls(nodes, point, {root: fmpq(0)}, lambda inner: mirrored).ball(node)
            other = Balls(nodes, point, {root: fmpq(1, 2)}, lambda inner: mirrored).ball(node)
            for ball, expected in ((plain, value), (one, value), (other, turned[name])):
                assert abs(ball - expected).upper() < 1e-60
        modulus, sign = nodes.add("Abs", z), nodes.add("sign", z)
        for share, way in ((fmpq(0), 1), (fmpq(1, 2), -1)):
            balls = Balls(nodes, point, {modulus: share, sign: share}, lambda inner: mirrored)
            assert abs(balls.ball(modulus) - way * size).upper() < 1e-60
            assert abs(balls.ball(sign) - way * acb(2, 4) / size).upper() < 1e-60


def test_a_real_part_is_not_real_on_every_branch() -> None:
    """For z = x**(1/3) + i x, and x**(1/3) = 2 exp(2 i pi/3) at 8, it is this root."""
    scope, z = read("x**(1/3) + I*x")
    mirrored, root = formula(scope, "x**(1/3) - I*x"), formula(scope, "x**(1/3)")
    turned = Balls(
        scope.nodes, {scope.node("x"): fmpq(8)}, {root: fmpq(1, 3)}, lambda inner: mirrored
    )
    with ctx.workprec(BITS):
        for name, value in (("re", acb(-1, acb(3).sqrt().real)), ("im", acb(8))):
            ball = turned.ball(scope.nodes.add(name, z))
            assert abs(ball - value).upper() < 1e-60


def test_a_parity_on_another_branch_is_a_unit() -> None:
    scope = Scope(Nodes())
    n = scope.declare("n", "integer")
    turn = scope.nodes.add("parity", n)
    for k, value in ((0, 1), (1, -1)):
        assert Balls(scope.nodes, {n: fmpq(3)}, {turn: fmpq(k, 2)}).ball(turn).overlaps(acb(value))
    assert Balls(scope.nodes, {n: fmpq(-4)}).ball(turn) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [("z", "the point must have a value of z"), ("diff(x, x)", "a node has no value")],
)
def test_a_node_without_a_value(text: str, message: str) -> None:
    scope, _ = read("x")
    scope.variables = [scope.node("x")]
    node = formula(scope, text)
    with pytest.raises(CertificateError, match=message):
        Balls(scope.nodes, {scope.node("x"): X}).ball(node)


def test_a_polynomial_at_the_values_of_its_generators() -> None:
    x, y, z = Ring(3).generators
    values = [acb(2), acb(0, 3), acb(5)]
    assert value_at(7 * x**3 * y - y**2 * z + fmpq(1, 2), values) == acb("45.5", 168)
    assert value_at(x - x, values) == 0


@pytest.mark.parametrize("place", [1, 2])
def test_the_rest_of_weierstrass_series_is_within_its_bound(
    place: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With g2 = 60 B**2 and g3 = 84 B**3 the first terms are as large as the bound says."""
    with ctx.workprec(BITS):
        bound, z = arb(1), acb(1) / 4
        g2, g3 = acb(60), acb(84)
        whole = function_values._series(z, g2, g3, bound)
        assert all(part.rad() < 1e-80 for part in whole)
        for terms in (4, 5, 8):
            monkeypatch.setattr(function_values, "TERMS", terms)
            part = function_values._series(z, g2, g3, bound)[place - 1]
            assert part.contains(whole[place - 1])
            assert part.real.rad() < 4 * 16.0 ** (1 - terms) * (1, 16 * terms)[place - 1]


def test_the_values_of_weierstrass_function_are_sharp() -> None:
    """The series is taken where its rest is small: 0.35 is halved before, 0.24 is not."""
    with ctx.workprec(BITS):
        for z in (acb("0.24"), acb("0.35")):
            assert all(part.rad() < 1e-90 for part in weierstrass(z, acb(60), acb(0)))


@pytest.mark.parametrize(("g2", "g3"), [(60, 0), (0, 84), (60, 84)])
def test_weierstrass_function_of_large_invariants(g2: int, g3: int) -> None:
    """With z for 10 z, g2 is 10**4 and g3 10**6 times what it was, p is 100 times."""
    with ctx.workprec(BITS):
        z = acb("0.044")
        large, small = (
            weierstrass(z, acb(g2 * 10**4), acb(g3 * 10**6)),
            weierstrass(10 * z, acb(g2), acb(g3)),
        )
        for power, value, other in zip((2, 3), large, small, strict=True):
            assert value.rad() < 1e-80
            assert value.overlaps(other * acb(10) ** power)


def test_weierstrass_function_far_out_and_of_small_invariants() -> None:
    with ctx.workprec(BITS):
        for z in (acb(3e4), acb(1e6), acb(0, 5)):
            value, slope = weierstrass(z, acb(0), acb(0))
            assert abs(value * z**2 - 1).upper() < 1e-30
            assert abs(slope * z**3 + 2).upper() < 1e-30


def test_what_stands_for_any_function_is_one_over_gamma_at_a_shift() -> None:
    assert generic_shift("f") == fmpq(102 % 89, 97)
    with ctx.workprec(BITS):
        z = acb("1.25", "0.5")
        for name in ("f", "gh"):
            moved = z + acb(arb(generic_shift(name)))
            assert jet_ball(z, (name, 0)).overlaps(moved.rgamma())
            slope = -moved.digamma() * moved.rgamma()
            assert abs(jet_ball(z, (name, 1)) - slope).upper() < 1e-60
            step = acb("1e-30")
            for order in (2, 10, 12):  # FLINT's series have 10 terms unless told
                lower = jet_ball(z + step, (name, order - 1)) - jet_ball(z, (name, order - 1))
                assert abs(jet_ball(z, (name, order)) - lower / step).upper() < 1e-20
