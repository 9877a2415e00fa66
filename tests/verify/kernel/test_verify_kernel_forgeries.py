"""Forged certificates that the kernel once accepted."""

import pytest
from flint import ctx

from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.check import opened, registered
from longwave.verify.kernel.node_balls import BITS, Balls, value_at
from searches.forged_proofs import Proof, certificate, signed
from tests.verify.kernel.test_verify_kernel_attacks import refused


def test_one_number_does_not_stand_for_another() -> None:
    """After a part 1 = 1 every number was known as a function of equal arguments, of none."""
    proof = Proof()
    one = proof.place("1")
    same = proof.data(["x"], {"x": "1"})
    data = proof.data(["x", "2"], {"x": "1"}, parts=[[one, one, same]], more=[["part", 0]])
    statement = {"equations": ["u - v"], "solutions": ["u = 1", "v = 2"]}
    refused(signed(statement, proof, data), "number is no generator")


@pytest.mark.parametrize("real", ["re", "abs"])
def test_a_tanh_of_complex_argument_has_poles(real: str) -> None:
    """tanh(x + i pi/2) is coth x, so that 1/(1 + coth(x)**2) is 0 at 0, and its root has a kink."""
    odd, even = "(exp(x) - exp(-x))", "(exp(2*x) + exp(-2*x))"
    radicand = f"({odd}**2/(2*{even}))"
    v, w, root = f"(2*{even})**(1/2)", f"{radicand}**(1/2)", f"({odd}**2)**(1/2)"
    gap = f"({v}*{w} - {odd})"
    hints = {
        "values": {root: f"-1*{odd}"},
        "signs": {
            f"-1*{odd}": f"{v}*{w}*{gap}**2/{gap}**2",
            radicand: f"1/(1 + {real}(tanh(x + I*pi/2))**2)",
        },
        "sums": {
            "exp(2*x)": {"x": "2"},
            "exp(-x)": {"x": "-1"},
            "exp(-2*x)": {"x": "-2"},
            "exp(x + I*pi/2)": {"x": "1", "I*pi": "1/2"},
            "exp(x - I*pi/2)": {"x": "1", "I*pi": "-1/2"},
        },
    }
    atoms = ["x", "I", "pi", "exp(x)", v, w]
    data = certificate(f"u + {odd}", f"u = {root}", atoms, {"x": "-1"}, **hints)
    refused(data, "a denominator is not shown")


@pytest.mark.parametrize("white", ["\r", "\f", "\v", "\t"])
def test_no_white_space_hides_a_part_of_what_is_printed(white: str) -> None:
    """A carriage return lets what follows it be written over what stands before it."""
    printed = check_certificate(certificate(f"u -{white}x", "u = x", ["x"], {"x": "1"}))
    assert "equation: u - x\n" in printed


@pytest.mark.parametrize(
    "domain",
    [
        "k: k != integer",
        "k: integer > k",
        "k: k>0, k < 2*integer",
        "k: 0 < integer < k",
        "k: k + abs(integer) != 0",
    ],
)
def test_a_kind_within_an_inequality_is_none(domain: str) -> None:
    """``k: k != integer`` made k an integer, with "integer" a parameter beside it."""
    data = certificate(
        "u - 1", "u = exp(2*I*pi*k) + 0*x", ["x", "I", "pi", "k"], {"x": "1", "k": "2"},
        {"parameters": [domain]},
    )  # fmt: skip
    refused(data, "has no meaning at this place|expected ,")


@pytest.mark.parametrize("word", ["real", "integer", "complex", "function", "nonzero", "positive"])
def test_a_word_for_a_domain_is_no_name(word: str) -> None:
    """A condition on a name ``integer`` reads as a word for a domain."""
    for statement in (
        {"parameters": [f"{word} = 2"]},
        {"parameters": [f"{word}: {word} > 0"]},
        {"variables": ["x", word]},
        {"domain": [f"x < {word}"]},
        {"equations": [f"u - x + {word} - {word}"]},
        {"equations": [f"{word} - x"], "solutions": [f"{word} = x"]},
    ):
        data = certificate("u - x", "u = x", ["x"], {"x": "1"}, statement)
        refused(data, "has no meaning at this place|means two things")


