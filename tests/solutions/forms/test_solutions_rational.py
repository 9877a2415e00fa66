"""The rational family: printed Y2 and Y3, exact facts, errors."""

from typing import Any

import pytest
import sympy as sp

from longwave.solutions import closed_form, rational, rational_tau
from longwave.solutions.symbols import tau, xi


@pytest.mark.parametrize("order", [1, 2, 3])
def test_printed_form_is_the_family_member_exactly(order: int) -> None:
    printed, member = closed_form(f"rational_{order}"), rational(order)
    fractions = [sp.fraction(sp.together(f.expression)) for f in (printed, member)]
    (n1, d1), (n2, d2) = fractions
    assert (sp.Poly(n1, xi, tau) * sp.Poly(d2, xi, tau)) == (
        sp.Poly(n2, xi, tau) * sp.Poly(d1, xi, tau)
    )
    assert printed.background == member.background


def test_a_changed_digit_in_print_is_detected() -> None:
    printed = closed_form("rational_2").expression
    wrong = printed.subs(12, 13)
    assert wrong != printed
    assert sp.together(wrong - rational(2).expression).subs({xi: 1, tau: 2}) != 0


def test_known_polynomials() -> None:
    third = rational_tau(3)
    assert str(third.A) == ("64*x^6 - 240*x^4 + 3840*x^3*t - 180*x^2 - 2880*x*t - 46080*t^2 - 45")
    assert str(third.B) == "-192*x^5 - 5760*x^2*t - 180*x + 4320*t"


@pytest.mark.parametrize("order", range(1, 6))
def test_peak_degree_and_background(order: int) -> None:
    member = rational(order)
    assert member.expression.subs({xi: 0, tau: 0}) == 2 * order + 1
    family = rational_tau(order)
    assert max(exponents[0] for exponents in family.A.monoms()) == order * (order + 1) // 2
    assert member.expression.subs({xi: 10**9, tau: 0}).evalf() == pytest.approx(
        (-1) ** order, abs=1e-12
    )


def test_shift_moves_the_wave_and_zero_shift_does_not(ctx: Any, in_mp: Any) -> None:
    free = rational(3, free=[5])
    fixed = in_mp(rational(3), rational(3).expression, {})
    assert in_mp(free, free.expression, {})(0.3, 0.1) == pytest.approx(fixed(0.3, 0.1))
    assert abs(in_mp(free, free.expression, {"tau_5": 1.0})(0.3, 0.1) - fixed(0.3, 0.1)) > 0.1


@pytest.mark.parametrize("order", [0, -1, 1.5, True, "2"])
def test_order_must_be_a_positive_integer(order: Any) -> None:
    with pytest.raises(ValueError, match="order must be a positive integer, got"):
        rational(order)


@pytest.mark.parametrize("index", [3, 6, 7])
def test_shift_must_occur(index: int) -> None:
    with pytest.raises(ValueError, match=r"odd with 5 <= index <= 5, got \d \(tau_1 and tau_3"):
        rational(3, free=[index])
