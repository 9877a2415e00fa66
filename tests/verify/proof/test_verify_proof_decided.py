"""True statements that are PROVED, each with a near miss that is REFUTED."""

from __future__ import annotations

import pytest

from derive.algebra.formula_text import FormulaError
from verify.proof.statement_text import read_statement
from verify.proof.text_prover import prove
from verify.verdict import Outcome


def outcome(equation: str, solution: str, **parts: str) -> str:
    """The verdict on a statement, without the note that the certificate states another."""
    verdict = prove(equation, solution, **parts)
    assert not any("what SymPy reads" in line for line in verdict.assumptions)
    return str(verdict.outcome)


VARIABLES = [
    ("u_tt - u_rr - 2*u_r/r", "u_tt - u_rr - u_r/r", "u = sin(r - t)/r", "r,t", ""),
    ("s**2*u_ss + s*u_s - u", "s**2*u_ss + s*u_s + u", "u = s - 1/s", "s", "s>0"),
    ("u_pp - u_qq", "u_pp + u_qq", "u = exp(-(p - q)**2)", "p, q", ""),
    ("u_t - x*u_r", "u_t + x*u_r", "u = sin(r + x*t)", "t, r", ""),
    ("diff(u[n], s) - u[n+1]", "diff(u[n], s) - u[n-1]", "u = 2**n*exp(2*s)", "s", ""),
    ("u_rr", "u_rr - 1", "u = 2", "r, t", ""),
]


@pytest.mark.parametrize(("true", "false", "solution", "variables", "domain"), VARIABLES)
def test_variables_are_those_that_are_named(
    true: str, false: str, solution: str, variables: str, domain: str
) -> None:
    named = {"variables": variables, "domain": domain}
    assert outcome(true, solution, **named) == Outcome.PROVED
    assert outcome(false, solution, **named) == Outcome.REFUTED


def test_letters_that_are_not_named_are_parameters() -> None:
    statement = read_statement("u_r - x", "u = x*r", variables="r")
    assert list(map(str, statement.variables)) == ["r"]


@pytest.mark.parametrize(
    ("variables", "column"), [("r t", 3), ("rho", 1), ("r, r", 4), ("I", 1), ("r,", 1), ("3", 1)]
)
def test_names_of_variables_are_different_letters(variables: str, column: int) -> None:
    with pytest.raises(FormulaError, match=rf"variables: expected .* \(column {column}\)"):
        read_statement("u_r", "u = 1", variables=variables)


def test_a_variable_is_no_parameter() -> None:
    with pytest.raises(FormulaError, match="the independent variable r"):
        read_statement("u_r", "u = r", "r: r>0", variables="r")
