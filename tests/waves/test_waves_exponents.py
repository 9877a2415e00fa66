"""Floquet exponents: known growth rates, and certificates that must be refused."""

import copy
from typing import Any

import numpy as np
import pytest
from flint import fmpq

from longwave.derive import LATTICES
from longwave.waves.exact_wave import ExactWave, Exponent, exact_wave
from longwave.waves.exponents import approximate_exponents, wave_stiffness
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.limits import CertificateError


def cn_wave(eps: str) -> ExactWave:
    lattice = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": 1})
    return exact_wave(lattice, near="cn", k="3/5", eps=eps)


@pytest.fixture(scope="module")
def exponent() -> Exponent:
    return cn_wave("3/25").exponent("1/4")


def test_a_cn_wave_is_unstable(exponent: Exponent) -> None:
    assert exponent.is_unstable
    assert abs(exponent.growth.value - 3.31740321373049803e-4) < 1e-21
    assert exponent.growth.error < 1e-15


def test_the_growth_does_not_depend_on_the_number_of_components(exponent: Exponent) -> None:
    """Catches an enclosure of another exponent: more components give the same."""
    wave = cn_wave("3/25")
    values, _ = approximate_exponents(wave_stiffness(wave.certificate), fmpq(1, 4), 60)
    close = values[np.argmin(np.abs(values - complex(
        exponent.growth.value, exponent.frequency.value
    )))]  # fmt: skip
    assert abs(close.real - exponent.growth.value) < 1e-10


def test_a_changed_certificate_is_refused(exponent: Exponent) -> None:
    certificate: dict[str, Any] = dict(exponent.certificate)
    vector = certificate["vector"]
    wave = certificate["wave"]
    changes: list[dict[str, Any]] = [
        {"bloch": "1/3"},
        {"growth": "4e-4"},
        {"fixed": certificate["fixed"] + 1},
        {"radius": "1e-3"},
        {"radius": "0"},
        {"vector": vector[:-1]},
        {"vector": [["0", "0"]] * len(vector)},
        {"vector": vector[10:-10]},
        {"wave": {**wave, "radius": "1e-60"}},
        {"wave": {**wave, "near": {"form": "cn", "k": "3/5", "eps": "1/10"}}},
        {"wave": {**wave, "claims": {"speed": ["0", "1/2"]}}},
        {"claims": {"growth": ["3.32e-4", "3.33e-4"]}},
        {"claims": {"rate": ["0", "1"]}},
    ]
    for change in changes:
        with pytest.raises(CertificateError):
            check_certificate({**copy.deepcopy(certificate), **change})


def test_a_solitary_wave_has_no_exponents() -> None:
    wave = exact_wave(
        LATTICES["fput_strain"].with_values({"K2": 1, "K3": 1, "K4": 0}), speed="21/20"
    )
    with pytest.raises(ValueError, match="periodic wave that exists"):
        wave.exponent("1/4")
