"""What a domain shows of a formula, text by text: reality, bounds, smoothness, conjugates."""

from __future__ import annotations

import pytest
from flint import fmpq

from longwave.verify.kernel import CertificateError
from longwave.verify.kernel.bounds import POSITIVE, UNIT, Interval
from longwave.verify.kernel.denominators import is_continuous_end, is_linear
from longwave.verify.kernel.field import Field, Hints
from longwave.verify.kernel.inverse_rules import is_continuous, is_convex, is_kept
from longwave.verify.kernel.nodes import Nodes
from longwave.verify.kernel.reading import Scope, formula
from longwave.verify.kernel.root_rules import angle_of, real_part
from longwave.verify.kernel.table import RULES


class Domain:
    """The field of real x, y, an integer n, a complex z and a function f, where x, y > 0."""

    def __init__(self, *positive: str, signs: dict[str, str] | None = None) -> None:
        self.scope = Scope(Nodes())
        for name, kind in (("n", "integer"), ("z", "complex"), ("f", "function")):
            self.scope.declare(name, kind)
        gaps = {self.node(text.removesuffix("=")): text.endswith("=") for text in positive}
        hints = {self.node(left): self.node(right) for left, right in (signs or {}).items()}
        self.scope.variables = [self.node("x"), self.node("y")]
        self.field = Field(self.scope.nodes, 4, self.scope.variables, gaps, Hints({}, hints), RULES)
        for name in "xyabc"[:4]:
            self.field.register(self.node(name))

    def node(self, text: str) -> int:
        return formula(self.scope, text)


WIDE, NARROW = Domain("x", "y="), Domain("x", "1 - x", "y + 1", "1 - y=")

REAL = {
    "x": True, "n": True, "z": False, "I": False, "pi": True, "2": True, "x + n": True,
    "x*z": False, "I*I": False, "abs(z)": True, "re(z)": True, "im(z)": True, "sqrt(x)": True,
    "sqrt(y)": True, "sqrt(a)": False, "a**2": True, "z**2": False, "x**a": True, "a**x": False,
    "x**z": False, "2**z": False, "a**n": False, "bessel_j(n, a)": True, "bessel_j(n, z)": False,
    "bessel_j(2, a)": True, "bessel_j(b, a)": False, "bessel_j(b, x)": True,
    "bessel_i(n, a)": True, "bessel_k(n, a)": False, "bessel_k(n, x)": True, "log(x)": True,
    "log(a)": False, "log(y)": True, "exp(a)": True, "exp(z)": False, "f(x)": True, "f(z)": False,
    "lambert_w(x)": True, "lambert_w(a)": False, "elliptic_k(1/2)": True, "elliptic_k(2)": False,
    "elliptic_k(1)": False, "jacobi_sn(a, 2)": True, "jacobi_sn(z, 1/2)": False,
    "jacobi_zeta(a, 2)": False, "jacobi_zeta(a, 1/2)": True, "jacobi_theta(a, 1/2)": True,
    "jacobi_theta(a, -1/2)": False, "jacobi_theta(a, 0)": False, "asin(a)": False,
    "jacobi_theta_1(a, 1/2)": True, "jacobi_theta_1(a, -1/2)": False,
    "asin(x/(1 + x))": False, "sign(a)": True, "conjugate(a)": True, "conjugate(z)": False,
}  # fmt: skip


@pytest.mark.parametrize("text", REAL)
def test_what_is_real(text: str) -> None:
    assert WIDE.field.signs.is_real(WIDE.node(text)) is REAL[text]


REAL_BETWEEN = {
    "asin(x)": True, "asin(y)": True, "acos(x)": True, "atanh(y)": True, "asin(x + 1)": False,
    "asin(2*y)": False, "acosh(x)": False, "acosh(x + 1)": True, "asin(-x)": True,
}  # fmt: skip


@pytest.mark.parametrize("text", REAL_BETWEEN)
def test_an_inverse_function_is_real_between_its_ends(text: str) -> None:
    assert NARROW.field.signs.is_real(NARROW.node(text)) is REAL_BETWEEN[text]


def inside(low: int | None, high: int | None, *opens: bool) -> Interval:
    ends = (None if end is None else fmpq(end) for end in (low, high))
    return Interval(*ends, *opens)


