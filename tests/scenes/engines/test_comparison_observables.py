"""Catches: effects computed or stored that nobody asked for, diagnostics that cost or disturb."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.optimize
import xarray as xr

from longwave.lattice.dynamics import Dynamics
from longwave.lattice.model import Model
from longwave.lattice.schemes import SCHEMES, Scheme
from longwave.lattice.state import State, empty_chain
from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import lattice_run
from longwave.scenes.engines.lattice_run import domain_plan, stated_cells
from longwave.scenes.engines.recorders import LOOK_EVALUATIONS
from longwave.scenes.engines.spectral_run import view_of
from longwave.scenes.observed.observables import (
    OBSERVABLES,
    Observable,
    axis_values,
    extremum,
    observable_named,
)
from longwave.scenes.starts.moving_wave import moving_wave
from longwave.solutions.numeric_wave import NumericWave

FLOPS = 9
"""Operations a site and force evaluation in the kernels with K2, K4: drift 2, force 3, kick 4."""

WAVE_CALLS = ("at", "background_at", "far_field_at")
VALUES = dict(
    zip(("wave", "background", "left", "right"), (*WAVE_CALLS, "far_field_at"), strict=True)
)
"""As which of them the value of a part alone is counted."""
TOUCHES = {
    "strain": {"at", "background_at", "far_field_at"},
    "error_curve": {"at", "background_at", "far_field_at"},
    "background_difference": {"background_at"},
    "error_split": {"at", "background_at", "least_squares"},
    "energy": {"energy"},
    "spectrum": {"rfft"},
}


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Counts the calls of everything costly that an observable could call."""
    xr.Variable("t", [0.0])  # imports dask, which subclasses FFTs that are still NumPy's
    counted: Counter[str] = Counter()

    def count(owner: Any, name: str) -> None:
        original = getattr(owner, name)

        def counting(*arguments: Any, **options: Any) -> Any:
            part = arguments[4] if len(arguments) > 4 else "wave"  # of value_at
            counted[VALUES[part] if name == "value_at" else name] += 1
            return original(*arguments, **options)

        monkeypatch.setattr(owner, name, counting)

    for name in (*WAVE_CALLS, "value_at"):
        count(NumericWave, name)
    count(Model, "energy")
    count(scipy.optimize, "least_squares")
    count(np.fft, "rfft")
    advance = Dynamics.advance

    def counting_advance(
        own: Any, scheme: Scheme, f: Any, v: Any, h: float, steps: int, *t: float
    ) -> None:
        counted["kernel steps"] += steps
        advance(own, scheme, f, v, h, steps, *t)

    monkeypatch.setattr(Dynamics, "advance", counting_advance)
    monkeypatch.setattr(lattice_run, "trust_attributes", lambda _: {})
    return counted


ELSEWHERE = {"sup_error", "slow_time", "strains", "analytics", "crest_law"}
"""Told of other lattices."""


def stored_bytes(entry: Observable, scene: Scene, moments: int) -> Iterator[int]:
    for variable in (one for one in entry.variables if one.name not in ELSEWHERE):
        size = moments
        for dimension in variable.dimensions:
            axis = axis_values(dimension, (scene.compared,))
            size *= scene.discretisation.sites if axis is None else axis[0].size
        yield 8 * size


@pytest.mark.parametrize("name", OBSERVABLES)
def test_nothing_else_is_computed_or_stored(
    ring_scene: Callable[..., Scene], calls: Counter[str], name: str
) -> None:
    scene = ring_scene(observables=(name,), look_points=5)
    entry = observable_named(name)
    for _ in range(2):  # what the plan looks at is kept
        calls.clear()
        run(replace(scene, observables=()))
    bare = calls.copy()
    calls.clear()
    measured = run(scene)
    repeats = 2.0 if name == "time_step_error" else 1.0
    refined = {"time_step_error": 1, "domain_error": 1}.get(name, 0)
    assert calls["kernel steps"] == bare["kernel steps"] * (1 + refined * repeats)
    extra = {key for key in calls if calls[key] > bare[key] * (1 + refined)}
    assert extra - {"kernel steps"} == TOUCHES.get(name, set())
    assert set(measured.data_vars) == {variable.name for variable in entry.variables} - ELSEWHERE
    moments = {"snapshots": 3, "refinement": 3}.get(entry.seen, 5)
    assert sum(measured[n].nbytes for n in measured.data_vars) == sum(
        stored_bytes(entry, scene, moments)
    )


def test_nothing_at_all_is_stored_when_nothing_is_asked(
    ring_scene: Callable[..., Scene], calls: Counter[str]
) -> None:
    measured = run(ring_scene(observables=()))
    assert dict(measured.data_vars) == {}
    assert set(measured.coords) == {"time"}
    assert set(calls) <= {"at", "far_field_at", "kernel steps"}  # what the plan looks at
    assert calls["kernel steps"] == 80


