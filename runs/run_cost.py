"""What a scene of either kind is expected to cost, before it is run."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from longwave.scenes.lattice_scene import LatticeScene
from longwave.support.request_limits import ExpectedCost, check_request, is_too_much

if TYPE_CHECKING:
    from longwave.runs.sweep_scene import AnyScene

CHEAPER = "take a larger eps, end earlier or compare fewer sites"

LEAST_SECONDS = 0.02
"""Of a cell of a sweep, whatever it holds: its plan, its data set, its place in a pack."""


def expected_run_cost(scene: AnyScene) -> ExpectedCost:
    """What a run of the scene is expected to cost, in a process that has just begun.

    What is known to be beyond the limits from the scene alone is not looked at any further. Raises
    ValueError for what no scene can be run with.
    """
    if isinstance(scene, LatticeScene):
        from longwave.scenes.lattice_run import expected_lattice_cost

        return expected_lattice_cost(scene)
    from longwave.scenes.chain.expected_cost import expected_cost, least_cost

    least = least_cost(scene)
    return least if is_too_much(least) else expected_cost(scene)


def check_run_cost(scene: AnyScene) -> ExpectedCost:
    """The same; TooMuchError if it is more than the limits allow."""
    found = expected_run_cost(scene)
    check_request(scene.name, found, CHEAPER)
    return found


def expected_cell_cost(scene: AnyScene) -> ExpectedCost:
    """The same as one of many in a process: what that does once is left out."""
    if isinstance(scene, LatticeScene):
        from longwave.scenes.ring_cost import BEGIN_SECONDS as once
    else:
        from longwave.scenes.chain.expected_cost import PROCESS_SECONDS as once
    found = expected_run_cost(scene)
    return replace(found, seconds=max(LEAST_SECONDS, found.seconds - once))
