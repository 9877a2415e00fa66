"""The reduction of the strain FPUT lattice and of lattices that differ from it as data."""

from dataclasses import replace
from typing import Any

import pytest
from sympy import Eq, Expr, Rational, Symbol, simplify, symbols

from longwave.derive import (
    LATTICES,
    Bond,
    Lattice,
    Reduction,
    ReductionError,
    Scaling,
    Stencil,
    reduce,
)
from longwave.derive.algebra.jets import DifferentialPolynomial, Monomial
from longwave.derive.symbols import K2, K3, K4, c, x, ybar

FPUT = LATTICES["fput_strain"]
L2, L4 = symbols("L2 L4", real=True)
Y, Y_X, Y_XX, Y_XXX, Y_4X, Y_5X, Y_6X = ((i, 0) for i in range(7))


def as_values(polynomial: DifferentialPolynomial) -> dict[Monomial, Expr]:
    return {monomial: value.as_expr() for monomial, value in polynomial.terms.items()}


def assert_polynomial(polynomial: DifferentialPolynomial, expected: dict[Monomial, Expr]) -> None:
    found = as_values(polynomial)
    assert set(found) == set(expected)
    for monomial, value in expected.items():
        assert simplify(found[monomial] - value) == 0, monomial


@pytest.fixture(scope="module")
def mkdv() -> Reduction:
    return reduce(FPUT)


def test_orders_read_as_the_paper_has_them(mkdv: Reduction) -> None:
    assert mkdv.orders[3].text() == "(c^2 - K2) Y_XX = 0"
    assert mkdv.orders[4].text() == "K3 (Y^2)_XX = 0"
    assert mkdv.orders[5].text() == "2 c Y_XT + K4 (Y^3)_XX + (K2/12) Y_XXXX = 0"
    assert set(mkdv.orders) == {3, 4, 5, 6, 7}


def test_sound_condition_and_its_order(mkdv: Reduction) -> None:
    assert mkdv.sound_condition == Eq(c**2, K2)


def test_the_condition_comes_with_its_reason(mkdv: Reduction) -> None:
    [condition] = mkdv.conditions
    assert (condition.order, condition.expression) == (4, K3)
    assert condition.reason == "order eps^4 reads K3 (Y^2)_XX = 0"


def test_mkdv_coefficients(mkdv: Reduction) -> None:
    assert_polynomial(mkdv.pde.flow, {(Y, Y, Y_X): -3 * K4 / (2 * c), (Y_XXX,): -c / 24})
    assert mkdv.pde.nonlinear_coefficient == 3 * K4 / (2 * c)
    assert mkdv.pde.dispersive_coefficient == c / 24


def test_next_order_of_mkdv(mkdv: Reduction) -> None:
    """R7 and F2, with the time derivatives gone; catches a wrong elimination of Y_TT."""
    assert_polynomial(
        mkdv.remainders[7],
        {
            (Y, Y, Y, Y, Y_XX): 9 * K4**2 / (4 * c**2),
            (Y, Y, Y, Y_X, Y_X): 9 * K4**2 / c**2,
            (Y, Y, Y_4X): -K4 / 8,
            (Y, Y_X, Y_XXX): -11 * K4 / 8,
            (Y, Y_XX, Y_XX): -9 * K4 / 8,
            (Y_X, Y_X, Y_XX): -9 * K4 / 4,
            (Y_6X,): -(c**2) / 960,
        },
    )
    assert_polynomial(
        mkdv.corrections[2],
        {
            (Y, Y, Y, Y, Y_X): 9 * K4**2 / (8 * c**3),
            (Y, Y, Y_XXX): -K4 / (16 * c),
            (Y, Y_X, Y_XX): -9 * K4 / (16 * c),
            (Y_X, Y_X, Y_X): -3 * K4 / (16 * c),
            (Y_5X,): -c / 1920,
        },
    )


def test_one_way_reduction_of_mkdv_stops_at_the_fourth_power() -> None:
    reduction = reduce(FPUT, orders=11)
    assert set(reduction.corrections) == {2}
    assert reduction.obstruction is not None
    assert reduction.obstruction[0] == 4


def test_quadratic_force_gives_kdv_with_its_correction() -> None:
    kdv = reduce(FPUT, Scaling(amplitude=2), orders=8)
    assert kdv.conditions == ()
    assert_polynomial(kdv.pde.flow, {(Y, Y_X): -K3 / c, (Y_XXX,): -c / 24})
    assert_polynomial(
        kdv.corrections[2],
        {
            (Y, Y, Y_X): -(3 * c**2 * K4 - K3**2) / (2 * c**3),
            (Y, Y_XXX): -K3 / (24 * c),
            (Y_X, Y_XX): -3 * K3 / (16 * c),
            (Y_5X,): -c / 1920,
        },
    )


