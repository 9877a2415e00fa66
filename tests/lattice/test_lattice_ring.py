"""The exponential engine of any lattice: exact if linear, and of its order otherwise."""

import math
from dataclasses import replace

import numpy as np
import pytest

from longwave.derive import LATTICES
from longwave.lattice.force_program import ForceProgram
from longwave.lattice.model import Model
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice
from longwave.lattice.spectral.evolution import SamplingError, SpectralRing
from longwave.lattice.spectral.field_ring import FieldRing
from longwave.lattice.spectral.lattice_ring import LatticeRing
from longwave.lattice.spectral.normal_modes import normal_modes
from tests.families import family
from tests.lattice.random_lattices import reference
from tests.lattice.test_numeric_lattice import numbers

END = 6.0

LATTICES_WITH_ALL_FEATURES = (
    "alpha_fput",
    "fput_strain",
    "granular",
    "klein_gordon",
    "mass_dimer",
    "square",
)
"""Lattices that together have every feature: strains, a site's force, two masses, two axes."""


def rough(chain: NumericLattice, sites: int) -> FieldRing:
    """Return random fields on all sites."""
    axes = chain.dimension
    size = 0.01 if chain.name == "lennard_jones" else 0.05
    shape = (2, len(chain.fields), *(sites,) * axes)
    f, v = size * np.random.default_rng(5).standard_normal(shape)
    return FieldRing(0.0, (0.0,) * axes, (float(sites),) * axes, f, v)


@pytest.mark.parametrize("name", family(sorted(LATTICES), quick=LATTICES_WITH_ALL_FEATURES))
def test_the_ring_agrees_with_the_lattice_in_any_frame(name: str) -> None:
    chain = numbers(name)
    state = rough(chain, 6)
    exact = reference(chain, state.f, state.v, [END])
    assert exact is not None
    steps = np.array([0.05, 0.025]) * 2.0 / chain.highest_frequency(chain.rest_slopes())
    for speed in (0.0, 0.8):
        rings = [LatticeRing(chain, state, h, END, (speed,) * chain.dimension) for h in steps]
        coarse, fine = (float(np.max(np.abs(ring.at(END).f - exact[0]))) for ring in rings)
        assert fine < 1e-5 * np.max(np.abs(exact))
        assert 3.4 < math.log2(coarse / fine) < 4.7


@pytest.mark.parametrize("name", ["dimer", "triatomic", "klein_gordon", "square"])
def test_a_linear_lattice_is_exact_whatever_the_step(name: str) -> None:
    bent = numbers(name)
    straight = [
        replace(bond, force=ForceProgram(bond.force.coefficients[:1])) for bond in bent.bonds
    ]
    chain = replace(bent, bonds=tuple(straight))
    state = rough(chain, 7)
    exact = reference(chain, state.f, state.v, [END])
    assert exact is not None
    found = LatticeRing(chain, state, 2.0, END, (1.0,) * chain.dimension).at(END)
    np.testing.assert_allclose(found.f, exact[0], atol=1e-10)


def test_a_chain_with_momentum_drifts() -> None:
    chain = numbers("dimer")
    state = FieldRing(2.0, (0.0,), (6.5,), np.full((2, 16), 0.7), np.full((2, 16), 0.3))
    found = LatticeRing(chain, state, 3.0, 40.0, (1.0,)).at(42.0)
    np.testing.assert_allclose(found.f, 12.7, rtol=1e-12)
    np.testing.assert_allclose(found.v, 0.3, rtol=1e-12)


def test_an_unstable_site_leaves_its_equilibrium() -> None:
    """u'' = u - u^3 from near 0: the mean slope is negative, so the frequency is imaginary."""
    here = ((Entry((0,), 1.0, 0),), (Entry((0,), -1.0, 0),))
    chain = NumericLattice(
        "hill", ("u",), (1.0,), (NumericBond(*here, ForceProgram((-1.0, 0, 1.0))),)
    )
    state = FieldRing(0.0, (0.0,), (4.0,), np.full((1, 8), 5e-3), np.zeros((1, 8)))
    exact = reference(chain, state.f, state.v, [9.0])
    assert exact is not None
    found = LatticeRing(chain, state, 0.01, 9.0, (0.0,)).at(9.0)
    np.testing.assert_allclose(found.f, exact[0], rtol=1e-6)


