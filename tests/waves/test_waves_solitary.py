"""Solitary waves: known crests, exact Toda solitons, and certificates that must be refused."""

import copy
from fractions import Fraction
from typing import Any

import mpmath
import pytest

from longwave.derive import LATTICES
from longwave.waves.exact_wave import ExactWave, exact_wave
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.force_text import read_force
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.proved import Existence


def wave_of(name: str, speed: str, **values: object) -> ExactWave:
    return exact_wave(LATTICES[name].with_values(values), speed=speed)


CRESTS = [
    ("alpha_fput", {"K2": 1, "K3": 1}, "21/20", ".15184654655941372769"),
    ("beta_fput", {"K2": 1, "K4": 1}, "11/10", ".626297190973906760"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "values", "speed", "crest"), CRESTS)
def test_crests(name: str, values: dict[str, object], speed: str, crest: str) -> None:
    wave = wave_of(name, speed, **values)
    assert wave.verdict is Existence.EXISTS
    assert abs(Fraction(wave.crest.lower) - Fraction(f"0{crest}")) < Fraction(1, 10**17)
    assert wave.crest.error < 1e-15


@pytest.mark.slow
def test_a_toda_soliton_is_the_exact_one() -> None:
    """Catches terms of a series that the library drops: crest 2 ln cosh k, v = sinh k/k."""
    with mpmath.workdps(40):
        k = mpmath.findroot(lambda k: mpmath.sinh(k) / k - mpmath.mpf("1.1"), 0.8)
        crest = 2 * mpmath.log(mpmath.cosh(k))
        wave = wave_of("toda", "11/10", a=1, b=1)
        assert mpmath.mpf(wave.crest.lower) < crest < mpmath.mpf(wave.crest.upper)
        assert wave.crest.error < 1e-10


def test_a_series_has_all_its_terms() -> None:
    coefficients = read_force("exp(r) - 1").taylor(0, 30)
    assert abs(coefficients[29] * mpmath.factorial(29) - 1) < 1e-10


@pytest.fixture(scope="module")
def certificate() -> dict[str, Any]:
    return dict(wave_of("alpha_fput", "21/20", K2=1, K3=1).certificate)


CHANGES: list[tuple[str, Any]] = [
    ("speed", "1"),
    ("speed", "99/100"),
    ("speed", "53/50"),
    ("radius", "1e-3"),
    ("radius", "0"),
    ("kappa", "1.2"),
    ("kappa", "-0.5"),
    ("kappa", "0"),
    ("half_length", "3"),
    ("half_length", "-30"),
    ("claims", {"crest": ["0.152", "0.153"]}),
    ("claims", {"mass": ["0", "1"]}),
    ("lattice", {"springs": [{"neighbour": 2, "force": "r + r**2"}]}),
    ("lattice", {"springs": [{"neighbour": 1, "force": "r + 1.001*r**2"}]}),
]


@pytest.mark.parametrize(("key", "value"), CHANGES)
def test_a_changed_certificate_is_refused(
    certificate: dict[str, Any], key: str, value: object
) -> None:
    with pytest.raises(CertificateError):
        check_certificate({**copy.deepcopy(certificate), key: value})


def test_the_zero_wave_is_refused(certificate: dict[str, Any]) -> None:
    """Catches g = 0, which solves the equation and passes with any small radius."""
    zero = {**certificate, "modes": ["0"] * len(certificate["modes"]), "claims": {}}
    for radius in ("1e-30", "1e-6"):
        with pytest.raises(CertificateError, match="g = 0 is no wave"):
            check_certificate({**zero, "radius": radius})


def test_a_subsonic_wave_is_not_proved() -> None:
    wave = wave_of("alpha_fput", "19/20", K2=1, K3=1)
    assert wave.verdict is Existence.NOT_PROVED
    assert "speed of sound" in wave.reason
