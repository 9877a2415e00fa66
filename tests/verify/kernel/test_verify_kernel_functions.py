"""Hand-made proofs of one rule each: a true value is accepted, one beside it refused."""

from typing import Any

import pytest
from flint import fmpq

from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.node_balls import Balls
from longwave.verify.kernel.nodes import Nodes
from tests.verify.kernel.test_verify_kernel_attacks import Proof, certificate, refused, signed

Hints = dict[str, Any]

ATOMS = ("x", "y", "I")
XY: Hints = {"variables": ["x", "y"]}
POINT = {"x": "1/2", "y": "1/3"}

VALUES: list[tuple[str, str, str, tuple[str, ...], list[str], Hints]] = [
    # formula, value, wrong value, atoms, domain, hints
    ("abs(x)", "-x", "x", ATOMS, ["x < 0"], {"values": {"abs(x)": "-x"}}),
    ("abs(x*I)", "x", "-x", ATOMS, ["x > 0"], {"values": {"abs(x*I)": "x"}}),
    ("sign(x)", "1", "-1", ATOMS, ["x > 0"], {"values": {"abs(x)": "x"}}),
    ("sign(x)", "-1", "1", ATOMS, ["x < 0"], {"values": {"abs(x)": "-x"}}),
    ("sqrt(9*x)", "3*sqrt(x)", "-3*sqrt(x)", (*ATOMS, "x**(1/2)"), ["x > 0"],
     {"values": {"sqrt(9*x)": "3*sqrt(x)"}}),
    ("(-8*y)**(1/3)", "2*(-y)**(1/3)", "-2*y**(1/3)", (*ATOMS, "(-y)**(1/3)", "y**(1/3)"), [],
     {"values": {"(-8*y)**(1/3)": "2*(-y)**(1/3)"}}),
    ("sqrt(-x**2)", "I*x", "-I*x", ATOMS, ["x > 0"], {"values": {"sqrt(-x**2)": "I*x"}}),
    ("sqrt((1 + I*x)**2)", "1 + I*x", "-1 - I*x", ATOMS, [],
     {"values": {"sqrt((1 + I*x)**2)": "1 + I*x"}}),
    ("conjugate((1 + I*x)/(y - I))", "(1 - I*x)/(y + I)", "(1 + I*x)/(y - I)", ATOMS, [], {}),
    ("conjugate(sign(1 + I*x))", "1/sign(1 + I*x)", "sign(1 + I*x)",
     (*ATOMS, "abs(1 + I*x)"), [], {}),
    ("conjugate(conjugate(x + I))", "x + I", "x - I", ATOMS, [], {}),
    ("re(exp(I*x))", "(exp(I*x) + 1/exp(I*x))/2", "exp(I*x)", (*ATOMS, "exp(I*x)"), [],
     {"sums": {"exp(I*x)": {"I*x": "1"}, "exp(-I*x)": {"I*x": "-1"}}}),
    ("im(jacobi_sn(x, 1/2) + I*x)", "x", "-x", (*ATOMS, "jacobi_sn(x, 1/2)"), [], {}),
    ("log(x*y)", "log(x) + log(y)", "log(x) - log(y)", (*ATOMS, "log(x)", "log(y)"),
     ["x > 0", "y > 0"], {"logs": {"log(x*y)": {"x": "1", "y": "1"}}}),
    ("log(x*I)", "log(x) + I*pi/2", "log(x) - I*pi/2", (*ATOMS, "pi", "log(x)"), ["x > 0"],
     {"logs": {"log(x*I)": {"x": "1", "I": "1"}}}),
    ("log(exp(x)*y)", "x + log(y)", "log(y)", (*ATOMS, "exp(x)", "log(y)"), ["y > 0"],
     {"logs": {"log(exp(x)*y)": {"exp(x)": "1", "y": "1"}}}),
    ("exp(2*log(x))", "x**2", "x", (*ATOMS, "log(x)"), ["x > 0"],
     {"sums": {"exp(2*log(x))": {"log(x)": "2"}}}),
    ("exp(I*atan(x))", "(1 + I*x)/sqrt(1 + x**2)", "(1 - I*x)/sqrt(1 + x**2)",
     (*ATOMS, "sqrt(1 + x**2)", "atan(x)"), [], {"sums": {"exp(I*atan(x))": {"I*atan(x)": "1"}}}),
    ("x**y", "exp(y*log(x))", "y*log(x)", (*ATOMS, "log(x)", "exp(y*log(x))"), ["x > 0"],
     {"sums": {"exp(y*log(x))": {"y*log(x)": "1"}}}),
    ("atan(tan(x))", "x", "-x", (*ATOMS, "exp(I*x)"), ["-1 < x < 1"],
     {"values": {"atan(tan(x))": "x"}, "sums": {"exp(I*x)": {"I*x": "1"}}}),
    ("acos(cos(x))", "x", "-x", (*ATOMS, "exp(I*x)"), ["0 < x < 3.1"],
     {"values": {"acos(cos(x))": "x"}, "sums": {"exp(I*x)": {"I*x": "1"}}}),
    ("jacobi_sn(0*x, 1/2)", "0", "1", ATOMS, [], {"sums": {"jacobi_sn(0*x, 1/2)": {"x": "0"}}}),
    ("jacobi_cn(-x, 1/2)", "jacobi_cn(x, 1/2)", "-jacobi_cn(x, 1/2)",
     (*ATOMS, *(f"jacobi_{n}(x, 1/2)" for n in ("cn", "sn", "dn"))), [],
     {"sums": {"jacobi_sn(-x, 1/2)": {"x": "-1"}}}),
    ("jacobi_epsilon(-x, 1/2)", "-jacobi_epsilon(x, 1/2)", "jacobi_epsilon(x, 1/2)",
     (*ATOMS, *(f"jacobi_{n}(x, 1/2)" for n in ("cn", "sn", "dn", "epsilon"))), [],
     {"sums": {"jacobi_sn(-x, 1/2)": {"x": "-1"}}}),
    ("log(1) + x", "x", "x + 1", ATOMS, [], {}),
    ("log(-x)", "log(x) + I*pi", "log(x) - I*pi", (*ATOMS, "pi", "log(x)"), ["x > 0"], {}),
    ("log(x)", "log(-x) + I*pi", "log(-x)", (*ATOMS, "pi", "log(-x)"), ["x < 0"], {}),
    ("log(-2)", "log(2) + I*pi", "log(2) - I*pi", (*ATOMS, "pi", "log(2)"), [], {}),
    ("jacobi_sn(x + x + y, 1/2)", "jacobi_sn(2*x + y, 1/2)", "jacobi_sn(x + y, 1/2)",
     (*ATOMS, *(f"jacobi_{n}({z}, 1/2)" for z in "xy" for n in ("sn", "cn", "dn"))), [], {}),
    ("exp(2*I*pi/5)**4", "-1 - w - w**2 - w**3".replace("w", "exp(2*I*pi/5)"),
     "-1 + w - w**2 + w**3".replace("w", "exp(2*I*pi/5)"), (*ATOMS, "pi", "exp(2*I*pi/5)"), [], {}),
    ("exp(I*pi/5)**4", "-1 + w - w**2 + w**3".replace("w", "exp(I*pi/5)"),
     "-1 - w - w**2 - w**3".replace("w", "exp(I*pi/5)"), (*ATOMS, "pi", "exp(I*pi/5)"), [], {}),
    ("x**y*0**0", "x**y", "1", (*ATOMS, "log(x)", "exp(y*log(x))"), ["x > 0"], {}),
    ("1/(-8*x)**(1/3)", "(-8*x)**(2/3)/(-8*x)", "(-8*x)**(1/3)/(-8*x)", (*ATOMS, "(-8*x)**(1/3)"),
     [], {}),
    ("exp(x + x - x)", "exp(x)", "2*exp(x)", (*ATOMS, "exp(x)", "exp(x + x - x)"), [], {}),
    ("exp(2*lambert_w(x))", "x**2/lambert_w(x)**2", "x/lambert_w(x)", (*ATOMS, "lambert_w(x)"), [],
     {}),
    ("exp(3*x + y)", "exp(x)**3*exp(y)", "exp(x)*exp(y)", (*ATOMS, "exp(x)", "exp(y)"), [], {}),
    *((f"exp(I*pi*{n}/5)", "-exp(I*pi/5)", "exp(I*pi/5)", (*ATOMS, "pi", "exp(I*pi/5)"), [], {})
      for n in (6, 16, -4)),
    ("exp(9*I*pi/5)", "1/exp(I*pi/5)", "exp(I*pi/5)", (*ATOMS, "pi", "exp(I*pi/5)"), [], {}),
    ("sqrt((1 + sqrt(I*x))**2)", "1 + sqrt(I*x)", "-1 - sqrt(I*x)", (*ATOMS, "sqrt(I*x)"), [],
     {"values": {"sqrt((1 + sqrt(I*x))**2)": "1 + sqrt(I*x)"}}),
    ("jacobi_dn(elliptic_k(1/4), 1/4)", "sqrt(3/4)", "-sqrt(3/4)",
     (*ATOMS, "sqrt(1 - 1/4)", "elliptic_k(1/4)"), [],
     {"sums": {"jacobi_sn(elliptic_k(1/4), 1/4)": {"elliptic_k(1/4)": "1"}}}),
]  # fmt: skip


