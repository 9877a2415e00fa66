"""Periodic waves: known numbers, exact solutions, and statements that must be refused."""

import copy
import json
from typing import Any

import mpmath
import pytest

from longwave.derive import LATTICES
from longwave.derive.lattice import Lattice
from longwave.waves.exact_wave import ExactWave, exact_wave
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.proved import Existence


def chain(k3: object = 0, k4: object = 0) -> Lattice:
    return LATTICES["fput_strain"].with_values({"K2": 1, "K3": k3, "K4": k4})


def contains(wave: ExactWave, name: str, digits: str) -> bool:
    """Return whether a proved interval agrees with a number to all its digits."""
    interval = wave.numbers[name]
    value, unit = mpmath.mpf(digits), mpmath.mpf(10) ** -len(digits.partition(".")[2])
    return bool(mpmath.mpf(interval.lower) - unit < value < mpmath.mpf(interval.upper) + unit)


@pytest.fixture(autouse=True)
def digits() -> Any:
    with mpmath.workdps(50):
        yield


NEAR = [
    ("dn", 1, "3/5", "2/25", "1.0025612617666522026", (1.06674e-4, 1.06675e-4)),
    ("cn", 1, "4/5", "1/10", "1.0006902714396877242", (1.499222e-3, 1.499274e-3)),
    ("sn", -1, "2/5", "3/25", ".99582949723966363018", (1.34490e-4, 1.34492e-4)),
]


@pytest.mark.parametrize(("form", "k4", "k", "eps", "speed", "distance"), NEAR)
def test_a_wave_near_an_elliptic_one(
    form: str, k4: int, k: str, eps: str, speed: str, distance: tuple[float, float]
) -> None:
    wave = exact_wave(chain(k4=k4), near=form, k=k, eps=eps)
    assert wave.verdict is Existence.EXISTS
    assert contains(wave, "speed", speed)
    assert wave.distance is not None
    assert distance[0] < float(wave.distance.lower) <= float(wave.distance.upper) < distance[1]


def test_crest_and_energy_of_a_dn_wave() -> None:
    wave = exact_wave(chain(k4=1), near="dn", k="3/5", eps="2/25")
    assert contains(wave, "crest", ".079991466057936664853")
    assert contains(wave, "energy", ".0467275056803124257")


GIVEN = [
    ("alpha_fput", {"K2": 1, "K3": 1}, 15, "1/50", "1.00149282978922425721"),
    ("granular", {"A": "2/3", "d": 1}, 10, "-1/25", ".984459626161568216148"),
]


@pytest.mark.parametrize(("name", "values", "period", "first_mode", "speed"), GIVEN)
def test_a_wave_of_given_period_and_first_mode(
    name: str, values: dict[str, object], period: int, first_mode: str, speed: str
) -> None:
    wave = exact_wave(LATTICES[name].with_values(values), period=period, first_mode=first_mode)
    assert contains(wave, "speed", speed)


def test_a_toda_wave_is_the_exact_one() -> None:
    """f = ln(1 + B (dn^2(2 K x/P) - E/K)), v = P sqrt(B)/(2 K)."""
    m, period = mpmath.mpf("0.8"), 12
    quarter = mpmath.ellipk(m)
    ratio = mpmath.ellipe(m) / quarter
    b = 1 / (1 / mpmath.ellipfun("sn", 2 * quarter / period, m=m) ** 2 - 1 + ratio)

    def strain(x: Any) -> Any:
        return mpmath.log(
            1 + b * (mpmath.ellipfun("dn", 2 * quarter * x / period, m=m) ** 2 - ratio)
        )

    def mode(j: int) -> Any:
        wave = lambda x: strain(x) * mpmath.cos(2 * mpmath.pi * j * x / period)  # noqa: E731
        return 2 * mpmath.quad(wave, [0, 3, 6]) / period

    mean, first_mode = (mpmath.nstr(mode, 32) for mode in (mode(0), mode(1)))
    toda = LATTICES["toda"].with_values({"a": 1, "b": 1})
    wave = exact_wave(toda, period=period, mean=mean, first_mode=first_mode)
    assert contains(wave, "speed", ".99093316886473061459")
    assert abs(wave.at([1.0, 2.5]) - [float(strain(1)), float(strain(2.5))]).max() < 1e-14


def test_forces_of_several_neighbours() -> None:
    values = {"K2": 1, "K3": 0, "K4": 1, "L2": "1/4", "L3": 0, "L4": 0}
    wave = exact_wave(LATTICES["next_nearest"].with_values(values), period=10, first_mode="1/20")
    assert contains(wave, "crest", "0.10021782596893196443166")


