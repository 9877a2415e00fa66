"""Roots whose sign follows from a domain: factors in one exponential, ends that are logarithms."""

import pytest
import sympy as sp

from longwave.verify.proof.domain_signs import DomainSigns, excess_of_exponential
from longwave.verify.proof.domains import Domain
from longwave.verify.proof.seams import seams
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.text_prover import prove

FLAT, PERIODIC = "u_x - sqrt((u+1)**2-1)", "u_x - sqrt(1-u**2)"
GROWING = "u = exp(-x) + exp(x)/4 - 1"


@pytest.mark.parametrize(
    ("equation", "solution", "domain", "outcome"),
    [
        (FLAT, GROWING, "x > 1", "PROVED"),
        (FLAT, GROWING, "x > log(2)", "PROVED"),
        (FLAT, GROWING, "x > 7/10", "PROVED"),
        (FLAT, GROWING, "x > 69/100", "REFUTED"),
        (FLAT, GROWING, "x < log(2)", "REFUTED"),
        (FLAT, GROWING, "", "REFUTED"),
        ("u_x + sqrt((u+1)**2-1)", GROWING, "x < 0", "PROVED"),
        ("u_x + sqrt((u+1)**2-1)", GROWING, "x < 1/2", "PROVED"),
        (FLAT, "u = exp(-c-x) + exp(c+x)/4 - 1", "x > 1 - c", "PROVED"),
        (FLAT, "u = exp(-c-x) + exp(c+x)/4 - 1", "x + c > 1", "PROVED"),
        (FLAT, "u = exp(-c-x) + exp(c+x)/4 - 1", "x > 1/2 - c", "REFUTED"),
        (FLAT, "u = exp(-2*x) + exp(2*x)/4 - 1", "x > 1", "REFUTED"),
        ("u_x - 2*sqrt((u+1)**2-1)", "u = exp(-2*x) + exp(2*x)/4 - 1", "x > 1", "PROVED"),
        (FLAT, "u = cosh(x) - 1", "x > 0", "PROVED"),
        ("u - abs(exp(x) - 3)", "u = exp(x) - 3", "x > log(3)", "PROVED"),
        ("u - abs(exp(x) - 3)", "u = exp(x) - 3", "x > log(5/2)", "REFUTED"),
        ("u - abs(exp(x) - 3)", "u = 3 - exp(x)", "x < 1", "PROVED"),
    ],
)
def test_the_sign_of_a_root_on_a_side(
    equation: str, solution: str, domain: str, outcome: str
) -> None:
    verdict = prove(equation, solution, domain=domain)
    assert verdict.outcome == outcome, verdict.detail
    assert not verdict.outcome.passed or not verdict.sides


def test_a_root_of_a_factor_that_is_not_0_is_no_seam() -> None:
    assert seams(read_statement(FLAT, GROWING, "", "x > 1")) == ()
    assert len(seams(read_statement(FLAT, GROWING, "", "x > 1/2"))) == 1


def test_a_reason_does_not_begin_with_a_way_that_does_not_apply() -> None:
    verdict = prove("u_x - sqrt((u+1)**2-1)", "u = exp(-x) + exp(x)/4 - 1 + 0*erf(x)*x**c")
    assert "multiply it out" not in verdict.detail


def test_an_exponential_less_a_number() -> None:
    x = sp.Symbol("x", real=True)
    found = excess_of_exponential(2 * sp.exp(x) - 6)
    assert found is not None
    assert found[0] == 6
    assert found[1].args == (x - sp.log(3),)
    for other in (sp.exp(x), sp.exp(x) + 2, 2 - sp.exp(x), x - 2, sp.exp(x) - x):
        assert excess_of_exponential(other) is None


def test_exponentials_are_between_their_values_at_the_ends() -> None:
    x = sp.Symbol("x", real=True)
    signs = DomainSigns({x: Domain(sp.Rational(7, 10), sp.S.One)})
    assert signs.is_positive(sp.exp(x) - 2)
    assert signs.is_positive(sp.Rational(28, 10) - sp.exp(x))
    assert not signs.is_positive(sp.exp(x) - sp.Rational(21, 10))
    assert not signs.is_positive(sp.Rational(27, 10) - sp.exp(x))
