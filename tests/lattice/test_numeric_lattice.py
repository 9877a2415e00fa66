"""Numerical lattices: forces, energies and frequencies against each other."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from sympy import Rational

from longwave.derive import LATTICES
from longwave.lattice.force_program import ForceProgram
from longwave.lattice.model import Model
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice, numeric_lattice

NAMES = "K2 K3 K4 H2 H3 H4 L2 L3 L4 m1 m2 m3 g1 g2 g3 a b A d r E"
NUMBERS = (1, Rational(1, 4), 1, 2, 1, Rational(1, 3), Rational(1, 5), 1, 2, 1, 3, 2, 1, 1, 1)
VALUES = dict(zip(NAMES.split(), (*NUMBERS, 1, 2, 1, 1, 1, 1), strict=True))
STRAINED = {"fput_strain", *(name for name in LATTICES if name.startswith("next_nearest"))}
DISPLACED = sorted(set(LATTICES) - STRAINED)


def numbers(name: str, mean_strain: tuple[float, ...] = ()) -> NumericLattice:
    lattice = LATTICES[name]
    given = {str(symbol): VALUES[str(symbol)] for symbol in lattice.constants}
    return numeric_lattice(lattice, given, mean_strain)


def random_fields(chain: NumericLattice) -> np.ndarray:
    shape = (len(chain.fields), *(8,) * chain.dimension)
    return 0.01 * np.random.default_rng(3).normal(size=shape)


@pytest.mark.parametrize("name", DISPLACED)
def test_forces_are_minus_the_slope_of_the_energy(name: str) -> None:
    chain = numbers(name)
    f, step = random_fields(chain), 1e-5
    for field, mass in enumerate(chain.masses):
        place = (field, *(3,) * chain.dimension)
        moved = np.zeros_like(f)
        moved[place] = step
        rise = chain.energy(f + moved, 0 * f) - chain.energy(f - moved, 0 * f)
        assert mass * chain.acceleration(f)[place] == pytest.approx(-rise / (2 * step), rel=1e-6)


@pytest.mark.parametrize("name", sorted(LATTICES))
def test_the_dynamical_matrix_is_that_of_small_forces(name: str) -> None:
    chain = numbers(name)
    cells, small = 8, 1e-7
    k = 2 * np.pi * np.array([1.0, 3.0][: chain.dimension]) / cells
    n = np.stack(np.meshgrid(*[np.arange(cells)] * chain.dimension, indexing="ij"), axis=-1)
    share = np.arange(1.0, 1.0 + len(chain.fields))
    matrix = chain.dynamical_matrix(k, chain.rest_slopes())
    for part in (np.cos, np.sin):
        wave = small * part(n @ k)
        found = chain.acceleration(np.multiply.outer(share, wave))
        turned = matrix @ share
        other = np.sin if part is np.cos else np.cos
        sign = 1.0 if part is np.cos else -1.0
        expected = -np.multiply.outer(turned.real, wave)
        expected += sign * np.multiply.outer(turned.imag, small * other(n @ k))
        np.testing.assert_allclose(found, expected, atol=1e-5 * np.max(np.abs(expected)))


def test_the_strain_lattice_agrees_with_the_model() -> None:
    chain = numbers("fput_strain")
    model = Model(1.0, 0.25, 1.0)
    y = random_fields(chain)
    force = model.K2 * y + model.K3 * y**2 + model.K4 * y**3
    expected = np.roll(force, -1) - 2 * force + np.roll(force, 1)
    np.testing.assert_allclose(chain.acceleration(y), expected, atol=1e-16)
    assert chain.highest_frequency(chain.rest_slopes()) == 2.0 == model.highest_frequency(0 * y[0])


@pytest.mark.parametrize("name", ["fput", "dimer", "toda", "square"])
def test_a_mean_strain_is_a_displacement_that_grows_with_the_cell(name: str) -> None:
    slope = 0.03
    still, strained = numbers(name), numbers(name, (slope,) + (0.0,) * (name == "square"))
    f = random_fields(still)
    grown = f + slope * np.arange(8.0).reshape(-1, *(1,) * (still.dimension - 1))
    inner = (slice(None), slice(2, 6))
    np.testing.assert_allclose(
        strained.acceleration(f)[inner], still.acceleration(grown)[inner], atol=1e-15
    )


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("fput", {"K2": 1}, "constant K3 of fput must be given, got none"),
        ("fput", {"K2": 1, "K3": 0, "K4": 0, "q": 1}, "constant q of fput is not known"),
        ("beta_fput", {"K2": -1, "K4": 0}, "K2 must satisfy K2 > 0, got -1"),
        ("granular", {"A": 1, "d": -1}, "d must satisfy d > 0, got -1"),
        ("granular", {"A": 0, "d": 1}, "A must satisfy A > 0, got 0"),
    ],
)
def test_constants_that_do_not_fit_are_refused(
    name: str, given: dict[str, int], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        numeric_lattice(LATTICES[name], given)


def test_a_tied_site_has_no_mean_strain() -> None:
    with pytest.raises(ValueError, match="mean_strain must be 0"):
        numbers("klein_gordon", (0.1,))


def test_forces_are_numpys_polynomials_to_the_last_bit() -> None:
    """So are slopes and potentials, for any degree and for stretches that are nan or infinite."""
    random = np.random.default_rng(0)
    stretches = np.array([0.0, -0.0, np.inf, np.nan, *random.normal(size=50)])
    for degree in range(7):
        law = ForceProgram(tuple(random.normal(size=degree).tolist()))
        whole = Polynomial([0.0, *law.coefficients])
        with np.errstate(invalid="ignore"):
            found = law(stretches), law.slope(stretches), law.potential(stretches)
            wanted = [each(stretches) for each in (whole, whole.deriv(), whole.integ())]
        np.testing.assert_array_equal(found, wanted)


def test_stretches_use_the_cells_at_their_shifts() -> None:
    """For shifts of either sign, also several times around a short ring."""
    f = np.random.default_rng(0).normal(size=(2, 3, 5))
    for shift in range(-7, 8):
        bond = NumericBond((Entry((shift,), 2.0, 1), Entry((0,), -1.0, 0)), (), ForceProgram())
        wanted = 2.0 * np.roll(f[1], -shift, axis=-1) - f[0]
        np.testing.assert_array_equal(bond.stretched(f), wanted)
