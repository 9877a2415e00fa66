"""Hand-made certificates of false statements, and of statements that read as others."""

import pytest
import sympy as sp
from flint import fmpq

from longwave.verify.kernel import CertificateError, check_certificate, opened
from longwave.verify.kernel.check import registered
from longwave.verify.kernel.denominators import is_connected
from longwave.verify.kernel.node_balls import Balls
from longwave.verify.proof import prove
from longwave.verify.verdict import Outcome
from searches.forged_proofs import Data, Proof, certificate, signed


def refused(data: Data, message: str) -> None:
    with pytest.raises(CertificateError, match=message):
        check_certificate(data)


def test_a_power_of_minus_one_has_its_sign() -> None:
    """2*(-1)**1 counted as positive, so that 4**(1/2) was -2."""
    value = "2*(-1)**(2 - 1)"
    for equation in ("u + 2", "u - 2"):
        data = certificate(
            equation, "u = 4**(1/2) + 0*x", ["x"], {"x": "1"}, values={"4**(1/2)": value}
        )
        refused(data, "not shown to be >= 0")


def test_a_hidden_denominator_that_is_zero() -> None:
    """1 + (-1)**1 was 2 in balls."""
    value = "x/(1 + (-1)**(2 - 1))"
    refused(certificate(f"u - {value}", f"u = {value}", ["x"], {"x": "1"}), "vanishes identically")


def test_the_point_of_an_integer_is_an_integer() -> None:
    """Between 0 and 1 there is none: what holds there is empty."""
    statement = {"variables": ["n", "x"], "domain": ["0 < n < 1"]}
    for value in ("1/3", "0"):
        data = certificate("u_x", "u = n", ["n"], {"n": value, "x": "1"}, statement)
        refused(data, "integers to integer symbols|the point is not in the domain")
    good = certificate("u_x", "u = n", ["n"], {"n": "1", "x": "1"}, {"variables": ["n", "x"]})
    assert "integer n" in check_certificate(good)


def test_a_domain_without_points() -> None:
    statement = {"domain": ["x < 0", "x > 0"]}
    for value in ("-1", "0", "1"):
        data = certificate("u_x", "u = 1", ["x"], {"x": value}, statement)
        refused(data, "the point is not in the domain")


@pytest.mark.parametrize(
    "name", ["\u0445", "u_t", "ut", "utx", "ubar", "u_bar", "ustar", "I", "pi", "exp", "diff"]
)
def test_a_parameter_is_not_called_like_something_else(name: str) -> None:
    statement = {"variables": ["x", "t"], "parameters": [f"{name}: 0 < {name}"]}
    data = certificate("diff(u, t)", f"u = {name}", ["x"], {"x": "1", "t": "1"}, statement)
    refused(data, "name|grammar")


def test_an_undeclared_name_that_reads_as_a_derivative_is_no_parameter() -> None:
    """ut + 6*u*ux + uxxx was an equation of three parameters."""
    statement = {"variables": ["x", "t"]}
    data = certificate("ut + 6*u*ux + uxxx", "u = x", ["x"], {"x": "1", "t": "1"}, statement)
    refused(data, "reads as a derivative")


@pytest.mark.parametrize(
    ("q", "value"),
    [
        ("1", "-1"),
        ("1/2", "I"),
        ("2**-1", "I"),
        ("3/2", "-I"),
        ("1/3", "(1 + I*3**(1/2))/2"),
        ("-2/3", "(-1 - I*3**(1/2))/2"),
        ("1/4", "(1 + I)*2**(1/2)/2"),
        ("7/4", "(1 - I)*2**(1/2)/2"),
        ("1/6", "(3**(1/2) + I)/2"),
        ("5/6", "(-3**(1/2) + I)/2"),
    ],
)
def test_a_root_of_unity_is_the_right_one(q: str, value: str) -> None:
    u = f"exp(({q})*I*pi)"

    def states(right: str) -> Data:
        atoms = ["I", "pi", "2**(1/2)", "3**(1/2)"]
        sums = {u: {"I*pi": q}}
        return certificate(f"u - ({right})", f"u = {u}", atoms, {"x": "1"}, sums=sums)

    assert "u = exp" in check_certificate(states(value))
    for other in (f"-({value})", f"I*({value})"):
        refused(states(other), "the residual is not 0")


@pytest.mark.parametrize(
    ("formula", "right", "wrong"),
    [("re(x + I*y)", "x", "y"), ("im(x + I*y)", "y", "-y"), ("conjugate(x + I*y)", "x - I*y", "x")],
)
def test_parts_of_complex_numbers(formula: str, right: str, wrong: str) -> None:
    def states(value: str) -> Data:
        statement = {"variables": ["x", "y"]}
        point = {"x": "1", "y": "2"}
        return certificate(f"u - ({value})", f"u = {formula}", ["x", "y", "I"], point, statement)

    assert formula in check_certificate(states(right))
    refused(states(wrong), "the residual is not 0")