def logarithm(formula: str) -> str:
    """A formula's square, positive wherever it is defined: nowhere where the formula is 0."""
    return f"1/4*exp(log((2*{formula})**2))"


HALF_LINE = "(x + abs(x))"
"""Not 0 for x > 0 alone."""

JUMP = "(atan(x) + atan(1/x) - pi/2)"
"""Not 0 for x < 0 alone."""

FALSE_ROOTS = [
    (HALF_LINE, f"{HALF_LINE}**2", logarithm(HALF_LINE), "1"),
    (JUMP, f"{JUMP}**2/(1 + {JUMP}**2)", f"1/(1 + 1/{JUMP}**2)", "-1"),
]


ONE = f"{JUMP}/{JUMP}"
"""1, where it is defined: for x < 0."""

JUMPING = ["x", "pi", "atan(x)", "atan(1/x)"]


@pytest.mark.parametrize(
    ("one", "atoms", "message"),
    [
        (ONE, JUMPING, "a denominator that may jump is none of the statement's"),
        (f"exp(0*{ONE})", JUMPING, "a denominator that may jump is none of the statement's"),
        (f"jacobi_cn(0*{ONE}, 1/2)", JUMPING, "a denominator that may jump is none of the"),
        (f"{HALF_LINE}/{HALF_LINE}", ["x", "abs(x)"], "not shown to be other than 0"),
        ("(1 + atan(x)**2)/(1 + atan(x)**2)", ["x", "atan(x)"], ""),
        ("(3 + atan(1/x))/(3 + atan(1/x))", ["x", "atan(1/x)"], "a denominator that may jump"),
        ("log(1 + x**2)/log(1 + x**2)", ["x", "log(1 + x**2)"], ""),
        ("log(x)/log(x)", ["x", "log(x)"], "a denominator that may jump"),
        ("lambert_w(x)/lambert_w(x)", ["x", "lambert_w(x)"], ""),
        ("bessel_y(1, x)/bessel_y(1, x)", ["x", "bessel_y(1, x)", "bessel_y(2, x)"], "may jump"),
    ],
)
def test_a_hint_is_undefined_on_no_part_of_a_domain(
    one: str, atoms: list[str], message: str
) -> None:
    """A hint that divides by what is 0 for x > 0 shows nothing there."""
    point = "-2" if JUMP in one else "2"
    data = certificate("u_x - u", "u = exp(x)", [*atoms, f"exp(x*{one})"], {"x": point})
    if message:
        refused(data, message)
    else:
        assert "u = exp(x)" in check_certificate(data)


def test_a_generator_is_undefined_on_no_part_of_a_domain() -> None:
    """log(x + abs(x)) is not defined for x < 0, and nothing divides by it."""
    atoms = ["x", "abs(x)", f"log({HALF_LINE})"]
    data = certificate("u_x - 1", "u = x", atoms, {"x": "2"})
    refused(data, "a denominator is not shown to be other than 0")


def test_an_exponential_is_nowhere_0() -> None:
    atoms = ["x", "log(x)", "exp(exp(2*log(x)))", "exp(1)"]
    data = certificate("u_x + 2*x*u", "u = exp(1 - exp(2*log(x)))", atoms, {"x": "2"})
    assert "exp(2*log(x))" in check_certificate(data)


def test_a_statement_may_divide_by_what_jumps() -> None:
    """It is not smooth where that is 0."""
    u = f"u = 1/{JUMP}"
    assert u in check_certificate(certificate(u.replace("=", "-"), u, JUMPING, {"x": "-2"}))
    for function in ("tanh(log(x))", "coth(log(x))", "tan(log(x))", "1/log(x)"):
        u = f"u = {function}"
        atoms = ["x", "I", "log(x)", "exp(log(x)*I)"]
        assert u in check_certificate(certificate(u.replace("=", "-"), u, atoms, {"x": "2"}))
    u = f"u = x/{JUMP}"
    data = certificate(f"u_x*{JUMP} - 1", u, JUMPING, {"x": "-2"})
    assert u in check_certificate(data)


