"""Catches: a stability limit that differs from where the kernels themselves become unstable."""

import numpy as np
import pytest

from longwave.lattice.model import Model
from longwave.lattice.schemes import SCHEMES, Scheme, check_step, scheme_named, stability_limit
from longwave.lattice.stepper import advance

LINEAR = Model(4.0, 0.0, 0.0)


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
def test_zone_boundary_noise_is_bounded_below_and_grows_above(scheme: Scheme) -> None:
    grown = {}
    for share in (0.998, 1.0001):
        y = 1e-12 * (-1.0) ** np.arange(8)
        s = np.zeros(8)
        h = share * stability_limit(scheme) / LINEAR.highest_frequency(np.zeros(1))
        advance(scheme, y[None], s[None], h, 80_000, LINEAR.lattice)
        grown[share] = np.max(np.abs(y)) / 1e-12
    assert grown[0.998] < 100
    assert not grown[1.0001] < 1e6


@pytest.mark.parametrize(
    ("name", "limit"),
    [("stoermer_verlet", 2.0), ("rk4", 2.0 * np.sqrt(2.0))],
)
def test_known_limits(name: str, limit: float) -> None:
    assert stability_limit(scheme_named(name)) == pytest.approx(limit, abs=2e-5)


def test_strain_stiffens_the_lattice() -> None:
    """Without the term 3 K4 y^2, a step that is unstable on the crest would be accepted."""
    scheme, constants = scheme_named("rk4"), Model(4.0, 0.0, 1.0)
    step = 0.99 * stability_limit(scheme) / 4.0
    check_step(step, scheme, constants.highest_frequency(np.zeros(3)))
    with pytest.raises(ValueError, match=r"step must satisfy step <= 0\.53.*rk4.*smaller step"):
        check_step(step, scheme, constants.highest_frequency(np.array([0.0, 1.0])))
