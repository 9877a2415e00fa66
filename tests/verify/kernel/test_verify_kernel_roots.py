"""Which values a kernel takes for a principal root: certificates written by hand."""

from typing import Any

import pytest

from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.limits import FORMAT, digest


def certificate(
    root: str, value: str, generators: list[str], domain: list[str], kind: str = "real"
) -> dict[str, Any]:
    """That a root, which is no generator, equals ``value``; b is a parameter."""
    formulas = [*generators, root, value]
    body: dict[str, Any] = {"format": FORMAT, "name": "root"}
    body["statement"] = {
        "variables": ["x"],
        "equations": [f"u - ({value})"],
        "solutions": [f"u = {root} + 0*x"],
        "parameters": [f"b: {kind}"],
        "domain": domain,
    }
    places = {name: place for place, name in enumerate(formulas)}
    point = [[places[name], "3/4"] for name in ("x", "b") if name in places]
    body["proof"] = {
        "signs": [],
        "parts": [],
        "point": point,
        "formulas": formulas,
        "generators": [["atom", place] for place in range(len(generators))],
        "values": [[len(formulas) - 2, len(formulas) - 1]],
    }
    return {**body, "digest": digest(body)}


PAIR = ["x", "b", "sqrt(1+x)", "sqrt(1-x)"]
RIGHT = [
    ("sqrt(b)", "(b**(1/4))**2", ["x", "b", "b**(1/4)"], "complex"),
    ("sqrt(4*b)", "2*(b**(1/4))**2", ["x", "b", "b**(1/4)"], "complex"),
    ("sqrt(1-x**2)", "sqrt(1+x)*sqrt(1-x)", PAIR, "real"),
    ("sqrt((1-x**2)*(1+b**2)**2)", "(1+b**2)*sqrt(1+x)*sqrt(1-x)", PAIR, "real"),
]
WRONG = [
    ("(b**2)**(1/6)", "b**(1/3)", ["x", "b", "b**(1/3)"], "complex"),  # b = -1
    ("sqrt(b**3)", "(b**(1/4))**6", ["x", "b", "b**(1/4)"], "complex"),  # b = -1
    ("sqrt(1/b)", "b**(-1/2)", ["x", "b", "b**(1/2)"], "complex"),  # b = -1
    ("sqrt(x**2*b)", "x*b**(1/2)", ["x", "b", "b**(1/2)"], "real"),  # x < 0
    ("sqrt(x**2-1)", "sqrt(x+1)*sqrt(x-1)", ["x", "b", "sqrt(x+1)", "sqrt(x-1)"], "real"),
    ("sqrt((x+b)*(x-b))", "sqrt(x+b)*sqrt(x-b)", ["x", "b", "sqrt(x+b)", "sqrt(x-b)"], "real"),
    ("sqrt(1-b**2)", "sqrt(1+b)*sqrt(1-b)", ["x", "b", "sqrt(1+b)", "sqrt(1-b)"], "complex"),
]  # of the last it is true, but nothing is said of two numbers that are not real


@pytest.mark.parametrize(("root", "value", "generators", "kind"), RIGHT)
def test_a_principal_root_is_accepted(
    root: str, value: str, generators: list[str], kind: str
) -> None:
    assert root in check_certificate(certificate(root, value, generators, [], kind))


@pytest.mark.parametrize(("root", "value", "generators", "kind"), WRONG)
def test_a_root_on_another_branch_is_refused(
    root: str, value: str, generators: list[str], kind: str
) -> None:
    with pytest.raises(CertificateError, match="not shown to be >= 0"):
        check_certificate(certificate(root, value, generators, [], kind))


def test_the_sum_of_two_radicands_is_positive_by_signs_too() -> None:
    generators = ["x", "b", "sqrt(x+b)", "sqrt(b**2-x)"]
    root, value = "sqrt((x+b)*(b**2-x))", "sqrt(x+b)*sqrt(b**2-x)"
    with pytest.raises(CertificateError, match="not shown to be >= 0"):
        check_certificate(certificate(root, value, generators, []))
    domain = ["x+b+b**2-x > 0"]
    assert root in check_certificate(certificate(root, value, generators, domain))