@pytest.mark.parametrize(
    ("domain", "connected"), [("x + y > 1", True), ("x*y > 1", False), ("2*x > pi", True)]
)
def test_a_domain_is_connected_where_it_is_linear(domain: str, connected: bool) -> None:
    """x*y > 1 has two parts."""
    proof = Proof()
    statement = {"variables": ["x", "y"], "equations": ["u - x"], "solutions": ["u = x"]}
    data = signed({**statement, "domain": [domain]}, proof, proof.data(["x", "y", "pi"], {}))
    found = opened(data)
    assert is_connected(registered(found, data["proof"]), found) is connected


def test_a_witness_of_a_sign_must_be_real() -> None:
    """-x**2 is (i x)**2, which is no square of a real number: sqrt(x**4) is not -x**2."""
    root = "(x**4)**(1/2)"
    hints = {"values": {root: "-x**2"}, "signs": {"-x**2": "(I*x)**2"}}
    data = certificate("u + x**2", f"u = {root}", ["x", "I"], {"x": "1"}, **hints)
    refused(data, "not shown to be >= 0")


def test_a_root_does_not_show_that_it_is_real() -> None:
    """x is sqrt(x)**2, which is a square of a real number only if x >= 0."""
    root, signs = "x**(1/2)", {"x": "(x**(1/2))**2"}
    data = certificate("u - conjugate(u)", f"u = {root}", ["x", root], {"x": "1"}, signs=signs)
    refused(data, "the conjugate of Pow does not follow from the domain")


@pytest.mark.parametrize("domain", ["", "0 < x**2", "0 <= abs(x) - x"])
def test_a_denominator_that_vanishes_on_a_half_line(domain: str) -> None:
    """abs(x) - x is 0 for x > 0; divided by it, abs(x) would be -x everywhere."""
    root, even = "(x**2)**(1/2)", "(abs(x) - x)**2"
    hints = {"values": {root: "-x"}, "signs": {"-x": f"abs(x)*{even}/{even}"}}
    stated = {"domain": [domain] if domain else []}
    data = certificate("u + x", f"u = {root}", ["x", "abs(x)"], {"x": "-1"}, stated, **hints)
    refused(data, r"a denominator|the point|without jumps")


def test_a_formula_must_be_defined_where_only_its_shift_is_needed() -> None:
    """1/(abs(x) + x) is nothing for -1 < x < 0, and at x + 1 it is 1/(2*(x + 1))."""
    data = certificate(
        "2*(x + 1)*u[x + 1] - 1",
        "u = 1/(abs(x) + x)",
        ["x", "abs(x)"],
        {"x": "1"},
        {"domain": ["x > -1"]},
        values={"abs(x + 1)": "x + 1"},
    )
    refused(data, "a denominator is not shown")


def test_a_slope_that_divides_by_a_function_that_is_zero_on_a_part() -> None:
    """u = sqrt(|x| + x + |y| + y) is 0 where x, y < 0, but (|x| - x)(|y| - y) is not."""
    left, right = "(abs(x) + x)", "(abs(y) + y)"
    u = f"({left} + {right})**(1/2)"
    equation = f"{left}*u_x + {right}*u_x - 1/2*{left}/x*u + (abs(x) - x)*(abs(y) - y)"
    atoms = ["x", "y", "abs(x)", "abs(y)", u]
    point = {"x": "1", "y": "1"}
    data = certificate(equation, f"u = {u}", atoms, point, {"variables": ["x", "y"]})
    refused(data, "a denominator is not shown")


def test_the_prover_does_not_take_a_function_that_is_zero_on_a_part() -> None:
    """The same far from the points that a search for a witness tries."""
    x, y = sp.symbols("x y", real=True)
    u, far = sp.Function("u")(x, y), 10**40
    a, b = x + far, y + far
    left, right = sp.Abs(a) + a, sp.Abs(b) + b
    last = (sp.Abs(a) - a) * (sp.Abs(b) - b)
    equation = u.diff(x) * left + u.diff(x) * right - u * left / (2 * a) + last
    assert prove(equation, sp.sqrt(left + right)).outcome is Outcome.UNDECIDED


def test_a_domain_needs_an_inside() -> None:
    """At x = 0 alone sqrt(x**4) is -x**2, but its second derivative is 2."""
    root = "(x**4)**(1/2)"
    hints = {"values": {root: "-x**2"}, "signs": {"-x**2": "x*(-x)"}}
    data = certificate(
        "u_xx + 2", f"u = {root}", ["x"], {"x": "0"}, {"domain": ["0 <= x <= 0"]}, **hints
    )
    refused(data, "the point is not in the domain")


def test_an_inequality_is_between_real_numbers() -> None:
    data = certificate("u - x", "u = x", ["x", "I"], {"x": "0"}, {"domain": ["0 < 1 + I"]})
    refused(data, "the point is not in the domain")