BOUNDS = {
    "x": inside(0, 1, True, True), "y": inside(-1, 1, True, False),
    "x + y": inside(-1, 2, True, True),
    "2*x - 3": inside(-3, -1, True, True), "y**2": inside(0, 1), "a": Interval(),
    "1/x": inside(1, None, True), "x**3": inside(0, 1, True, True), "sqrt(x)": inside(0, 1, True),
    "x**(-1/2)": inside(1, None), "x**y": POSITIVE, "2**a": POSITIVE,
    "abs(y)": inside(0, 1),
    "abs(a)": Interval(fmpq(0)), "abs(z)": Interval(fmpq(0)),
    "exp(-x)": Interval(fmpq(367879, 10**6), fmpq(1), True, True),
    "exp(x)": Interval(fmpq(1), fmpq(2718282, 10**6), True, True),
    "exp(y - 1)": Interval(fmpq(27067, 200000), fmpq(1), True), "exp(a)": POSITIVE,
    "cos(y)": inside(0, 1, True), "cos(2*y)": UNIT, "sin(x)": inside(0, 1, True), "sin(y)": UNIT,
    "sin(y + 1)": inside(0, 1, True), "sin(1 - y)": inside(0, 1), "sin(4*x)": UNIT,
    "jacobi_dn(a, x)": inside(0, 1, True), "jacobi_dn(a, y - 1)": POSITIVE,
    "jacobi_dn(a, 2)": Interval(), "jacobi_sn(a, x)": UNIT, "tanh(a)": inside(-1, 1, True, True),
    "tanh(x)": inside(0, 1, True, True), "tanh(-x)": inside(-1, 0, True, True),
    "sinh(x)": POSITIVE, "sinh(a)": Interval(), "cosh(a)": inside(1, None),
    "sech(a)": inside(0, 1, True),
    "erf(a)": inside(-1, 1, True, True), "erf(x)": inside(0, 1, True, True),
    "bessel_k(a, x)": POSITIVE, "bessel_j(a, x)": Interval(), "bessel_i(a, x)": Interval(),
    "lambert_w(x)": inside(0, None), "elliptic_k(x)": POSITIVE, "jacobi_theta(a, x)": POSITIVE,
    "acos(x)": inside(0, None), "asin(x)": POSITIVE, "atan(x)": POSITIVE, "log(x)": Interval(),
    "pi - 3": Interval(fmpq(141592, 10**6), fmpq(141593, 10**6)), "z": Interval(), "I": Interval(),
    "3": inside(3, 3), "conjugate(x)": POSITIVE, "f(x)": Interval(), "x*a": Interval(),
}  # fmt: skip


@pytest.mark.parametrize("text", BOUNDS)
def test_where_a_formula_is(text: str) -> None:
    found = NARROW.field.signs.interval(NARROW.node(text))
    assert found == BOUNDS[text]


def test_what_the_domain_says_of_a_multiple_and_a_sum() -> None:
    signs, node = WIDE.field.signs, WIDE.node
    assert signs.interval(node("2*x + 3")) == inside(3, None, True)
    assert signs.interval(node("3 - 2*x")) == inside(None, 3, False, True)
    assert signs.interval(node("5 - y")) == inside(None, 5)
    both = Domain("x - y + 1", "2*a*x=")
    assert both.field.signs.interval(both.node("3*x - 3*y")) == inside(-3, None, True)
    assert both.field.signs.interval(both.node("x*a - 1")) == inside(-1, None)
    assert both.field.signs.interval(both.node("x + y")) == Interval()
    assert both.field.signs.interval(both.node("x + y + w")) == Interval()
    assert both.field.signs.below_one(both.node("y - x")) is True
    assert both.field.signs.below_one(both.node("x - y")) is False


def test_a_witness_shows_a_sign_with_its_ends_where_it_is_defined() -> None:
    square = Domain(signs={"x**2 + 2*x + 1": "(x + 1)**2", "x**2 + x**2": "1/(1/2/x**2)"})
    signs = square.field.signs
    assert signs.interval(square.node("x**2 + 2*x + 1")) == Interval(fmpq(0))
    assert signs.interval(square.node("x**2 + x**2")) == Interval(fmpq(0))
    other = Domain(signs={"x*y": "(x + 1)**2"})
    with pytest.raises(CertificateError, match="the witness of a sign has another image"):
        other.field.signs.interval(other.node("x*y"))
    plain = Domain("a", signs={"a*x*x": "a*x**2", "b*b + 1": "1 + b**2"})
    assert plain.field.signs.interval(plain.node("b*b + 1")) == inside(1, None)


ANALYTIC = {
    "x": True, "I*x + pi": True, "x**-2": True, "sqrt(x)": True, "sqrt(y)": False,
    "sqrt(a)": False, "sqrt(1/x)": True, "sqrt(x + a**2)": True, "sqrt(x + 1/a**2)": False,
    "exp(a)": True, "log(x)": False, "abs(x)": False, "sign(x)": False, "conjugate(z)": False,
    "jacobi_sn(1/a, a)": True, "jacobi_zeta(1/a, 1/2)": True, "jacobi_zeta(a, 1/x)": True,
    "jacobi_zeta(a, 1/b)": False, "elliptic_k(1/b)": False, "elliptic_k(b)": True,
    "jacobi_theta(1/a, b)": True, "tanh(a)": False, "exp(abs(x))": False, "f(x)": False,
    "bessel_j(0, x)": False, "atan(x)": False, "airy_ai(z)": True,
}  # fmt: skip


