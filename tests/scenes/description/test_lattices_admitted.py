"""Admissible scenes that an earlier check refused."""

from __future__ import annotations

import json
from typing import Any

import pytest

from longwave.scenes import run
from longwave.scenes.description.scene import Scene

SCENE: dict[str, Any] = {
    "name": "admitted",
    "eps": 0.1,
    "tolerance": 1e-3,
    "half_width": 6,
    "slow_times": [0, 0.2],
    "order": "slaved",
}

GRANULAR = {"lattice": "granular", "wave": "kdv_soliton", "parameters": {"kappa": 1}}


@pytest.mark.parametrize("d", [2, "3/5"])
def test_a_granular_chain_has_solitons_where_its_coefficients_are_roots(d: int | str) -> None:
    """Catches: a refusal because a second ansatz does not fit, although the first does."""
    found = run(Scene.of(**SCENE, **GRANULAR, constants={"A": 1, "d": d}))
    assert found.equation.startswith("KdV: ")
    assert float(found["sup_error"].max()) < 0.1


def test_a_carrier_whose_first_cell_is_far_from_rest_is_run() -> None:
    """Catches: the stiffness of a cell within the carrier used as that of the lattice at rest."""
    constants = {"K2": 0.636, "g1": 1, "g2": 0, "g3": -1}
    wave = {"wave": "nls_plane", "parameters": {"A": 1}, "carrier": "pi", "eps": 0.6}
    scene = Scene.of(**SCENE | wave, lattice="klein_gordon", constants=constants)
    found = run(scene)
    assert float(found["error"].max()) < 0.1


ROTATING = {
    "name": "rotating",
    "fields": ["u", "f"],
    "masses": ["1", "J"],
    "positive": ["K", "J", "G", "H"],
    "spring": [
        {"between": ["u[n]", "u[n+1]"], "force": "K*x + K3*x**2"},
        {"between": ["f[n]", "f[n+1]"], "force": "G*x"},
    ],
    "bond": [
        {
            "stretch": "u[n+1] - u[n] - f[n] - f[n+1]",
            "action": {"u": "F[n] - F[n-1]", "f": "F[n] + F[n-1]"},
            "force": "H*x",
        }
    ],
}


def test_a_chain_of_displacement_and_rotation_is_run() -> None:
    """Catches: rotations that grow along a ring as displacements do."""
    constants = {"K": 1, "K3": "1/2", "J": 1, "G": 1, "H": 1}
    wave = {"wave": "kdv_soliton", "parameters": {"kappa": 1}, "constants": constants}
    errors = []
    for order in ("leading", "slaved"):
        lattice = {"lattice": "rotating", "declared": json.dumps(ROTATING), "order": order}
        found = run(Scene.of(**SCENE | lattice, **wave))
        errors.append(float(found["sup_error"].max()))
    assert errors[1] < 0.1 * errors[0] < 0.01


def test_a_steep_kink_of_displacements_is_run() -> None:
    """Catches: a jump of the strain at the ring's seam, which overshoots until no wave exists."""
    kink = {"lattice": "beta_fput", "wave": "kink", "eps": 0.2, "parameters": {"A": "9/4"}}
    found = run(Scene.of(**SCENE | kink, constants={"K2": 1, "K4": -1}))
    assert found.error_estimate <= found.tolerance
    assert float(found["sup_error"].max()) < 0.3
