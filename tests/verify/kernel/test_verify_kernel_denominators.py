"""Domains that are connected, denominators on all branches, and points."""

from __future__ import annotations

import pytest

from longwave.verify.kernel import check_certificate, opened
from longwave.verify.kernel.check import registered
from longwave.verify.kernel.denominators import Denominators, is_connected
from searches.forged_proofs import Data, Proof, certificate, signed
from tests.verify.kernel.test_verify_kernel_attacks import refused

CONNECTED: list[tuple[list[str], bool]] = [
    ([], True),
    (["x + y > 1", "x < 2*y <= 3"], True),
    (["x*y > 1"], False),
    (["x > 0", "x*y > 1", "y > 0"], False),
    (["0 < m < 1", "x < elliptic_k(m)"], True),
    (["0 < m < 1", "0 < x < elliptic_k(m)"], True),
    (["0 < m < 1", "-1 <= x < elliptic_k(m)"], True),
    (["0 < x < elliptic_k(m)", "0 < m < 1"], True),
    (["0 < m < 1", "1/2 < x < elliptic_k(m)"], False),
    (["0 < m < 1", "y < x < elliptic_k(m)"], False),
    (["0 < m < 1", "0 < x < elliptic_k(m)", "x < 3"], False),
    (["0 < m < 1", "x + y < elliptic_k(m)"], False),
    (["0 < m < 1", "elliptic_k(m) < x"], False),
    (["x < elliptic_k(m)"], False),
    (["x < 1", "x < elliptic_k(x)"], False),
    (["0 < m < 1", "x < elliptic_k(m)", "y < elliptic_k(m)"], True),
    (["0 < m < 1", "x < elliptic_k(m)", "x < elliptic_k(m/2)"], False),
    (["0 < m < 1", "x < elliptic_k(m)", "x*y > 1"], False),
]


@pytest.mark.parametrize(("domain", "connected"), CONNECTED, ids=lambda value: str(value))
def test_what_is_evidently_connected(domain: list[str], connected: bool) -> None:
    proof = Proof()
    statement = {"variables": ["x", "y"], "equations": ["u - x"], "solutions": ["u = x"]}
    more = {"parameters": ["m: real"], "domain": domain}
    data = signed(
        {**statement, **more}, proof, proof.data(["x", "y", "m", "elliptic_k(m)"][:3], {})
    )
    found = opened(data)
    assert is_connected(registered(found, data["proof"]), found) is connected


def quotient(below: str, atoms: list[str], point: str, domain: str = "") -> Data:
    u = f"1/({below})"
    stated = {"domain": [domain] if domain else []}
    return certificate(f"u - {u}", f"u = {u}", ["x", *atoms], {"x": point}, stated)


@pytest.mark.parametrize(
    ("below", "atoms", "point", "domain", "message"),
    [
        ("3 + abs(x)", ["abs(x)"], "1", "", ""),
        ("1 + abs(x)", ["abs(x)"], "1", "", "other than 0 at the point"),
        ("1 + abs(x)", ["abs(x)"], "2", "", ""),
        ("2 + sqrt(x)", ["sqrt(x)"], "4", "", "other than 0 at the point"),
        ("2 + sqrt(x)", ["sqrt(x)"], "4", "x > 0", ""),
        ("2 + sqrt(x)", ["sqrt(x)"], "4", "x**2 > 1", "other than 0 at the point"),
        ("2 + x**(1/3)", ["x**(1/3)"], "8", "", ""),
        ("8*x + x**(1/3)", ["x**(1/3)"], "1/8", "", ""),
        ("2 + (-x)**(1/3)", ["(-x)**(1/3)"], "8", "", "other than 0 at the point"),
        ("exp(x) - 1", ["exp(x)"], "0", "", "other than 0 at the point"),
        ("exp(x) - 1", ["exp(x)"], "1/3", "", ""),
        ("log(x)", ["log(x)"], "-1", "", ""),
        ("log(x) + abs(x)", ["log(x)", "abs(x)"], "1/2", "", "both a root and a function"),
        ("log(x) + abs(x)", ["log(x)", "abs(x)"], "1/2", "x > 0", ""),
        ("log(x + 1) + abs(x)", ["log(x + 1)", "abs(x)"], "1/2", "", "both a root"),
        ("log(1 + x**2) + abs(x)", ["log(1 + x**2)", "abs(x)"], "1/2", "", ""),
        ("atan(x) + abs(x)", ["atan(x)", "abs(x)"], "1/2", "", ""),
        ("lambert_w(x) + abs(x)", ["lambert_w(x)", "abs(x)"], "1/2", "", "both a root"),
        ("lambert_w(x) + abs(x)", ["lambert_w(x)", "abs(x)"], "1/2", "x > 0", ""),
    ],
)  # fmt: skip
def test_a_denominator_on_all_branches(
    below: str, atoms: list[str], point: str, domain: str, message: str
) -> None:
    data = quotient(below, atoms, point, domain)
    if message:
        refused(data, message)
    else:
        assert f"1/({below})" in check_certificate(data)


def test_the_scale_of_a_root_is_a_part_of_what_it_stands_for() -> None:
    """sqrt(1/(2 + abs(x))) is a generator over a power of 2 + abs(x), which turns as well."""
    root = "sqrt(1/(2 + abs(x)))"
    for point, message in (("1", ""), ("2", "other than 0 at the point")):
        data = quotient(f"{root} + 3", ["abs(x)", root], point)
        if message:
            refused(data, message)
        else:
            assert root in check_certificate(data)


