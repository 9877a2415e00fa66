"""Catches: a tolerance that is not kept, an estimate below the error or absurdly above it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from longwave.lattice.spectral.evolution import SpectralRing
from longwave.scenes.description.named_scenes import (
    load_scene,
    rational_family_scenes,
    shipped_scenes,
)
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import spectral_search
from longwave.scenes.engines.lattice_run import choose_engine
from longwave.scenes.engines.scene_run import run
from longwave.scenes.engines.spectral_data import spectral_start
from longwave.scenes.starts.moving_wave import moving_wave

Array = NDArray[np.float64]

PESSIMISM = 500.0
"""Most by which an estimate may exceed the error, unless it is a small part of the tolerance.
That an error falls faster than its law is not believed, and in this window it does."""

SMALL = 0.1

ROUNDING = 1e-9


RING_UNITS = 8
"""Circumference of the spectral reference, in compared regions: its domain error is below 1e-8."""

RING_STEPS = {"rational_2": 10_000, "rational_3": 24_000}

RING_DENSITY = {0.05: 2.0, 0.075: 3.0}
"""Points per site of the spectral reference, by eps."""


def stencil_reference(scene: Scene) -> Array:
    """Strains of the paper's scene by another scheme, with a finer step and more sites."""
    fine = {"window": (0.15, 6144), "ring": (0.25, 2 * scene.discretisation.sites)}
    step, sites = fine[scene.discretisation.domain]
    changes = {"scheme": "kahan_li_8", "step": step, "sites": sites, "observables": ("strain",)}
    return np.asarray(run(scene.changed(**changes)).strain)  # type: ignore[arg-type]


def spectral_reference(scene: Scene) -> Array:
    """The same by the spectral ring, with stated step, sampling and circumference."""
    moving = moving_wave(scene)
    data = spectral_start(moving, 1e-8)
    where = data.ring(RING_UNITS * (2 * scene.compared + 1))
    state = data.state(where, 2 * round(RING_DENSITY[scene.eps] * where.circumference / 2))
    step = moving.duration / RING_STEPS[scene.wave_name]
    ring = SpectralRing(scene.model, state, step, absorbed=data.absorbed)
    return np.array([ring.at(t).at(moving.compared_sites(t))[0] for t in scene.snapshots])


def check(scene: Scene, exact: Array) -> None:
    measured = run(replace(scene, observables=("strain",)))
    error = float(np.max(np.abs(measured.strain.values - exact))) / scene.eps
    estimate = measured.attrs["error_estimate"]
    assert scene.tolerance is not None
    assert error <= scene.tolerance
    assert error <= estimate + ROUNDING
    assert estimate <= scene.tolerance
    assert estimate <= max(PESSIMISM * error, SMALL * scene.tolerance)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_a_short_window_keeps_its_tolerance(
    window_scene: Callable[..., Scene], tolerance: float
) -> None:
    scene = window_scene(observables=("strain",))
    exact = run(scene.changed(step=0.08, sites=4096)).strain.values
    check(scene.with_tolerance(tolerance), exact)


@pytest.mark.slow
def test_stops_that_shorten_the_steps_do_not_widen_a_ring() -> None:
    """Catches: the time step's error taken for the seam's where a dense curve changes the steps."""
    scene = load_scene("rogue_cn_k_0.5").with_tolerance(1e-9)
    measured = run(scene.changed(engine="stencil"))
    assert "error_curve" in scene.observables
    assert measured.attrs["sites"] < 2048


@pytest.mark.parametrize("engine", ["stencil", "spectral"])
def test_both_engines_keep_a_tolerance_on_a_periodic_background(
    ring_scene: Callable[..., Scene], engine: str
) -> None:
    scene = ring_scene(observables=("strain",))
    exact = run(scene.changed(step=0.08, sites=800)).strain.values
    check(scene.with_tolerance(1e-4).changed(engine=engine), exact)


RATIONAL = tuple(name for name in shipped_scenes() if name.startswith("rational"))
PERIODIC = tuple(name for name in shipped_scenes() if name not in RATIONAL)


