"""Catches: a wave across the square lattice that runs elsewhere than it was told to."""

import json

import pytest
from sympy import Integer, Rational, Symbol, simplify, sqrt

from longwave.derive import LATTICES, find_scaling
from longwave.derive.__main__ import main
from longwave.derive.direction import read_direction, slow_variables
from longwave.derive.scaling import Scaling, SlowVariable
from longwave.derive.symbols import c

SQUARE = LATTICES["square"]
NUMBERS = "K2=1,H2=2,K3=1,H3=1,K4=0,H4=1"


def coefficients(capsys: pytest.CaptureFixture[str], direction: str) -> dict[str, str]:
    assert (
        main(["square", "--direction", direction, "--order", "5", "--set", NUMBERS, "--json"]) == 0
    )
    data = json.loads(capsys.readouterr().out)
    return {"c": data["coefficients"]["c"], **data["coefficients"]["terms"]}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("pi/4", (sqrt(2) / 2, sqrt(2) / 2)),
        ("atan(4/3)", (Rational(3, 5), Rational(4, 5))),
        ("3/5,4/5", (Rational(3, 5), Rational(4, 5))),
        ("-0.3, 0.4", (-Rational(3, 5), Rational(4, 5))),
        ("1,sqrt(3)", (Rational(1, 2), sqrt(3) / 2)),
        ("pi/2", (0, 1)),
    ],
)
def test_a_direction_is_an_angle_or_a_vector_of_any_length(text: str, expected: object) -> None:
    assert read_direction(text) == expected


def test_the_command_derives_the_equation_of_a_direction(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Speed^2 K2 C^2 + H2 S^2, and the terms of an inclined wave; along an axis those of it."""
    found = coefficients(capsys, "3,4")
    assert found["c"] == "sqrt(41)/5"  # sqrt(9/25 + 32/25)
    assert found["Y Y_X"] == "91 sqrt(41)/1025"  # (27 + 64)/125 over c
    assert found["Y_XXX"] == "593 sqrt(41)/123000"  # (81 + 512)/625 over 24 c
    assert found["Y_ZZ"] == "125 sqrt(41)/1681"  # 2/(2 c^3)
    assert coefficients(capsys, "0,1")["c"] == "sqrt(2)"


def test_a_direction_in_numbers_finds_its_drift_too() -> None:
    """Once a number was solved for in its place: the coefficients kept a drift without a value."""
    along, across = (Rational(3, 5), Rational(4, 5)), (-Rational(4, 5), Rational(3, 5))
    drift = Symbol("drift", real=True)
    space = (SlowVariable("X", 1, along, c), SlowVariable("Z", 2, across, drift))
    numbers = {"K2": 1, "H2": 2, "K3": 1, "H3": 1}
    [inclined] = [r for r in find_scaling(SQUARE, space=space) if r.scaling.amplitude == 1]
    oblique, values = slow_variables(SQUARE, along)
    [named] = [r for r in find_scaling(SQUARE, space=oblique) if r.scaling.amplitude == 1]
    found = inclined.coefficients(**numbers).terms
    expected = named.coefficients(**numbers, **values).terms
    assert {name: simplify(found[name] - expected[name]) for name in expected} == dict.fromkeys(
        expected, Integer(0)
    )


def test_along_an_axis_nothing_drifts() -> None:
    space, values = slow_variables(SQUARE, (Integer(0), Integer(1)))
    assert values == {}
    assert Scaling(1, space).text("u", "W").startswith("u = eps W(X, Z, T), X = eps (m - c t)")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            "fput --direction pi/4",
            "direction must be given for a lattice with two axes only",
        ),
        ("square --direction 1,2,3", "direction must be an angle or two numbers"),
        ("square --direction 0,0", "direction must be an angle or two numbers"),
        ("square --direction I", "direction must be a finite real number"),
        ("square --direction __import__", "direction: expected a formula"),
        ("square --direction K2", "direction: expected a known name"),
        ("square --direction 1 --set C=1", "C must not be given"),
        ("fput --envelope k --direction 1", "--direction must be left out with --envelope"),
    ],
)
def test_an_invalid_direction_is_refused_in_one_line(
    words: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words.split()) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") <= 1