def test_a_denominator_is_that_of_all_its_factors() -> None:
    proof = Proof()
    u = "1/(abs(x) + 3) + 1/(exp(x) + 2)"
    statement = {"equations": [f"u - {u}"], "solutions": [f"u = {u}"]}
    data = signed(statement, proof, proof.data(["x", "abs(x)", "exp(x)"], {"x": "1"}))
    found = opened(data)
    field = registered(found, data["proof"])
    field.walk(found.formulas)
    denominators = Denominators(field, found, field.point)
    formulas = [
        {field.nodes.all[node][0] for node in denominators._formulas(factor)}
        for factor in field.ring.factors
    ]
    assert sorted(map(sorted, formulas)) == [["Abs"], ["exp"]]


DOMAINS = [
    # inequality, point, message
    ("x > 0", "1", ""),
    ("x > 0", "0", "the point is not in the domain, or not inside it"),
    ("x >= 0", "0", "the point is not in the domain, or not inside it"),
    ("x >= 0", "1", ""),
    ("x > 0", "-1", "the point is not in the domain"),
    ("x**2 >= 0", "1", "<= must be between formulas of degree 1"),
    ("0 <= x**2", "1", "<= must be between formulas of degree 1"),
    ("x**2 > 0", "1", ""),
    ("1/x > 0", "1", "a domain's ends must be shown to be real and without jumps"),
    ("0 < 1/x", "1", "a domain's ends must be shown to be real and without jumps"),
    ("x + 1 > I", "1", "the point is not in the domain"),
    ("2*pi*x >= x - 1", "1", ""),
    ("x > log(2)", "1", ""),
    ("x >= log(2)", "1", ""),
    ("x > log(2)", "2/3", "the point is not in the domain"),
    ("log(2) < x < sqrt(2)", "1", ""),
    ("x + log(2) > 0", "1", ""),
    ("log(3)*x > log(2)", "1", ""),
    ("x > jacobi_sn(1, 1/2)", "1", ""),
    ("x > log(x)", "1", "a domain's ends must be shown to be real and without jumps"),
    ("x > log(2)*log(x)", "1", "a domain's ends must be shown to be real and without jumps"),
    ("x > log(-2)", "1", "the point is not in the domain"),
    ("x > 1/0", "1", "the point is not in the domain"),
    ("x > I*x*(-I)", "1", "the point is not in the domain"),
]


@pytest.mark.parametrize(("inequality", "point", "message"), DOMAINS)
def test_a_point_is_inside_a_domain(inequality: str, point: str, message: str) -> None:
    data = certificate("u - x", "u = x", ["x"], {"x": point}, {"domain": [inequality]})
    if message:
        refused(data, message)
    else:
        assert inequality in check_certificate(data)


def test_a_point_gives_integers_to_integers_alone() -> None:
    statement = {"variables": ["n", "x"]}
    for point, right in (({"n": "2", "x": "1/2"}, True), ({"n": "1/2", "x": "2"}, False)):
        data = certificate("u - n*x", "u = n*x", ["n", "x"], point, statement)
        if right:
            assert "integer n; real x" not in check_certificate(data)
            assert "real x; integer n" in check_certificate(data)
        else:
            refused(data, "the point must give integers to integer symbols")


def test_a_function_is_finite_at_the_point() -> None:
    for point, right in (("1", True), ("0", False)):
        data = certificate("u - log(x)", "u = log(x)", ["x", "log(x)"], {"x": point})
        if right:
            assert "u = log(x)" in check_certificate(data)
        else:
            refused(data, "a function is not shown to be finite at the point")


@pytest.mark.parametrize(
    ("domain", "point", "shown"),
    [
        ("x > log(2)", "1", "x"),
        ("x > log(1/2)", "1", ""),
        ("x - log(2) >= 0", "1", "x"),
        ("x + log(2) > 0", "1", ""),
        ("-log(2) > x", "-1", "-x"),
        ("x < log(1/2)", "-1", "-x"),
        ("x < log(2)", "-1", ""),
        ("0 < x + log(1/3) + log(2)", "1", "x"),
        ("0 < x + log(1/3) + log(4)", "1", ""),
        ("0 < 2*x + log(1/2)", "1", ""),
        ("x > log(t)", "1", ""),
    ],
)
def test_a_sign_follows_from_an_end_that_is_a_constant(domain: str, point: str, shown: str) -> None:
    for value in ("x", "-x"):
        stated = {"variables": ["x", "t"], "domain": [domain]}
        data = certificate(
            f"u - ({value})", "u = abs(x)", ["x", "t"], {"x": point, "t": "1"}, stated,
            values={"abs(x)": value},
        )  # fmt: skip
        if value == shown:
            assert domain in check_certificate(data)
        else:
            refused(data, "not shown to be >= 0|real and without jumps")


@pytest.mark.parametrize(
    ("domain", "connected"),
    [
        ("x > log(2)", True),
        ("log(2)*x < pi*exp(1)", True),
        ("x > I", False),
        ("I*x > 0", False),
        ("x > log(-1)", False),
        ("x > log(x)", False),
        ("x*t > 1", False),
        ("x > weierstrass_p(1, 2, 3)", False),
        ("x > diff(2, x)", False),
    ],
)
def test_constants_that_are_real_leave_an_inequality_linear(domain: str, connected: bool) -> None:
    stated = {"variables": ["x", "t"], "domain": [domain]}
    data = certificate("u - x", "u = x", ["x", "t"], {"x": "1", "t": "1"}, stated)
    statement = opened(data)
    assert is_connected(registered(statement, data["proof"]), statement) is connected
