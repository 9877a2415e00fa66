"""Catches: losses in the lattice but not in its equation or vice versa, a soliton that does not
follow its law, a seam whose signals dashpots carry to the compared cells, a wrong convergence rate,
two grammars of one table.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from longwave import resume, run
from longwave.lattice.driving import DrivenChain
from longwave.runs.sweep_scene import changed_document, make_scene
from longwave.scenes.convergence import at_eps, fitted_rate, scene_convergence, scene_rate
from longwave.scenes.description.losses import Losses
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.lattice_run import compared_cells, domain_plan, record_scene
from longwave.scenes.starts.lattice_derivation import derivation, lattice_wave, wave_of
from longwave.support.request_limits import request_limits

SOLITON: dict[str, Any] = {
    "name": "worn",
    "lattice": "alpha_fput",
    "wave": "kdv_soliton",
    "parameters": {"kappa": 2},
    "eps": 0.2,
    "order": "slaved",
    "slow_times": [0, 0.5, 1],
    "half_width": 6,
    "tolerance": 1e-5,
    "constants": {"K2": 1, "K3": 1, "gamma": 0.1},
    "losses": {"site": "eps**3*gamma"},
}
MKDV: dict[str, Any] = SOLITON | {
    "lattice": "fput",
    "wave": "soliton_sech",
    "parameters": {"A": 1},
    "constants": {"K2": 1, "K3": 0, "K4": 1, "gamma": 0.1},
}
SHOCK: dict[str, Any] = SOLITON | {
    "lattice": "fput_strain",
    "wave": "kdv_burgers_shock",
    "parameters": {},
    "half_width": 8,
    "constants": {"K2": 1, "K3": 1, "K4": 0, "eta": 1},
    "losses": {"bond": "eps*eta"},
}


def scene(base: dict[str, Any] = SOLITON, **changes: Any) -> Scene:
    return Scene.of(**(base | changes))


def test_losses_are_in_the_equation_and_in_the_lattice() -> None:
    damped = scene(losses={"site": "eps**3*gamma", "bond": "eps*gamma/2"})
    assert derivation(damped).text() == (
        "damped KdV-Burgers: Y_T + (1/c) Y Y_X + (1/(24 c)) Y_XXX + (1/20) Y - (1/40) Y_XX = 0"
    )
    wave = lattice_wave(damped)
    ring = wave.ring(np.arange(-40.0, 40.0), 0.0)
    assert isinstance(ring.lattice, DrivenChain)
    assert ring.lattice.losses == pytest.approx((0.2**3 * 0.1,), rel=1e-15)
    assert ring.lattice.dashpots == pytest.approx((0.2 * 0.05,), rel=1e-15)
    assert (ring.lattice.cells, ring.lattice.walls) == (80, ())


def test_numbers_are_scaled_by_eps() -> None:
    """Losses as numbers give the same equation and bits, and scale with eps in `at_eps`."""
    formula = scene(constants={"K2": 1, "K3": 1})
    formula = formula.changed(losses={"site": "eps**3/10"})
    number = formula.changed(losses={"site": 0.0008})
    assert derivation(number).text() == derivation(formula).text()
    assert np.array_equal(run(number).strain, run(formula).strain)
    assert derivation(at_eps(number, 0.1)).text() == derivation(formula).text()
    [rate] = lattice_wave(at_eps(number, 0.1)).losses.sites  # type: ignore[union-attr]
    assert rate == pytest.approx(0.0001, rel=1e-14)


@pytest.mark.parametrize(("base", "power", "decay"), [(SOLITON, 1, 2 / 3), (MKDV, 2, 1.0)])
def test_the_compared_soliton_solves_its_equation_to_leading_order(
    base: dict[str, Any], power: int, decay: float
) -> None:
    """Y_T by differences equals that of the equation up to a residual of order gamma.

    The residual is orthogonal to the soliton, since the law is its momentum balance.
    """
    damped = scene(base, losses={"site": "eps**3*gamma", "bond": "eps*gamma/7"})
    found, wave = derivation(damped), wave_of(damped)
    assert found.law is not None
    terms = found.source.coefficients().terms  # type: ignore[union-attr]
    X, T, h = np.linspace(-14.0, 14.0, 2801), 0.7, 1e-4
    Y, Y_X, Y_XX, Y_XXX = wave.jets(X, T, 3)
    moved = (wave.jets(X, T + h, 0)[0] - wave.jets(X, T - h, 0)[0]) / (2 * h)
    [nonlinear] = [
        float(value) for name, value in terms.items() if name.startswith("Y ") or "^" in name
    ]
    left = moved + nonlinear * Y**power * Y_X + float(terms["Y_XXX"]) * Y_XXX
    left += float(terms["Y"]) * Y + float(terms["Y_XX"]) * Y_XX
    assert np.abs(left).max() < 0.6 * 0.1 * np.abs(Y).max()
    assert abs(np.sum(left * Y)) < 1e-6 * np.sum(Y * Y)
    if power == 1:  # on a softening chain the soliton is inverted
        softer = scene(base, constants={"K2": 1, "K3": -1, "gamma": 0.1}, losses=damped.losses)
        assert wave_of(softer).jets(X, T, 0)[0] == pytest.approx(-Y, rel=1e-12)
    alone = wave_of(scene(base))
    crest = alone.crest(T) / alone.crest(0.0)  # type: ignore[union-attr]
    assert crest == pytest.approx(math.exp(-decay * 0.1 * T), rel=1e-12)
    assert np.gradient(wave.antiderivative(X, T), X)[1:-1] == pytest.approx(Y[1:-1], abs=4e-4)


def test_the_law_is_recorded_beside_the_crest() -> None:
    found = run(scene(observables=["strain", "crest_track"]))
    crest, law = found.crest_strain.values, found.crest_law.values
    assert law[-1] / law[0] == pytest.approx(math.exp(-0.2 / 3), rel=1e-12)
    assert np.abs(crest / law - 1.0).max() < 0.03
    lossless = scene(losses={}, constants={"K2": 1, "K3": 1}, observables=["crest_track"])
    assert "crest_law" not in run(lossless)
    assert "energy_drift" in run(lossless).attrs
    assert "energy_drift" not in found.attrs


def damped_equation(power: int, damping: float, end: float) -> float:
    """Return the final crest of U_tau + 6 U^power U_xi + U_xixixi = -damping U over the law's.

    The solution is a Fourier series; it starts from 2 sech^2 (power 1) or sech (power 2).
    """
    count, length = 512, 96.0
    xi = np.arange(count) * length / count - 48.0
    k = 2 * np.pi * np.fft.rfftfreq(count, length / count)
    speed = 4.0 if power == 1 else 1.0
    linear = 1j * k**3 + 1j * k * speed - damping
    begin = 2 / np.cosh(xi) ** 2 if power == 1 else 1 / np.cosh(xi)

    def slope(tau: float, modes: np.ndarray) -> np.ndarray:
        turned = np.exp(linear * tau)
        U = np.fft.irfft(turned * modes, count)
        return -6j * k / (power + 1) * np.fft.rfft(U ** (power + 1)) / turned

    modes = np.fft.rfft(begin)
    found = solve_ivp(slope, (0, end), modes, "DOP853", rtol=1e-9, atol=1e-9).y[:, -1]
    fine = np.fft.irfft(np.pad(np.exp(linear * end) * found, (0, 15 * 256)), 16 * count) * 16
    law = 2 * math.exp(-4 * damping * end / 3) if power == 1 else math.exp(-2 * damping * end)
    return float(fine.max() / law)


@pytest.mark.parametrize("power", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_the_equation_leaves_its_law_with_the_first_power_of_the_damping(power: int) -> None:
    """The final `damping * tau` is the same for all dampings."""
    dampings = [0.02, 0.01, 0.005] if power == 2 else [0.08, 0.04, 0.02]
    deviations = [damped_equation(power, one, 0.08 / one) - 1 for one in dampings]
    assert all(0.0 < value < 0.05 for value in deviations)
    assert fitted_rate(dampings, deviations).holds(1)


def worn(eps: float, gamma: float, base: dict[str, Any] = SOLITON) -> float:
    """Return the relative deviation of the lattice's crest from the law.

    Effects of eps alone cancel: the crest is divided by that of an equally long lossless run.
    """
    ends = {"eps": eps, "slow_times": [0, 0.3 / gamma], "half_width": 10, "tolerance": 1e-4}
    ends |= {"observables": ["crest_track"], "look_points": 2}
    left = []
    for losses in (base["losses"], {}):
        constants = base["constants"] | {"gamma": gamma}
        if not losses:
            del constants["gamma"]
        damped = scene(base, **ends, constants=constants, losses=losses)
        left.append(float(run(damped).crest_strain[-1]))
    law = wave_of(scene(base, constants=base["constants"] | {"gamma": gamma}))
    return left[0] / left[1] * law.crest(0.0) / law.crest(0.3 / gamma) - 1  # type: ignore[union-attr]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("base", "gammas", "largest"),
    [(SOLITON, [0.1, 0.05, 0.025], 0.02), (MKDV, [0.05, 0.025, 0.0125], 0.08)],
)
def test_the_lattice_leaves_the_law_with_the_first_power_of_the_losses(
    base: dict[str, Any], gammas: list[float], largest: float
) -> None:
    """All runs end at the same gamma T; two eps extrapolate the error of order eps^2."""
    deviations = [2 * worn(0.1, g, base) - worn(math.sqrt(0.02), g, base) for g in gammas]
    assert fitted_rate(gammas, deviations).holds(1)
    assert 0.0 < deviations[-1] < 0.4 * deviations[0] < largest


@pytest.mark.slow
def test_the_shock_of_dashpots_runs_on_the_lattice_with_the_rate_of_theory() -> None:
    """Strains have errors of order eps^4, which is eps^2 relative to the wave's eps^2."""
    found = scene_convergence(scene(SHOCK), [0.2, 0.14, 0.1, 0.07])
    assert (found.equation, found.theory, found.reached) == ("KdV-Burgers (s = 1)", 4, True)
    assert found.points[-1].relative < 0.01
    assert scene_rate(scene()) is None


