"""Every known envelope comes out of its declaration, with the same coefficients."""

import math
from typing import Any

import pytest
from sympy import Rational

from longwave.derive import LATTICES, envelope
from tests.derive.known_envelopes import CHAIN, KNOWN, of, unlike


@pytest.mark.parametrize("name", KNOWN)
def test_the_known_envelope_comes_out(name: str) -> None:
    assert not KNOWN[name]()


@pytest.mark.parametrize("name", CHAIN)
def test_another_coefficient_is_detected(name: str) -> None:
    wrong = {name: CHAIN[name] * 101 / 100}
    assert list(unlike(of("fput_strain").expressions, wrong))


def test_the_largest_growth_rate_is_that_of_all_wavenumbers() -> None:
    """sigma^2 = p K^2 (2 q |A|^2 - p K^2) of a disturbance exp(i K X)."""
    values: Any = {"K2": 1, "K3": Rational(1, 4), "K4": 1}
    numbers = envelope(LATTICES["fput_strain"], k=2).coefficients(**values)
    p, q = numbers.p, numbers.q
    squares = [p * K**2 * (2 * q * 0.3**2 - p * K**2) for K in (i / 1000 for i in range(3000))]
    assert numbers.growth_rate(0.3) == pytest.approx(math.sqrt(max(squares)), rel=1e-5)