@pytest.mark.slow
@pytest.mark.parametrize("name", RATIONAL)
def test_the_window_keeps_every_tolerance(name: str) -> None:
    """Measured by the ring, which has no window's ends and no site's step.

    Where the crest is as short as two sites the ring's own steps leave 5e-8: a finer stencil then.
    """
    scene = load_scene(name)
    exact = spectral_reference(scene) if scene.eps <= 0.05 else stencil_reference(scene)
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
        check(scene.with_tolerance(tolerance).changed(engine="stencil"), exact)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "tolerances"),
    [(name, (1e-2, 1e-4)) for name in RATIONAL] + [("rational_2_eps_0.05", (1e-6,))],
)
def test_the_ring_keeps_its_tolerance(name: str, tolerances: tuple[float, ...]) -> None:
    """Measured by the window."""
    scene = load_scene(name)
    exact = stencil_reference(scene)
    for tolerance in tolerances:
        check(scene.with_tolerance(tolerance).changed(engine="spectral"), exact)


@pytest.mark.slow
@pytest.mark.parametrize("name", PERIODIC)
@pytest.mark.parametrize("engine", ["stencil", "spectral"])
def test_both_engines_keep_every_tolerance_on_periodic_backgrounds(name: str, engine: str) -> None:
    scene = load_scene(name)
    exact = stencil_reference(scene)
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8):
        check(scene.with_tolerance(tolerance).changed(engine=engine), exact)


def test_the_model_takes_the_cheaper_engine() -> None:
    """Sites and steps of the window grow as eps falls, those of the ring do not."""
    family = rational_family_scenes(orders=(2,))
    chosen = {name: choose_engine(scene) for name, scene in family.items()}
    assert chosen["Y2_eps_0.1"] == chosen["Y2_eps_0.05"] == "stencil"
    assert chosen["Y2_eps_0.0125"] == chosen["Y2_eps_0.00625"] == "spectral"


def test_the_engine_follows_from_the_duration_and_from_what_is_asked(
    ring_scene: Callable[..., Scene],
) -> None:
    scene = ring_scene().with_tolerance(1e-3)
    assert choose_engine(scene) == "stencil"
    scene = replace(scene, snapshots=(2e4,))
    assert choose_engine(scene) == "spectral"
    assert choose_engine(replace(scene, observables=("energy",))) == "stencil"
    assert choose_engine(scene.changed(engine="stencil")) == "stencil"
    with pytest.raises(ValueError, match="engine must be 'stencil' for energy, got 'spectral'"):
        choose_engine(scene.changed(engine="spectral", observables=("energy",)))


def test_a_stencil_run_carries_the_scene_that_was_run(
    window_scene: Callable[..., Scene],
) -> None:
    """So that it can be repeated to the bit without planning again."""
    from longwave.scenes.description.named_scenes import scene_of

    measured = run(window_scene(observables=("strain",)).with_tolerance(1e-3))
    stated = scene_of(measured)
    assert stated.tolerance is None
    assert np.array_equal(run(stated).strain, measured.strain)