@pytest.mark.slow
@pytest.mark.parametrize("lattice", ["fput", "fput_strain"])
def test_the_seam_of_a_shock_is_not_felt_however_dashpots_smear_it(lattice: str) -> None:
    """A ring twice as wide agrees to rounding; without the margin the error is 1e-8."""
    shock = scene(SHOCK, lattice=lattice, slow_times=[0, 8], tolerance=1e-8)
    timed, domains = domain_plan(shock)
    least = math.prod(high - low + 1 for low, high in domains.ends())
    stated = {"tolerance": None, "domain": "ring", "step": 0.5, "scheme": "reduced_phase_6"}
    narrow, wide = (
        record_scene(shock.changed(**stated, sites=sites)).values("strain")
        for sites in (least, 2 * least)
    )
    assert np.abs(narrow - wide).max() < 1e-12
    assert compared_cells(shock, domains.wave).reach[0] < least / 4
    assert timed.end == pytest.approx(1000.0)


def test_losses_are_stored_in_files_and_swept() -> None:
    damped = scene()
    assert Scene.from_json(damped.json()) == damped
    document = {key: value for key, value in SOLITON.items() if key != "name"}
    from_file = make_scene(document, "worn", Path())
    assert from_file == damped
    assert 'site = "eps**3*gamma"' in damped.toml()
    swept = make_scene(changed_document(document, {"losses.site": "eps**3/50"}), "worn", Path())
    assert swept.losses == Losses(site="eps**3/50")
    assert run(damped).attrs["scene"].count("losses") == 1


