"""Catches: arcs that overlap too little, lose a site, or round otherwise than one core does."""

import multiprocessing

import numpy as np
import pytest

from lattice.kernels import blocked as tiled
from lattice.kernels import two_cores as arcs
from lattice.model import Constants
from lattice.schemes.catalogue import KAHAN_LI_8, REDUCED_PHASE_6, STOERMER_VERLET
from lattice.schemes.splitting import Splitting

CONSTANTS = Constants(4.0, 0.2, 1.0)


@pytest.mark.parametrize("scheme", [REDUCED_PHASE_6, KAHAN_LI_8, STOERMER_VERLET])
@pytest.mark.parametrize("size", [arcs.SITES, arcs.SITES + 3 * tiled.LANES])
@pytest.mark.parametrize("steps", [0, 1, arcs.TOGETHER, 2 * arcs.TOGETHER + 3])
def test_two_cores_give_the_bits_of_one(scheme: Splitting, size: int, steps: int) -> None:
    y, s = 0.05 * np.random.default_rng(3).standard_normal((2, size))
    u, v = y.copy(), s.copy()
    work = 0.2 * scheme.drifts, 0.2 * scheme.kicks, steps, *CONSTANTS.kernel
    tiled.advance_tiled(y, s, *work)
    arcs.advance_on_arcs(u, v, *work)
    np.testing.assert_array_equal(u, y)
    np.testing.assert_array_equal(v, s)


def test_a_worker_process_leaves_the_other_core_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arcs.os, "cpu_count", lambda: 2)
    assert arcs.pays(arcs.SITES)
    assert not arcs.pays(arcs.SITES - 1)
    monkeypatch.setattr(multiprocessing, "parent_process", lambda: object())
    assert not arcs.pays(arcs.SITES)


def test_one_core_is_not_divided(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arcs.os, "cpu_count", lambda: 1)
    assert not arcs.pays(arcs.SITES)