def test_a_formula_is_defined_somewhere() -> None:
    """exp(x) - exp(2 x/2) is 0, and log(0) has no value."""
    first, second = "exp(x)", "exp(1/2*(2*x))"
    u = f"1/({first} - {second})"
    proof = Proof()
    one, zero = proof.place("1"), proof.place("0")
    rows = [[[one, zero], zero], [[zero, one], zero]]
    forms = ["forms", [proof.place(first), proof.place(second)], rows]
    statement = {"equations": [f"u - {u}"], "solutions": [f"u = {u}"]}
    refused(
        signed(statement, proof, proof.data([], {"x": "0"}, more=[forms])), r"finite|a denominator"
    )
    data = certificate("u - log(0)", "u = log(0)", ["log(0)"], {"x": "0"})
    refused(data, r"finite|a denominator")


def test_a_sine_is_not_positive_where_its_argument_is_zero() -> None:
    """sin((|x| + x)**2) is 0 for x < 0, where sqrt((0 + i y)**2) is not i y for y < 0."""
    z = "(abs(x) + x)**2"
    value = f"(sin({z}) + I*y)"
    root = f"({value}**2)**(1/2)"
    statement = {"variables": ["x", "y"], "domain": [f"{z} < 3"]}
    atoms = ["x", "y", "I", "abs(x)", f"exp(I*{z})"]
    point = {"x": "1/2", "y": "1"}
    data = certificate(f"u - {value}", f"u = {root}", atoms, point, statement, values={root: value})
    refused(data, "not shown to be >= 0")


@pytest.mark.parametrize("where", ["radicand", "witness"])
def test_a_root_with_a_pole_under_it_may_change_its_branch(where: str) -> None:
    """x sqrt(1 + 1/x**2) - sqrt(1 + x**2) is 0 for x > 0, but not for x < 0.

    So is sqrt(1 + x**2) sqrt(x**2/(1 + x**2)) - x, whose radicand 1/(1 + 1/x**2) is 0 at 0.
    """
    v, steep, signs = "(1 + x**2)**(1/2)", "(1 + x**(-2))", {}
    if where == "radicand":
        w = f"{steep}**(1/2)"
        gap, size = f"(x*{w} - {v})", f"{v}/{w}"
    else:
        radicand = "(x**2/(1 + x**2))"
        w, signs = f"{radicand}**(1/2)", {radicand: f"1/{steep}"}
        gap, size = f"({v}*{w} - x)", f"{v}*{w}"
    root = "(x**2)**(1/2)"
    hints = {"values": {root: "-x"}, "signs": {"-x": f"{size}*{gap}**2/{gap}**2", **signs}}
    data = certificate("u + x", f"u = {root}", ["x", v, w], {"x": "-1"}, **hints)
    refused(data, "a denominator is not shown")


def test_a_sign_is_tried_with_both_values() -> None:
    """sign x changes its branch at 0, also where abs x is no generator."""
    proof = Proof()
    place = proof.place("sign(x)")
    statement = {"equations": ["u - x*x"], "solutions": ["u = x*x"]}
    data = signed(statement, proof, proof.data(["x"], {"x": "-1"}))
    found = opened(data)
    conjugate = registered(found, data["proof"]).signs.conjugate
    node, x = found.nodes.place(place), found.variables[0]
    turns = [{node: fmpq(k, 2)} for k in (0, 1)]
    balls = [Balls(found.nodes, {x: fmpq(-1)}, turn, conjugate).ball(node).real for turn in turns]
    assert [bool(value < 0) for value in balls] == [True, False]


@pytest.mark.parametrize(("exponent", "degree"), [("2", 1), ("-2", 1), ("3/2", 2)])
def test_a_power_that_stands_for_an_equal_part_has_its_own_slope(
    exponent: str, degree: int
) -> None:
    """x**2 as a generator had the slope x**2/x; that of x**(p/q) is p/q x**(p/q)/x."""
    power = f"x**({exponent})"

    def slope(factor: str) -> Data:
        proof = Proof()
        atoms = ["x", f"x**(1/{degree})"][:degree]
        same = proof.data(atoms, {"x": "1"})
        place = proof.place(power)
        data = proof.data([], {"x": "1"}, parts=[[place, place, same]])
        data["generators"] = [["atom", proof.place("x")], ["part", 0]]
        equation = f"u_x - {power}/x*({factor})"
        return signed({"equations": [equation], "solutions": [f"u = {power}"]}, proof, data)

    refused(slope(f"1/{degree}"), "the residual is not 0")
    assert "u_x" in check_certificate(slope(exponent))


def test_a_part_is_what_was_proved() -> None:
    proof = Proof()
    left, right = proof.place("x**2"), proof.place("x")
    same = proof.data(["x"], {"x": "1"})
    data = proof.data(["x"], {"x": "1"}, parts=[[left, right, same]], more=[["part", 0]])
    statement = {"equations": ["u - x"], "solutions": ["u = x**2"]}
    refused(signed(statement, proof, data), "the residual is not 0")


def test_a_proof_speaks_of_the_statement_alone() -> None:
    refused(certificate("u - x", "u = x", ["x", "y"], {"x": "1"}), "the statement's symbols")


def test_a_certificate_of_an_older_format_is_refused_with_the_remedy() -> None:
    data = certificate("u - x", "u = x", ["x"], {"x": "1"}) | {"format": "longwave proof 3"}
    refused(data, "prove the statement again")