@pytest.fixture(scope="module")
def certificate() -> dict[str, Any]:
    return dict(exact_wave(chain(k4=1), near="dn", k="3/5", eps="2/25").certificate)


CHANGES: list[tuple[str, Any]] = [
    ("nu", "0.9"),
    ("bits", 8),
    ("bits", 128.0),
    ("weight", "0"),
    ("weight", "-1"),
    ("radius", "0"),
    ("radius", "-1e-20"),
    ("radius", "1e-3"),
    ("radius", "nan"),
    ("radius", 1e-20),
    ("speed_squared", "-1"),
    ("speed_squared", "1.1"),
    ("kind", "theorem"),
    ("version", 2),
    ("modes", []),
    ("unknown", "1"),
    ("near", {"form": "cn", "k": "3/5", "eps": "2/25"}),
    ("near", {"form": "dn", "k": "3/5", "eps": "2/25", "K4": "1"}),
    ("near", {"form": "dn", "k": "1", "eps": "2/25"}),
    ("period", "18"),
    ("lattice", {"springs": [{"neighbour": 1, "force": "r + 2*r**3"}]}),
    ("lattice", {"springs": [{"neighbour": 1, "force": "r - r**3"}]}),
    ("lattice", {"springs": [{"neighbour": 1, "force": "r + r**2 + r**3"}]}),
    ("lattice", {"springs": []}),
    ("claims", {"sped": ["0", "2"]}),
    ("claims", {"speed": ["1.1", "1.2"]}),
    ("claims", {"distance": ["1.0667428e-4", "1.07e-4"]}),
    ("claims", {"distance": ["0", "1.066743e-4"]}),
]


@pytest.mark.parametrize(("key", "value"), CHANGES)
def test_a_changed_certificate_is_refused(
    certificate: dict[str, Any], key: str, value: object
) -> None:
    """Catches a hypothesis that is not tested, and a claim that goes unchecked."""
    changed = {**copy.deepcopy(certificate), key: value}
    with pytest.raises(CertificateError):
        check_certificate(changed)


def test_the_certificate_is_accepted_from_its_file(certificate: dict[str, Any]) -> None:
    statement = check_certificate(json.loads(json.dumps(certificate)))
    assert "r**3 + r" in statement
    assert "dn wave" in statement


def test_a_constant_is_no_wave() -> None:
    """Catches f_1 = 0, for which a constant passes every inequality."""
    proof = dict(exact_wave(chain(k3=1), period=15, first_mode="1/50").certificate)
    zero = {**proof, "first_mode": "0", "modes": ["0"] * len(proof["modes"]), "claims": {}}
    with pytest.raises(CertificateError):
        check_certificate(zero)


def test_another_period_needs_its_own_proof() -> None:
    """Catches P/2 and 2 P accepted for P."""
    proof = dict(exact_wave(chain(k3=1), period=15, first_mode="1/50").certificate)
    for period in ("7.5", "30", "15.0001"):
        with pytest.raises(CertificateError):
            check_certificate({**proof, "period": period, "claims": {}})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "one of near, period and speed"),
        ({"period": 12, "speed": 2}, "one of near, period and speed"),
        ({"period": 12}, "first_mode must not be 0"),
        ({"period": 1, "first_mode": "1/10"}, "period must be more than 2"),
        ({"near": "cd", "k": "1/2", "eps": "1/10"}, "near must be one of dn, cn, sn, cnoidal"),
        ({"near": "sn", "k": "1/2", "eps": "1/10"}, "K4 < 0"),
        ({"near": "dn", "k": "2", "eps": "1/10"}, "0 < k < 1"),
    ],
)
def test_arguments_that_state_no_wave(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        exact_wave(chain(k4=1), **arguments)


def test_lattices_outside_the_theorems_are_refused() -> None:
    dimer = LATTICES["mass_dimer"].with_values({"K2": 1, "K3": 0, "K4": 1, "m1": 1, "m2": 2})
    sites = LATTICES["klein_gordon"].with_values({"K2": 1, "g1": 1, "g2": 0, "g3": 1})
    for lattice in (dimer, sites, chain(k4=1).with_losses(site="1/10")):
        assert exact_wave(lattice, period=12, first_mode="1/50").verdict is Existence.REFUSED


def test_a_wave_too_high_for_its_force_is_not_proved() -> None:
    lattice = LATTICES["granular"].with_values({"A": 1, "d": "1/10"})
    wave = exact_wave(lattice, period=10, first_mode="1/4")
    assert wave.verdict is Existence.NOT_PROVED
    assert wave.reason
