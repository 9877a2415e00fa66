"""What can be explored, without a page: choices as they are typed -> scene -> lattice against wave.

A wave of the catalogue is at home on the lattices of its `settings`; each is a scene to begin with.
What a person types is text, and is judged by the scene, the wave and the lattice themselves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from longwave.scenes.description.named_scenes import load_scene, shipped_scenes
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import finite, positive
from longwave.support.known_names import one_of
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.solutions import ClosedForm, Parameter

CHAIN = "fput_chain"
"""The setting of mKdV waves that no shipped scene names: the paper's chain itself."""

FRAMES = 41
"""Equidistant times at which lattice and wave are compared."""

CHAIN_STARTS: Mapping[str, Mapping[str, float]] = {
    **{f"rational_{order}": {"K2": 4, "eps": 0.05, "half_width": 20} for order in (1, 2, 3)},
    "rogue_cn": {"begin": -0.25, "end": 0.25},
    "soliton_dn": {"begin": -0.25, "end": 0.25, "eps": 0.05},
    **{
        name: {"begin": -4, "end": 4}
        for name in ("soliton_sech", "kink", "two_soliton", "soliton_background", "kink_antikink")
    },
}
"""Where a wave on the chain begins other than `_chain` says: the paper's constants, shorter times
where the background is unstable, longer ones where waves only travel."""

OTHER_CONSTANTS: Mapping[str, tuple[str, Mapping[str, float]]] = {
    "gardner_table_soliton": ("gardner_soliton", {"K4": -1}),
    "gardner_kink": ("gardner_soliton", {"K4": -1}),
    "modified_kawahara_soliton": ("kawahara_soliton", {"K3": 0, "K4": 1}),
    "nls_dark": ("fput_peregrine", {"K4": -1}),
}
"""Waves of equations that no shipped scene has: a scene, and what makes its lattice theirs."""


@dataclass(frozen=True)
class WaveSetting:
    """A lattice on which a wave is at home, and the scene from which choices begin."""

    name: str
    title: str
    scene: Scene


@dataclass(frozen=True)
class Chosen:
    """What is chosen, as it is typed; ``begin``, ``end`` are slow times T, ``half_width`` is in X.

    >>> choices = first_choices("soliton_sech")
    >>> choices.parameters, choices.constants
    ({'A': '1'}, {'K2': '1', 'K3': '0', 'K4': '1'})
    >>> scene_of_choices(choices.changed(eps="0.2"))
    <Scene soliton_sech: soliton_sech with A = 1 on fput_strain, eps = 0.2, ... to 0.001>
    >>> scene_of_choices(choices.changed(eps="small"))
    Traceback (most recent call last):
    ...
    ValueError: eps must be a number, got 'small' (such as 0.05)
    """

    wave: str
    setting: str
    eps: str
    tolerance: str
    begin: str
    end: str
    half_width: str
    parameters: Mapping[str, str] = field(default_factory=dict)
    constants: Mapping[str, str] = field(default_factory=dict)

    def changed(self, **changes: Any) -> Chosen:
        """The choices with other values for some of them."""
        return replace(self, **changes)


def waves_by_equation() -> dict[str, dict[str, str]]:
    """The waves of the catalogue that have a lattice here: equation -> title -> name.

    That of the mKdV-Burgers equation has none: no scene of its losses is shipped.

    >>> waves_by_equation()["KP"]
    {'KP line soliton': 'kp_line_soliton', 'KP-I lump': 'kp_lump'}
    """
    from longwave.solutions import CATALOGUE, closed_form

    at_home = (*(wave for wave, _ in examples().values()), *OTHER_CONSTANTS)
    known = {"mKdV", *(closed_form(wave).equation.normal for wave in at_home)}
    found: dict[str, dict[str, str]] = {}
    for form in CATALOGUE:
        if form.equation.normal not in known:
            continue
        title = f"{form.title[0].upper()}{form.title[1:]}"
        found.setdefault(form.equation.normal, {})[title] = form.name
    return found


