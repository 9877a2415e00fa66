"""Choices of the explorer's page, turned into scenes, independent of any user interface.

Each wave of the catalogue can be put on the lattices of its `settings`; a setting has a scene as
starting point. What a user types is text, which is validated by the scene, the wave and the
lattice.
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
"""Name of the setting for mKdV waves that have no shipped scene: the paper's FPUT chain."""

FRAMES = 41
"""Number of equidistant times at which lattice and wave are compared."""

CHAIN_CHOICES: Mapping[str, Mapping[str, float]] = {
    **{f"rational_{order}": {"K2": 4, "eps": 0.05, "half_width": 20} for order in (1, 2, 3)},
    "rogue_cn": {"begin": -0.25, "end": 0.25},
    "soliton_dn": {"begin": -0.25, "end": 0.25, "eps": 0.05},
    **{
        name: {"begin": -4, "end": 4}
        for name in ("soliton_sech", "kink", "two_soliton", "soliton_background", "kink_antikink")
    },
}
"""Initial choices on the chain that differ from those in `_chain_scene`: the paper's constants,
shorter times on unstable backgrounds, longer times for waves that only travel."""

OTHER_CONSTANTS: Mapping[str, tuple[str, Mapping[str, float]]] = {
    "gardner_table_soliton": ("gardner_soliton", {"K4": -1}),
    "gardner_kink": ("gardner_soliton", {"K4": -1}),
    "modified_kawahara_soliton": ("kawahara_soliton", {"K3": 0, "K4": 1}),
    "nls_dark": ("fput_peregrine", {"K4": -1}),
}
"""Waves whose equation no shipped scene has -> a shipped scene, and the lattice constants to change
so that its reduced equation is that of the wave."""


@dataclass(frozen=True)
class WaveSetting:
    """A lattice for a wave, and the scene with the initial choices."""

    name: str
    title: str
    scene: Scene