@pytest.mark.parametrize("case", VALUES, ids=lambda case: f"{case[0]} {case[4]}")
def test_a_value(case: tuple[str, str, str, tuple[str, ...], list[str], Hints]) -> None:
    formula, value, wrong, atoms, domain, hints = case
    below = {symbol: "-" + p for symbol, p in POINT.items() if f"{symbol} < 0" in domain}
    statement = XY | {"domain": domain}
    for said, right in ((value, True), (wrong, False)):
        u, point = f"u = {formula}", POINT | below
        data = certificate(f"u - ({said})", u, atoms, point, statement, **hints)
        if right:
            assert u in check_certificate(data)
        else:
            refused(data, "the residual is not 0")


@pytest.mark.parametrize(
    ("formula", "atoms", "domain", "hints", "message"),
    [
        ("abs(x)", ("x",), [], {"values": {"abs(x)": "x"}}, "not shown to be >= 0"),
        ("abs(x)", ("x",), ["x > 0"], {"values": {"abs(x)": "2*x"}}, "not the square"),
        ("abs(x)", ("x",), ["x > 0"], {}, "no generator for a Abs"),
        ("sqrt(x)", ("x",), ["x > 0"], {"values": {"sqrt(x)": "x"}}, "is not the radicand"),
        ("sqrt(x**2)", ("x",), [], {"values": {"sqrt(x**2)": "x"}}, "not shown to be >= 0"),
        ("log(x*y)", ("x", "y"), [], {}, "no generator for a log"),
        ("log(x*y)", ("x", "y"), [], {"logs": {"log(x*y)": {"x": "1", "y": "1"}}}, "be positive"),
        ("log(x)", ("x", "log(2*x)"), ["x > 0"], {"logs": {"log(x)": {"2*x": "1"}}}, "of another"),
        ("exp(x)", ("x",), [], {"sums": {"exp(x)": {"2*x": "1"}}}, "is not equal to it"),
        ("exp(x)", ("x", "exp(2*x)"), [], {"sums": {"exp(x)": {"2*x": "1/2"}}}, "integers"),
        ("exp(x)", ("x",), [], {}, "a function of a sum"),
        ("exp(I*pi/5)", ("I", "pi"), [], {}, "must be integers"),
        ("log(x*y)", ("x", "y"), [], {"values": {"log(x*y)": "x"}}, "must be a sum of logarithms"),
        ("asin(sin(x))", ("x", "I", "exp(I*x)"), [],
         {"values": {"asin(sin(x))": "x"}, "sums": {"exp(I*x)": {"I*x": "1"}}}, "principal value"),
        ("acos(cos(x))", ("x", "I", "exp(I*x)"), ["3.2 < x < 4"],
         {"values": {"acos(cos(x))": "x"}, "sums": {"exp(I*x)": {"I*x": "1"}}}, "principal value"),
        ("atan(tan(2*x))", ("x", "I", "exp(I*x)"), ["-1/2 < x < 1/2"],
         {"values": {"atan(tan(2*x))": "x"},
          "sums": {"exp(I*x)": {"I*x": "1"}, "exp(I*(2*x))": {"I*x": "2"}}}, "another argument"),
        ("conjugate(log(x))", ("x", "log(x)"), [], {}, "conjugate of log"),
        ("jacobi_sn(x, x)", ("x", "jacobi_sn(x, x)"), [], {}, "must be constant"),
        ("elliptic_k(y)", ("x", "y", "elliptic_k(y)"), [], {}, "constant|needs m < 1"),
        ("elliptic_k(2)", ("x", "elliptic_k(2)"), [], {}, "needs m < 1"),
        ("jacobi_theta(x, -1)", ("x", "jacobi_theta(x, -1)"), [], {}, "needs m > 0"),
        ("jacobi_theta(x, 1/2)", ("x",), [], {"sums": {"jacobi_theta(x, 1/2)": {"x": "1"}}},
         "a difference of two"),
        ("x", ("x + 1",), [], {}, "no generator"),
        ("x", ("x", "x"), [], {}, "must be new"),
        ("I", (), [], {}, "no generator for I"),
        ("1/(x - x)", ("x",), [], {}, "vanishes identically"),
        ("x", ("x",), [], {"signs": {"x": "x + y", "y": "x"}, "values": {}}, "residual"),
    ],
)  # fmt: skip
def test_what_does_not_follow(
    formula: str, atoms: tuple[str, ...], domain: list[str], hints: Hints, message: str
) -> None:
    statement = XY | {"domain": domain}
    data = certificate("u - 1", f"u = {formula}", atoms, POINT, statement, **hints)
    refused(data, message)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (["atom", "sqrt(1 - x**2)"], "no generator for the symbol x"),
        (["atom", "sqrt(1 + z**2)"], "no generator for the symbol z"),
        (["forms", ["tanh(x)"], [[["1"], "0"]]], "tanh is no generator"),
        (["forms", ["I"], [[["1"], "k"]]], "a multiple of a root, or have none"),
        (["forms", ["I", "x"], [[["1", "0"], "0"], [["0", "1"], "0"]]], "or have none"),
        (["forms", ["x"], [[["abs(k)"], "0"]]], "must be analytic"),
        (["forms", ["x", "y"], [[["1", "1"], "0"], [["2", "2"], "0"]]], "must be independent"),
        (["part", 0], "no generator is written"),
        (["atom"], "no generator is written"),
    ],
)
def test_a_generator_that_is_none(entry: list[Any], message: str) -> None:
    proof = Proof()
    data = proof.data(["k", "y"] if entry[0] == "forms" and "y" in str(entry[2]) else ["k"], POINT)

    def placed(value: Any) -> Any:
        return [placed(v) for v in value] if isinstance(value, list) else (
            proof.place(value) if isinstance(value, str) else value
        )  # fmt: skip

    rows = [entry[0], *map(placed, entry[1:])]
    if entry[0] == "forms":
        rows[2] = [[factors, shift] for factors, shift in rows[2]]
    data["generators"].append(rows)
    data["point"].append([proof.place("k"), "1/5"])
    statement = {"equations": ["u - k"], "solutions": ["u = k"], **XY, "parameters": ["z: real"]}
    refused(signed(statement, proof, data), message)


