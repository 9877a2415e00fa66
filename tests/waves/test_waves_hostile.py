"""Certificates that once passed, crashed or never ended: each must be refused, soon."""

import json
from pathlib import Path
from typing import Any

import pytest
from flint import acb, arb, fmpq

from longwave.derive import LATTICES
from longwave.waves.exact_wave import exact_wave, waves_of_all_eps
from longwave.waves.kernel.__main__ import main
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.exponent import ExponentCentre, Stiffness, exponent_contraction
from longwave.waves.kernel.force_text import read_force
from longwave.waves.kernel.limits import CertificateError


@pytest.fixture(scope="module")
def periodic() -> dict[str, Any]:
    lattice = LATTICES["alpha_fput"].with_values({"K2": 1, "K3": 1})
    return {**exact_wave(lattice, period=15, first_mode="1/50").certificate, "claims": {}}


@pytest.fixture(scope="module")
def solitary() -> dict[str, Any]:
    lattice = LATTICES["alpha_fput"].with_values({"K2": 1, "K3": 1})
    return {**exact_wave(lattice, speed="21/20").certificate, "claims": {}}


def springs(force: str, neighbour: int = 1) -> dict[str, Any]:
    return {"lattice": {"springs": [{"neighbour": neighbour, "force": force}]}}


def test_an_energy_is_proved_for_nearest_neighbours_only() -> None:
    """Catches the energy of another chain: with second neighbours alone, V' acts on S_2 f."""
    lattice = LATTICES["next_nearest"].with_values(
        {"K2": 1, "K3": 0, "K4": 1, "L2": "1/4", "L3": 0, "L4": 0}
    )
    proof = dict(exact_wave(lattice, period=10, first_mode="1/20").certificate)
    linear = {
        **proof, **springs("r", 2), "modes": ["0"] * len(proof["modes"]),
        "speed_squared": "3.5005608003335232683", "radius": "1e-9",
    }  # fmt: skip
    assert "neighbour 2" in check_certificate({**linear, "claims": {}})
    with pytest.raises(CertificateError, match="unknown keys: energy"):
        check_certificate({**linear, "claims": {"energy": ["0", "1000"]}})


FORCES = [
    "(" * 400 + "r" + ")" * 400,
    "-" * 1500 + "r",
    "((r**64)**64)**64",
    "((1e9999**64)**64)**64*r",
    "r" + "*r" * 70,
    "exp(r)" + "+exp(r)" * 900,
]


@pytest.mark.parametrize("force", FORCES)
def test_a_force_is_small(periodic: dict[str, Any], force: str) -> None:
    with pytest.raises(CertificateError):
        check_certificate({**periodic, **springs(force)})


@pytest.mark.parametrize("force", ["0", "1"])
def test_a_constant_force_has_no_solitary_wave(solitary: dict[str, Any], force: str) -> None:
    with pytest.raises(CertificateError, match="speed of sound"):
        check_certificate({**solitary, **springs(force)})


@pytest.mark.parametrize("length", ["0", "-31"])
def test_a_length_is_positive(solitary: dict[str, Any], length: str) -> None:
    with pytest.raises(CertificateError, match="half_length > 0"):
        check_certificate({**solitary, "half_length": length})


@pytest.mark.parametrize("change", [{"bits": 10**5000}, {"version": 10**5000}, {1: 2}])
def test_odd_values_are_refused(periodic: dict[str, Any], change: dict[Any, Any]) -> None:
    with pytest.raises(CertificateError):
        check_certificate({**periodic, **change})


def test_a_problem_is_not_too_large(periodic: dict[str, Any]) -> None:
    with pytest.raises(CertificateError, match="entries"):
        check_certificate({**periodic, "modes": [*periodic["modes"], *["0"] * 1900]})


@pytest.mark.slow
def test_a_modulus_next_to_1_ends() -> None:
    """Catches an endless search for the modes of Y: at 53 bits the modulus is 1."""
    lattice = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": 1})
    proof = dict(waves_of_all_eps(lattice, near="dn", k="3/5", eps="1/50").certificate)
    near = {"form": "dn", "k": f"{10**30 - 1}/{10**30}"}
    with pytest.raises(CertificateError, match="too close to 1"):
        check_certificate({**proof, "near": near, "bits": 53, "claims": {}})


def test_a_constant_stiffness_counts_in_the_tail() -> None:
    """Catches a tail that is left out where V''(f) has one mode."""
    stiffness = Stiffness([arb(1)], arb(0), arb(1) / 100, arb(10))
    centre = ExponentCentre(stiffness, fmpq(1, 4), acb(0), [acb(1)], 0, arb("1e-9"))
    assert exponent_contraction(centre).z1 > 1


def test_a_key_is_not_given_twice(periodic: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "doubled.json"
    text = json.dumps(periodic)
    path.write_text('{"claims": {"speed": ["2", "3"]}, ' + text[1:], encoding="utf-8")
    assert main([str(path)]) == 1


def test_a_number_is_ascii() -> None:
    with pytest.raises(CertificateError):
        read_force("\u0661*r")