@dataclass(frozen=True)
class Choices:
    """The user's choices, as typed; ``begin`` and ``end`` are slow times T, ``half_width`` is in X.

    >>> choices = initial_choices("soliton_sech")
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

    def changed(self, **changes: Any) -> Choices:
        """Return a copy of the choices with these fields changed."""
        return replace(self, **changes)


def waves_by_equation() -> dict[str, dict[str, str]]:
    """Return the waves that the explorer can put on a lattice, as equation -> title -> name.

    The wave of the mKdV-Burgers equation is missing, because no scene with its losses is shipped.

    >>> waves_by_equation()["KP"]
    {'KP line soliton': 'kp_line_soliton', 'KP-I lump': 'kp_lump'}
    """
    from longwave.solutions import CATALOGUE, closed_form

    waves_with_scene = (*(wave for wave, _ in examples().values()), *OTHER_CONSTANTS)
    equations = {"mKdV", *(closed_form(wave).equation.normal for wave in waves_with_scene)}
    titles: dict[str, dict[str, str]] = {}
    for form in CATALOGUE:
        if form.equation.normal not in equations:
            continue
        title = f"{form.title[0].upper()}{form.title[1:]}"
        titles.setdefault(form.equation.normal, {})[title] = form.name
    return titles


def examples() -> dict[str, tuple[str, str]]:
    """Return the shipped scenes on any lattice, as title -> (wave, setting)."""
    scenes = map(load_scene, shipped_scenes("lattices"))
    return {scene.title or scene.name: (scene.wave_name, scene.name) for scene in scenes}


def settings(wave: str) -> tuple[WaveSetting, ...]:
    """Return the lattices on which a wave can be put; raise ValueError for an unknown wave.

    >>> [setting.title for setting in settings("kp_lump")]
    ['square next nearest']
    """
    from longwave.solutions import closed_form

    form = closed_form(wave)
    found: list[WaveSetting] = []
    if form.equation.normal == "mKdV":
        found.append(WaveSetting(CHAIN, "FPUT chain", _chain_scene(form)))
    scene_name, constants = OTHER_CONSTANTS.get(wave, ("", {}))
    for name in shipped_scenes("lattices"):
        scene = load_scene(name)
        if name == scene_name:
            scene = scene.changed(constants={**dict(scene.constants), **constants})
        elif not _same_equation(form, closed_form(scene.wave_name)) or (
            scene.losses and scene.wave != wave
        ):
            continue
        if scene.wave != wave:
            parameters = _usual_parameters(form)
            scene = scene.changed(wave=wave, parameters=parameters, order="slaved", title="")
        found.append(WaveSetting(name, _lattice_title(scene), scene))
    return tuple(found)


def _same_equation(form: ClosedForm, other: ClosedForm) -> bool:
    """Whether both forms solve the same normal form with equal r and, unless free, equal s."""
    first, second = form.equation, other.equation
    same_sign = not isinstance(first.s, int) or first.s == second.s
    return first.normal == second.normal and same_sign and first.r == second.r


def _lattice_title(scene: Scene) -> str:
    from longwave.derive import LATTICES

    known = LATTICES.get(scene.lattice)
    title = scene.lattice.replace("_", " ") if known is None else known.title
    if scene.is_envelope:
        title += f", carrier k = {scene.carrier}, {scene.branch} branch"
    return title


def _usual_parameters(form: ClosedForm) -> dict[str, float | None]:
    """Return a value in the domain of each parameter without a default: the middle if bounded."""
    values: dict[str, float | None] = {}
    for parameter in form.parameters:
        if parameter.default is None:
            low, high = bounds(parameter, values)
            if low is not None and high is not None:
                values[parameter.name] = float(f"{0.5 * (low + high):.3g}")
            else:
                values[parameter.name] = 1.0 if low is None else low + 1.0
    return values


def _chain_scene(form: ClosedForm) -> Scene:
    """Return a scene with the mKdV wave ``form`` on the paper's chain, for slow times about 0."""
    values = {"K2": 1, "eps": 0.1, "begin": -0.5, "end": 0.5, "half_width": 20}
    values |= CHAIN_CHOICES.get(form.name, {})
    times = [values.pop("begin"), values.pop("end")]
    wave = {"name": form.name, "wave": form.name, "parameters": _usual_parameters(form)}
    numerics = {"tolerance": 1e-3, "observables": ["strain"]}
    return Scene.of(slow_times=times, K4=form.equation.s, **wave, **values, **numerics)


def bounds(
    parameter: Parameter, values: Mapping[str, float | None]
) -> tuple[float | None, float | None]:
    """Return the ends of a parameter's declared domain, given the other values; None if unbounded.

    >>> from longwave.solutions import closed_form
    >>> k, alpha, _ = closed_form("breather_sn").parameters
    >>> bounds(k, {}), [round(end, 3) for end in bounds(alpha, {"k": 0.5})]
    ((0.0, 1.0), [0.0, 1.686])
    """
    lower, upper = parameter.lower, parameter.upper
    low = _end_value(lower.value, values) if lower else None
    return low, _end_value(upper.value, values) if upper else None


def _end_value(value: Any, values: Mapping[str, float | None]) -> float | None:
    """Evaluate a bound at the parameters' values; None if one is unknown or the bound infinite."""
    known = {symbol: values.get(symbol.name) for symbol in value.free_symbols}
    if None in known.values():
        return None
    number = value.subs(known).evalf(15)
    return float(number) if number.is_real and number.is_finite else None


SLIDER_SPAN = 3.0
"""Length of a parameter's slider if its domain is unbounded; values beyond it can be typed."""

SLIDER_MARGIN = 0.01
"""Distance of a slider's end from an open end of the domain, as a fraction of its length."""


