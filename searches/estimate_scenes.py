"""Random scenes with a tolerance, over all waves and their whole domains: (seed, index) names one.

Up to units of time and strain a scene on this lattice is told by its wave's parameters, its width
in sites and its length. So the width is drawn, as e = a eps max|Y| (for long waves e is small; at
e = 1 they are a site wide; waves on K4 < 0 cease to exist at e = sqrt(2)), and K4 follows from it.
Times follow from the wave's drift against c t: its crest begins inside of the compared sites, at
their edge or far away, and moves through them.

What would take too long is drawn anew. The rule looks at the scene alone (`predicted_seconds`).
"""

import math
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from scipy.special import ellipkm1

from longwave.scenes.description.entries import table
from longwave.scenes.description.numerics import EngineRules
from longwave.scenes.description.scene import Scene

__all__ = ["BUDGET", "WAVES", "RandomScene", "predicted_seconds", "random_scene"]

Draw = random.Random
Values = Mapping[str, float]

BUDGET = 6.0
"""Predicted seconds, of the run and its reference, beyond which a scene is drawn anew."""

EVALUATION = 4e-9
"""Seconds per site and time 1/c of a reference at a tolerance of 1: steps, stages, two runs."""

PASSES = 4.0
"""What a plan site by site takes, in units of one reference on the same sites."""

POINT = 3e-6
"""Seconds per point and its log2 on the last spectral ring, at a tolerance of 1 and without turns:
evaluations on all rings."""

FARTHEST = 1e7
"""Largest distance c t0 in sites."""


@dataclass(frozen=True)
class WaveShape:
    """A wave's parameters, its largest |U| and wave number in xi, and its drift d xi/d tau.

    ``tails``: "short" ones are gone some widths away, those of a "step" to different constants;
    "long" ones fall like a power; a "periodic" wave has no end.
    """

    values: Values
    largest: float
    drift: float
    tails: str
    number: float = 0.0


@dataclass(frozen=True)
class RandomScene:
    """The scene of (seed, index); ``redrawn`` counts what the budget forbade before it."""

    seed: int
    index: int
    scene: Scene
    redrawn: int


def random_scene(seed: int, index: int, budget: float = BUDGET) -> RandomScene:
    """Return the scene that belongs to (seed, index).

    >>> random_scene(1, 2).scene == random_scene(1, 2).scene
    True
    """
    draw = random.Random(f"{seed}:{index}")
    wave = draw.choice(list(WAVES))
    redrawn = 0
    while True:
        scene, seconds = _scene(draw, wave, f"scene {seed}:{index}")
        if seconds <= budget:
            return RandomScene(seed, index, scene, redrawn)
        redrawn += 1


def _scene(draw: Draw, wave: str, name: str) -> tuple[Scene, float]:
    shape = WAVES[wave](draw)
    e = _slenderness(draw)
    eps = _short(_power(draw, 0.01, 0.2))
    K2 = 1.0 if draw.random() < 0.4 else _short(_power(draw, 1e-3, 1e3))
    a = e / (eps * max(shape.largest, shape.number))
    K4 = _short(a**2 * K2 / 6.0)
    compared = round(_power(draw, 30, 1000))
    tolerance = _short(_power(draw, 1e-8, 1e-2))
    engine = draw.choice(["", *table(EngineRules)])
    c, way = math.sqrt(K2), _power(draw, 1e2, 1e5)
    drift = shape.drift * (a * eps) ** 2 / 24.0
    t0, span = _start(draw, drift, compared, way) / c, way / c
    snapshots = _snapshots(draw, t0, span)
    scene = Scene.of(
        name=name,
        wave=wave,
        eps=eps,
        t0=t0,
        snapshots=snapshots,
        K2=K2,
        K4=math.copysign(K4, -1.0 if wave in DEFOCUSING else 1.0),
        compared=compared,
        tolerance=tolerance,
        engine=engine,
        parameters=tuple(shape.values.items()),
        observables=("strain",),
    )
    return scene, predicted_seconds(scene, shape, e)


