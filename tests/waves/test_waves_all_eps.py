"""The tie to the modified KdV equation for all small eps, and certificates that must be refused."""

import copy
from fractions import Fraction
from typing import Any

import pytest
from flint import fmpq

from longwave.derive import LATTICES
from longwave.waves.exact_wave import ExactWave, exact_wave, waves_of_all_eps
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.force_text import read_force
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.periodic import Spring
from longwave.waves.periodic_waves import PeriodicProblem, periodic_certificate
from longwave.waves.proved import Existence
from longwave.waves.small_waves import tie_certificate


def tie(form: str, k4: int, k: str, eps: str) -> ExactWave:
    lattice = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": k4})
    return waves_of_all_eps(lattice, near=form, k=k, eps=eps)


BOUNDS = [
    ("dn", 1, "3/5", "1/10", (0.01566, 0.01740)),
    ("cn", 1, "4/5", "1/10", (0.1465, 0.1589)),
    ("sn", -1, "2/5", "3/20", (0.00922, 0.00964)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("form", "k4", "k", "eps", "expected"), BOUNDS)
def test_the_distance_is_of_third_order(
    form: str, k4: int, k: str, eps: str, expected: tuple[float, float]
) -> None:
    wave = tie(form, k4, k, eps)
    assert wave.verdict is Existence.EXISTS
    interval = wave.numbers["distance_over_eps3"]
    assert expected[0] < float(interval.lower) < float(interval.upper) < expected[1]
    assert f"For every 0 < eps <= {eps}" in wave.statement


@pytest.mark.slow
@pytest.mark.parametrize("eps", ["1/50", "1/25", "2/25"])
def test_a_wave_of_one_eps_is_within_the_bounds_of_all(eps: str) -> None:
    """Catches a bound that does not hold: single waves are proved by other inequalities."""
    bounds = tie("dn", 1, "3/5", "1/10").numbers
    lattice = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": 1})
    wave = exact_wave(lattice, near="dn", k="3/5", eps=eps)
    value = {"1/50": 0.02, "1/25": 0.04, "2/25": 0.08}[eps]
    assert wave.distance is not None
    distance = wave.distance.value / value**2
    assert float(bounds["distance_over_eps3"].lower) < distance
    assert distance < float(bounds["distance_over_eps3"].upper)
    sigma = (2 - 0.36) / 2
    change = abs(wave.speed.value**2 - 1 - sigma * value**2) / value**4
    assert change < float(bounds["speed_over_eps4"].upper)


@pytest.fixture(scope="module")
def certificate() -> dict[str, Any]:
    return dict(tie("dn", 1, "3/5", "1/10").certificate)


@pytest.mark.slow
def test_a_changed_certificate_is_refused(certificate: dict[str, Any]) -> None:
    pieces = certificate["pieces"]
    half = [{**pieces[0], "bound": str(float(pieces[0]["bound"]) / 2)}, *pieces[1:]]
    changes: list[dict[str, Any]] = [
        {"eps": "1/9"},
        {"eps": "0"},
        {"eps": "-1/10"},
        {"weight": "0"},
        {"pieces": pieces[:-1]},
        {"pieces": pieces[1:]},
        {"pieces": [*pieces[:3], *pieces[4:]]},
        {"pieces": pieces[::-1]},
        {"pieces": []},
        {"pieces": half},
        {"near": {"form": "cn", "k": "3/5"}},
        {"near": {"form": "dn", "k": "7/10"}},
        {"near": {"form": "dn", "k": "3/5", "eps": "1/10"}},
        {"lattice": {"springs": [{"neighbour": 1, "force": "r + 2*r**3 + r**5"}]}},
        {"lattice": {"springs": [{"neighbour": 1, "force": "r + r**2 + r**3"}]}},
        {"lattice": {"springs": [{"neighbour": 1, "force": "r + r**3 + r**4"}]}},
        {"lattice": {"springs": [{"neighbour": 1, "force": "r + r**3 + exp(r)"}]}},
        {"claims": {"distance_over_eps3": ["0.0162", "0.02"]}},
        {"claims": {"distance_over_eps3": ["0.01", "0.016"]}},
    ]
    for change in changes:
        with pytest.raises(CertificateError):
            check_certificate({**copy.deepcopy(certificate), **change})


def test_a_large_eps_is_not_proved() -> None:
    assert tie("cn", 1, "4/5", "3/2").verdict is Existence.NOT_PROVED


KDV = [
    ("1", "0", "3/5"),
    pytest.param("1", "1", "9/10", marks=pytest.mark.slow),
    pytest.param("-1", "0", "99/100", marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("k3", "k4", "k"), KDV)
def test_kdv_cnoidal_waves_are_within_the_bounds_of_all_eps(k3: str, k4: str, k: str) -> None:
    """Catches a wrong bound of G_1 or of a tail: single waves are proved by other inequalities."""
    lattice = LATTICES["fput_strain"].with_values({"K2": 1, "K3": k3, "K4": k4})
    bounds = waves_of_all_eps(lattice, near="cnoidal", k=k, eps="1/10").numbers
    distance = bounds["distance_over_eps4"]
    assert float(distance.upper) < 1.04 * float(distance.lower)
    sigma = (2 * float(Fraction(k)) ** 2 - 1) / 3
    for eps in ("1/50", "1/20", "1/10"):
        wave, value = exact_wave(lattice, near="cnoidal", k=k, eps=eps), float(Fraction(eps))
        assert wave.distance is not None
        assert float(distance.lower) < wave.distance.value / value**2 < float(distance.upper)
        change = abs(wave.speed.value**2 - 1 - sigma * value**2) / value**4
        assert change < float(bounds["speed_over_eps4"].upper)


def test_a_fifth_power_changes_the_distance_as_single_waves_do() -> None:
    springs = [{"neighbour": 1, "force": "r + r**3 + 2*r**5"}]
    spring = Spring(1, read_force(springs[0]["force"]))
    claims = tie_certificate(spring, "dn", fmpq(3, 5), fmpq(1, 10))["claims"]
    problem = PeriodicProblem.near_elliptic((spring,), "dn", fmpq(3, 5), fmpq(1, 20))
    low, high = map(float, periodic_certificate(problem, 1e-10)["claims"]["distance"])
    least, most = map(float, claims["distance_over_eps3"])
    assert least < low * 400 <= high * 400 < most
    assert most < 0.016  # without the fifth power it is at least 0.01615


def test_a_force_with_even_powers_has_no_mkdv_tie() -> None:
    spring = Spring(1, read_force("r + r**3 + r**4"))
    with pytest.raises(CertificateError, match="odd powers"):
        tie_certificate(spring, "dn", fmpq(3, 5), fmpq(1, 10))
