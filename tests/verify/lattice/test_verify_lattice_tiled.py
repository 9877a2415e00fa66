"""The tiled vector kernel is the plain one, for all constants and at every seam."""

import numpy as np
import pytest

from verify.lattice import stencil, tiled
from verify.lattice.constants import Constants
from verify.lattice.nystroem_conditions import splitting_defect
from verify.lattice.splitting import BLANES_MOAN_6, Splitting


@pytest.mark.parametrize("K3", [0.0, 0.3])
@pytest.mark.parametrize("K4", [0.0, -0.7, 1.0])
@pytest.mark.parametrize(("size", "steps"), [(4096, 9), (2304, 4), (60, 5)])
def test_tiled_equals_plain(K3: float, K4: float, size: int, steps: int) -> None:
    random = np.random.default_rng(1)
    y, s = 0.1 * random.standard_normal((2, size))
    u, v = y.copy(), s.copy()
    drifts, kicks = 0.3 * BLANES_MOAN_6.drifts, 0.3 * BLANES_MOAN_6.kicks
    constants = Constants(4.0, K3, K4).kernel
    assert tiled.fits(size, kicks.size)
    stencil.advance_composition(y, s, drifts, kicks, steps, *constants)
    tiled.advance_tiled(u, v, drifts, kicks, steps, *constants)
    np.testing.assert_allclose(u, y, atol=1e-13)
    np.testing.assert_allclose(v, s, atol=1e-13)


def test_odd_ring_falls_back() -> None:
    random = np.random.default_rng(2)
    y, s = 0.1 * random.standard_normal((2, 61))
    begin = y.copy(), s.copy()
    constants = Constants(4.0, 0.0, 1.0)
    BLANES_MOAN_6.advance(y, s, 0.1, 7, constants)
    BLANES_MOAN_6.advance(y, s, -0.1, 7, constants)
    np.testing.assert_allclose(y, begin[0], atol=1e-13)
    np.testing.assert_allclose(s, begin[1], atol=1e-13)


def test_order_is_six() -> None:
    random = np.random.default_rng(3)
    modes = np.arange(1, 6)[:, None] * 2 * np.pi / 64 * np.arange(64)
    y0 = 0.5 * random.standard_normal(5) @ np.cos(modes)
    constants = Constants(1.0, 0.2, 0.5)

    def end(steps: int) -> np.ndarray:
        y, s = y0.copy(), np.zeros(64)
        BLANES_MOAN_6.advance(y, s, 8.0 / steps, steps, constants)
        return y

    reference = end(448)
    errors = [np.abs(end(steps) - reference).max() for steps in (32, 40, 56)]
    slope = np.polyfit(np.log([32, 40, 56]), np.log(errors), 1)[0]
    assert -6.5 < slope < -5.5


def test_wrong_digit_is_refused() -> None:
    drifts = (BLANES_MOAN_6.drift_half[0] + "1", *BLANES_MOAN_6.drift_half[1:])
    drifts = (*drifts[:-1], "0.2073050690668954")
    with pytest.raises(ValueError, match="conditions of order 6"):
        Splitting("wrong", 6, drifts, BLANES_MOAN_6.kick_half, "")
    assert splitting_defect(["0.5", "0.5"], ["1"], 3) > 0.01