@pytest.mark.parametrize("text", ANALYTIC)
def test_what_is_analytic_but_for_poles(text: str) -> None:
    assert WIDE.field.signs.is_analytic(WIDE.node(text)) is ANALYTIC[text]


BOUNDED = {
    "x": True, "1/x": True, "1/a": False, "1/y": False, "1/(1 + y)": True, "a**(1/2)": True,
    "a**(-1/2)": False, "exp(1/a)": False, "exp(z)": True, "abs(z)": True, "conjugate(z)": True,
    "re(z)": True, "sign(x)": False, "log(x)": False, "tanh(a)": True, "tanh(z)": False,
    "tan(a)": False, "atan(a)": True, "atan(z)": False, "asin(x)": False, "erf(z)": True,
    "jacobi_sn(a, 1/2)": True, "jacobi_sn(a, b)": True, "jacobi_sn(z, 1/2)": False,
    "jacobi_zeta(a, 1/2)": True, "jacobi_zeta(a, b)": False, "jacobi_theta(a, 1/2)": True,
    "f(a)": True, "f(z)": False, "jacobi_theta_3(a, 1/2)": True, "a**0": False, "x**0": True,
    "elliptic_k(1/2)": True, "elliptic_k(1)": False, "elliptic_k(b)": False, "log(2)": True,
    "log(0)": False, "diff(2, x)": False, "x**a": False,
}  # fmt: skip


@pytest.mark.parametrize("text", BOUNDED)
def test_what_has_no_poles_and_no_jumps(text: str) -> None:
    assert WIDE.field.signs.is_bounded(WIDE.node(text)) is BOUNDED[text]


def test_what_is_bounded_has_bounded_witnesses() -> None:
    for witness, bounded in (("(a + 1)**2", True), ("1/(1/(a + 1)**2)", False)):
        domain = Domain(signs={"a**2 + 2*a + 1": witness})
        node = domain.node("a**2 + 2*a + 1")
        assert domain.field.signs.is_bounded(node) is bounded
        assert domain.field.signs.is_bounded(domain.node("exp(a**2 + 2*a + 1)")) is bounded


CONTINUOUS = {
    "x": True, "n": False, "z": False, "1/x": True, "1/y": False, "y**2": True, "x**0": True,
    "y**0": False, "abs(a)": True, "log(x)": True, "log(y)": False, "exp(a)": True, "tan(a)": False,
    "atan(a)": True, "tanh(1/y)": False, "sign(x)": False, "I*x": False, "pi*x + 1": True,
    "re(z)": False, "sqrt(y)": True, "jacobi_sn(a, b)": True, "elliptic_k(1/2)": False,
}  # fmt: skip


@pytest.mark.parametrize("text", CONTINUOUS)
def test_what_is_real_and_continuous(text: str) -> None:
    assert is_continuous(WIDE.field, WIDE.node(text)) is CONTINUOUS[text]


def test_inverse_functions_are_continuous_where_they_are_real() -> None:
    for name in ("asin", "acos", "acosh"):
        inner = "x + 1" if name == "acosh" else "x"
        assert is_continuous(NARROW.field, NARROW.node(f"{name}({inner})")) is True
        assert is_continuous(NARROW.field, NARROW.node(f"{name}(5*y - 5)")) is False


LINEAR = {
    "3": True, "pi": True, "x": True, "n": True, "z": False, "I": False, "x + 2*y - pi": True,
    "2*pi*x": True, "x*y": False, "x*x": False, "2*(x + y)": True, "2*(x*y)": False, "x**2": False,
    "x**1": True, "x/2": True, "exp(x)": False, "x + exp(x)": False, "2*3": True, "f(x)": False,
}  # fmt: skip


@pytest.mark.parametrize("text", LINEAR)
def test_what_is_of_degree_one(text: str) -> None:
    assert is_linear(WIDE.scope.nodes, WIDE.node(text)) is LINEAR[text]


@pytest.mark.parametrize(
    ("positive", "convex"),
    [((), True), (("x", "1 - x - y"), True), (("x*y",), False), (("n",), False), (("z",), False)],
)
def test_a_domain_is_convex_if_its_ends_are_linear_in_reals(
    positive: tuple[str, ...], convex: bool
) -> None:
    assert is_convex(Domain(*positive).field) is convex