def predicted_seconds(scene: Scene, shape: WaveShape, e: float) -> float:
    """Estimate the seconds of run and reference, from the scene alone.

    Site by site: sites times time, more for less tolerance. A window needs the compared sites and
    some hundred more; on a periodic background, and for the reference of a wave with long tails,
    all sites count that sound reaches. On a spectral ring: its points, and the steps in which the
    wave's phase turns.
    """
    way = scene.model.sound_speed() * (scene.end - scene.t0)
    tolerance = scene.target.tolerance / max(1.0, shape.largest)
    cone = 2.0 * scene.compared + 500.0 + 2.0 * way
    window = 2.0 * scene.compared + 1000.0 + 60.0 / e + 0.2 * min(e, 2.0) ** 2 * way
    work = EVALUATION * tolerance ** (-1.0 / 6.0) * way
    planned = {
        "stencil": PASSES * work * (cone if shape.tails in ("periodic", "step") else window),
        "spectral": _ring_seconds(scene.compared, way, tolerance, shape, e),
    }
    seconds = planned.get(scene.target.engine, min(planned.values()))
    short = shape.tails in ("short", "step")
    return seconds + work * (window if short else 0.6 * cone)


def _ring_seconds(compared: int, way: float, tolerance: float, shape: WaveShape, e: float) -> float:
    """Estimate the seconds of the spectral rings; the last one is causal, or long for its tails."""
    number = e * max(1.0, shape.number / shape.largest)
    turns = way * e**2 * number / 24.0
    power = 1.0 / 2.0 if shape.tails == "periodic" else 1.0 / 3.0
    tail = 40.0 if shape.tails == "short" else 4.0 * (1.0 + turns) ** power * tolerance**-power
    length = min(2.2 * way + 2.0 * compared, max(8.0 * compared, max(tail, 150.0) / e))
    points = 4.0 * number * length + 64.0
    return POINT * points * math.log2(points) * (1.0 + turns) * tolerance ** (-1.0 / 8.0)


def _slenderness(draw: Draw) -> float:
    """Draw e: mostly from long waves to those of a site's width; some far longer, some shorter."""
    kind = draw.random()
    if kind < 0.1:
        return _power(draw, 0.004, 0.02)
    return _power(draw, 0.02, 1.2) if kind < 0.95 else _power(draw, 1.2, 2.5)


def _start(draw: Draw, drift: float, compared: int, way: float) -> float:
    """Draw c t0: the wave's centre runs through 0, or is at a chosen site at a chosen time."""
    kind, slow = draw.random(), max(abs(drift), 1e-12) * (1.0 if drift > 0 else -1.0)
    if kind < 0.4:
        return -draw.random() * way
    if kind < 0.85:
        site = draw.uniform(-1.2, 1.2) * compared
        passed = draw.choice([0.0, 1.0, draw.random()])
    else:
        site = draw.choice([-1.0, 1.0]) * _power(draw, 1.0, 10.0) * compared
        passed = draw.choice([0.0, 0.0, draw.random()])
    return min(max(site / slow, -FARTHEST), FARTHEST) - passed * way


def _snapshots(draw: Draw, t0: float, span: float) -> tuple[float, ...]:
    """Draw one to four times; sometimes t0 alone or among them, sometimes two that almost agree."""
    kind, end = draw.random(), t0 + span
    if kind < 0.02:
        return (t0,)
    if kind < 0.4:
        return (end,)
    if kind < 0.6:
        return (t0, end)
    if kind < 0.7:
        return (end - 1e-6 * span, end)
    times = {t0 + draw.random() * span for _ in range(draw.randint(1, 3))}
    return tuple(sorted(times | {end}))


