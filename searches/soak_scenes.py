"""Random scenes on the lattices of the catalogue, over waves, constants, orders and disorder.

A scene is drawn without a look at what it takes. The wave is one of those that solve the equation
which its lattice turns out to have; where none does, the scene is one to be refused.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction

from longwave.derive import LATTICES
from longwave.lattice.random_sites import DISTRIBUTIONS
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import ORDERS
from longwave.scenes.starts.lattice_derivation import derivation
from longwave.solutions import CATALOGUE, closed_form

Draw = random.Random

LARGEST_SITE = 9_999

POSITIVE = ("0.25", "1/2", "1", "1", "1.5", "2", "3", "4")
REAL = ("-2", "-1", "-1/2", "0", "0", "1/3", "1", "1", "2", "eps/2", "-eps")

CARRIERS = ("pi/6", "pi/4", "pi/3", "pi/2", "2*pi/3", "3*pi/4", "pi", "1", "0.3")


def _between(low: float, high: float) -> Callable[[Draw], float]:
    return lambda draw: float(f"{math.exp(draw.uniform(math.log(low), math.log(high))):.4g}")


def _about_zero(size: float) -> Callable[[Draw], float]:
    return lambda draw: round(draw.uniform(-size, size), 4)


PARAMETERS: Mapping[str, Callable[[Draw], float]] = {
    **dict.fromkeys(("kappa", "kappa_1", "A", "A_1", "p"), _between(0.3, 2.0)),
    **dict.fromkeys(("kappa_2", "A_2"), _between(0.05, 0.3)),
    **dict.fromkeys(("q", "v", "U_0"), _about_zero(1.0)),
    "X_0": _about_zero(3.0),
    "k": lambda draw: round(draw.uniform(0.05, 0.98), 3),
    "alpha": _between(0.1, 1.5),
    "a": lambda draw: round(draw.uniform(0.05, 0.45), 3),
}
"""By name; where a wave asks for something else, `OWN` says it."""

OWN: Mapping[tuple[str, str], Callable[[Draw], float]] = {
    ("nls_kuznetsov_ma", "a"): lambda draw: round(draw.uniform(0.55, 1.2), 3),
    ("gardner_table_soliton", "kappa"): lambda draw: round(draw.uniform(0.1, 0.99), 3),
    ("kink_antikink", "kappa"): _between(0.1, 0.5),
    ("breather", "q"): _between(0.3, 2.0),
}


def soak_scene(
    seed: int, index: int, redrawn: int = 0, lattice: str = "", enveloped: bool | None = None
) -> Scene:
    """Return the scene of (seed, index), or its substitute after so many others.

    It is on that ``lattice``, and ``enveloped`` or a long wave, where that is given.

    >>> soak_scene(1, 3) == soak_scene(1, 3)
    True
    """
    draw = random.Random(f"{seed}:{index}:{redrawn}")
    scene = _scene(draw, f"scene {seed}:{index}", lattice, enveloped)
    try:
        derivation(scene)
    except ValueError as refusal:
        fitting = re.search(r"\(one of ([\w, ]+)[;)]", str(refusal))
        if fitting:
            wave = draw.choice(fitting[1].split(", "))
            scene = scene.changed(wave=wave, parameters=_parameters(draw, wave))
    return _varied(random.Random(f"{seed}:{index}:{redrawn}:varied"), scene)


def _varied(draw: Draw, scene: Scene) -> Scene:
    """Return the scene; one in four times with deviations, or its plane wave's growth rate."""
    chance = draw.random()
    if chance < 0.15:
        begin = draw.choice([-LARGEST_SITE, draw.randint(-50, 200)])
        disorder = {
            "of": draw.choice(["mass", *(name for name, _ in scene.constants)]),
            "spread": draw.choice([0.0, round(draw.uniform(0.0, 0.5), 3)]),
            "seed": draw.randrange(10**6),
            "distribution": draw.choice(DISTRIBUTIONS),
            "sites": (begin, LARGEST_SITE),
        }
        return scene.changed(disorder=tuple(disorder.items()))
    if chance < 0.25 and scene.carrier:
        perturbation = {
            "amplitude": _between(0.1, 1.0)(draw),
            draw.choice(["kappa", "share"]): _between(0.2, 2.0)(draw),
        }
        found = {"slow_times": (), "half_width": None, "order": draw.choice(ORDERS[:2])}
        return scene.changed(
            wave="perturbed_plane", parameters=tuple(perturbation.items()), **found
        )
    return scene


def _scene(draw: Draw, name: str, on: str, carried: bool | None) -> Scene:
    drawn, chance = draw.choice(list(LATTICES)), draw.random()
    lattice = LATTICES[on or drawn]
    enveloped = chance < 0.4 if carried is None else carried
    waves = CATALOGUE.of("NLS" if enveloped else draw.choice(["KdV", "mKdV", "Gardner"])).names
    wave = draw.choice(list(waves))
    eps = _between(0.02, 0.2)(draw)
    span = _between(0.05, 1.0)(draw)
    begin = draw.choice([0.0, -span, -span / 2.0, draw.uniform(-span, 0.0)])
    times = sorted({round(begin + span * share, 6) for share in (0.0, draw.random(), 1.0)})
    carrier = {"carrier": draw.choice(CARRIERS)} if enveloped else {}
    if enveloped and len(lattice.fields) > 1:
        carrier["branch"] = draw.choice(["acoustic", "optical"])
    return Scene.of(
        name=name,
        lattice=lattice.name,
        wave=wave,
        parameters=_parameters(draw, wave),
        constants=tuple(_constants(draw, lattice.constants, enveloped)),
        eps=eps,
        order=draw.choice(ORDERS[:2] if enveloped else ORDERS),
        slow_times=times,
        half_width=_between(2.0, 10.0)(draw),
        tolerance=_between(1e-6, 1e-2)(draw),
        **carrier,
    )


def _constants(draw: Draw, symbols: object, enveloped: bool) -> Iterator[tuple[str, str]]:
    """Yield values of a lattice's constants; some are small if the long wave may be chosen."""
    for symbol in symbols:  # type: ignore[attr-defined]
        value = draw.choice(POSITIVE if symbol.is_positive else REAL)
        if enveloped and "eps" in value:
            value = str(Fraction(draw.randint(-4, 4), 4))
        yield str(symbol), value


def _parameters(draw: Draw, wave: str) -> tuple[tuple[str, float], ...]:
    names = [str(one.symbol) for one in closed_form(wave).parameters]
    return tuple((name, OWN.get((wave, name), PARAMETERS[name])(draw)) for name in names)
