"""Chains whose masses or springs differ from cell to cell.

Catches: a deviation of the wrong cell, of a mass instead of its inverse or of a force in another
unit, a wave faster than the bound, an ordered chain with other bits, a realisation that depends on
the ring.
"""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from longwave.derive import LATTICES
from longwave.lattice import FieldRing, State, integrate, spectral_integrate
from longwave.lattice.disordered_lattice import DisorderedLattice, disordered, mass_kind
from longwave.lattice.force_program import ForceProgram
from longwave.lattice.kernels.ring_kernel import RingKernel
from longwave.lattice.numeric_lattice import Array, NumericLattice, numeric_lattice
from longwave.lattice.random_sites import mean_inverse, site_deviations
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.lattice.variation import Variation
from tests.lattice.test_numeric_lattice import numbers

CHAINS = ("fput_strain", "next_nearest", "fput", "dimer", "klein_gordon", "toda", "granular")

LINEAR: dict[str, Any] = {"K2": 1, "K3": 0, "K4": 0}


def varied(lattice: NumericLattice, of: str, spread: float, size: int) -> DisorderedLattice:
    """Return the lattice with deviations of all masses or of its forces.

    Forces deviate in the first half of each polynomial.
    """
    if of == "mass":
        variation = Variation(spread, mass_kind(lattice))
    else:
        parts = tuple(
            bond.force
            if bond.force.instructions
            else ForceProgram(bond.force.coefficients[: -(-len(bond.force.coefficients) // 2)])
            for bond in lattice.bonds
        )
        variation = Variation(spread, None, (None, *parts[1:]) if len(parts) > 2 else parts)
    rows = variation.rows(len(lattice.fields))
    cells = np.arange(size)
    return disordered(
        lattice, variation, [spread * site_deviations(cells, 7, row) for row in range(rows)]
    )


def kick(lattice: NumericLattice, f: Array) -> Array:
    """Return the acceleration by the kernel."""
    v = np.zeros_like(f)
    RingKernel(lattice, f.shape[1]).advance_stages(f.copy(), v, np.zeros(1), np.ones(1), 1)
    return v


@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.parametrize("of", ["mass", "springs"])
def test_the_kernel_agrees_with_numpy(name: str, of: str) -> None:
    if (name, of) == ("granular", "springs"):
        return
    for size in (5, 33, 1032):
        f = 0.02 * np.random.default_rng(size).standard_normal((len(numbers(name).fields), size))
        chain = varied(numbers(name), of, 0.3, size)
        scale = np.abs(chain.acceleration(f)).max()
        np.testing.assert_allclose(
            kick(chain, f), chain.acceleration(f), rtol=0, atol=1e-13 * scale
        )
        assert np.abs(kick(chain, f) - kick(numbers(name), f)).max() > 1e-3 * scale


def test_the_order_of_deviations_in_memory_does_not_matter() -> None:
    f = 0.02 * np.random.default_rng(1).standard_normal((2, 9))
    chain = varied(numbers("mass_dimer"), "mass", 0.3, 9)
    turned = replace(chain, deviations=np.asfortranarray(chain.deviations))
    np.testing.assert_array_equal(kick(turned, f), kick(chain, f))


@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.parametrize("of", ["mass", "springs"])
def test_without_deviations_all_bits_are_those_of_the_ordered_chain(name: str, of: str) -> None:
    if (name, of) == ("granular", "springs"):
        return
    size, lattice = 700, numbers(name)
    chain = varied(lattice, of, 0.0, size)
    start = 0.02 * np.random.default_rng(1).standard_normal((2, len(lattice.fields), size))
    step = 0.3 / lattice.highest_frequency(lattice.rest_slopes())
    ends = []
    for held in (lattice, chain):
        f, v = start.copy()
        weights = step * REDUCED_PHASE_6.drifts, step * REDUCED_PHASE_6.kicks
        RingKernel(held, size).advance(f, v, *weights, 9)
        ends.append((f, v))
    np.testing.assert_array_equal(*ends)
    slopes = lattice.rest_slopes()
    assert chain.highest_frequency(chain.rest_slopes()) == lattice.highest_frequency(slopes)


@pytest.mark.parametrize("of", ["mass", "springs"])
def test_strains_and_displacements_agree(of: str) -> None:
    size, random = 200, np.random.default_rng(3)
    strained, displaced = (
        varied(numeric_lattice(LATTICES[name], {"K2": 1, "K3": 0.2, "K4": 1}), of, 0.4, size)
        for name in ("fput_strain", "fput")
    )
    u, w = 0.1 * random.standard_normal((2, 1, size))
    y, s = (np.roll(part, -1, 1) - part for part in (u, w))
    start = strained.energies(y, s, float(w[0, 0])).sum()
    assert displaced.energy(u, w) == pytest.approx(start, rel=1e-13)
    weights = 0.1 * REDUCED_PHASE_6.drifts, 0.1 * REDUCED_PHASE_6.kicks
    RingKernel(strained, size).advance(y, s, *weights, 300)
    RingKernel(displaced, size).advance(u, w, *weights, 300)
    np.testing.assert_allclose(y, np.roll(u, -1, 1) - u, rtol=0, atol=1e-12)
    assert displaced.energy(u, w) == pytest.approx(start, rel=1e-9)
    assert strained.energies(y, s, float(w[0, 0])).sum() == pytest.approx(start, rel=1e-9)


def frequencies(chain: DisorderedLattice) -> Array:
    """Return the frequencies of a linear ring, ascending, from its matrix."""
    size = chain.deviations.shape[1]
    columns = [chain.acceleration(unit[None])[0] for unit in np.eye(size)]
    squares = np.linalg.eigvals(-np.array(columns).T).real
    return np.sqrt(np.sort(np.maximum(squares, 0.0)))


@pytest.mark.parametrize("of", ["mass", "springs"])
@pytest.mark.parametrize("name", ["fput", "fput_strain"])
def test_long_waves_have_the_speed_of_springs_in_series_and_no_wave_is_above_the_bound(
    name: str, of: str
) -> None:
    chain = varied(numeric_lattice(LATTICES[name], LINEAR), of, 0.5, 150)
    found = frequencies(chain)
    d = chain.deviations[0]
    speed = np.mean(1.0 + d) ** -0.5 if of == "mass" else np.mean(1.0 / (1.0 + d)) ** -0.5
    assert found[1:3].mean() == pytest.approx(speed * 2.0 * np.pi / 150, rel=2e-3)
    most = chain.highest_frequency(chain.rest_slopes())
    assert 0.75 * most < found[-1] < most


@pytest.mark.parametrize("distribution", ["uniform", "binary"])
def test_deviations_belong_to_the_sites(distribution: str) -> None:
    words = {"seed": 5, "distribution": distribution}
    whole = site_deviations(np.arange(-1000, 4000), **words)  # type: ignore[arg-type]
    for first, last in ((-1000, -3), (-3, 2), (1, 2), (0, 4000), (1237, 2411)):
        part = site_deviations(np.arange(first, last), **words)  # type: ignore[arg-type]
        np.testing.assert_array_equal(part, whole[first + 1000 : last + 1000])
    assert np.abs(whole).max() <= 1.0
    assert abs(whole.mean()) < 0.05
    assert abs(np.mean(whole[1:] * whole[:-1])) < 0.05
    for other in (site_deviations(np.arange(5), 6), site_deviations(np.arange(5), 5, row=1)):
        assert not np.array_equal(other, site_deviations(np.arange(5), 5))
    drawn = np.mean(1.0 / (1.0 + 0.5 * whole))
    assert mean_inverse(distribution, 0.5) == pytest.approx(drawn, rel=0.02)


def philox(counter: int, key: tuple[int, int]) -> list[int]:
    """Return the four numbers of Philox4x64-10, computed with integers.

    Source: Salmon et al., SC11 (2011) 16.
    """
    mask = 2**64 - 1
    c, k = [counter & mask, counter >> 64, 0, 0], list(key)
    for _ in range(10):
        one, other = 0xD2E7470EE14C6C93 * c[0], 0xCA5A826395121157 * c[2]
        c = [(other >> 64) ^ c[1] ^ k[0], other & mask, (one >> 64) ^ c[3] ^ k[1], one & mask]
        k = [(k[0] + 0x9E3779B97F4A7C15) & mask, (k[1] + 0xBB67AE8584CAA73B) & mask]
    return c


def test_a_realisation_is_the_same_on_any_machine() -> None:
    for site in (-3, 0, 2, 1001):
        block, place = divmod(site + 2**60, 4)
        bits = philox(block + 1, (12, 1))[place]
        [found] = site_deviations([site], seed=12, row=1)
        assert found == float(Fraction(2 * (bits >> 11) + 1, 2**53) - 1)
        [sign] = site_deviations([site], seed=12, row=1, distribution="binary")
        assert sign == (1.0 if bits >= 2**63 else -1.0)


def test_invalid_disorder_is_refused_in_one_line() -> None:
    size = 8
    hertz = numbers("granular")
    with pytest.raises(
        ValueError, match=r"must exert no force at zero stretch, got granular, .* \(let the"
    ):
        disordered(hertz, Variation(0.1, None, (hertz.bonds[0].force,)), np.zeros((1, size)))
    soft = numeric_lattice(
        LATTICES["next_nearest"], {"K2": 1, "K3": 0, "K4": 0, "L2": "-1/5", "L3": 0, "L4": 0}
    )
    parts = soft.bonds[0].force, None
    with pytest.raises(
        ValueError, match=r"spread must leave next_nearest linearly stable, got 0\.3"
    ):
        disordered(soft, Variation(0.3, None, parts), np.zeros((1, size)))
    plane = Variation(0.1, "displacements")
    with pytest.raises(ValueError, match="disorder must be in a chain, got square in 2 dim"):
        disordered(numbers("square"), plane, np.zeros((1, size)))
    chain = varied(numbers("fput"), "mass", 0.1, size)
    state = State(0.0, np.zeros((1, size + 1)), np.zeros((1, size + 1)))
    with pytest.raises(ValueError, match="state must have the 8 cells of the lattice, got 9"):
        integrate(chain, state, [1.0], 1e-6)
    ring = FieldRing(0.0, (0.0,), (8.0,), np.zeros((1, size)), np.zeros((1, size)))
    with pytest.raises(ValueError, match="lattice must be the same in all cells, got disorder"):
        spectral_integrate(chain, ring, [1.0], 1e-6)


def test_slope_bounds_hold_in_every_cell() -> None:
    chain = varied(numbers("dimer"), "springs", 0.5, 300)
    stretches = chain.stretches(np.random.default_rng(4).uniform(-0.2, 0.2, (2, 300)))
    for place, slopes in enumerate(chain.slopes(stretches)):
        ordered = chain.ordered.steepest(place, stretches[place])
        for bound in (chain.steepest, chain.largest_slope):
            assert ordered < np.max(slopes) <= bound(place, stretches[place]) < 1.6 * ordered


def test_estimates_bound_the_error() -> None:
    """A step that is stable only in the ordered chain would be far off, or blow up."""
    size = 100
    chain = varied(
        numeric_lattice(LATTICES["fput"], {"K2": 1, "K3": 0, "K4": 1}), "mass", 0.8, size
    )
    f = 0.3 * np.exp(-((np.arange(size) - 50.0) ** 2) / 8.0)[None]
    runs = [
        integrate(chain, State(0.0, f, np.zeros_like(f)), [40.0], tolerance)
        for tolerance in (1e-4, 1e-9)
    ]
    apart = np.abs(runs[0].f - runs[1].f).max()
    assert apart <= runs[0].error_estimate + runs[1].error_estimate
    assert runs[0].error_estimate <= 1e-4