class CountedArray(np.ndarray[Any, np.dtype[np.float64]]):
    """Counts the elements that pass through ufuncs (sums and maxima included)."""

    operations = 0

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        plain = [np.asarray(item) if isinstance(item, CountedArray) else item for item in inputs]
        CountedArray.operations += max(np.size(item) for item in plain)
        options.pop("out", None)
        result = getattr(ufunc, method)(*plain, **options)
        return result.view(CountedArray) if isinstance(result, np.ndarray) else result


def operations(scene: Scene, entry: Observable) -> float:
    """Elementary array operations of one look, 5 N log2 N for a Fourier transform."""
    state = stated_cells(*domain_plan(scene)).stepper(None)[0].state
    counted = State(state.t, state.f.view(CountedArray), state.v.view(CountedArray), state.left)
    CountedArray.operations = 0
    entry.measure(view_of(moving_wave(scene), counted))
    size = 2 * scene.compared + 1
    return CountedArray.operations + (5 * size * np.log2(size) if entry.name == "spectrum" else 0)


DIAGNOSTICS = tuple(n for n in OBSERVABLES if not TOUCHES.get(n, set()) & {*WAVE_CALLS})[:-2]


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
@pytest.mark.parametrize("name", ["breather_sn_k_0.7", "soliton_dn_k_0.7"])
def test_diagnostics_cost_less_than_a_twentieth_at_their_default_cadence(
    name: str, scheme: Any
) -> None:
    """Counted, not timed: array operations of all of them against those of the kernels."""
    assert set(DIAGNOSTICS) == {
        "energy", "momentum", "spectrum", "crest_track", "space_time", "state"
    }  # fmt: skip
    scene = load_scene(name).changed(scheme=scheme.name, observables=DIAGNOSTICS)
    per_look = {n: operations(scene, observable_named(n)) for n in DIAGNOSTICS}
    assert all(per_look[n] > 0 for n in DIAGNOSTICS if n != "state")
    measured = run(replace(scene, observables=(*DIAGNOSTICS,)))
    looks, snapshots = measured.sizes["look_time"], measured.sizes["time"]
    total = sum(
        per_look[n] * (looks if observable_named(n).seen == "looks" else snapshots)
        for n in DIAGNOSTICS
    )
    kernels = FLOPS * measured.attrs["force_evaluations"] * scene.discretisation.sites
    assert total < 0.05 * kernels


def test_a_dense_error_curve_does_not_make_diagnostics_dense(
    ring_scene: Callable[..., Scene],
) -> None:
    """Every stop is an opportunity; most must be let pass."""
    scene = ring_scene(observables=("error_curve", "energy"), curve_points=81)
    measured = run(scene)
    assert measured.sizes["curve_time"] == 81
    gap = np.diff(measured.look_time.values).min()
    assert gap >= LOOK_EVALUATIONS / 17 * scene.discretisation.step * (1.0 - 1e-9)


def test_diagnostics_do_not_disturb_the_run(window_scene: Callable[..., Scene]) -> None:
    """Same bits with and without them: looks change no step and no feed."""
    names = ("crest_track", "space_time", "spectrum", "state")
    bare = run(window_scene(observables=("strain",)))
    seen = run(window_scene(observables=("strain", *names)))
    assert seen.sizes["look_time"] > 3
    assert np.array_equal(bare.strain, seen.strain)
    assert bare.attrs["steps"] == seen.attrs["steps"]


def state_of(t: float, sites: Any, y: Any) -> State:
    """A state that holds just these sites, at rest."""
    state = empty_chain(t, int(sites[0]), sites.size)
    state.store(sites, y, np.zeros_like(y))
    return state


def test_the_crest_of_Y2_is_tracked_between_sites(window_scene: Callable[..., Scene]) -> None:
    """Against the wave itself, displaced by a quarter of a site: 5 eps at its centre."""
    scene = replace(load_scene("rational_2_eps_0.05"), snapshots=(0.0,), t0=0.0, observables=())
    wave, sites = moving_wave(scene).wave, moving_wave(scene).compared_sites(0.0)
    y = scene.eps * wave.at(sites - 0.25, 0.0, scene.eps).Y
    view = view_of(moving_wave(scene), state_of(0.0, sites, y))
    found = observable_named("crest_track").measure(view)
    assert found["crest_position"] == pytest.approx(0.25, abs=5e-3)
    missed = 5.0 * scene.eps - np.max(y)
    assert abs(found["crest_strain"] - 5.0 * scene.eps) < 0.03 * missed
    later = moving_wave(scene).compared_sites(40.0)
    view = view_of(moving_wave(scene), state_of(40.0, later, y))
    moved = later[0] - sites[0] - moving_wave(scene).speed * 40.0
    found = observable_named("crest_track").measure(view)
    assert found["crest_position"] == pytest.approx(0.25 + moved, abs=5e-3)