def test_a_run_with_losses_resumes_from_its_state() -> None:
    damped = scene(observables=["strain", "state"], losses={"site": "eps**3*gamma", "bond": 0.02})
    whole = run(damped)
    later = resume(whole, at=float(whole.time[1]))
    assert np.array_equal(later.strain[-1], whole.strain[-1])


REFUSED = [
    ({"losses": {"bond": "eps*gamma"}, "slow_times": [-50, 0]}, "slow_times must be later than"),
    (
        {"losses": {"bond": "eps*gamma*10**9"}},
        "take a larger eps, end earlier or compare fewer cells",
    ),
    (
        {
            "losses": {"bond": "eps"},
            "wave": "kdv_two_soliton",
            "parameters": {"kappa_1": 2, "kappa_2": 1},
            "constants": {"K2": 1, "K3": 1},
        },
        "wave must solve the KdV-Burgers (s = 1) equation",
    ),
    ({"losses": {"site": "eps**2*gamma"}}, "site loss must enter at the order of the reduced"),
    ({"losses": {"site": -0.1}}, "site in [losses] must be 0 or more, got -0.1"),
    ({"losses": {"sites": 1}}, "keys in [losses] must be known ones, got sites"),
    ({"losses": 0.1}, "losses must be a table, got 0.1"),
    ({"losses": {"site": [0.1]}}, "site in [losses] must be a number, got [0.1]"),
    ({"losses": {"site": {"w": 0.1}}}, "site must be a loss of u, got one of 'w'"),
    ({"losses": {"bond": [0.1, 0.1]}}, "bond in [losses] must be a loss for each of 1 springs"),
    ({"losses": {"site": "eps**3*other"}}, "constant other of alpha_fput must be given"),
    ({"losses": {"site": "eps**3*__import__('os')"}}, "site: "),
    ({"losses": {}}, "constants must be among K2, K3, got 'gamma'"),
    ({"constants": {"K2": 1, "K3": 1, "gamma": -1}}, "gamma must satisfy gamma > 0, got -1"),
    ({"order": "corrected"}, "losses must not be given with order corrected"),
    ({"engine": "spectral"}, "engine must be 'stencil' with losses"),
    (
        {"disorder": {"of": "mass", "spread": 0.1, "seed": 1}},
        "losses must not be given with disorder",
    ),
    ({"carrier": 1, "wave": "nls_bright"}, "losses must not be given with an envelope"),
    (
        {"wave": "kdv_two_soliton", "parameters": {"kappa_1": 2, "kappa_2": 1}},
        "wave must solve the damped KdV equation",
    ),
    ({"wave": "nls_bright"}, "(one of kdv_soliton;"),
    ({"lattice": "square", "constants": {"gamma": 1}}, "constant"),
]


@pytest.mark.parametrize(("changes", "text"), REFUSED, ids=[text for _, text in REFUSED])
def test_what_is_refused(changes: dict[str, Any], text: str) -> None:
    with (
        request_limits(seconds="1h"),
        pytest.raises(ValueError, match=re.escape(text)) as caught,
    ):
        run(scene(**changes))
    assert "\n" not in str(caught.value)


def test_a_table_has_one_spelling() -> None:
    assert Losses.of({}) is Losses.of("") is Losses.of(None) is None
    stated = Losses.of({"bond": (1, "eta")})
    assert str(stated) == '{"bond": [1, "eta"]}'
    assert Losses.of(str(stated)) == Losses.of(stated) == stated


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [("damped_kdv_soliton", -0.005, 0.015), ("damped_mkdv_soliton", -0.01, 0.05)],
)
def test_shipped_solitons_fade_as_the_law_has_it(name: str, least: float, most: float) -> None:
    found = run(load_scene(name))
    deviations = found.crest_strain / found.crest_law - 1
    assert least < float(deviations.min()) < float(deviations.max()) < most
    assert float(found.crest_law[-1]) < 0.72 * float(found.crest_law[0])