def examples() -> dict[str, tuple[str, str]]:
    """The shipped scenes that name a lattice: title -> wave and setting."""
    scenes = map(load_scene, shipped_scenes("lattices"))
    return {scene.title or scene.name: (scene.wave_name, scene.name) for scene in scenes}


def settings(wave: str) -> tuple[WaveSetting, ...]:
    """The lattices on which the wave can be put; ValueError if there is no such wave.

    >>> [setting.title for setting in settings("kp_lump")]
    ['square next nearest']
    """
    from longwave.solutions import closed_form

    form = closed_form(wave)
    found = (
        [WaveSetting(CHAIN, "FPUT chain", _chain(form))] if form.equation.normal == "mKdV" else []
    )
    base, constants = OTHER_CONSTANTS.get(wave, ("", {}))
    for name in shipped_scenes("lattices"):
        scene = load_scene(name)
        if name == base:
            scene = scene.changed(constants={**dict(scene.constants), **constants})
        elif not _alike(form, closed_form(scene.wave_name)) or (
            scene.losses and scene.wave != wave
        ):
            continue
        if scene.wave != wave:
            scene = scene.changed(
                wave=wave, parameters=_usual_parameters(form), order="slaved", title=""
            )
        found.append(WaveSetting(name, _lattice_title(scene), scene))
    return tuple(found)


def _alike(form: ClosedForm, other: ClosedForm) -> bool:
    """Whether both solve one equation, with the same signs where their waves depend on them."""
    one, two = form.equation, other.equation
    free = not isinstance(one.s, int)
    return one.normal == two.normal and (free or one.s == two.s) and one.r == two.r


def _lattice_title(scene: Scene) -> str:
    from longwave.derive import LATTICES

    known = LATTICES.get(scene.lattice)
    title = scene.lattice.replace("_", " ") if known is None else known.title
    if scene.is_envelope:
        title += f", carrier k = {scene.carrier}, {scene.branch} branch"
    return title


def _usual_parameters(form: ClosedForm) -> dict[str, float | None]:
    """Values in the middle of what is admitted; a parameter with a default is left to it."""
    found: dict[str, float | None] = {}
    for parameter in form.parameters:
        if parameter.default is None:
            low, high = bounds(parameter, found)
            if low is not None and high is not None:
                found[parameter.name] = float(f"{0.5 * (low + high):.3g}")
            else:
                found[parameter.name] = 1.0 if low is None else low + 1.0
    return found


def _chain(form: ClosedForm) -> Scene:
    """The paper's chain with an mKdV wave, to be seen about T = 0."""
    values = {"K2": 1, "eps": 0.1, "begin": -0.5, "end": 0.5, "half_width": 20}
    values |= CHAIN_STARTS.get(form.name, {})
    return Scene.of(
        name=form.name,
        wave=form.name,
        parameters=_usual_parameters(form),
        eps=values["eps"],
        slow_times=[values["begin"], values["end"]],
        half_width=values["half_width"],
        K2=values["K2"],
        K4=form.equation.s,
        tolerance=1e-3,
        observables=["strain"],
    )


def bounds(
    parameter: Parameter, values: Mapping[str, float | None]
) -> tuple[float | None, float | None]:
    """The ends of a parameter's declared domain, given others' values; None where there is none.

    >>> from longwave.solutions import closed_form
    >>> k, alpha, _ = closed_form("breather_sn").parameters
    >>> bounds(k, {}), [round(end, 3) for end in bounds(alpha, {"k": 0.5})]
    ((0.0, 1.0), [0.0, 1.686])
    """
    ends = [_end(bound.value, values) for bound in (parameter.lower, parameter.upper) if bound]
    low = ends[0] if parameter.lower else None
    return low, ends[-1] if parameter.upper else None


def _end(value: Any, values: Mapping[str, float | None]) -> float | None:
    """The number that a bound is, None if what it depends on is no number or not admitted."""
    known = {symbol: values.get(symbol.name) for symbol in value.free_symbols}
    if None in known.values():
        return None
    found = value.subs(known).evalf(15)
    return float(found) if found.is_real and found.is_finite else None


SPAN = 3.0
"""How far a slider reaches where the domain has no end; beyond that a value can be typed."""