def test_an_equal_part_may_not_divide_by_what_jumps() -> None:
    """Its sides are hints of the proof that rests on it."""
    proof = Proof()
    left, right = f"x*{ONE}", f"x*({JUMP} + 1 - 1)/{JUMP}"
    same = proof.data(JUMPING, {"x": "-2"})
    data = proof.data(
        ["x"], {"x": "-2"}, parts=[[proof.place(left), proof.place(right), same]],
        more=[["part", 0]],
    )  # fmt: skip
    statement = {"equations": ["u - x"], "solutions": ["u = x"]}
    refused(signed(statement, proof, data), "a denominator that may jump is none")


@pytest.mark.parametrize("by_hint", [True, False])
@pytest.mark.parametrize(("zero", "real", "witness", "point"), FALSE_ROOTS)
def test_a_real_part_is_not_positive_where_its_witness_is_undefined(
    zero: str, real: str, witness: str, point: str, by_hint: bool
) -> None:
    """sqrt(w**2) is w where the real part of w is positive, and -w for w = -i."""
    atoms = ["x", "I", "abs(x)", "pi", "atan(x)", "atan(1/x)", f"log((2*{zero})**2)"]
    w = f"{real} + I*x*{point}"
    value = w if by_hint else f"{witness} + I*x*{point}"
    signs = {real: witness} if by_hint else {}
    data = certificate(
        f"u - sqrt(({w})**2)", f"u = {w}", atoms, {"x": point},
        values={f"sqrt(({w})**2)": value}, signs=signs,
    )  # fmt: skip
    refused(data, "not shown to be >= 0 on the domain|not shown to be finite")


@pytest.mark.parametrize(
    ("equation", "solution", "value", "zero", "square", "domain"),
    [
        ("u - asin(sin(x))", "u = x", "asin(sin(x))", "cos(x)", "1 - sin(x)**2", ["0 < x < 2"]),
        ("u - atan(x/x**2)", "u = pi/2 - atan(x)", "atan(x/x**2)", "x", "x**2", []),
    ],
)
def test_a_value_is_not_kept_through_a_point_at_which_a_witness_is_undefined(
    equation: str, solution: str, value: str, zero: str, square: str, domain: list[str]
) -> None:
    """asin(sin(1.8)) is pi - 1.8, and atan(1/x) jumps at x = 0."""
    atoms = ["x", "I", "pi", "exp(I*x)", "atan(x)", f"log((2*{zero})**2)"]
    data = certificate(
        equation, solution, atoms, {"x": "1"}, {"domain": domain},
        values={value: solution.removeprefix("u = ")}, signs={square: logarithm(zero)},
    )  # fmt: skip
    refused(data, "not shown to be a principal value")


def test_no_point_of_a_domain_is_alone() -> None:
    """With sign(0) = 0 the domain holds x = 0, at which abs(x - 1) is not x - 1."""
    domain, hints = "0 < x + 1 - 2*sign(x)**2", {"values": {"abs(x-1)": "x-1"}}
    data = certificate(
        "u - abs(x-1)", "u = x-1", ["x", "abs(x)"], {"x": "2"}, {"domain": [domain]}, **hints
    )
    refused(data, "real and without jumps")


@pytest.mark.parametrize("index", ["n+1+1", "n+x+7", "n+1/2+k", "n+n+n"])
def test_an_index_of_more_terms_is_not_its_variable(index: str) -> None:
    """What had two terms besides its variable was read as the variable alone."""
    statement = {"variables": ["n", "x"]}
    data = certificate(f"u[{index}] - u[n]", "u[n] = n", ["n"], {"n": "1", "x": "1"}, statement)
    refused(data, "the residual is not 0|an index must be a variable plus an integer")


