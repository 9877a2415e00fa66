"""The dispersion relation, its long-wave expansion and the reduced equation's linear part."""

from dataclasses import replace

import pytest
from sympy import Integer, Symbol, expand, sin, sqrt

from derive import LATTICES, Bond, Stencil, dispersion_relation, mkdv_reduction
from derive.dispersion import agrees_with_reduction, long_wave_of_reduction
from derive.symbols import K2, K3, K4, k, x, ybar

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


def test_disagreement_is_seen() -> None:
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


def test_one_sided_force_is_refused() -> None:
    bond = replace(FPUT.bonds[0], action=(Stencil((1,)), Stencil((0,), -1)))
    with pytest.raises(ValueError, match="must carry equal weights"):
        dispersion_relation(replace(FPUT, bonds=(bond,)))
