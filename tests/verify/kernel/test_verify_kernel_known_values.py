"""Values of special functions and conjugates: what the kernel refuses in certificates by hand."""

from typing import Any

import pytest

from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.limits import FORMAT, digest


def certificate(
    formula: str,
    value: str,
    generators: list[str],
    domain: list[str],
    values: list[tuple[str, str]],
    kind: str = "real",
) -> dict[str, Any]:
    """That a formula in x and a parameter b is ``value``, with values of functions by hand."""
    formulas = [*generators, *(text for pair in values for text in pair)]
    body: dict[str, Any] = {"format": FORMAT, "name": "value"}
    body["statement"] = {
        "variables": ["x"],
        "equations": [f"u - ({value})"],
        "solutions": [f"u = {formula} + 0*x"],
        "parameters": [f"b: {kind}"],
        "domain": domain,
    }
    first = len(generators)
    point = [[formulas.index(name), "3/4"] for name in ("x", "b") if name in formulas]
    body["proof"] = {
        "signs": [],
        "parts": [],
        "point": point,
        "formulas": formulas,
        "generators": [["atom", place] for place in range(first)],
        "values": [[first + 2 * n, first + 2 * n + 1] for n in range(len(values))],
    }
    return {**body, "digest": digest(body)}


W = ("lambert_w(x*exp(x))", ["x", "exp(x)"])


def test_w_is_what_it_inverts_from_minus_one_on() -> None:
    formula, generators = W
    data = certificate(formula, "x", generators, ["x >= -1"], [(formula, "x")])
    assert formula in check_certificate(data)


@pytest.mark.parametrize("domain", [[], ["x > -101/100"]])
def test_w_is_another_branch_below_minus_one(domain: list[str]) -> None:
    formula, generators = W
    with pytest.raises(CertificateError, match="not shown to be >= -1"):
        check_certificate(certificate(formula, "x", generators, domain, [(formula, "x")]))


def test_w_of_another_argument_is_refused() -> None:
    formula, generators = "lambert_w(2*x*exp(x))", W[1]
    with pytest.raises(CertificateError, match="that of another argument"):
        check_certificate(certificate(formula, "x", generators, ["x > 0"], [(formula, "x")]))


@pytest.mark.parametrize("name", ["bessel_k", "bessel_i", "bessel_j", "bessel_y"])
def test_k_alone_is_even_in_its_order(name: str) -> None:
    generators = ["x", "b", f"{name}(b, x)", f"{name}(b+1, x)"]
    data = certificate(f"{name}(-b, x)", f"{name}(b, x)", generators, ["x > 0"], [])
    if name == "bessel_k":
        assert "bessel_k(-b, x)" in check_certificate(data)
    else:
        with pytest.raises(CertificateError, match="there is no generator"):
            check_certificate(data)


def test_other_orders_are_of_no_known_function() -> None:
    generators = ["x", "b", "bessel_j(b, x)", "bessel_j(b+1, x)"]
    for formula in ("bessel_j(b+1/3, x)", "bessel_j(1/3, x)", "bessel_j(b, 2*x)"):
        with pytest.raises(CertificateError, match="there is no generator"):
            check_certificate(certificate(formula, formula, generators, ["x > 0"], []))


def test_a_complex_parameter_has_a_conjugate_of_its_own() -> None:
    """Catches: a parameter that is its own conjugate, or a modulus that is not in both."""
    generators = ["x", "b", "conjugate(b)"]
    for value, holds in (("b*conjugate(b)", True), ("b**2", False), ("conjugate(b)**2", False)):
        data = certificate("abs(b)**2", value, generators, [], [], "complex")
        if holds:
            assert "abs(b)**2" in check_certificate(data)
        else:
            with pytest.raises(CertificateError, match="is not 0"):
                check_certificate(data)


