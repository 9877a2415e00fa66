"""Digits and seconds of an evaluation: the digits are those that each arithmetic must have."""

import pytest

from longwave.reports.studies.evaluation_cost import (
    EvaluationCost,
    evaluation_costs,
    exact_values,
    ordinary_case,
)


@pytest.fixture(scope="module")
def costs() -> dict[str, EvaluationCost]:
    return {cost.arithmetic: cost for cost in evaluation_costs("soliton_sech")}


@pytest.mark.parametrize(
    ("arithmetic", "least", "most"),
    [
        ("double-double", 28, 35),
        ("balls, 40 digits", 35, 42),
        ("mpmath, 60 digits", 58, 63),
    ],
)
def test_each_arithmetic_has_its_digits(
    costs: dict[str, EvaluationCost], arithmetic: str, least: float, most: float
) -> None:
    """Catches points, scales or derivatives that differ from one arithmetic to another."""
    assert least < costs[arithmetic].digits < most


def test_the_exact_values_are_those_of_the_wave() -> None:
    """Catches a derivative not scaled to X and T."""
    case = ordinary_case("breather_sn")
    for place, values in enumerate(exact_values(case)):
        X = (7 * place - 24) / 16
        expected = [float(part) for part in case.wave()(X, 5 / 16)]
        assert [float(value) for value in values] == pytest.approx(expected, rel=1e-10, abs=1e-12)
