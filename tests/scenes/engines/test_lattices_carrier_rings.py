"""Catches: a ring on which a carrier does not close, a blow-up at a seam blamed on the lattice."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from longwave.lattice.state import BlowUp
from longwave.scenes import run
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import domain_plan as rings_module
from longwave.scenes.engines.lattice_run import domain_plan
from longwave.scenes.starts.lattice_derivation import lattice_wave

SOFT = Scene.of(
    name="soft",
    lattice="klein_gordon",
    constants={"K2": 0.91, "g1": 1, "g2": 0, "g3": -1},
    eps=0.5,
    wave="nls_plane",
    parameters={"A": 1},
    carrier="pi",
    order="slaved",
    times=[0, 100],
    compared=3,
    tolerance=1e-3,
)


@pytest.mark.slow
@pytest.mark.parametrize("order", ["slaved", "leading"])
def test_neighbours_that_move_against_each_other_do_so_all_round_the_ring(order: str) -> None:
    """Compare with the equation of one neighbour, by SciPy. Catches: a blow-up on an odd ring."""
    scene = SOFT.changed(order=order)
    found = run(scene)
    f, v = (float(values[0, 0]) for values in lattice_wave(scene).state(np.zeros(1), 0.0))
    exact = solve_ivp(
        lambda _, y: [y[1], -(4 * 0.91 + 1) * y[0] + y[0] ** 3],
        (0.0, 100.0), [f, v], "DOP853", rtol=1e-12, atol=1e-14,
    ).y[0, -1]  # fmt: skip
    middle = float(found.strain[-1].sel(site=0))
    assert not found.attrs["blow_up"]
    assert abs(middle - exact) < 0.5 * found.attrs["error_estimate"] <= 0.5e-3


@pytest.mark.parametrize(
    "k",
    [
        *("pi", "pi/2", "2*pi/3", "3*pi/4"),
        *(pytest.param(k, marks=pytest.mark.slow) for k in ("3*pi/5", "5*pi/12", "7*pi/9")),
    ],
)
def test_rings_are_commensurate_with_carriers_that_can_be(k: str) -> None:
    _, domains = domain_plan(SOFT.changed(carrier=k, times=[0, 3]))
    for wider in (0, rings_module.EXTRA_CELLS):
        ends = domains.ends(wider)
        [(low, high)], [(_, least)] = ends, domains.plain_ends(wider)
        assert domains.seam_mismatch(ends)[0] < 1e-9
        assert least <= high < least + rings_module.MAX_ADDED_CELLS
        turns = (high + 1 - low) * float(lattice_wave(SOFT.changed(carrier=k)).carrier.k)
        assert abs(turns / (2 * np.pi) - round(turns / (2 * np.pi))) < 1e-9


def test_a_carrier_that_closes_on_no_ring_gets_the_one_of_least_mismatch() -> None:
    found = run(SOFT.changed(carrier=3))
    assert not found.attrs["blow_up"]
    _, domains = domain_plan(SOFT.changed(carrier=3, times=[0, 3]))
    assert (
        domains.seam_mismatch(domains.ends())[0]
        < 0.1 * domains.seam_mismatch(domains.plain_ends(0))[0]
    )


@pytest.mark.slow
def test_a_blow_up_at_a_seam_has_its_distance_from_the_seam(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, domains = domain_plan(SOFT.changed(times=[0, 3]))
    closed = domains.ends()
    torn = [(closed[0][0], closed[0][1] + 1)]
    found = BlowUp("the fields are not finite", 2.0, torn[0][0] + 1)
    assert domains.with_seam_distance(found, torn).from_seam == 1
    assert "not the lattice" in str(domains.with_seam_distance(found, torn))
    assert domains.with_seam_distance(found, closed).from_seam is None
    far = BlowUp("the fields are not finite", 0.01, (torn[0][0] + torn[0][1]) // 2)
    assert domains.with_seam_distance(far, torn).from_seam is None
    monkeypatch.setattr(rings_module, "MAX_ADDED_CELLS", 1)
    message = run(SOFT).attrs["blow_up"]
    assert "from the ring's seam" in message
