"""Starts whose wave is not a closed form: record types, and the starts of longwave."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from longwave.scenes.description.scene_checks import NOT_GIVEN, plain
from longwave.scenes.description.scene_fields import SceneFields, StartRules
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from sympy import Expr

    from longwave.derive import Reduction
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.starts.computed_soliton import ComputedSoliton
    from longwave.scenes.starts.lattice_wave import LatticeWave


@dataclass(frozen=True, kw_only=True)
class WaveStart(StartRules):
    """Start with a wave of the lattice itself, without a reduced equation.

    ``wave`` builds the wave and raises ValueError for inadmissible parameters. ``equation`` is the
    text that runs record as their equation.
    """

    wave: Callable[[Scene], LatticeWave]
    equation: str = ""


@dataclass(frozen=True, kw_only=True)
class ReducedStart(StartRules):
    """Start with a numerical solution of the lattice's reduced equation.

    ``solve`` computes it and raises ValueError for inadmissible parameters.
    """

    solve: Callable[[Scene, Reduction, Mapping[str, Expr]], ComputedSoliton]


def _solve_soliton(
    scene: Scene, reduction: Reduction, parameters: Mapping[str, Expr]
) -> ComputedSoliton:
    from longwave.scenes.starts.computed_soliton import ComputedSoliton

    if {*parameters} != {"speed"}:
        raise ValueError(
            f"parameters of {scene.wave_name} must be speed, got "
            f"{', '.join(map(plain, parameters)) or 'none'} (its speed in X/T, such as 1)"
        )
    if scene.order == "corrected":
        raise ValueError(
            f"order must be leading or slaved with the wave {scene.wave_name}, got corrected (its "
            "derivatives are too noisy for the next order)"
        )
    return ComputedSoliton(reduction, float(parameters["speed"]))


PERTURBATION_PARAMETERS = ("amplitude", "kappa", "share")
"""Parameters of a perturbed plane wave: ``amplitude`` |A|, and either the perturbation's wavenumber
``kappa`` in X or its ``share`` of the fastest growing wavenumber, by default 1."""


def _check_growth(scene: SceneFields) -> None:
    """Raise ValueError for scene fields that a growth-rate measurement does not admit."""
    t0 = None if scene.t0 == NOT_GIVEN else scene.t0
    given = ("times", scene.snapshots), ("compared", scene.compared or None), ("t0", t0)
    for key, value in (*given, *((k, getattr(scene, k)) for k in ("slow_times", "half_width"))):
        if value not in ((), None):
            raise ValueError(
                f"{key} must not be given with the wave {scene.wave_name}, got {shown(value)} "
                "(the times and cells of its measurement are computed)"
            )
    if not scene.is_envelope:
        raise ValueError(
            f"k in [envelope] must be given with the wave {scene.wave_name}, got nothing "
            '(such as k = "pi/2")'
        )
    if scene.disorder:
        raise ValueError(
            f"disorder must not be given with the wave {scene.wave_name}, got "
            f"{shown(dict(scene.disorder.pairs))} (its waves would be scattered into all others)"
        )
    names = [name for name, _ in scene.parameters]
    unknown = [name for name in names if name not in PERTURBATION_PARAMETERS]
    if unknown or "amplitude" not in names or {"kappa", "share"} <= {*names}:
        raise ValueError(
            f"parameters of {scene.wave_name} must be amplitude, and kappa or share or "
            f"neither, got {shown(', '.join(names) or 'none')} (such as amplitude = 0.5)"
        )
    if scene.order == "corrected":
        raise ValueError(
            f"order must be leading or slaved with the wave {scene.wave_name}, got corrected "
            "(its theory is the envelope equation alone)"
        )


computed_soliton = ReducedStart(solve=_solve_soliton)
"""Soliton, of a ``speed`` in X/T, of an equation without a soliton in closed form."""

perturbed_plane = StartRules(method="sidebands", measured="growth rate", check=_check_growth)
"""Plane wave of a carrier with a perturbation, whose growth rate is measured."""
