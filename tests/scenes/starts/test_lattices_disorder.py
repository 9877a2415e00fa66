"""Solitons on disordered lattices.

Catches: a realisation that changes with the ring or is missing in a store's key, a measurement of
the wrong crest, an energy that is not conserved, a wrong loss or delay for weak disorder.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from sympy import Rational

from longwave.derive import LATTICES
from longwave.derive.algebra.exact_numbers import exact
from longwave.lattice.disordered_lattice import disordered
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.runs.run_store import RunStore
from longwave.scenes import run as run_scene
from longwave.scenes.description.named_scenes import scene_of_toml
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_disorder import Disorder
from longwave.scenes.description.scene_file import scene_fields
from longwave.scenes.starts.disordered_wave import variation_of
from longwave.scenes.starts.lattice_derivation import lattice_wave
from longwave.scenes.starts.pulse_meter import PulseMeter, crest

SOLITON: dict[str, Any] = {
    "name": "soliton",
    "lattice": "fput_strain",
    "wave": "soliton_sech",
    "constants": {"K2": 1, "K3": 0, "K4": 1},
    "parameters": {"A": 1},
    "eps": 0.2,
    "order": "slaved",
    "times": (0.0, 150.0, 400.0),
    "half_width": 20,
    "tolerance": 1e-4,
}

MASSES: dict[str, Any] = {"of": "mass", "spread": 0.1, "seed": 1, "sites": [60, 9999]}


def run(spread: float, of: str = "mass", **changes: Any) -> xr.Dataset:
    disorder = MASSES | {"spread": spread, "of": of}
    return run_scene(Scene.of(**(SOLITON | {"disorder": disorder} | changes)))


def last(of: xr.Dataset) -> dict[str, Any]:
    return {key: value for key, value in of.attrs.items() if key.startswith(("last", "eff"))}


@pytest.mark.parametrize("of", ["mass", "K2"])
def test_a_loss_is_as_the_square_of_a_small_spread(of: str) -> None:
    """The scattered wave of one realisation is linear in the deviations, its energy quadratic."""
    none, small, large = (last(run(spread, of)) for spread in (0.0, 0.03, 0.06))
    losses = [none["last_energy"] - found["last_energy"] for found in (small, large)]
    assert losses[1] / losses[0] == pytest.approx(4.0, rel=0.1)
    assert losses[0] > 100 * float(run(0.03, of)["energy_error"][-1])


def test_springs_delay_by_the_speed_of_the_effective_medium() -> None:
    runs = [
        run(0.4, "K2", disorder=MASSES | {"of": "K2", "spread": 0.4, "seed": n}) for n in range(6)
    ]
    delays = np.array([last(found)["last_delay"] for found in runs])
    expected = last(run(0.0))["last_delay"] + 340.0 * (1.0 / last(runs[0])["effective_speed"] - 1.0)
    assert expected > 8.0
    assert abs(delays.mean() - expected) < 3.0 * delays.std(ddof=1) / len(runs) ** 0.5 + 0.5


@pytest.mark.parametrize("of", ["mass", "K2"])
def test_what_is_measured_is_within_its_error(of: str) -> None:
    rough, fine = run(0.3, of, tolerance=1e-2), run(0.3, of, tolerance=1e-7)
    for name in ("peak", "delay", "energy"):
        difference = np.abs(rough[name].values - fine[name].values)
        allowed = rough[f"{name}_error"].values + fine[f"{name}_error"].values
        assert np.all(difference <= allowed)
        assert allowed[-1] > 0.0


def test_an_energy_on_a_ring_that_cuts_the_wave_is_within_its_error() -> None:
    """If one of the two runs has no energy, neither energy nor error is recorded."""
    wide = run(0.3, "K4", half_width=20)
    for half_width in (1, 2, 3, 5, 7, 10):
        found = run(0.3, "K4", half_width=half_width)
        energy, error = found["energy"].values, found["energy_error"].values
        difference = np.abs(energy - wide["energy"].values)
        assert np.array_equal(np.isnan(energy), np.isnan(error))
        assert np.all(np.isnan(energy) | (difference <= error + wide["energy_error"].values))
        assert half_width < 3 or not np.isnan(energy).any()


def test_no_spread_has_the_bits_of_no_disorder() -> None:
    on_a_ring = {"observables": ["strain", "momentum"]}
    ordered = run_scene(Scene.of(**SOLITON, **on_a_ring))
    still = run(0.0, "K2", **on_a_ring)
    np.testing.assert_array_equal(still["strain"], ordered["strain"])
    assert still.error_estimate == ordered.error_estimate
    assert "peak" not in ordered


def test_strains_and_displacements_lose_alike_and_keep_their_energy() -> None:
    """The initial waves differ by a shift of half a cell."""
    strained, displaced = run(0.3), run(0.3, lattice="fput")
    for found in (strained, displaced):
        assert found.energy_drift < 1e-5
        assert found["peak"].dims == ("time",)
    assert last(strained)["last_energy"] == pytest.approx(last(displaced)["last_energy"], abs=2e-3)
    assert last(strained)["last_delay"] == pytest.approx(last(displaced)["last_delay"], abs=0.1)


@pytest.mark.parametrize(
    ("lattice", "of", "constants", "share"),
    [
        ("fput_strain", "K2", {}, 1.0),
        ("fput_strain", "K2", {"K2": 4}, 1.0),
        ("fput", "K2", {"K2": "1/2"}, 1.0),
        ("fput_strain", "K4", {"K2": 4}, 0.0),
        ("fput_strain", "mass", {"K2": 4}, 0.0),
    ],
)
def test_the_effective_medium_is_that_of_springs_in_series(
    lattice: str, of: str, constants: dict[str, Any], share: float
) -> None:
    """<1/(1 + d)> for d uniform in -r .. r is artanh(r)/r, for any mean spring."""
    scene = SOLITON | {"lattice": lattice, "constants": SOLITON["constants"] | constants}
    disorder = MASSES | {"of": of, "spread": 0.4}
    wave = lattice_wave(Scene.of(**(scene | {"disorder": disorder})))
    assert wave.disorder is not None
    mean = np.arctanh(0.4) / 0.4 if share else 1.0
    assert wave.disorder.effective_speed == pytest.approx(mean**-0.5, rel=1e-14)


def test_a_wider_ring_is_the_same_lattice() -> None:
    wave = lattice_wave(Scene.of(**(SOLITON | {"disorder": MASSES | {"sites": [-50, 50]}})))
    near, wide = (wave.ring(np.arange(-n, n + 1.0), 0.0) for n in (70, 101))
    deviations = [ring.lattice.deviations[0] for ring in (near, wide)]  # type: ignore[attr-defined]
    np.testing.assert_array_equal(deviations[0], deviations[1][31:-31])
    assert np.flatnonzero(deviations[0]).tolist() == list(range(20, 121))
    assert np.abs(deviations[0]).max() <= 0.1


def test_a_constant_deviates_in_every_bond_that_has_it_and_nothing_else_does() -> None:
    constants = {"K2": 4, "K3": Rational(1, 2), "K4": 3, "L2": 1, "L3": 0, "L4": 0}
    x = np.array([0.1, 0.2, 0.3])
    d = Disorder("K2", 0.3, seed=1).deviations(np.arange(3))
    symbolic = LATTICES["next_nearest"]
    values = {name: exact(name, value) for name, value in constants.items()}
    ordered = numeric_lattice(symbolic, values)
    variation = variation_of(Disorder("K2", 0.3, seed=1), symbolic, values, ordered)
    chain = disordered(ordered, variation, [d])
    near, far = chain.slopes([x, x])
    np.testing.assert_allclose(near, 4.0 * (1.0 + d) + x + 9.0 * x**2, rtol=1e-14)
    np.testing.assert_allclose(far, 1.0, rtol=1e-14)


def test_the_meter_finds_the_crest_and_the_energy_about_it() -> None:
    wave = lattice_wave(Scene.of(**(SOLITON | {"disorder": MASSES})))
    ring = wave.ring(np.arange(-100.0, 101.0), 0.0)
    assert wave.disorder is not None
    meter = wave.disorder.meter(ring)
    assert isinstance(meter, PulseMeter)
    found = meter(ring.f, ring.v)
    assert found.place == pytest.approx(0.0, abs=1e-9)
    assert found.energy == pytest.approx(0.999 * found.whole, rel=2e-3)
    moved = meter(np.roll(ring.f, 7, 1), np.roll(ring.v, 7, 1))
    assert moved.place == pytest.approx(7.0, abs=1e-9)
    assert crest(np.arange(5.0), np.array([0.0, -1.0, -3.0, -3.0, -1.0])) == (3.25, 2.5)


def test_a_crest_is_followed_out_of_the_cells_that_are_compared() -> None:
    """The crest is delayed by 15 cells, and 10 cells are compared on either side."""
    springs = {"of": "K2", "spread": 0.5}
    wide, narrow = (
        last(run(0.5, disorder=MASSES | springs, times=(0.0, 500.0), half_width=half))
        for half in (20, 2)
    )
    assert wide["last_delay"] > 12.0
    assert narrow == pytest.approx(wide, rel=1e-5)


def test_on_a_background_is_measured_what_rises_above_it() -> None:
    """About the strain 1/5 the forces equal those of springs with K2 = 0.88 and K3 = 0."""
    mean: dict[str, Any] = {"background": "-K3/(3*K4)"}
    mean["constants"] = {"K2": 1, "K3": -0.6, "K4": 1}
    same = last(run(0.2, constants={"K2": 0.88, "K3": 0, "K4": 1}))
    assert last(run(0.2, **mean)) == pytest.approx(same, rel=1e-5)


def test_disorder_leaves_a_wave_its_uniform_strain_and_the_room_of_its_seam() -> None:
    mean = {"background": "-K3/(3*K4)", "constants": {"K2": 1, "K3": -0.6, "K4": 1}}
    kink = {"lattice": "fput", "wave": "kink", "constants": {"K2": 1, "K3": 0, "K4": -1}}
    waves = [
        lattice_wave(Scene.of(**(SOLITON | changes | {"disorder": disorder})))
        for changes in (mean, kink)
        for disorder in (MASSES, ())
    ]
    assert waves[0].uniform().tolist() == waves[1].uniform().tolist() != [0.0]
    assert waves[2].seam_room(0.0) == waves[3].seam_room(0.0) > 0


def test_a_lattice_without_masses_has_no_energy() -> None:
    """Its second bond acts between strains, unlike any spring between masses."""
    near = {"stretch": "y[n]", "force": "K2*x + K4*x**3", "action": {"y": "F[n+1]-2*F[n]+F[n-1]"}}
    far = {"stretch": "y[n+1] - y[n-1]", "force": "K2*x/4", "action": {"y": "F[n+1] - F[n-1]"}}
    declared = json.dumps({"fields": ["y"], "masses": [1], "positive": ["K2"], "bond": [near, far]})
    given: dict[str, Any] = {"constants": {"K2": 1, "K4": 1}, "times": (0.0, 9.0), "eps": 0.1}
    found = run(0.2, "K2", lattice="mine", declared=declared, tolerance=1e-2, **given)
    assert np.isnan(last(found)["last_energy"])
    assert last(found)["last_peak"] > 0.5
    assert "energy_drift" not in found.attrs


@pytest.mark.parametrize(
    "changes",
    [
        {"constants": {"K2": 1, "K3": -0.6, "K4": 1}, "background": "-K3/(3*K4)"},
        {"wave": "rational_2", "parameters": {}, "eps": 0.05},
    ],
)
def test_springs_do_not_differ_where_a_background_stretches_them(changes: dict[str, Any]) -> None:
    given = SOLITON | changes | {"disorder": MASSES | {"of": "K2"}}
    with pytest.raises(ValueError, match=r"of in .* must be mass with a wave on a background"):
        lattice_wave(Scene.of(**given))


@pytest.mark.parametrize(
    ("wave", "parameters", "K4"), [("kink", {"A": 1}, -1), ("wave_cn", {"k": 0.9}, 1)]
)
def test_a_wave_that_does_not_end_has_no_crest(wave: str, parameters: Any, K4: int) -> None:
    constants = {"K2": 1, "K3": 0, "K4": K4}
    given = {"wave": wave, "parameters": parameters, "constants": constants, "times": (0.0, 9.0)}
    assert "peak" not in run(0.1, **given, tolerance=1e-2)


def test_a_scene_reads_back_and_its_key_is_its_own(tmp_path: Path) -> None:
    scene = Scene.of(**(SOLITON | {"disorder": MASSES}))
    assert Scene.from_json(scene.json()) == scene == scene_of_toml(scene.toml())
    assert Scene.of(**(SOLITON | {"disorder": list(MASSES.items())})) == scene
    store = RunStore(tmp_path)
    others = [
        Scene.of(**(SOLITON | {"disorder": given}))
        for given in ((), *(MASSES | {key: value} for key, value in OTHER))
    ]
    assert len({store.key(one) for one in (scene, *others)}) == 1 + len(others)
    same = scene.changed(disorder=json.loads(json.dumps(scene.disorder.pairs)))
    assert store.key(same) == store.key(scene)


OTHER = (("seed", 2), ("seed", 2**62 + 1), ("seed", 2**62), ("of", "K2"), ("spread", 0.2))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"spread": -0.1}, "spread in .disorder. must satisfy 0 <= spread < 1, got -0.1"),
        ({"spread": 1}, "spread in .disorder. must satisfy 0 <= spread < 1, got 1 "),
        ({"spread": "large"}, "spread in .disorder. must be a number, got 'large'"),
        ({"seed": 1.5}, "seed in .disorder. must be a whole number, .*, got 1.5"),
        ({"seed": -1}, "seed in .disorder. must be a whole number, .*, got -1"),
        ({"of": "K5"}, "of in .disorder. must be mass or a constant .*, got 'K5' .*mass, K2, K3"),
        ({"of": "K3"}, "of in .disorder. must name a constant that is not 0, got K3 = 0"),
        ({"of": 3}, "of in .disorder. must be a text, got 3"),
        ({"distribution": "normal"}, "distribution in .disorder. must be a known one"),
        ({"sites": [3, 1]}, "sites in .disorder. must have first <= last, got 3 and 1"),
        ({"sites": 5}, "sites in .disorder. must be the first and the last cell"),
        ({"colour": 1}, "must be known ones, got colour"),
    ],
)
def test_what_is_no_disorder_is_one_line(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said) as caught:
        lattice_wave(Scene.of(**(SOLITON | {"disorder": MASSES | changes})))
    assert "\n" not in str(caught.value)


def test_what_has_no_such_disorder_is_one_line() -> None:
    toda = {"lattice": "toda", "wave": "kdv_soliton", "constants": {"a": 1, "b": 1}}
    given = SOLITON | toda | {"parameters": {"kappa": 1}, "disorder": MASSES | {"of": "b"}}
    with pytest.raises(ValueError, match="must name a constant that forces are proportional to"):
        lattice_wave(Scene.of(**given))
    with pytest.raises(ValueError, match=r"of in \[disorder\] must be stated, got nothing"):
        Scene.of(**(SOLITON | {"disorder": {"seed": 1}}))
    chain = {"lattice": {"K2": 1, "K4": 1}, "disorder": MASSES, "tolerance": 1e-3}
    assert scene_fields(chain)["disorder"].of == "mass"
    with pytest.raises(ValueError, match=r"of in \[disorder\] must be stated, got nothing"):
        scene_fields({"lattice": "fput", "disorder": {}})
    assert Disorder.of_pairs(MASSES).pairs == tuple((MASSES | {"sites": (60, 9999)}).items())
