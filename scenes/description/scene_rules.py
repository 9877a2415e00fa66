"""Rules between several fields of a scene.

Each check raises ValueError with a one-line message: argument, condition, value, remedy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from longwave.scenes.description import entries
from longwave.scenes.description import scene_checks as check
from longwave.scenes.description.numerics import Discretisation, DomainRules, Tolerance
from longwave.scenes.description.scene_checks import CHAIN
from longwave.scenes.observed.observables import observable_named

if TYPE_CHECKING:
    from longwave.scenes.description.scene_fields import SceneFields

LARGEST_EPS = 1.0
"""Largest eps accepted; a larger one is likely a mistake of units."""


def check_moving_wave(scene: SceneFields) -> None:
    """Raise ValueError for numerics, observables or times that moving mKdV waves do not admit."""
    numerics = scene.numerics
    if isinstance(numerics, Discretisation):
        check.enough_steps(numerics.step, scene.end - scene.t0)
    check_observables(scene)
    check.within_reach(scene.model.sound_speed(), (scene.t0, scene.end))


def check_eps(given: object) -> float:
    """Return eps as a float; ValueError unless it is positive and at most `LARGEST_EPS`."""
    eps = check.positive("eps", given)
    if eps > LARGEST_EPS:
        raise ValueError(
            f"eps must satisfy eps <= {LARGEST_EPS:g}, got {eps:g} (it is small, as the waves are "
            "long: such as 0.05)"
        )
    return eps


def check_any_lattice(scene: SceneFields) -> None:
    """Raise ValueError for fields that waves other than moving mKdV waves do not admit."""
    if not isinstance(scene.wave, str):
        raise ValueError(
            f"wave must be the name of a closed form on {scene.lattice}, got {scene.wave.name}, "
            "which is not in the catalogue (a custom wave needs the paper's chain with K3 = 0 and "
            "leading data)"
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
    """Raise ValueError for domains and engines that the scene's wave does not admit."""
    numerics = scene.numerics
    if isinstance(numerics, Discretisation):
        may_move = not (scene.is_envelope or scene.disorder or scene.losses)
        known = entries.table(DomainRules).items()
        domains = [name for name, rule in known if not (rule.moves or rule.ends_meet)]
        domains += [name for name, rule in known if rule.moves and may_move]
        if numerics.domain not in domains or scene.is_growth:
            raise ValueError(
                f"domain must be {' or '.join(map(repr, domains))} for {scene.wave} on "
                f"{scene.lattice}, or a tolerance be given, got {numerics} (mKdV waves on {CHAIN} "
                "have others)"
            )
    elif not numerics.steps_cells and (scene.disorder or scene.losses or scene.is_growth):
        effect = "losses" if scene.losses else f"the wave {scene.wave_name}"
        what = f"with {'disorder' if scene.disorder else effect}"
        raise ValueError(
            f"engine must be 'stencil' {what}, got {numerics.engine!r} (it takes waves on a "
            "lattice that is the same in all cells and loses nothing; leave the engine out)"
        )
    elif not numerics.steps_cells and "state" in scene.observables:
        raise ValueError(
            f"engine must be 'stencil' for state, got {numerics.engine!r} (it has no sites to "
            "resume from)"
        )
    elif numerics.scheme and scene.is_growth:
        raise ValueError(
            f"scheme must not be given with the wave {scene.wave_name}, got {numerics.scheme} "
            "(leave it out)"
        )


def _check_losses(scene: SceneFields) -> None:
    """Raise ValueError for losses in a scene whose theory does not include them."""
    for word, is_given, why in (
        ("disorder", scene.disorder, "scattering and losses could not be distinguished"),
        ("an envelope", scene.is_envelope, "its waves have no closed form with losses"),
        ("order corrected", scene.order == "corrected", "take slaved"),
    ):
        if scene.losses and is_given:
            raise ValueError(f"losses must not be given with {word}, got {scene.losses} ({why})")


def check_observables(scene: SceneFields) -> None:
    """Raise ValueError for observables that the scene's numerics do not admit."""
    if scene.is_growth and scene.observables != scene.start.observables:
        raise ValueError(
            f"observables must not be given with the wave {scene.wave_name}, got "
            f"{', '.join(scene.observables)} (only its {scene.start.measured} is measured)"
        )
    numerics = scene.numerics
    for name in scene.observables:
        observable = observable_named(name)
        if isinstance(numerics, Tolerance):
            if observable.measured_at == "refinement":
                raise ValueError(
                    f"observables must have no refinement with a tolerance, got {name} "
                    "(leave it out: the run reports an estimate of its own)"
                )
        elif observable.needs_ring and numerics.rules.moves:
            raise ValueError(
                f"domain must be 'ring' for {name}, got {numerics.domain!r} (a {numerics.domain} "
                "drops sites)"
            )
