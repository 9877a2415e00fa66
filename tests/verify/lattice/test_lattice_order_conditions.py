"""Catches: a wrong digit or sign in a table, an order claimed that the table does not have."""

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import pytest

from verify.lattice.order_conditions import composition_defect, runge_kutta_defect, trees, words
from verify.lattice.scheme import Composition
from verify.lattice.schemes import KAHAN_LI_8, RK4, SCHEMES, STOERMER_VERLET, SUZUKI_UMENO_8

COMPOSITIONS = (STOERMER_VERLET, SUZUKI_UMENO_8, KAHAN_LI_8)


@pytest.mark.parametrize("scheme", COMPOSITIONS, ids=lambda scheme: scheme.name)
def test_compositions_have_their_order_to_all_digits_and_no_more(scheme: Composition) -> None:
    assert composition_defect(scheme.gammas, scheme.order) < 1e-25
    assert composition_defect(scheme.gammas, scheme.order + 1) > 1e-4


@pytest.mark.parametrize("scheme", [SUZUKI_UMENO_8, KAHAN_LI_8], ids=lambda scheme: scheme.name)
@pytest.mark.parametrize("place", range(8))
def test_one_digit_off_is_refused(scheme: Composition, place: int) -> None:
    """A change of 1e-20 in one weight is far below what an order test by slopes can see."""
    literal = scheme.half[place]
    wrong = str(Decimal(literal) + Decimal("1e-20"))
    half = (*scheme.half[:place], wrong, *scheme.half[place + 1 :])
    with pytest.raises(ValueError, match=r"order 8 .* got a defect"):
        replace(scheme, half=half)


def test_a_yoshida_weight_off_by_a_thousandth_is_refused() -> None:
    """Such a scheme still shows slope 3.95 on coarse steps."""
    outer = "1.35120719195965763404768780897"
    inner = "-1.70241438391931526809537561795"
    Composition("yoshida_4", 4, (outer, inner), "")
    with pytest.raises(ValueError, match="order 4"):
        Composition("yoshida_4", 4, ("1.3525", "-1.705"), "")


def test_runge_kutta_table_is_exact_and_perturbations_are_refused() -> None:
    assert runge_kutta_defect(RK4.A, RK4.b, 4) == 0
    with pytest.raises(ValueError, match="order 5"):
        replace(RK4, order=5)
    with pytest.raises(ValueError, match="order 4"):
        replace(RK4, b=(Fraction(1, 4),) * 4)


def test_jameson_is_not_of_order_four() -> None:
    """Its stability polynomial is RK4's, so every linear test passes it; on FPUT it has order 2."""
    A = tuple(
        tuple(Fraction(1, 5 - i) if j == i - 1 else Fraction(0) for j in range(4)) for i in range(4)
    )
    b = (Fraction(0), Fraction(0), Fraction(0), Fraction(1))
    assert runge_kutta_defect(A, b, 2) == 0
    with pytest.raises(ValueError, match="order 4"):
        replace(RK4, A=A, b=b)


def test_an_implicit_table_is_refused() -> None:
    A = ((Fraction(1, 2), *RK4.A[0][1:]), *RK4.A[1:])
    with pytest.raises(ValueError, match="strictly lower triangular"):
        replace(RK4, A=A)


def test_number_of_conditions() -> None:
    """Rooted trees: OEIS A000081; words of odd letters: Fibonacci numbers."""
    assert [len(trees(n)) for n in range(1, 8)] == [1, 1, 2, 4, 9, 20, 48]
    assert [len(words(n)) for n in range(1, 9)] == [1, 1, 2, 3, 5, 8, 13, 21]


def test_names_are_unique() -> None:
    assert len({scheme.name for scheme in SCHEMES}) == len(SCHEMES)