def test_toda_ratio_has_no_obstruction_where_the_generic_lattice_has() -> None:
    """3 K2 K4 = 2 K3^2 is Toda's ratio: the near-integrability test of the corrections."""
    scaling, constant = Scaling(amplitude=2), Symbol("g", positive=True)
    toda = replace(
        FPUT,
        bonds=(
            replace(
                FPUT.bonds[0],
                force=K2
                * (
                    x
                    + constant * x**2 / 2
                    + constant**2 * x**3 / 6
                    + constant**3 * x**4 / 24
                    + constant**4 * x**5 / 120
                ),
            ),
        ),
    )
    assert reduce(toda, scaling, orders=12).obstruction is None
    generic = reduce(FPUT, scaling, orders=12)
    assert generic.obstruction is not None
    assert generic.obstruction[0] == 6


def test_background_mean_shifts_sound_speed_and_nonlinearity() -> None:
    reduction = reduce(FPUT, Scaling(amplitude=2, background=((0, ybar),)), orders=6)
    assert reduction.speed_squared == K2 + 2 * K3 * ybar + 3 * K4 * ybar**2
    assert_polynomial(reduction.pde.flow, {(Y, Y_X): -(K3 + 3 * K4 * ybar) / c, (Y_XXX,): -c / 24})


def test_background_at_the_inflection_gives_mkdv() -> None:
    reduction = reduce(FPUT, Scaling(background=((0, -K3 / (3 * K4)),)))
    assert reduction.conditions == ()
    assert simplify(reduction.speed_squared - (K2 - K3**2 / (3 * K4))) == 0
    assert_polynomial(reduction.pde.flow, {(Y, Y, Y_X): -3 * K4 / (2 * c), (Y_XXX,): -c / 24})


def test_next_nearest_springs_are_only_data() -> None:
    """Springs of range two: the stretch of two bonds, its force spread over four sites."""
    second = Bond(
        stretch=(Stencil((0,)), Stencil((1,))),
        force=L2 * x + L4 * x**3,
        action=(Stencil((1,)), Stencil((0,), -1), Stencil((-1,), -1), Stencil((-2,))),
    )
    first = replace(FPUT.bonds[0], force=K2 * x + K4 * x**3)
    reduction = reduce(replace(FPUT, bonds=(first, second)))
    assert reduction.speed_squared == K2 + 4 * L2
    stiffness = (c**2 + 12 * L2) / (24 * c)
    assert_polynomial(
        reduction.pde.flow,
        {(Y, Y, Y_X): -3 * (K4 + 16 * L4) / (2 * c), (Y_XXX,): -stiffness},
    )


def test_displacement_form_of_the_lattice_gives_the_same_physics() -> None:
    """u'' = F(u_{n+1} - u_n) - F(u_n - u_{n-1}) with u = W, Y = W_X."""
    bond = Bond(
        stretch=(Stencil((1,)), Stencil((0,), -1)),
        force=K2 * x + K4 * x**3,
        action=(Stencil((0,)), Stencil((-1,), -1)),
    )
    lattice = Lattice("chain", "chain in the displacement", ("u",), (Rational(1),), (bond,))
    reduction = reduce(lattice, Scaling(amplitude=0))
    assert_polynomial(reduction.pde.flow, {(Y, Y, Y_X): -3 * K4 / (2 * c), (Y_XXX,): -c / 24})
    assert "2 c W_XT" in reduction.orders[4].text()
    strain = reduce(replace(FPUT, bonds=(replace(FPUT.bonds[0], force=bond.force),)))
    assert_polynomial(
        reduction.pde.flow, {m: v.as_expr() for m, v in strain.pde.flow.terms.items()}
    )


def test_mass_enters_the_sound_speed() -> None:
    mass = Symbol("m", positive=True)
    assert reduce(replace(FPUT, masses=(mass,))).speed_squared == K2 / mass


@pytest.mark.parametrize(
    ("scaling", "message"),
    [
        (Scaling(amplitude=0), r"order eps\^2 must be a multiple of Y_XX alone"),
        (Scaling(time=5), r"order eps\^5 must be solvable .* got K4 \(Y\^3\)_XX \+ "),
    ],
)
def test_wrong_ansatz_is_refused_with_its_terms(scaling: Scaling, message: str) -> None:
    with pytest.raises(ReductionError, match=message):
        reduce(FPUT, scaling)


def test_unbalanced_stencil_is_refused() -> None:
    """A force that a uniform strain would feel leaves Y itself at the lowest order."""
    bond = replace(FPUT.bonds[0], action=(Stencil((1,)), Stencil((0,), -1), Stencil((-1,))))
    with pytest.raises(ValueError, match="must have one wave of vanishing frequency, got 0"):
        reduce(replace(FPUT, bonds=(bond,)))


def test_a_changed_force_changes_the_coefficient() -> None:
    bond = replace(FPUT.bonds[0], force=K2 * x + Rational(101, 100) * K4 * x**3)
    changed = reduce(replace(FPUT, bonds=(bond,)))
    assert changed.pde.nonlinear_coefficient == Rational(101, 100) * 3 * K4 / (2 * c)


def test_orders_below_the_equation_are_refused() -> None:
    with pytest.raises(ValueError, match="orders must satisfy orders >= 5, got 4"):
        reduce(FPUT, orders=4)


@pytest.mark.parametrize("change", [{"amplitude": -1}, {"time": 0}])
def test_scaling_checks_its_exponents(change: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"must be an integer >= \d, got"):
        Scaling(**change)