def test_it_agrees_with_the_strain_ring_on_a_real_circumference() -> None:
    x = 140.5 / 512 * np.arange(512)
    y = 0.1 / np.cosh((x - 70.0) / 4.0)
    s = y * np.tanh((x - 70.0) / 4.0) / 4.0
    state = FieldRing(0.0, (0.0,), (140.5,), y[None], s[None])
    old = SpectralRing(Model(1.0, 0.25, 1.0), state, 0.05).at(80.0)
    new = LatticeRing(numbers("fput_strain"), state, 0.05, 80.0, (1.0,)).at(80.0)
    places = np.linspace(0.0, 140.5, 50)
    np.testing.assert_allclose(new.at(places), old.at(places), atol=1e-8)
    np.testing.assert_allclose(new.velocities_at(places), old.velocities_at(places), atol=1e-8)


def test_waves_along_one_axis_of_the_square_lattice_are_those_of_the_chain() -> None:
    chain, square = numbers("fput"), numbers("square")
    x = 30.5 / 64 * np.arange(64)
    u = 0.2 * np.sin(2 * np.pi * x / 30.5)
    line = LatticeRing(
        chain, FieldRing(0.0, (0.0,), (30.5,), u[None], 0 * u[None]), 0.1, 20.0, (1.0,)
    ).at(20.0)
    sheet = np.repeat(u[None, :, None], 6, axis=2)
    plane = LatticeRing(
        square, FieldRing(0.0, (0.0, 0.0), (30.5, 3.7), sheet, 0 * sheet), 0.1, 20.0, (1.0, 0.0)
    ).at(20.0)
    np.testing.assert_allclose(plane.f[0], np.repeat(line.f[0][:, None], 6, axis=1), atol=1e-12)


def test_the_tail_is_checked() -> None:
    x = 40.0 / 64 * np.arange(64)
    steep = np.exp(-((x - 20.0) ** 2) / 8.0)[None]
    state = FieldRing(0.0, (0.0,), (40.0,), steep, 0 * steep)
    with pytest.raises(SamplingError, match="tail is"):
        LatticeRing(numbers("fput"), state, 0.1, 50.0, (0.0,), tail=1e-9).at(50.0)


def test_strains_of_two_fields_decouple() -> None:
    """Strains of a mass dimer: no weights of the masses make their matrix Hermitian."""
    here, back, ahead = (0,), (-1,), (1,)
    m = (1.0, 3.0)
    first = NumericBond(
        (Entry(here, 1.0, 0),),
        (
            Entry(here, -1 / m[0] - 1 / m[1], 0),
            Entry(here, 1 / m[1], 1),
            Entry(ahead, 1 / m[0], 1),
        ),
        ForceProgram((1.0, 0.3)),
    )
    # y = v_n - u_n, z = u_{n+1} - v_n
    first = replace(
        first,
        action=(
            Entry(here, -1 / m[0] - 1 / m[1], 0),
            Entry(here, 1 / m[1], 1),
            Entry(back, 1 / m[0], 1),
        ),
    )
    second = NumericBond(
        (Entry(here, 1.0, 1),),
        (
            Entry(here, -1 / m[0] - 1 / m[1], 1),
            Entry(here, 1 / m[1], 0),
            Entry(ahead, 1 / m[0], 0),
        ),
        ForceProgram((2.0, 0.5)),
    )
    chain = NumericLattice("strains", ("y", "z"), (1.0, 1.0), (first, second))
    state = rough(chain, 6)
    exact = reference(chain, state.f, state.v, [END])
    assert exact is not None
    found = LatticeRing(chain, state, 0.01, END, (0.7,)).at(END)
    np.testing.assert_allclose(found.f, exact[0], atol=1e-8)


def test_waves_that_grow_like_time_are_refused() -> None:
    """f'' = -f - g, g'' = -g has no two eigenvectors."""
    here = (0,)
    bonds = (
        NumericBond((Entry(here, 1.0, 0),), (Entry(here, -1.0, 0),), ForceProgram((1.0,))),
        NumericBond(
            (Entry(here, 1.0, 1),),
            (Entry(here, -1.0, 0), Entry(here, -1.0, 1)),
            ForceProgram((1.0,)),
        ),
    )
    chain = NumericLattice("jordan", ("f", "g"), (1.0, 1.0), bonds)
    with pytest.raises(
        ValueError, match="lattice must have normal modes that decouple, got jordan"
    ):
        normal_modes(chain, np.zeros((1, 1)), [1.0, 1.0], 0.01)
