"""Functions that are known by their differential equations, in hand-made proofs."""

from typing import Any

import pytest
from flint import acb, acb_series, ctx, fmpq

from longwave.verify.kernel import check_certificate
from longwave.verify.kernel.function_values import jet_ball, theta_ball, weierstrass
from longwave.verify.kernel.node_balls import BITS, Balls
from longwave.verify.kernel.nodes import Nodes
from longwave.verify.kernel.reading import Scope, formula
from longwave.verify.kernel.signs import Signs
from tests.verify.kernel.test_verify_kernel_attacks import certificate, refused

Hints = dict[str, Any]

POINT = {"x": "1/2", "t": "1/3", "v": "2/5", "g": "2", "h": "3/7"}
XT: Hints = {"variables": ["x", "t"], "parameters": ["f: function"]}


def bessel(name: str) -> tuple[str, ...]:
    return ("v", "x", f"bessel_{name}(v, x)", f"bessel_{name}(v + 1, x)")


def towers(argument: str, *names: str, order: int = 4) -> tuple[str, ...]:
    return tuple(f"{name}{chr(39) * n}({argument})" for name in names for n in range(order + 1))


P = ("x", "g", "h", "weierstrass_p(x, g, h)", "weierstrass_p_prime(x, g, h)")
HEAT = ("x", "t", "exp(t)")
NOME = {"exp(-t)": {"t": "-1"}}

TRUE: list[tuple[str, str, str, tuple[str, ...], list[str], Hints]] = [
    # equation, what makes it false, formula, atoms, domain, sums
    *(
        (f"x**2*u_xx + x*u_x + ({sign}x**2 - v**2)*u", "u_x", f"bessel_{name}(v, x)", bessel(name),
         ["x > 0"], {})
        for name, sign in (("j", ""), ("y", ""), ("i", "-"), ("k", "-"))
    ),
    ("x*u - 2*(v + 3)*bessel_j(v + 3, x) + x*bessel_j(v + 2, x)", "u", "bessel_j(v + 4, x)",
     bessel("j"), ["x > 0"], {}),
    ("u - 2*(v - 1)/x*bessel_i(v - 1, x) - bessel_i(v, x)", "u", "bessel_i(v - 2, x)", bessel("i"),
     ["x > 0"], {}),
    ("u + 2*(v - 1)/x*bessel_k(v - 1, x) - bessel_k(v, x)", "u", "bessel_k(v - 2, x)", bessel("k"),
     ["x > 0"], {}),
    ("u - bessel_y(1, x)", "u", "-bessel_y(-1, x)", ("x", "bessel_y(0, x)", "bessel_y(1, x)"), [],
     {}),
    ("u - bessel_j(v, x)", "u", "conjugate(bessel_j(v, x))", bessel("j"), ["x > 0"], {}),
    ("u - bessel_j(3, x)", "u", "conjugate(bessel_j(3, x))",
     ("x", "bessel_j(3, x)"), [], {}),
    ("u_x**2 - 4*u**3 + g*u + h", "u", "weierstrass_p(x, g, h)", P, [], {}),
    ("u_xx - 6*u**2 + g/2", "u", "weierstrass_p(x, g, h)", P, [], {}),
    ("u - weierstrass_p(x, g, h)", "u", "weierstrass_p(-x, g, h)", P, [], {}),
    ("u + weierstrass_p_prime(x, g, h)", "u", "weierstrass_p_prime(-x, g, h)", P, [], {}),
    ("u*conjugate(u) - abs(u)**2", "u", "weierstrass_p(x + I, g, h)",
     ("I", *P[:3], "weierstrass_p(x + I, g, h)", "weierstrass_p(x - I, g, h)"), [], {}),
    *(
        ("u_t - u_xx/4", "u_xx", f"jacobi_theta_{n}(x, exp(-t))",
         (*HEAT, *towers("x, exp(-t)", f"jacobi_theta_{n}")), ["t > 0"], NOME)
        for n in (1, 2, 3, 4)
    ),
    ("u + jacobi_theta_1(x, 1/3)", "u", "jacobi_theta_1(-x, 1/3)", ("x", "jacobi_theta_1(x, 1/3)"),
     [], {}),
    ("u + jacobi_theta_2'(x, 1/3)", "u", "jacobi_theta_2'(-x, 1/3)",
     ("x", "jacobi_theta_2'(x, 1/3)"), [], {}),
    ("u - jacobi_theta_1'''(x, 1/3)", "u", "jacobi_theta_1'''(-x, 1/3)",
     ("x", "jacobi_theta_1'''(x, 1/3)"), [], {}),
    ("u - jacobi_theta_3(x, 1/3)", "u", "conjugate(jacobi_theta_3(x, 1/3))",
     ("x", "jacobi_theta_3(x, 1/3)"), [], {}),
    ("u_t + 3*u_x", "u", "f(x - 3*t)", ("x", "t", *towers("x - 3*t", "f", order=1)), [], {}),
    ("u_t + 3*u_x", "u", "f''(3*t - x)**2/(1 + f(x - 3*t))",
     ("x", "t", *towers("x - 3*t", "f", order=1), *towers("3*t - x", "f", order=3)), [], {}),
    ("u - f(x)", "u", "conjugate(f(x))", ("x", "f(x)"), [], {}),
]  # fmt: skip


