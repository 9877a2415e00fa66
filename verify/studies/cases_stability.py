"""Hard cases: steps, strains and feeds at the edge of what a run admits."""

import math
from dataclasses import replace

import numpy as np

from lattice.model import Model
from lattice.schemes.catalogue import KAHAN_LI_8, SCHEMES
from lattice.schemes.scheme import Composition, Scheme, check_step, stability_limit
from lattice.stepper import Stepper
from verify.comparison import Scene, load_scene, run
from verify.comparison.domain import SiteRing, Window
from verify.comparison.initial_data import build_wave
from verify.studies.doubledouble_ring import advance_doubled, doubled
from verify.studies.hard_case import Measurement
from verify.studies.travelling import travelling_wave

LINEAR = Model(4.0, 0.0, 0.0)
NOISE = 1e-12


def step_limit() -> Measurement:
    """Refusal just past the limit, none just below, and the limit against the kernels' own."""
    worst, told = 0.0, []
    for scheme in SCHEMES:
        limit = stability_limit(scheme) / LINEAR.highest_frequency(np.zeros(1))
        check_step(limit * (1.0 - 1e-6), scheme, LINEAR, np.zeros(1))
        told.append(_refusal(scheme, limit * (1.0 + 1e-6)))
        worst = max(worst, abs(_observed_limit(scheme, limit) / limit - 1.0))
    refused = f"{sum(map(bool, told))} of {len(SCHEMES)} schemes refused"
    return Measurement(worst if all(told) else math.inf, refused, told[0])


def _refusal(scheme: Scheme, step: float) -> str:
    try:
        check_step(step, scheme, LINEAR, np.zeros(1))
    except ValueError as error:
        return str(error)
    return ""


def _observed_limit(scheme: Scheme, limit: float) -> float:
    """The step at which zone-boundary noise starts to grow in the kernels, by bisection.

    Past its limit a scheme may be unstable in a narrow resonance only, so the search ends close
    above the limit; infinity if the noise does not grow there.
    """
    low, high = 0.98 * limit, 1.0002 * limit
    if not _noise_grows(scheme, high):
        return math.inf
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _noise_grows(scheme, middle) else (middle, high)
    return low


def _noise_grows(scheme: Scheme, step: float) -> bool:
    y, s = np.tile([NOISE, -NOISE], 4), np.zeros(8)
    scheme.advance(y, s, step, 40_000, LINEAR)
    return not np.max(np.abs(y)) < 1e3 * NOISE


def soft_scene() -> Scene:
    """A steep sn wave, 7 sites long, whose strains come near 1/sqrt(3), where V'' = 0."""
    scene = Scene(
        name="soft",
        wave="wave_sn",
        parameters=(("k", 0.9),),
        eps=0.1,
        t0=-20.0,
        snapshots=(-20.0, -10.0, 200.0),
        K2=1.0,
        K4=-1.0,
        step=0.5,
        domain="ring",
        sites=1680,
        compared=50,
        observables=("strain",),
    )
    return replace(scene, eps=float(build_wave(scene).wavelength or math.nan) / 7.0)


def soft_lattice() -> Measurement:
    """The reported time of the blow-up against a double-double run of the same scene, in steps."""
    scene = soft_scene()
    measured = run(scene)
    text = str(measured.attrs["blow_up"]).partition(" (")[0]
    kept = measured.time.values.tolist() == [-20.0, -10.0] and np.isfinite(measured.strain).all()
    t, site = _first_soft_site(scene)
    expected = f"blow-up: K2 + 2 K3 y + 3 K4 y^2 <= 0 at t = {t:g}, site {site}"
    reported = float(text.split("t = ")[1].split(",")[0]) if "t = " in text else math.nan
    sound = kept and f"site {site}," in f"{text}," and text[:30] == expected[:30]
    return Measurement(abs(reported - t) / scene.step if sound else math.inf, expected, text)


def _first_soft_site(scene: Scene) -> tuple[float, int]:
    """When and where V'' <= 0 is first met, in double-double arithmetic and step by step."""
    state = SiteRing(scene, build_wave(scene)).start()
    y, s = doubled(state.y), doubled(state.s)
    for step in range(1, round((scene.end - scene.t0) / scene.step) + 1):
        advance_doubled(KAHAN_LI_8, y, s, scene.step, 1, scene.constants)
        state.y[:] = y[:, 0]
        soft = scene.constants.stiffness(state.y) <= 0.0
        if soft.any():
            sites = state.sites
            return scene.t0 + step * scene.step, int(sites[soft[sites % state.size]][0])
    return math.nan, 0


def zone_boundary_noise() -> Measurement:
    """Largest growth of noise at k = pi on a dn wave, over t = 10^4, at 0.99 of the step limit."""
    wave = travelling_wave("wave_dn", 0.5, 27, 1, 1)
    n = np.arange(float(8 * wave.period))
    alternating = np.where(n % 2 == 0, 1.0, -1.0)
    grown = []
    for scheme in SCHEMES:
        if not isinstance(scheme, Composition):
            continue
        y, s = wave.strain(n) + NOISE * alternating, wave.velocity(n)
        h = 0.99 * stability_limit(scheme) / wave.constants.highest_frequency(y)
        for _ in range(20):
            scheme.advance(y, s, h, math.ceil(500.0 / h), wave.constants)
            grown.append(abs(float(np.mean(alternating * y))) / NOISE)
    return Measurement(max(grown), f"growth {max(grown):.2g} of {NOISE:g}")


def wrong_feed() -> Measurement:
    """Moves of the window until a feed wrong by 0.1 % stops the run."""
    scene = replace(load_scene("rational_2_eps_0.05"), t0=-400.0, snapshots=(0.0,))
    scene = replace(scene, sites=2048, compared=500)
    wave, sound = build_wave(scene), Window(scene, build_wave(scene))
    window = Window(scene, wave)
    state = window.start()
    amplitude = float(np.max(np.abs(state.y)))
    window.scene = replace(scene, eps=1.001 * scene.eps)
    march = Stepper(state, scene.scheme_table, scene.constants, window, scene.step, amplitude)
    moves = sum(1 for _ in march.through([0.0])) + 1
    reference = sound.start()
    other = Stepper(reference, scene.scheme_table, scene.constants, sound, scene.step, amplitude)
    sound_moves = sum(1 for _ in other.through([0.0]))
    stopped = march.blow_up is not None and other.blow_up is None and sound_moves > 1
    detail = f"a sound feed misses by {sound.mismatch:.1g} eps"
    return Measurement(float(moves) if stopped else math.inf, detail, str(march.blow_up))
