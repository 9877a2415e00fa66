"""Catches: a wrong digit or sign in a table, a stated order that the table does not have."""

import pickle
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from longwave.lattice.scheme_order import NystroemTable, nystroem_defect, phase_lag_defect
from longwave.lattice.schemes import (
    BLANES_MOAN_6,
    KAHAN_LI_8,
    MCLACHLAN_4,
    REDUCED_PHASE_6,
    RK4,
    SCHEMES,
    STOERMER_VERLET,
    SUZUKI_UMENO_8,
    Composition,
    Scheme,
    Splitting,
    check_order,
    scheme_named,
)
from tests.lattice.order_conditions import composition_defect, runge_kutta_defect, trees, words

COMPOSITIONS = (STOERMER_VERLET, SUZUKI_UMENO_8, KAHAN_LI_8)


@pytest.mark.parametrize("scheme", COMPOSITIONS, ids=lambda scheme: scheme.name)
def test_compositions_have_their_order_to_all_digits_and_no_more(scheme: Composition) -> None:
    assert composition_defect(scheme.gammas, scheme.order) < 1e-25
    assert composition_defect(scheme.gammas, scheme.order + 1) > 1e-4


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
def test_every_table_has_the_order_that_it_claims_and_no_more(scheme: Scheme) -> None:
    check_order(scheme)
    assert nystroem_defect(scheme.table(), scheme.order + 1) > 1e-6


def test_a_wrong_position_weight_is_detected() -> None:
    """The velocity conditions are those of Verlet's method."""
    half, one = Fraction(1, 2), Fraction(1)
    assert nystroem_defect(NystroemTable([half], [[]], [half], [one]), 2) == 0.0
    assert nystroem_defect(NystroemTable([half], [[]], [one], [one]), 2) == 0.5


def off(literal: str, change: str) -> str:
    return str(Decimal(literal) + Decimal(change))


@pytest.mark.parametrize("scheme", [SUZUKI_UMENO_8, KAHAN_LI_8], ids=lambda scheme: scheme.name)
@pytest.mark.parametrize("place", [0, 3, 6])
def test_one_digit_off_is_refused(scheme: Composition, place: int) -> None:
    """A change of 1e-20 in one weight is far below what a convergence test can detect."""
    half = list(scheme.half)
    half[place] = off(half[place], "1e-20")
    with pytest.raises(ValueError, match=r"must sum to 1 .* got a defect of 2\.0e-20"):
        replace(scheme, half=tuple(half))
    half[-1] = off(half[-1], "-2e-20")
    consistent = replace(scheme, half=tuple(half))
    with pytest.raises(ValueError, match=r"order 8 .* got a defect"):
        check_order(consistent)


@pytest.mark.parametrize(
    "scheme", [MCLACHLAN_4, BLANES_MOAN_6, REDUCED_PHASE_6], ids=lambda scheme: scheme.name
)
def test_splittings_have_their_phase_lag_order_and_no_more(scheme: Splitting) -> None:
    reached = max(scheme.order, scheme.phase_order)
    assert phase_lag_defect(*scheme.exact, reached) < scheme.rounding
    assert phase_lag_defect(*scheme.exact, reached + 2) > 1e-11


@pytest.mark.parametrize("place", range(6))
def test_one_digit_off_in_a_splitting_is_refused(place: int) -> None:
    half = list(REDUCED_PHASE_6.kick_half)
    half[place] = off(half[place], "1e-22")
    with pytest.raises(ValueError, match=r"must sum to 1 .* got a defect of 2\.0e-22"):
        replace(REDUCED_PHASE_6, kick_half=tuple(half))
    half[-1] = off(half[-1], "-2e-22")
    with pytest.raises(ValueError, match=r"order 6 .* got a defect"):
        check_order(replace(REDUCED_PHASE_6, kick_half=tuple(half)))


def test_a_wrong_phase_lag_order_is_refused() -> None:
    with pytest.raises(ValueError, match="phase-lag order 8"):
        check_order(replace(BLANES_MOAN_6, phase_order=8))


def test_mismatched_halves_are_refused() -> None:
    with pytest.raises(ValueError, match="drift_half must have as many weights as kick_half"):
        replace(BLANES_MOAN_6, drift_half=BLANES_MOAN_6.drift_half[:3])


