"""Strains at the snapshots, the errors there, and what a restart needs."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from verify.lattice.observables.entry import View


def strain(view: View) -> Mapping[str, Any]:
    """Strains of run, wave and bare background, the sites' numbers, and the errors.

    Errors are NaN at a time when the wave is its own background on all compared sites.
    """
    rows = {
        "strain": view.numeric,
        "analytic": view.analytic,
        "background": view.background,
        "n": view.sites,
    }
    if not np.array_equal(view.analytic, view.background):
        return rows | _errors(view, "error")
    far = {"error_far_field": np.nan} if view.has_far_field else {}
    return rows | {"error": np.nan} | far


def error_curve(view: View) -> Mapping[str, Any]:
    """The relative sup errors alone."""
    return _errors(view, "error_curve")


def background_difference(view: View) -> Mapping[str, Any]:
    """Strain of the run less the bare wave of the same phase (or the constant)."""
    return {"background_difference": view.numeric - view.background}


def whole_state(view: View) -> Mapping[str, Any]:
    """Strains and velocities of all computed sites, in the order of storage."""
    state = view.state
    return {"state_y": state.y.copy(), "state_s": state.s.copy(), "state_left": state.left}


def _errors(view: View, prefix: str) -> dict[str, float]:
    found = {prefix: view.error}
    if view.has_far_field:
        found[f"{prefix}_far_field"] = view.error_far_field
    return found
