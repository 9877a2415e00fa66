"""What goes together in a scene: rules that ask more than one of its fields.

Each raises ValueError in one line: argument, condition, value, remedy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from longwave.scenes.description import scene_checks as check
from longwave.scenes.description.numerics import Discretisation, Tolerance
from longwave.scenes.description.scene_checks import CHAIN, NOT_GIVEN, PERTURBED_PLANE
from longwave.scenes.observed.observables import observable_named
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.scenes.description.scene_fields import SceneFields

PERTURBATION = ("amplitude", "kappa", "share")
"""Parameters of a perturbed plane wave: |A|, and the wavenumber of the perturbation in X, or that
in units of the one that grows fastest, which it is if neither is given."""

COMPUTED = "computed_soliton"
"""The soliton of a long-wave equation that has none in closed form, of a ``speed`` in X/T."""

LARGEST_EPS = 1.0
"""A parameter that is not small is a mistake in its unit."""

USUAL_OBSERVABLES: dict[str, tuple[str, ...]] = {
    "bench": (),
    "moving_wave": ("strain", "error_curve"),
    "ring": ("strain",),
    "sidebands": ("strain",),
}


def check_growth(scene: SceneFields) -> None:
    """Refuse what does not go with a growth rate: what is found, and what it has no theory for."""
    given: dict[str, object] = {"times": scene.snapshots, "compared": scene.compared or None}
    given |= {"t0": None if scene.t0 == NOT_GIVEN else scene.t0}
    for key in ("slow_times", "half_width"):
        given[key] = getattr(scene, key)
    for key, value in given.items():
        if value not in ((), None):
            raise ValueError(
                f"{key} must not be given with the wave {PERTURBED_PLANE}, got {shown(value)} "
                "(when its growth is measured is found)"
            )
    if not scene.is_envelope:
        raise ValueError(
            f"k in [envelope] must be given with the wave {PERTURBED_PLANE}, got nothing "
            '(such as k = "pi/2")'
        )
    if scene.disorder:
        raise ValueError(
            f"disorder must not be given with the wave {PERTURBED_PLANE}, got "
            f"{shown(dict(scene.disorder.pairs))} (its waves would be scattered into all others)"
        )
    names = [name for name, _ in scene.parameters]
    unknown = [name for name in names if name not in PERTURBATION]
    if unknown or "amplitude" not in names or {"kappa", "share"} <= {*names}:
        raise ValueError(
            f"parameters of {PERTURBED_PLANE} must be amplitude, and kappa or share or "
            f"neither, got {shown(', '.join(names) or 'none')} (such as amplitude = 0.5)"
        )
    if scene.order == "corrected":
        raise ValueError(
            f"order must be leading or slaved with the wave {PERTURBED_PLANE}, got corrected "
            "(its theory is the envelope equation alone)"
        )


def check_moving_wave(scene: SceneFields) -> None:
    """Refuse numerics that do not go with what is asked for."""
    numerics = scene.numerics
    if isinstance(numerics, Discretisation):
        check.enough_steps(numerics.step, scene.end - scene.t0)
    check_observables(scene)
    check.within_reach(scene.model.sound_speed(), (scene.t0, scene.end))


def check_eps(given: object) -> float:
    """The value as a float, if it is small and positive."""
    eps = check.positive("eps", given)
    if eps > LARGEST_EPS:
        raise ValueError(
            f"eps must satisfy eps <= {LARGEST_EPS:g}, got {eps:g} (it is small, as the waves are "
            "long: such as 0.05)"
        )
    return eps


def check_any_lattice(scene: SceneFields) -> None:
    """Refuse what is there for mKdV waves on the paper's chain alone."""
    if not isinstance(scene.wave, str):
        raise ValueError(
            f"wave must be the name of a closed form on {scene.lattice}, got {scene.wave.name}, "
            "which is not in the catalogue"
        )
    _check_numerics(scene)
    _check_losses(scene)
    check_observables(scene)
    if not scene.is_growth and len(scene.slow_times or {scene.t0, *scene.snapshots}) < 2:
        raise ValueError(
            f"times must hold one after the start, got {scene.t0:g} alone (such as "
            "times = [0, 100])"
        )


def _check_numerics(scene: SceneFields) -> None:
    """Refuse domains and engines that are there for mKdV waves on the paper's chain alone."""
    numerics = scene.numerics
    if isinstance(numerics, Discretisation):
        same = not (scene.is_envelope or scene.disorder or scene.losses)
        domains = ("ring", "window")[: 1 + same]
        if numerics.domain not in domains or scene.is_growth:
            raise ValueError(
                f"domain must be {' or '.join(map(repr, domains))} for {scene.wave} on "
                f"{scene.lattice}, or a tolerance be given, got {numerics} (mKdV waves on {CHAIN} "
                "have others)"
            )
    elif numerics.engine == "spectral" and (scene.disorder or scene.losses or scene.is_growth):
        effect = "losses" if scene.losses else f"the wave {PERTURBED_PLANE}"
        what = f"with {'disorder' if scene.disorder else effect}"
        raise ValueError(
            f"engine must be 'stencil' {what}, got 'spectral' (it takes waves on a lattice that is "
            "the same in all cells and loses nothing; leave the engine out)"
        )
    elif numerics.engine == "spectral" and "state" in scene.observables:
        raise ValueError(
            "engine must be 'stencil' for state, got 'spectral' (it has no sites to go on with)"
        )
    elif numerics.scheme and scene.is_growth:
        raise ValueError(
            f"scheme must not be given with the wave {PERTURBED_PLANE}, got {numerics.scheme} "
            "(leave it out)"
        )


def _check_losses(scene: SceneFields) -> None:
    """Refuse losses where no theory has them."""
    for word, is_given, why in (
        ("disorder", scene.disorder, "what scatters and what is lost would not be told apart"),
        ("an envelope", scene.is_envelope, "its waves have no closed form with losses"),
        ("order corrected", scene.order == "corrected", "take slaved"),
    ):
        if scene.losses and is_given:
            raise ValueError(f"losses must not be given with {word}, got {scene.losses} ({why})")


def check_observables(scene: SceneFields) -> None:
    """Refuse observables that do not go with how a scene is computed."""
    if scene.is_growth and scene.observables != USUAL_OBSERVABLES[scene.method]:
        raise ValueError(
            f"observables must not be given with the wave {PERTURBED_PLANE}, got "
            f"{', '.join(scene.observables)} (its growth rate is what is measured)"
        )
    numerics = scene.numerics
    for name in scene.observables:
        asked = observable_named(name)
        if isinstance(numerics, Tolerance) and asked.measured_at == "refinement":
            raise ValueError(
                f"observables must have no refinement with a tolerance, got {name} "
                "(leave it out: the run reports an estimate of its own)"
            )
        if asked.needs_ring and getattr(numerics, "domain", "") == "window":
            raise ValueError(
                f"domain must be 'ring' for {name}, got 'window' (a window drops sites)"
            )