def test_ends_of_a_domain() -> None:
    good = {"elliptic_k(x)", "elliptic_k(x**2)", "x", "1/(1 + x)", "sin(a)", "elliptic_k(1/2)"}
    bad = {"elliptic_k(2)", "elliptic_k(a)", "1/a", "sign(a)", "z", "I*I", "log(a)"}
    for text in good | bad:
        assert is_continuous_end(NARROW.field, NARROW.node(text)) is (text in good), text


CONJUGATES = {
    "x": "x", "I": "-I", "x + I*y": "x + (-I)*y", "z": "conjugate(z)", "conjugate(z)": "z",
    "(x + I)**-2": "(x + (-I))**-2", "sqrt(I*x)": None, "exp(I*x)": "exp((-I)*x)",
    "tan(I*x)": "tan((-I)*x)", "log(I*x)": None, "atan(I*x)": None,
    "jacobi_sn(I*x, b)": "jacobi_sn((-I)*x, b)", "jacobi_sn(x, I*b)": None, "f(I*x)": "f((-I)*x)",
    "diff(I*x, x)": "diff((-I)*x, x)", "weierstrass_p(I*x, a, b)": "weierstrass_p((-I)*x, a, b)",
    "bessel_j(I, x)": None, "abs(z)": "abs(z)", "sign(z)": "1/sign(z)",
    "sign(a)": "sign(a)", "sign(x + I*y)": "1/sign(x + I*y)",
    "jacobi_theta_1'(I*x, b)": "jacobi_theta_1'((-I)*x, b)",
}  # fmt: skip


@pytest.mark.parametrize("text", CONJUGATES)
def test_conjugates_as_formulas(text: str) -> None:
    expected, signs = CONJUGATES[text], WIDE.field.signs
    if expected is None:
        with pytest.raises(CertificateError, match="does not follow from the domain"):
            signs.conjugate(WIDE.node(text))
    else:
        assert signs.conjugate(WIDE.node(text)) == WIDE.node(expected)


def test_angles_and_real_parts() -> None:
    field, node, nodes = WIDE.field, WIDE.node, WIDE.scope.nodes
    angles = {"I*x": "x", "2*I*a": "2*a", "I": None, "I*z": None, "I*I*x": None, "x": None}
    for text, angle in angles.items():
        assert angle_of(field, node(text)) == (None if angle is None else node(angle)), text
    parts = {
        "x": "x", "I": "0", "x + I*y": "x + 0*y", "z": None, "x + z": None, "I*z": None,
        "x*exp(I*a)": "cos(a)*x", "exp(I*a)": "cos(a)", "exp(z)": None, "I*z*x": None,
        "(1 + I)*x": "(1 + 0)*x", "sqrt(z)": "abs(re(sqrt(z)))", "z**(1/3)": None,
    }  # fmt: skip
    for text, part in parts.items():
        found = real_part(field, node(text))
        assert found == (None if part is None else node(part)), (text, found and nodes.all[found])


KEPT = [
    # domain, function, argument, value, whether it is the principal one by continuity
    (("1 - x", "x + 1"), "acos", "x", "pi/2 - asin(x)", True),
    (("1 - x", "x + 1"), "acos", "x", "asin(x) - pi/2", False),
    (("1 - x", "x + 1"), "acos", "x", "5*pi/2 - asin(x)", False),
    (("1 - x", "x + 1"), "acos", "x", "pi/2 + asin(x)", True),
    (("1 - x", "x + 1"), "acos", "x", "0", False),
    (("1 - x", "x + 1"), "asin", "x", "asin(x)", True),
    (("1 - x", "x + 1"), "asin", "x", "pi - asin(x)", False),
    (("1 - x", "x + 1"), "asin", "x", "-pi - asin(x)", False),
    (("1 - x=", "x + 1="), "asin", "x", "asin(x)", False),
    (("2 - x", "x + 1"), "asin", "x", "asin(x)", False),
    ((), "atan", "x", "atan(x)", True),
    ((), "atan", "x", "atan(x) + pi", False),
    ((), "atan", "x", "atan(x) - pi", False),
    ((), "atan", "1/x", "atan(1/x)", False),
    ((), "atan", "x", "sign(x)", False),
    (("x*y",), "atan", "x", "atan(x)", False),
    ((), "atanh", "x", "atan(x)", False),
]  # fmt: skip


@pytest.mark.parametrize("case", KEPT, ids=str)
def test_a_value_is_kept_on_a_convex_domain(
    case: tuple[tuple[str, ...], str, str, str, bool],
) -> None:
    positive, name, argument, value, kept = case
    domain = Domain(*positive)
    domain.field.point = {domain.node("x"): fmpq(1, 2), domain.node("y"): fmpq(1)}
    assert is_kept(domain.field, name, domain.node(argument), domain.node(value)) is kept