INSIDE = 0.01
"""How far from an end that does not belong to the domain a slider stops, in units of its reach."""


def slider_ends(parameter: Parameter, values: Mapping[str, float | None]) -> tuple[float, float]:
    """From where to where a slider goes: within the declared domain.

    >>> from longwave.solutions import closed_form
    >>> slider_ends(closed_form("kink").parameters[0], {})
    (0.03, 3.0)
    """
    low, high = bounds(parameter, values)
    first = -SPAN if low is None and high is None else (high or 0.0) - SPAN if low is None else low
    last = first + SPAN * (2.0 if low is None else 1.0) if high is None else high
    inside = INSIDE * (last - first)
    return (
        float(f"{first + inside * (low is not None):.6g}"),
        float(f"{last - inside * (high is not None):.6g}"),
    )


def number(text: str) -> int | float | str:
    """A typed text as scene files have it: a whole number, a number, or the text itself.

    >>> number("2"), number(" 0.5"), number("K/2")
    (2, 0.5, 'K/2')
    """
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return text.strip()


def plain_value(text: str) -> float | None:
    """The value of a typed number or ratio, None for anything else.

    >>> plain_value("1/4"), plain_value("-2e-3"), plain_value("K/2"), plain_value("1/0")
    (0.25, -0.002, None, None)
    """
    top, _, below = text.partition("/")
    with suppress(ValueError, ZeroDivisionError):
        found = float(top) / float(below or 1)
        return found if math.isfinite(found) else None
    return None


def first_choices(wave: str, setting: str | None = None) -> Chosen:
    """What is chosen at first for a wave on the lattice of a setting (its first one)."""
    found = _setting(wave, setting)
    scene = found.scene
    return Chosen(
        wave=wave,
        setting=found.name,
        eps=_typed(scene.eps),
        tolerance=_typed(scene.tolerance),
        begin=_typed(scene.slow_times[0]),
        end=_typed(scene.slow_times[-1]),
        half_width=_typed(scene.half_width),
        parameters=_all_parameters(scene),
        constants={name: _typed(value) for name, value in scene.constants},
    )


def _all_parameters(scene: Scene) -> dict[str, str]:
    """Every parameter of the scene's wave, with its default where the scene says nothing."""
    from longwave.solutions import closed_form

    given = dict(scene.parameters)
    return {
        parameter.name: _typed(given.get(parameter.name, parameter.default))
        for parameter in closed_form(str(scene.wave)).parameters
    }


def _typed(value: Any) -> str:
    """A value as one would type it; a default of the catalogue is a number of SymPy.

    >>> _typed(1.0), _typed(0.30000000000000004), _typed("eps/2")
    ('1', '0.3', 'eps/2')
    """
    return value if isinstance(value, str) else f"{float(value):.12g}"


def _setting(wave: str, name: str | None) -> WaveSetting:
    found = settings(wave)
    for setting in found:
        if name in (None, setting.name):
            return setting
    known = one_of(name, [setting.name for setting in found])
    raise ValueError(f"setting must be one of {wave}, got {shown(name)} ({known})")


def scene_of_choices(choices: Chosen) -> Scene:
    """The scene that is chosen. ValueError, in one line, for what no scene can say."""
    base = _setting(choices.wave, choices.setting).scene
    eps = finite("eps", number(choices.eps))
    positive("eps", eps)
    begin, end = (finite(name, number(getattr(choices, name))) for name in ("begin", "end"))
    if end <= begin:
        raise ValueError(f"end must satisfy end > begin = {begin:g}, got {end:g} (end later)")
    half_width = finite("half_width", number(choices.half_width))
    positive("half_width", half_width)
    times = [float(f"{begin + (end - begin) * i / (FRAMES - 1):.12g}") for i in range(FRAMES)]
    typed = {name: number(text) for name, text in choices.constants.items()}
    return base.changed(
        eps=eps,
        tolerance=number(choices.tolerance),
        parameters={name: number(text) for name, text in choices.parameters.items() if text},
        constants={**dict(base.constants), **typed},
        slow_times=times,
        half_width=half_width,
    )