@pytest.mark.parametrize("case", TRUE, ids=lambda case: f"{case[2]} {case[0]}")
def test_a_differential_equation(case: tuple[str, str, str, tuple[str, ...], Any, Hints]) -> None:
    equation, change, formula, atoms, domain, sums = case
    point = {name: value for name, value in POINT.items() if name in "xt" or name in atoms}
    for added, right in (("", True), (f" + 1e-40*{change}", False)):
        texts = (equation + added, f"u = {formula}")
        data = certificate(*texts, atoms, point, XT | {"domain": domain}, sums=sums)
        if right:
            assert texts[1] in check_certificate(data)
        else:
            refused(data, "the residual is not 0")


@pytest.mark.parametrize(
    ("formula", "atoms", "domain", "message"),
    [
        ("bessel_j(v, x)", ("x", "v"), [], "no generator for a bessel_j"),
        ("bessel_j(v, x)", ("x", "v", "bessel_j(v + 1/2, x)"), [], "no generator"),
        ("bessel_j(v, x)", ("x", "v", "bessel_j(v + 1, x)"), [], "defined by itself"),
        ("bessel_j(v, x)", ("x", "v", "bessel_j(2*v, x)", "bessel_j(v, 2*x)"), [], "no generator"),
        ("bessel_j(x, x)", ("x", "bessel_j(x, x)"), [], "parameters of bessel_j must be constant"),
        ("weierstrass_p(1, x, 2)", ("x", "weierstrass_p(1, x, 2)"), [], "must be constant"),
        ("conjugate(bessel_j(v, x))", bessel("j"), [], "conjugate of bessel_j"),
        ("conjugate(bessel_j(x, 2))", ("x",), [], "parameters|conjugate|no generator"),
        ("jacobi_theta_3(x, t)", ("x", "t", "jacobi_theta_3(x, t)"), ["t < 1"], "needs m > 0"),
        ("jacobi_theta_3(x, t)", ("x", "t", "jacobi_theta_3(x, t)"), ["t > 0"], "needs m < 1"),
        ("sqrt(f(0)**2)", ("x", "f(0)"), [], "no generator for a Pow"),
        ("f(x)/(f(x) - f(x))", ("x", "f(x)"), [], "vanishes identically"),
        ("f", ("x",), [], "the name f has no meaning"),
        ("f(x, t)", ("x",), [], "no function with derivatives"),
        ("exp'(x)", ("x",), [], "no function with derivatives"),
        ("x'", ("x",), [], "expected [(]"),
        ("f'(x) + g'(x)", ("x",), [], "no function with derivatives"),
        ("f" + 30 * "'" + "(x)", ("x",), [], "the order of a derivative must be at most"),
    ],
)  # fmt: skip
def test_what_does_not_follow(
    formula: str, atoms: tuple[str, ...], domain: list[str], message: str
) -> None:
    point = {name: value for name, value in POINT.items() if name in "xt" or name in atoms}
    refused(certificate("u - 1", f"u = {formula}", atoms, point, XT | {"domain": domain}), message)


def test_an_arbitrary_function_of_a_constant_has_no_sign() -> None:
    for said in ("f(0)", "-f(0)"):
        hints = {"values": {"sqrt(f(0)**2)": said}}
        data = certificate(
            f"u - {said}", "u = sqrt(f(0)**2)", ("x", "f(0)"), {"x": "1"}, XT, **hints
        )
        refused(data, "not shown to be >= 0")


def test_a_denominator_of_arbitrary_functions_must_differ_from_0_for_one_of_them() -> None:
    for inner, right in (("x**2", True), ("x", False)):  # f(|x|) and f(x**2), or twice f(|x|)
        gap = f"(f(sqrt(x**2)) - f(abs({inner})))"
        roots = dict.fromkeys(("x", "abs(x)", f"abs({inner})", "sqrt(x**2)"))
        atoms = (*roots, f"f(abs({inner}))", "f(sqrt(x**2))")
        data = certificate(f"u*{gap} - 1", f"u = 1/{gap}", atoms, {"x": "1/2"}, XT)
        if right:
            assert "function f" in check_certificate(data)
        else:
            refused(data, "is not shown to be other than 0")


