"""Tables and numbers: digits follow the error, signs and powers of ten are right."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reports.latex import measured, scientific, table


@given(st.floats(min_value=1e-30, max_value=1e30), st.integers(2, 6))
def test_scientific_keeps_the_value(value: float, digits: int) -> None:
    """Catches a lost exponent and a rounded-away digit."""
    text = scientific(value, digits).strip("$").replace(r"\times 10^{", "e").replace("}", "")
    assert float(text.replace(" ", "").replace("\\", "")) == pytest.approx(
        value, rel=0.51 * 10 ** (1 - digits)
    )


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (0.10138, 4e-5, r"$0.101380 \pm 0.000040$"),
        (0.10138, 4.11e-5, r"$0.101380 \pm 0.000042$"),
        (5.25, 0.5, r"$5.25 \pm 0.50$"),
        (-3.0, 0.02, r"$-3.000 \pm 0.020$"),
        (1.5, 2e-9, r"$1.50000 \pm 0.00001$"),
        (0.12, 0.0, r"$0.120000 \pm 0.000000$"),
        (3.6e-5, 1e-12, r"$(3.60000 \pm 0.00001)\times 10^{-5}$"),
        (0.0, 0.0, "$0$"),
    ],
)
def test_the_error_sets_the_digits_and_is_rounded_up(
    value: float, error: float, shown: str
) -> None:
    assert measured(value, error) == shown


def test_infinite_values_are_words() -> None:
    assert scientific(math.inf) == r"$\mathrm{inf}$"


def test_rows_have_the_columns_of_the_head() -> None:
    text = table("ll", ["a", "b"], [["1", "2"], ["3", "4"]])
    lines = [line for line in text.splitlines() if line.endswith(r"\\")]
    assert [line.count("&") for line in lines] == [1, 1, 1]