@pytest.mark.parametrize(
    ("function", "shown"),
    [
        ("atan(x)", True),
        ("atan(I*x/9)", False),
        ("log(x + 1)", False),
        ("log(1 + x**2)", True),
    ],
)
def test_a_denominator_with_a_modulus_has_no_function_that_may_jump(
    function: str, shown: bool
) -> None:
    u = f"u = 1/(3 + abs(x) + {function})"
    data = certificate(u.replace("=", "-"), u, ("I", "x", "abs(x)", function), {"x": "1"})
    if shown:
        assert u in check_certificate(data)
    else:
        refused(data, "both a root and a function that may jump")


@pytest.mark.parametrize("domain", ["x < 1", "-1 < x", "y > 0"])
def test_a_logarithm_is_taken_apart_where_its_argument_is_negative(domain: str) -> None:
    stated = {"variables": ["x", "y"], "domain": [domain]}
    data = certificate(
        "u - log(-x)", "u = log(x) + I*pi", ["x", "y", "I", "pi", "log(x)"], POINT, stated
    )
    refused(data, "there is no generator for a log")


@pytest.mark.parametrize(
    ("domain", "shown"),
    [("-3 < x < 3.14159", True), ("-3 < x < 3.15", False), ("-3.15 < x < 3", False)],
)
def test_a_logarithm_of_a_phase_is_its_angle_within_half_a_turn(domain: str, shown: bool) -> None:
    atoms = ("x", "I", "exp(I*x)")
    data = certificate("u - I*x", "u = log(exp(I*x))", atoms, {"x": "1"}, {"domain": [domain]})
    if shown:
        assert domain in check_certificate(data)
    else:
        refused(data, "no generator for a log")


