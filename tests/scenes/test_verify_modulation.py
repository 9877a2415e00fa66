"""Envelopes on grids against the same coefficients at 60 digits, one at a time."""

import time
from typing import Any

import numpy as np
import pytest

from longwave.derive import LATTICES, EnvelopeError, envelope
from longwave.scenes.modulation import modulation_grid

CASES: dict[str, tuple[str, str, dict[str, Any]]] = {
    "chain": ("fput", "acoustic", {"K2": 1, "K3": 0.7, "K4": 1}),
    "pinned": ("klein_gordon", "acoustic", {"K2": 1, "g1": 0.5, "g2": 0.3, "g3": 1}),
    "granular": ("granular", "acoustic", {"A": 1, "d": 0.5}),
    "optical": ("mass_dimer", "optical", {"K2": 1, "K3": 0.3, "K4": 1, "m1": 1, "m2": 4}),
    "far": (
        "next_nearest",
        "acoustic",
        {"K2": 1, "K3": 0.3, "K4": 1, "L2": 0.2, "L3": 0.1, "L4": 0.5},
    ),
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n in ("optical", "far"))) for n in CASES]
)
def test_the_grid_is_that_of_single_points(name: str) -> None:
    lattice, branch, constants = CASES[name]
    wavenumbers = np.array([0.1, 0.9, 2.0, 3.0, np.pi])
    grid = modulation_grid(LATTICES[lattice], wavenumbers, branch, 2.0, **constants)
    found = envelope(LATTICES[lattice], **({} if name == "granular" else constants))
    for i, k in enumerate(wavenumbers):
        numbers = found.coefficients(float(k), branch, **constants)
        assert grid.omega[i] == pytest.approx(numbers.omega, rel=1e-9)
        assert grid.p[i] == pytest.approx(numbers.p, rel=1e-7)
        assert grid.q[i] == pytest.approx(numbers.q, rel=1e-7)
        assert grid.growth_rate[i] == pytest.approx(numbers.growth_rate(2.0), rel=1e-7)


def test_a_whole_map_takes_less_than_a_second() -> None:
    """K3 against k: bright where 3 K2 K4 > 2 K3^2 (1 + 1/s^2)."""
    k, K3 = np.linspace(0.02, np.pi, 200), np.linspace(0, 1.5, 200)[:, None]
    begun = time.process_time()
    found = modulation_grid(LATTICES["fput"], k, K2=1, K3=K3, K4=1)
    assert time.process_time() - begun < 1
    bright = 2 * K3**2 * (1 + 1 / np.sin(k / 2) ** 2) < 3
    assert found.product.shape == (200, 200)
    assert np.array_equal(found.product > 0, bright)
    assert np.all((found.growth_rate > 0) == bright)


def test_a_resonance_is_no_number() -> None:
    values: Any = {"K2": 1, "K3": 1, "K4": 0, "L2": -0.25, "L3": 0, "L4": 0}
    lattice = LATTICES["next_nearest"]
    with pytest.raises(EnvelopeError, match="omega"):
        envelope(lattice, **values).coefficients(np.pi / 2, **values)
    found = modulation_grid(lattice, [np.pi / 2, 1.0], **values)
    assert np.isnan(found.q).tolist() == [True, False]


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "k": ({"k": [0.0, 1.0]}, "k must satisfy 0 < k <= pi, got 0 .. 1"),
    "missing": ({"k": 1.0, "K2": 1, "K3": 0}, "K4 must be given, got none"),
    "unknown": (
        {"k": 1.0, "K2": 1, "K3": 0, "K4": 1, "K5": [1.0]},
        "constants must be those of the lattice, got K5",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_grid_is_refused(name: str) -> None:
    words, message = WRONG[name]
    with pytest.raises(ValueError, match=message):
        modulation_grid(LATTICES["fput"], **words)