def slider_ends(parameter: Parameter, values: Mapping[str, float | None]) -> tuple[float, float]:
    """Return the ends of a parameter's slider, inside the declared domain.

    >>> from longwave.solutions import closed_form
    >>> slider_ends(closed_form("kink").parameters[0], {})
    (0.03, 3.0)
    """
    low, high = bounds(parameter, values)
    first = (high or 0.0) - SLIDER_SPAN if low is None else low
    last = first + SLIDER_SPAN * (2.0 if low is None else 1.0) if high is None else high
    margin = SLIDER_MARGIN * (last - first)
    ends = first + margin * (low is not None), last - margin * (high is not None)
    return float(f"{ends[0]:.6g}"), float(f"{ends[1]:.6g}")


def parsed_number(text: str) -> int | float | str:
    """Parse a typed text as scene files do: an integer, a float, or else the text itself.

    >>> parsed_number("2"), parsed_number(" 0.5"), parsed_number("K/2")
    (2, 0.5, 'K/2')
    """
    for type_ in (int, float):
        with suppress(ValueError):
            return type_(text)
    return text.strip()


def plain_value(text: str) -> float | None:
    """Return the value of a typed number or ratio, None for anything else.

    >>> plain_value("1/4"), plain_value("-2e-3"), plain_value("K/2"), plain_value("1/0")
    (0.25, -0.002, None, None)
    """
    numerator, _, denominator = text.partition("/")
    with suppress(ValueError, ZeroDivisionError):
        value = float(numerator) / float(denominator or 1)
        return value if math.isfinite(value) else None
    return None


def initial_choices(wave: str, setting: str | None = None) -> Choices:
    """Return the initial choices for a wave on the lattice of a setting (default: the first)."""
    chosen = _setting(wave, setting)
    scene = chosen.scene
    numbers = {name: getattr(scene, name) for name in ("eps", "tolerance", "half_width")}
    numbers |= {"begin": scene.slow_times[0], "end": scene.slow_times[-1]}
    return Choices(
        wave,
        chosen.name,
        parameters=_all_parameters(scene),
        constants={name: _as_typed(value) for name, value in scene.constants},
        **{name: _as_typed(value) for name, value in numbers.items()},
    )


def _all_parameters(scene: Scene) -> dict[str, str]:
    """Return every parameter of the scene's wave, with defaults for those not stated."""
    from longwave.solutions import closed_form

    given = dict(scene.parameters)
    return {
        parameter.name: _as_typed(given.get(parameter.name, parameter.default))
        for parameter in closed_form(str(scene.wave)).parameters
    }


def _as_typed(value: Any) -> str:
    """Format a value, which may be a SymPy number, as a user would type it.

    >>> _as_typed(1.0), _as_typed(0.30000000000000004), _as_typed("eps/2")
    ('1', '0.3', 'eps/2')
    """
    return value if isinstance(value, str) else f"{float(value):.12g}"


def _setting(wave: str, name: str | None) -> WaveSetting:
    candidates = settings(wave)
    for setting in candidates:
        if name in (None, setting.name):
            return setting
    known = one_of(name, [setting.name for setting in candidates])
    raise ValueError(f"setting must be a lattice of {wave}, got {shown(name)} ({known})")


def scene_of_choices(choices: Choices) -> Scene:
    """Build the scene of the choices; raise ValueError in one line if it is not admissible."""
    base = _setting(choices.wave, choices.setting).scene
    eps = finite("eps", parsed_number(choices.eps))
    positive("eps", eps)
    begin, end = (finite(name, parsed_number(getattr(choices, name))) for name in ("begin", "end"))
    if end <= begin:
        raise ValueError(f"end must satisfy end > begin = {begin:g}, got {end:g} (increase end)")
    half_width = finite("half_width", parsed_number(choices.half_width))
    positive("half_width", half_width)
    times = [float(f"{begin + (end - begin) * i / (FRAMES - 1):.12g}") for i in range(FRAMES)]
    constants = {name: parsed_number(text) for name, text in choices.constants.items()}
    return base.changed(
        eps=eps,
        tolerance=parsed_number(choices.tolerance),
        parameters={name: parsed_number(text) for name, text in choices.parameters.items() if text},
        constants={**dict(base.constants), **constants},
        slow_times=times,
        half_width=half_width,
    )