@pytest.mark.parametrize("log", ["log(x)", "log(-x)"])
@pytest.mark.parametrize("wrong", ["", "2*"])
def test_a_power_of_what_is_negative(log: str, wrong: str) -> None:
    """It is that of its logarithm where this is a generator, else that of the opposite, turned."""
    statement = {"variables": ["x"], "parameters": ["j: integer"], "domain": ["x < 0"]}
    power = f"exp(j*{log})"
    turned = "" if log == "log(x)" else "(-1)**j*"
    atoms = ("x", "j", "(-1)**j", log, power)
    point = {"x": "-1", "j": "3"}
    data = certificate(f"u - {wrong}{turned}{power}", "u = x**j", atoms, point, statement)
    if wrong:
        refused(data, "the residual is not 0")
    else:
        assert "x**j" in check_certificate(data)


@pytest.mark.parametrize("equation", ["u - sinh(x)", "u_x - cosh(x)"])
def test_a_part_without_an_axiom_has_no_derivative(equation: str) -> None:
    proof = Proof()
    place = proof.place("sinh(x)")
    same = proof.data(["x", "exp(x)"], {"x": "1"})
    data = proof.data(["x", "exp(x)"], {"x": "1"}, parts=[[place, place, same]], more=[["part", 0]])
    data = signed({"equations": [equation], "solutions": ["u = sinh(x)"]}, proof, data)
    if equation == "u - sinh(x)":
        assert "sinh" in check_certificate(data)
    else:
        refused(data, "derivative does not follow")