def test_an_index_of_numbers_is_their_sum() -> None:
    statement = {"variables": ["n"]}
    data = certificate("u[n+3-1] - u[n] - 2", "u[n] = n", ["n"], {"n": "1"}, statement)
    assert "u[n+3-1]" in check_certificate(data)


def test_a_multiple_of_a_root_of_unity_does_not_satisfy_its_relation() -> None:
    """The relation of w**4 has lower powers of w, in which 2*w was put as if it were w."""
    w, proof = "exp(2*I*pi/5)", Proof()
    data = proof.data(["x", "I", "pi"], {"x": "1"})
    form = [proof.place("2")], proof.place("0")
    data["generators"].append(["forms", [proof.place(w)], [list(form)]])
    solution = f"u = x*({w}**4 + 8*{w}**3 + 4*{w}**2 + 2*{w} + 1)"
    statement = {"equations": ["u"], "solutions": [solution]}
    refused(signed(statement, proof, data), "a multiple of a root of unity is no generator")


MULTIPLES = [
    (["x"], "sqrt(x)"),
    (["x"], "(1/x)**(1/3)"),
    (["x"], "abs(x)"),
    (["I"], "exp(2*I*pi/5)"),
    (["x", "jacobi_cn(x, 1/2)"], "jacobi_sn(x, 1/2)"),
    (["x", "weierstrass_p(x, 1, 1)"], "weierstrass_p_prime(x, 1, 1)"),
    (["n"], "(-1)**n"),
    ([], "I"),
]


@pytest.mark.parametrize("factor", ["1", "2", "-3/2", "x", "1 + x**2", "pi"])
@pytest.mark.parametrize(("atoms", "root"), MULTIPLES)
def test_the_relation_of_a_multiple_holds_at_a_point(
    atoms: list[str], root: str, factor: str
) -> None:
    """Or there is none: a multiple of a root of unity is refused."""
    proof = Proof()
    everything = list(dict.fromkeys(["pi", "x", *atoms]))
    data = proof.data(everything, {"x": "2/3", "n": "3"})
    form = [[proof.place(factor)], proof.place("0")]
    data["generators"].append(["forms", [proof.place(root)], [form]])
    stated = {"variables": ["x", "n"], "equations": ["u"], "solutions": ["u = x"]}
    statement = opened(signed(stated, proof, data))
    if root.startswith("exp") and factor != "1":
        with pytest.raises(CertificateError, match="a multiple of a root of unity"):
            registered(statement, data)
        return
    field = registered(statement, data)
    values = field.balls(Balls(field.nodes, field.point))
    with ctx.workprec(BITS):
        moduli = [value_at(modulus, values) for *_, modulus in field.ring.relations]
    assert len(moduli) > 0
    assert all(modulus.contains(0) for modulus in moduli)


def test_theta_of_a_difference_is_that_of_the_product_theorem() -> None:
    theta, sine = "jacobi_theta({}, 1/2)", "jacobi_sn({}, 1/2)"
    left = f"u*{theta.format('x + d')}*{theta.format('0*x')}**2"
    even = f"(1 - 1/2*{sine.format('x')}**2*{sine.format('d')}**2)"
    right = f"({theta.format('d')}*{theta.format('x')})**2*{even}"
    forms = [theta.format(z) for z in ("x", "d", "x + d", "0*x")]
    atoms = ["x", "d", *(sine.format(z) for z in "xd"), *forms]
    for factor, message in (("1", ""), ("2", "the numerator of the residual is not 0")):
        data = certificate(
            f"{left} - {factor}*{right}", f"u = {theta.format('x - d')}", atoms,
            {"x": "1/3", "d": "1/5"},
        )  # fmt: skip
        if message:
            refused(data, message)
        else:
            assert "x - d" in check_certificate(data)