@pytest.mark.parametrize("place", [-1.6, -1.02, -0.99, 0.4, 0.99, 1.02, 1.6])
def test_a_crest_is_no_farther_than_the_next_site(place: float) -> None:
    """Catches: one that is extrapolated, from sites of which the middle one is not the highest."""
    f = 2.0 - (np.arange(-2.0, 3.0) - place) ** 2
    expected = (place, 2.0) if abs(place) < 1.0 else (0.0, f[2])
    assert extremum(f) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", ["rational_2_eps_0.05", "soliton_dn_k_0.7"])
def test_the_error_is_split_into_shift_amplitude_and_shape(name: str) -> None:
    """A wave displaced by 0.3 sites and raised by 2 % over its background, and nothing else."""
    scene = replace(load_scene(name), observables=())
    sites = moving_wave(scene).compared_sites(scene.t0)
    shown = view_of(moving_wave(scene), state_of(scene.t0, sites, np.zeros(sites.size)))
    w, b, _, _ = shown.displaced(0.3)
    y = b + 1.02 * (w - b)
    view = view_of(moving_wave(scene), state_of(scene.t0, sites, y))
    found = observable_named("error_split").measure(view)
    assert found["shift"] == pytest.approx(0.3, abs=1e-7)
    assert found["scale"] == pytest.approx(1.02, abs=1e-8)
    assert found["error_shape"] < 1e-8
    assert found["error_amplitude"] == pytest.approx(
        0.02 * np.max(np.abs(w - b)) / np.max(np.abs(view.analytic - view.background)), rel=1e-6
    )
    assert found["error_position"] > 0.01


def test_the_parts_of_the_error_add_up(window_scene: Callable[..., Scene]) -> None:
    measured = run(window_scene(observables=("strain", "error_split", "background_difference")))
    whole = measured.error.values
    parts = measured.error_position + measured.error_amplitude + measured.error_shape
    assert np.all(parts.values >= whole)
    assert np.all(measured.error_shape.values < whole)
    expected = measured.strain - measured.background
    assert np.array_equal(measured.background_difference, expected)


def test_momentum_is_conserved_and_the_mean_moves_with_it(
    ring_scene: Callable[..., Scene],
) -> None:
    measured = run(ring_scene(observables=("momentum",), look_points=9, t0=-40.0, sites=600))
    velocity = measured.mean_velocity.values
    assert np.max(np.abs(velocity - velocity[0])) < 1e-15
    moved = measured.mean_strain.values - measured.mean_strain.values[0]
    drift = velocity[0] * (measured.look_time.values + 40.0)
    assert np.max(np.abs(moved - drift)) < 1e-14


def test_the_spectrum_finds_the_carrier_and_noise_at_the_zone_boundary() -> None:
    amplitudes = observable_named("spectrum").measure
    scene = load_scene("soliton_dn_k_0.7")
    sites = moving_wave(scene).compared_sites(scene.t0)
    n = np.arange(sites.size)
    k = 2.0 * np.pi * 40.0 / sites.size
    y = 0.05 * np.cos(k * n) + 1e-9 * (-1.0) ** n
    view = view_of(moving_wave(scene), state_of(scene.t0, sites, y))
    found = amplitudes(view)["spectrum"]
    assert found[40] == pytest.approx(0.05, rel=1e-6)
    assert 1e-10 < found[-1] < 1e-8


def test_the_map_keeps_a_crest_narrower_than_its_cells(window_scene: Callable[..., Scene]) -> None:
    scene = window_scene(compared=300, sites=2048, eps=0.05, look_points=2)
    measured = run(replace(scene, observables=("space_time", "strain")))
    assert measured.sizes["map_site"] == 201
    assert measured.space_time.values[-1].max() == measured.strain.values[-1].max()


def test_strains_are_had_where_the_wave_is_its_own_background(
    window_scene: Callable[..., Scene],
) -> None:
    """Catches: a scene refused for a relative error that has no sense, and that it can do without.

    The crest is so far away that the compared strains are the background's, to the bit.
    """
    far = {"K2": 1.0, "K4": 0.7754, "eps": 0.02128, "t0": -25233.5, "snapshots": (-25133.5,)}
    parameters = (("U_0", -6.003), ("kappa", 3.515))
    scene = window_scene(wave="soliton_background", parameters=parameters, **far)
    found = run(replace(scene, observables=("strain",)))
    assert np.isfinite(found["strain"]).all()
    assert np.isnan(found["error"]).all()
    with pytest.raises(ValueError, match="background must differ from the wave"):
        run(replace(scene, observables=("error_curve",)))