LONG = "+".join(f"{n + 1}*x**{n}*g**{(3 * n) % 7}" for n in range(24))


@pytest.mark.parametrize(
    ("g", "equation", "message"),
    [
        ("t", "u_t*2 - u_t*2", ""),
        ("t", "u_tt - u_tt", "at most one derivative in t"),
        ("t", "u_t - u_x", "the residual is not 0"),
        ("exp(x)", "u_x - u_x", ""),
        ("exp(x)", "u_x - u", "the residual is not 0"),
    ],
)
def test_a_long_quotient(g: str, equation: str, message: str) -> None:
    """It is put in at values of its second generator if the slopes of both are constant."""
    formula = f"u = {LONG.replace('g', g)}"
    statement = {"variables": ["x", "t"]}
    atoms = ("x", g)
    data = certificate(equation, formula, atoms, {"x": "1", "t": "1"}, statement)
    if message:
        refused(data, message)
    else:
        assert formula[:20] in check_certificate(data)


def test_a_power_of_minus_one_has_a_value_at_integers_alone() -> None:
    nodes = Nodes()
    n = nodes.add("symbol", "n", "integer")
    turn = nodes.add("parity", n)
    assert Balls(nodes, {n: fmpq(3)}).ball(turn) == -1
    with pytest.raises(CertificateError, match="must be integers at the point"):
        Balls(nodes, {n: fmpq(1, 2)}).ball(turn)


