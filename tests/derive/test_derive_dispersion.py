"""The dispersion relation, its long-wave expansion and the reduced equation's linear part."""

from dataclasses import replace

import pytest
from sympy import Integer, Symbol, expand, sin, sqrt

from longwave.derive import (
    LATTICES,
    Bond,
    Scaling,
    Stencil,
    dispersion_relation,
    mkdv_reduction,
    reduce,
)
from longwave.derive.dispersion import agrees_with_reduction, long_wave_of_reduction
from longwave.derive.symbols import K2, K3, K4, k, x, ybar
from longwave.lattice.numeric_lattice import numeric_lattice

FPUT = LATTICES["fput_strain"]
STIFFNESS = K2 + 2 * K3 * ybar + 3 * K4 * ybar**2


def test_relation_is_the_papers() -> None:
    relation = dispersion_relation()
    assert expand(relation.omega_squared - 4 * STIFFNESS * sin(k / 2) ** 2) == 0
    assert relation.omega_plus == 2 * sqrt(STIFFNESS) * sin(k / 2)


def test_long_wave_expansion_is_the_papers() -> None:
    expected = 2 * sqrt(STIFFNESS) * (k / 2 - k**3 / 48)
    assert expand(dispersion_relation().long_wave() - expected) == 0


def test_positive_branch_squares_to_omega_squared_and_is_positive() -> None:
    relation = dispersion_relation()
    assert expand(relation.omega_plus**2 - relation.omega_squared) == 0
    numbers = {K2: 4, K3: 0, K4: 1, ybar: 0, k: 3}
    assert relation.omega_plus.subs(numbers) > 0


def test_lattice_and_reduced_equation_agree() -> None:
    assert agrees_with_reduction(FPUT, mkdv_reduction())
    assert expand(long_wave_of_reduction(mkdv_reduction()) - sqrt(K2) * (k - k**3 / 24)) == 0


def test_a_disagreement_is_detected() -> None:
    stiffer = replace(FPUT, bonds=(replace(FPUT.bonds[0], force=2 * K2 * x),))
    assert not agrees_with_reduction(stiffer, mkdv_reduction())


def test_next_nearest_springs() -> None:
    L2 = Symbol("L2", real=True)
    second = Bond(
        (Stencil((0,)), Stencil((1,))),
        L2 * x,
        (Stencil((1,)), Stencil((0,), -1), Stencil((-1,), -1), Stencil((-2,))),
    )
    relation = dispersion_relation(replace(FPUT, bonds=(FPUT.bonds[0], second)))
    expected = 4 * STIFFNESS * sin(k / 2) ** 2 + 4 * L2 * sin(k) ** 2
    for value in (Integer(1) / 3, Integer(2)):
        assert (
            abs(
                (relation.omega_squared - expected)
                .subs(k, value)
                .evalf(30, subs={K2: 1, K3: 2, K4: 3, ybar: 5, L2: 7})
            )
            < 1e-25
        )


def test_background_is_where_the_linear_waves_are() -> None:
    """About zero strain the lattice's waves would be too slow by 2 K3 ybar + 3 K4 ybar^2."""
    reduction = reduce(FPUT, Scaling(amplitude=2, background=((0, ybar),)), orders=6)
    assert agrees_with_reduction(FPUT, reduction)


def test_a_lattice_without_comparison_of_linear_waves_is_refused() -> None:
    gardner = reduce(FPUT, Scaling(background=((1, ybar),)), orders=5)
    with pytest.raises(ValueError, match=r"background must be of order one"):
        agrees_with_reduction(FPUT, gardner)
    with pytest.raises(ValueError, match=r"no linear term except Y_XXX"):
        long_wave_of_reduction(gardner)


ONE_FIELD = [name for name, it in LATTICES.items() if len(it.fields) == it.dimension == 1]


@pytest.mark.parametrize("name", ONE_FIELD)
def test_the_relation_is_that_of_the_lattice_with_numbers(name: str) -> None:
    """On-site forces were left out once: a Klein-Gordon chain got the waves of a free one."""
    lattice = LATTICES[name]
    constants = {str(symbol): 1 + i / 8 for i, symbol in enumerate(lattice.constants)}
    numeric = numeric_lattice(lattice, constants)
    found = dispersion_relation(lattice)
    for angle in (0.3, 1.7, 3.1):
        [expected] = numeric.squared_frequencies([angle], numeric.rest_slopes())
        at = {**constants, "k": angle, "ybar": 0}
        exact = {symbol: at[str(symbol)] for symbol in found.omega_squared.free_symbols}
        assert float(found.omega_squared.subs(exact)) == pytest.approx(expected, rel=1e-12)
        assert float(found.omega_plus.subs(exact)) == pytest.approx(expected**0.5, rel=1e-12)


def test_a_tied_chain_has_a_lowest_frequency() -> None:
    """Its expansion begins with it; a mean displacement is no state in which it rests."""
    g1 = Symbol("g1", positive=True)
    found = dispersion_relation(LATTICES["klein_gordon"])
    assert found.omega_squared.subs(k, 0) == g1
    assert expand(found.long_wave(3) - sqrt(g1) * (1 + K2 * k**2 / (2 * g1))) == 0
    assert ybar not in found.omega_squared.free_symbols


def test_several_fields_and_axes_are_refused() -> None:
    """With two fields omega^2 has two branches; the sum of all weights is neither."""
    two = replace(FPUT, fields=("y", "z"), masses=(Integer(1), Integer(2)))
    square = Bond((Stencil((0, 0)),), K2 * x, (Stencil((0, 1)), Stencil((0, 0), -2)))
    for lattice in (two, replace(FPUT, bonds=(square,))):
        with pytest.raises(ValueError, match="lattice must have one field and one axis, got"):
            dispersion_relation(lattice)


def test_one_sided_force_is_refused() -> None:
    bond = replace(FPUT.bonds[0], action=(Stencil((1,)), Stencil((0,), -1)))
    with pytest.raises(ValueError, match="must carry equal weights"):
        dispersion_relation(replace(FPUT, bonds=(bond,)))