@pytest.mark.parametrize(
    ("observables", "variables"),
    [
        (("spectrum",), {"spectrum"}),
        (("error_curve",), {"error_curve", "error_curve_far_field"}),
        (("crest_track",), {"crest_position", "crest_strain"}),
        ((), set()),
    ],
)
def test_the_spectral_ring_forms_what_is_asked_for_and_no_more(
    ring_scene: Callable[..., Scene], observables: tuple[str, ...], variables: set[str]
) -> None:
    scene = ring_scene(observables=observables).with_tolerance(1e-2)
    measured = run(scene.changed(engine="spectral"))
    assert set(measured.data_vars) == variables
    assert all(np.all(np.isfinite(measured[name])) for name in variables)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tolerance": 0.0}, "tolerance must satisfy tolerance > 0, got 0"),
        ({"tolerance": -1e-3}, "tolerance must satisfy tolerance > 0, got -0.001"),
        ({"tolerance": 1e-14}, "tolerance must satisfy tolerance >= 1e-11, got 1e-14"),
        ({"tolerance": "fine"}, "tolerance must be a number, got 'fine'"),
        ({"engine": "steam"}, "engine must be a known one, got 'steam'"),
        ({"step": 0.5}, "step must not be given with a tolerance, got 0.5"),
        ({"sites": 4096}, "sites must not be given with a tolerance, got 4096"),
        ({"domain": "ring"}, "domain must not be given with a tolerance, got ring"),
        ({"engine": "spectral", "scheme": "rk4"}, "scheme must not be given for engine 'spectral'"),
        (
            {"observables": ("domain_error",)},
            "observables must have no refinement",
        ),
        ({"tolerance": None, "step": 0.5, "sites": 99}, "domain must be a known one, got ''"),
        (
            {"tolerance": None, "step": 0.5, "sites": 99, "domain": "ring", "engine": "spectral"},
            "tolerance must be given for engine 'spectral'",
        ),
    ],
)
def test_what_contradicts_a_tolerance_is_refused_in_one_line(
    ring_scene: Callable[..., Scene], changes: dict[str, object], message: str
) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        ring_scene().with_tolerance(1e-3).changed(**changes)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


SOFT: dict[str, object] = {
    "wave": "breather_sn",
    "K4": -1.0,
    "parameters": (("k", 0.7), ("alpha", "K/2"), ("X_0", 0)),
    "observables": ("strain",),
}


def test_the_stencil_tells_a_blow_up_and_keeps_what_came_before(
    ring_scene: Callable[..., Scene],
) -> None:
    """K4 < 0 and an amplitude near the point where K2 + 3 K4 y^2 changes sign."""
    scene = ring_scene(**SOFT).with_tolerance(1e-3)
    measured = run(scene.changed(eps=0.8, engine="stencil"))
    assert measured.attrs["blow_up"].startswith(
        "blow-up: a bond is stretched to where waves grow at t = "
    )
    assert measured.sizes["time"] == measured.strain.shape[0] == 1
    assert measured.attrs["error_estimate"] == float("inf")


def test_the_spectral_ring_refuses_a_wave_as_short_as_the_lattice(
    ring_scene: Callable[..., Scene],
) -> None:
    """Its steps would have to be as short as the stencil's, and it would find a plateau first."""
    scene = replace(ring_scene(**SOFT).with_tolerance(1e-3), eps=0.8)
    refusal = r"engine must be 'stencil' .* width 1\.5 sites or more, this one has 0\.73"
    with pytest.raises(ValueError, match=refusal):
        run(scene.changed(engine="spectral"))
    assert run(scene).attrs["engine"] == "stencil"


def test_a_tolerance_that_no_ring_meets_is_refused_with_the_users_number(
    ring_scene: Callable[..., Scene], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: the share of it that the engine asks of itself."""
    monkeypatch.setattr(spectral_search, "MOST_POINTS", 100)
    scene = ring_scene().with_tolerance(1e-3).changed(engine="spectral")
    with pytest.raises(ValueError, match=r"larger than 0\.001: it needs a ring of more than 100 p"):
        run(scene)


@pytest.mark.parametrize("wave", ["rational_1", pytest.param("wave_dn", marks=pytest.mark.slow)])
def test_slow_times_and_half_width_are_times_and_sites(wave: str) -> None:
    """Catches: data nudged, or the wave looked at alone, of a scene that is no scene then."""
    parameters = {"k": 0.5} if wave == "wave_dn" else {}
    fields = {"wave": wave, "parameters": parameters, "eps": 0.1, "tolerance": 1e-3}
    fields["constants"] = {"K2": 1, "K4": 1}
    slow = Scene.of(name="slow", slow_times=[0, 0.1], half_width=20, **fields)
    by_sites = Scene.of(name="sites", t0=0, snapshots=[0, 100], compared=200, **fields)
    one, other = run(slow), run(by_sites)
    assert one.sizes["site"] == 401
    np.testing.assert_allclose(one.strain.values, other.strain.values, atol=1e-12)