SLOPES = [
    # formula, slope, wrong slope, atoms, hints
    ("sqrt(x/(1 + x**2))", "(1 - x**2)/(2*u*(1 + x**2)**2)", "1/(2*u*(1 + x**2)**2)", (), {}),
    ("(x/(1 + x)**2)**(1/3)", "(1 - x)/(3*u**2*(1 + x)**3)", "1/(3*u**2)", (), {}),
    ("exp(sqrt(9*x))", "3*u/(2*sqrt(x))", "9*u/2", ("sqrt(x)",),
     {"values": {"sqrt(9*x)": "3*sqrt(x)"}}),
    ("exp((1 + x**2)**3)", "6*x*(1 + x**2)**2*u", "3*(1 + x**2)**2*u", (), {}),
    ("exp(1/(1 + x)**2)", "-2*u/(1 + x)**3", "-2*u/(1 + x)", (), {}),
    ("x**(3/2)", "3*sqrt(x)/2", "sqrt(x)/2", ("sqrt(x)",), {}),
    ("abs(1 + I*x)", "x/u", "1/u", (), {}),
    ("log(2*x*(1 + x))", "1/x + 1/(1 + x)", "1/x", (), {}),
    ("exp(2*x*x*y)", "4*x*y*u", "2*x*y*u", (), {}),
    ("airy_ai(x**2)", "2*x*airy_ai_prime(x**2)", "airy_ai_prime(x**2)", ("airy_ai_prime(x**2)",),
     {}),
    ("airy_bi_prime(x)", "x*airy_bi(x)", "airy_bi(x)", ("airy_bi(x)",), {}),
    ("erf(x)", "2*exp(-x**2)/sqrt(pi)", "exp(-x**2)/sqrt(pi)",
     ("pi", "exp(-x**2)", "sqrt(pi)"), {}),
    ("lambert_w(x)", "u/(x*(1 + u))", "u/(1 + u)", (), {}),
]  # fmt: skip


@pytest.mark.parametrize("case", SLOPES, ids=lambda case: case[0])
def test_a_slope(case: tuple[str, str, str, tuple[str, ...], Hints]) -> None:
    formula, slope, wrong, atoms, hints = case
    own = () if formula == "x**(3/2)" else (formula,)
    for said, right in ((slope, True), (wrong, False)):
        statement = XY | {"domain": ["x > 0"]}
        atoms_of = ("x", "y", "I", *atoms, *own)
        data = certificate(f"u_x - ({said})", f"u = {formula}", atoms_of, POINT, statement, **hints)
        if right:
            assert f"u = {formula}" in check_certificate(data)
        else:
            refused(data, "the residual is not 0")


def test_a_hint_may_be_tried_before_its_generators_are_there() -> None:
    """What fails while y has no image is not "made of itself" when it has one."""
    root = "sqrt(1 + exp(2*x))"
    atoms = ("x", "exp(x)", root, "y", "exp(1)", "exp(y)")
    hints = {"values": {"exp(y + 1)": "exp(y + 1 + 0*x)"}}
    u = f"u = {root}*exp(y + 1)"
    data = certificate(f"u - {root}*exp(1)*exp(y)", u, atoms, POINT, XY, **hints)
    assert u in check_certificate(data)


def test_polynomials_in_symbols_may_be_0_at_the_point() -> None:
    data = certificate("u*x - 1", "u = 1/x", ["x"], {"x": "0"})
    assert "u = 1/x" in check_certificate(data)
    data = certificate("u*x - exp(x)", "u = exp(x)/x", ["x", "exp(x)"], {"x": "0"})
    refused(data, "a denominator is not shown to be other than 0")
