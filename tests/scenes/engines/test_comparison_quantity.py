"""Catches: text evaluated as code, a misread fraction, K of the parameter instead of k."""

import mpmath
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from longwave.scenes.starts.lattice_derivation import exact_parameters


def alpha(text: str) -> sp.Expr:
    return exact_parameters((("k", 0.7), ("alpha", text)))["alpha"]


@given(st.integers(1, 999), st.integers(1, 999))
def test_multiples_of_the_quarter_period(times: int, over: int) -> None:
    K = sp.elliptic_k(sp.Rational(49, 100))
    assert alpha(f" {times}*K / {over}") == sp.Rational(times, over) * K


@pytest.mark.parametrize("text", ["", "k/2", "K/0", "2K", "__import__('os')", "K/2; 1", "9" * 99])
def test_what_is_no_number_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="alpha"):
        alpha(text)


def test_K_is_taken_at_the_modulus() -> None:
    assert float(alpha("3*K/4")) == pytest.approx(0.75 * float(mpmath.ellipk(0.49)), abs=1e-15)


def test_a_multiple_of_K_needs_a_modulus() -> None:
    with pytest.raises(ValueError, match="tau_5"):
        exact_parameters((("tau_5", "K/2"),))
