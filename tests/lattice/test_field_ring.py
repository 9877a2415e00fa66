"""Interpolation of fields on a ring between their samples, in one and two dimensions."""

import numpy as np
import pytest

from longwave.lattice.spectral.field_ring import FieldRing


def ring(counts: tuple[int, ...]) -> FieldRing:
    f = np.random.default_rng(1).standard_normal((2, *counts))
    lengths = tuple(7.5 + axis for axis in range(len(counts)))
    return FieldRing(0.0, (0.3,) * len(counts), lengths, f, -f)


@pytest.mark.parametrize("counts", [(16,), (15,), (12, 9), (8, 10)])
def test_the_interpolant_matches_the_samples_and_is_periodic(counts: tuple[int, ...]) -> None:
    state = ring(counts)
    grid = np.meshgrid(*map(state.points, range(len(counts))), indexing="ij")
    np.testing.assert_allclose(state.at(*grid), state.f, atol=1e-12)
    turned = [part - 4 * length for part, length in zip(grid, state.circumferences, strict=True)]
    np.testing.assert_allclose(state.velocities_at(*turned), state.v, atol=1e-12)


@pytest.mark.parametrize("counts", [(16,), (15,), (12, 9), (8, 10)])
@pytest.mark.parametrize("more", [-3, -2, 1, 16])
def test_resampling_keeps_the_functions(counts: tuple[int, ...], more: int) -> None:
    state = ring(counts)
    other = state.sampled(tuple(count + more for count in counts))
    grid = np.meshgrid(*map(other.points, range(len(counts))), indexing="ij")
    np.testing.assert_allclose(other.f, state.at(*grid), atol=1e-12)
    np.testing.assert_allclose(other.v, state.velocities_at(*grid), atol=1e-12)


def test_the_tail_bounds_the_contribution_of_the_last_modes() -> None:
    x = np.arange(64) / 64.0
    waves = [0.3 * np.cos(2 * np.pi * 31 * x) - 0.2 * np.sin(2 * np.pi * 28 * x)]
    state = FieldRing(0.0, (0.0,), (1.0,), np.array([waves[0], np.cos(2 * np.pi * x)]), 0 * x)
    assert state.tail() == pytest.approx(0.3, abs=1e-12)
    across = np.multiply.outer(np.cos(2 * np.pi * x), waves[0])[None]
    both = FieldRing(0.0, (0.0, 0.0), (1.0, 1.0), across, across)
    turned = FieldRing(0.0, (0.0, 0.0), (1.0, 1.0), across.swapaxes(1, 2), across)
    assert both.tail() == pytest.approx(0.3, abs=1e-12) == turned.tail()