def _power(draw: Draw, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform."""
    return math.exp(draw.uniform(math.log(low), math.log(high)))


def _short(value: float) -> float:
    return float(f"{value:.4g}")


def _amplitude(draw: Draw) -> float:
    return _short(_power(draw, 0.1, 20.0))


def _modulus(draw: Draw) -> float:
    kind = draw.random()
    if kind < 0.25:
        return _short(_power(draw, 1e-3, 0.3))
    if kind < 0.7:
        return _short(draw.uniform(0.1, 0.95))
    return float(f"{1.0 - _power(draw, 1e-8, 0.05):.10g}")


def _place(draw: Draw, number: float) -> float:
    """Draw X_0: mostly 0, sometimes some widths away."""
    return 0.0 if draw.random() < 0.5 else _short(draw.uniform(-8.0, 8.0) / number)


def _rational(order: int) -> Callable[[Draw], WaveShape]:
    def shape(draw: Draw) -> WaveShape:
        values = {}
        if order >= 3 and draw.random() < 0.4:
            values["tau_5"] = _short(draw.choice([-1.0, 1.0]) * _power(draw, 0.1, 1e3))
        return WaveShape(values, 2.0 * order + 1.0, 6.0, "long")

    return shape


def _soliton_sech(draw: Draw) -> WaveShape:
    A = _amplitude(draw)
    return WaveShape({"A": A}, A, A**2, "short")


def _kink(draw: Draw) -> WaveShape:
    A = _amplitude(draw)
    return WaveShape({"A": A}, A, -2.0 * A**2, "step")


def _kink_antikink(draw: Draw) -> WaveShape:
    A = _amplitude(draw)
    share = draw.choice([draw.uniform(0.05, 0.95), 1.0 - _power(draw, 1e-8, 0.05)])
    kappa = float(f"{2.0 * A * share:.10g}")
    return WaveShape({"A": A, "kappa": kappa}, A, kappa**2 - 6.0 * A**2, "short")


def _soliton_background(draw: Draw) -> WaveShape:
    kappa = _amplitude(draw)
    level = draw.choice([-1.0, 1.0]) * _short(kappa * _power(draw, 0.02, 20.0))
    height = math.sqrt(4.0 * level**2 + kappa**2)
    largest = max(abs(level), height - level)
    return WaveShape({"U_0": level, "kappa": kappa}, largest, 6.0 * level**2 + kappa**2, "short")


def _two_soliton(draw: Draw) -> WaveShape:
    A = _amplitude(draw)
    share = draw.choice([draw.uniform(0.1, 0.9), 1.0 - _power(draw, 1e-6, 0.1)])
    second = float(f"{A * share:.10g}")
    values = {"A_1": A, "A_2": second, "X_0": _place(draw, A)}
    return WaveShape(values, A + second, draw.choice([A, second]) ** 2, "short")


def _breather(draw: Draw) -> WaveShape:
    q = _amplitude(draw)
    p = _short(q * _power(draw, 0.1, 10.0))
    values = {"p": p, "q": q, "X_0": _place(draw, q)}
    return WaveShape(values, 2.0 * q, q**2 - 3.0 * p**2, "short", p)


def _double_pole(draw: Draw) -> WaveShape:
    A = _amplitude(draw)
    return WaveShape({"A": A, "X_0": _place(draw, A)}, 2.0 * A, A**2, "short")


def _elliptic(
    largest: Callable[[float], float], drift: Callable[[float], float], number: float = 1.0
) -> Callable[[Draw], WaveShape]:
    def shape(draw: Draw) -> WaveShape:
        k = _modulus(draw)
        return WaveShape({"k": k}, largest(k), drift(k), "periodic", number)

    return shape


def _breather_sn(draw: Draw) -> WaveShape:
    k = _modulus(draw)
    share = draw.choice([draw.uniform(0.05, 0.95), _power(draw, 1e-4, 0.05)])
    quarter = float(ellipkm1((1.0 - k) * (1.0 + k)))
    alpha = _short(0.999 * quarter * share)
    values = {"k": k, "alpha": alpha, "X_0": _place(draw, 1.0)}
    return WaveShape(values, 1.0, draw.choice([-1.0 - k**2, -4.0]), "periodic", 1.0)


WAVES: Mapping[str, Callable[[Draw], WaveShape]] = {
    **{f"rational_{order}": _rational(order) for order in range(1, 6)},
    "breather_sn": _breather_sn,
    "soliton_dn": _elliptic(lambda k: 2.0 + math.sqrt(1.0 - k**2), lambda k: 2.0 - k**2, 2.0),
    "rogue_cn": _elliptic(lambda k: 3.0 * k, lambda k: 2.0 * k**2 - 1.0),
    "wave_sn": _elliptic(lambda k: k, lambda k: -1.0 - k**2),
    "wave_cn": _elliptic(lambda k: k, lambda k: 2.0 * k**2 - 1.0),
    "wave_dn": _elliptic(lambda k: 1.0, lambda k: 2.0 - k**2, 2.0),
    "soliton_sech": _soliton_sech,
    "kink": _kink,
    "breather": _breather,
    "double_pole": _double_pole,
    "two_soliton": _two_soliton,
    "soliton_background": _soliton_background,
    "kink_antikink": _kink_antikink,
}
"""All waves of the catalogue, and the rational ones up to order 5."""

DEFOCUSING = ("breather_sn", "wave_sn", "kink", "kink_antikink")
"""Those that solve the equation with K4 < 0."""