def test_phase_lag_is_that_of_the_matrices() -> None:
    """The angle of one step against its length: the error falls like z^(phase order + 1)."""
    z = np.array([0.4, 0.8])
    step = STOERMER_VERLET.oscillator(z)
    lag = z - np.arccos(0.5 * np.trace(step, axis1=1, axis2=2))
    assert np.log2(lag[1] / lag[0]) == pytest.approx(3.0, abs=0.2)
    step = REDUCED_PHASE_6.oscillator(3.0 * z)
    lag = 3.0 * z - np.arccos(0.5 * np.trace(step, axis1=1, axis2=2))
    assert np.log2(lag[1] / lag[0]) == pytest.approx(9.0, abs=1.0)


def test_reduced_phase_has_no_unstable_band_at_pi() -> None:
    """Blanes and Moan's trace passes -2 by 4e-7 there: its stable steps end at 3.1409."""
    z = np.pi + np.linspace(-1e-4, 1e-4, 20_001)
    depth = {
        scheme.name: -2.0 - np.trace(scheme.oscillator(z), axis1=1, axis2=2).min()
        for scheme in (BLANES_MOAN_6, REDUCED_PHASE_6)
    }
    assert depth["blanes_moan_6"] > 1e-8
    assert depth["reduced_phase_6"] < 1e-14


def test_a_yoshida_weight_off_by_a_thousandth_is_refused() -> None:
    """Such a scheme still converges with slope 3.95 on coarse steps."""
    outer = "1.35120719195965763404768780897"
    inner = "-1.70241438391931526809537561795"
    check_order(Composition("yoshida_4", 4, (outer, inner), ""))
    wrong = Composition("yoshida_4", 4, ("1.3525", "-1.705"), "")
    with pytest.raises(ValueError, match="order 4"):
        check_order(wrong)


def test_runge_kutta_table_is_exact_and_perturbations_are_refused() -> None:
    assert runge_kutta_defect(RK4.A, RK4.b, 4) == 0
    with pytest.raises(ValueError, match="order 5"):
        check_order(replace(RK4, order=5))
    with pytest.raises(ValueError, match="order 4"):
        check_order(replace(RK4, b=(Fraction(1, 4),) * 4))
    with pytest.raises(ValueError, match="b must sum to 1, got 3/4 in rk4"):
        replace(RK4, b=(*RK4.b[:3], Fraction(-1, 12)))
    with pytest.raises(ValueError, match="A must have 4 rows and columns"):
        replace(RK4, A=RK4.A[:3])


def test_jameson_is_not_of_order_four() -> None:
    """Its stability polynomial is RK4's, so every linear test passes it; on FPUT it has order 2."""
    A = tuple(
        tuple(Fraction(1, 5 - i) if j == i - 1 else Fraction(0) for j in range(4)) for i in range(4)
    )
    b = (Fraction(0), Fraction(0), Fraction(0), Fraction(1))
    assert runge_kutta_defect(A, b, 2) == 0
    with pytest.raises(ValueError, match="order 4"):
        check_order(replace(RK4, A=A, b=b))


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


def test_a_user_defined_scheme_has_the_table_of_its_weights() -> None:
    weights = [" ".join(half) for half in (BLANES_MOAN_6.drift_half, BLANES_MOAN_6.kick_half)]
    stated = scheme_named(f"mine, order 6: drifts {weights[0]}, kicks {weights[1]}")
    assert stated.table() == BLANES_MOAN_6.table()
    assert stated.order == 6
    assert pickle.loads(pickle.dumps(stated)) == stated


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mine, order 4: drifts 1/2, kicks 1", "mine, order 4: drifts 1/2, kicks 1 must satisfy"),
        ("mine, order 2: drifts 1/2", "scheme must be defined as 'mine, order 2: "),
        ("mine, order 2: drifts __import__, kicks 1", "weights of a scheme must be decimals or"),
        ("mine, order 2: drifts 1/0, kicks 1", "weights of a scheme must be decimals or"),
        ("mine, order 2: drifts 1/2 1/2 1/2, kicks 1", "drift_half must have as many weights"),
        ("mine, order 2: drifts 2, kicks 1", "the weights of mine, order 2: drifts 2, kicks 1 mu"),
        ("mine, order 40: drifts 1/2, kicks 1", "order of a scheme must be 1 to 10, got 40"),
        (f"mine, order 2: drifts {'0 ' * 30}, kicks 1", "weights of a scheme must be 1 to 20"),
        ("kahan_li_9", r"scheme must be a known one, got 'kahan_li_9' \(did you mean kahan_li_8"),
    ],
)
def test_invalid_schemes_are_refused_in_one_line(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=rf"^{message}[^\n]*$"):
        scheme_named(text)