def test_a_function_is_without_poles_at_real_arguments_alone() -> None:
    nodes = Nodes()
    scope = Scope(nodes)
    scope.declare("f", "function")
    signs = Signs(nodes, lambda node: None, {}, {})  # type: ignore[arg-type, return-value]
    texts = {
        "f(x)": True,
        "f(x + I)": False,
        "jacobi_theta_1(x, 1/2)": True,
        "bessel_k(0, x)": False,
    }
    for text, bounded in texts.items():
        assert signs.is_bounded(formula(scope, text)) is bounded


def test_a_variable_is_no_function() -> None:
    statement = XT | {"parameters": ["x: function"]}
    refused(certificate("u - 1", "u = 1", (), {}, statement), "variables must be real or integers")


@pytest.mark.parametrize("tau", [acb(0.25, 1.25), acb(0, 1), acb(0.5, 0.875)], ids=str)
@pytest.mark.parametrize("z", [acb(0.25, 0.375), acb(0.5), acb(3.125, 0.75)], ids=str)
def test_the_values_of_weierstrass_function_are_those_of_a_lattice(tau: acb, z: acb) -> None:
    with ctx.workprec(BITS):
        values = weierstrass(z, *tau.elliptic_invariants())
        series = acb_series([z, 1], 2).elliptic_p(tau)
        for own, other in zip(values, (series[0], series[1]), strict=True):
            assert own.overlaps(other)
            assert abs((own - other).real) < 1e-60


def test_an_invariant_may_be_0() -> None:
    with ctx.workprec(BITS):
        for g2, g3 in ((acb(4), acb(0)), (acb(0), acb(-2))):
            p, slope = weierstrass(acb(2.5), g2, g3)
            assert p.is_finite()
            assert (slope**2).overlaps(4 * p**3 - g2 * p - g3)


def test_the_degenerate_functions_of_weierstrass() -> None:
    with ctx.workprec(BITS):
        assert weierstrass(acb(2), acb(0), acb(0))[0].overlaps(acb(1) / 4)
        for z in (acb("1.5"), acb("0.3", "2.2")):  # e = 2/3, -1/3, -1/3
            value, slope = weierstrass(z, acb(4) / 3, acb(8) / 27)
            assert value.overlaps(acb(1) / z.sin() ** 2 - acb(1) / 3)
            assert slope.overlaps(-2 * z.cos() / z.sin() ** 3)
            assert abs((value - 1 / z.sin() ** 2 + acb(1) / 3).real) < 1e-60


@pytest.mark.parametrize("place", [1, 2, 3, 4])
def test_the_values_of_theta_functions_are_their_series(place: int) -> None:
    def series(z: acb, q: acb, order: int) -> acb:
        found = acb(0)
        for n in range(-25, 25):
            power = acb(n) + (acb("1/2") if place < 3 else 0)
            sign = (
                acb(0, 1) * (-1) ** (n + 1) if place == 1 else acb((-1) ** n if place == 4 else 1)
            )
            frequency = 2 * acb(0, 1) * power
            found += sign * q ** (power * power) * frequency**order * (frequency * z).exp()
        return found

    with ctx.workprec(BITS):
        for order in range(4):
            for z in (acb("0.3"), acb("0.2", "0.4")):
                q = acb("0.3")
                own, other = theta_ball(z, q, (f"jacobi_theta_{place}", order)), series(z, q, order)
                assert abs((own - other).abs_upper()) < 1e-60


@pytest.mark.parametrize("name", ["bessel_j", "bessel_y", "bessel_i", "bessel_k"])
def test_the_values_of_bessels_functions_satisfy_the_recurrence(name: str) -> None:
    nodes = Nodes()
    scope = Scope(nodes)
    up, down = {"bessel_i": (1, 1), "bessel_k": (-1, -1)}.get(name, (-1, 1))
    x, v = scope.node("x"), scope.node("v")
    sides = f"({down})*{name}(v - 1, x) - ({up})*{name}(v + 1, x)", f"2*v/x*{name}(v, x)"
    balls = Balls(nodes, {x: fmpq(3, 2), v: fmpq(1, 3)})
    left, right = (balls.ball(formula(scope, side)) for side in sides)
    assert left.overlaps(right)
    assert abs(right) > 0.01


def test_the_generic_function_satisfies_no_simple_equation_and_differs_from_name_to_name() -> None:
    with ctx.workprec(BITS):
        z = acb("1/3")
        f = [jet_ball(z, ("f", order)) for order in range(3)]
        assert all(abs(value) > 1e-3 for value in (*f, f[0] * f[2] - f[1] ** 2, f[0] + f[2]))
        assert abs(jet_ball(z, ("g", 0)) - f[0]) > 1e-3
        step = acb("1e-30")
        assert abs((jet_ball(z + step, ("f", 0)) - f[0]) / step - f[1]) < 1e-25