def test_only_a_complex_parameter_has_one() -> None:
    with pytest.raises(CertificateError, match="no generator for the conjugate"):
        check_certificate(certificate("abs(b)**2", "b**2", ["x", "b"], [], [], "complex"))
    for formula in ("conjugate(log(b))", "conjugate(b**(1/3))"):
        generators = ["x", "b", "b**(1/3)", "log(b)", formula]
        with pytest.raises(CertificateError, match="conjugate"):
            check_certificate(certificate(formula, formula, generators, [], [], "complex"))


def test_a_denominator_in_a_complex_parameter_is_looked_at_on_all_branches() -> None:
    """Catches: a walk without end from a conjugate to itself."""
    generators = ["x", "b", "conjugate(b)", "abs(b)"]
    right = certificate("1/(2+abs(b))", "1/(abs(b)+2)", generators, [], [], "complex")
    assert "abs(b)" in check_certificate(right)
    wrong = certificate("1/(3/4-abs(b))", "1/(3/4-abs(b))", generators, [], [], "complex")
    with pytest.raises(CertificateError, match="not shown to be other than 0"):
        check_certificate(wrong)


@pytest.mark.parametrize(
    ("formula", "value", "generators"),
    [
        ("jacobi_sn(x, b-b)", "sin(x)", ["x", "I", "b", "exp(I*x)"]),
        ("jacobi_cn(x, 1+b-b)", "sech(x)", ["x", "b", "exp(x)"]),
        ("elliptic_k(b-b)", "pi/2", ["x", "b", "pi"]),
        ("elliptic_e(1+b-b)", "1", ["x", "b"]),
        ("jacobi_epsilon(x, b-b)", "x", ["x", "b"]),
        ("jacobi_zeta(x, 0)", "0", ["x", "b", "pi"]),
    ],
)
def test_an_end_of_the_parameter_is_known_by_its_image(
    formula: str, value: str, generators: list[str]
) -> None:
    assert formula in check_certificate(certificate(formula, value, generators, [], []))


def test_k_of_one_has_no_value() -> None:
    with pytest.raises(CertificateError, match="there is no generator"):
        check_certificate(certificate("elliptic_k(1)", "1", ["x", "b"], [], []))


def test_w_without_a_value_is_refused() -> None:
    formula, generators = W
    with pytest.raises(CertificateError, match="no generator for a lambert_w"):
        check_certificate(certificate(formula, "x", generators, ["x > 0"], []))


ROOT = "sqrt(2)/(sqrt(pi)*sqrt(x))"
TURN, REAL = ["I", "exp(I*x)"], ["exp(x)"]


@pytest.mark.parametrize(
    ("formula", "value", "more"),
    [
        ("bessel_j(1/2, x)", "sin(x)", TURN),
        ("bessel_j(-1/2, x)", "cos(x)", TURN),
        ("bessel_y(1/2, x)", "-cos(x)", TURN),
        ("bessel_y(-1/2, x)", "sin(x)", TURN),
        ("bessel_i(1/2, x)", "sinh(x)", REAL),
        ("bessel_i(-1/2, x)", "cosh(x)", REAL),
        ("bessel_k(1/2, x)", "pi/2*exp(-x)", REAL),
        ("bessel_j(5/2, x)", "(3/x**2 - 1)*sin(x) - 3*cos(x)/x", TURN),
        ("bessel_i(-3/2, x)", "sinh(x) - cosh(x)/x", REAL),
    ],
)
def test_half_orders_are_elementary(formula: str, value: str, more: list[str]) -> None:
    """Catches: a sign, or the two orders in one another's places."""
    generators = ["x", "pi", "sqrt(2)", "sqrt(pi)", "sqrt(x)", *more]
    right = f"({value})*{ROOT}"
    assert formula in check_certificate(certificate(formula, right, generators, [], []))
    with pytest.raises(CertificateError, match="is not 0"):
        check_certificate(certificate(formula, f"-{right}", generators, [], []))
