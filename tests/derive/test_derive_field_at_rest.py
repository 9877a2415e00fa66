"""Carriers at k = 0 and pi, and fields at rest there, against hand calculations."""

import json
from typing import Any

import pytest
from sympy import Rational, Symbol, pi, simplify

from longwave.derive import LATTICES, EnvelopeError, envelope
from longwave.derive.__main__ import main
from longwave.derive.carrier_numbers import carrier_fields
from longwave.derive.lattice_file import lattice_of
from longwave.derive.sines import omega
from searches.carriers import judged, random_case
from tests.families import family

DIMER = lattice_of(
    {
        "fields": ["u", "v"],
        "masses": ["m", "m"],
        "positive": ["C", "D", "m"],
        "spring": [
            {"between": ["u[n]", "v[n]"], "force": "C*x + g*x**3"},
            {"between": ["v[n]", "u[n+1]"], "force": "D*x + g*x**3"},
        ],
    }
)
"""Equal masses: at k = pi the branches are v = -u and v = u, omega^2 = 2 C and 2 D."""

AT_PI = {
    "acoustic": (1.4142135623730951, -0.2209708691207961, -8.485281374238571),
    "optical": (3.1622776601683795, 0.0988211768802619, -3.794733192202055),
}
"""omega, p, q where C and D are 1 and 5 in either order; u has amplitude 1 in both."""


@pytest.mark.parametrize("branch", AT_PI)
@pytest.mark.parametrize("order", [(1, 5), (5, 1)])
def test_both_branches_of_equal_masses_are_given_at_the_zone_boundary(
    branch: str, order: tuple[int, int]
) -> None:
    """Catches: formulas of one branch evaluated on the other, where they are 0/0."""
    values: Any = {"C": order[0], "D": order[1], "m": 1, "g": 1}
    for found in (
        envelope(DIMER, k=pi, branch=branch, **values).coefficients(**values),
        envelope(DIMER, k=pi, branch=branch).coefficients(**values),
        envelope(DIMER, **values).coefficients(pi, branch, **values),
    ):
        assert (found.omega, found.p, found.q) == pytest.approx(AT_PI[branch], rel=1e-12)
        assert found.v == 0


def test_a_carrier_that_leaves_the_first_field_at_rest_is_that_of_the_next(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Masses between others at rest: m v'' = -2 K2 v - 2 K4 v^3 is Duffing's oscillator."""
    numbers = "m1=1,m2=4,K2=1,K3=0,K4=1"
    words = ["mass_dimer", "--envelope", "k=pi", "--set", numbers, "--branch"]
    assert main([*words, "acoustic", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["numbers"]
    own = (2 / 4) ** 0.5
    assert found["omega"] == pytest.approx(own, rel=1e-14)
    assert found["q"] == pytest.approx(-3 / (4 * own), rel=1e-12)
    assert main([*words, "acoustic"]) == 0
    assert "carrier: v_n = eps A(X, T)" in capsys.readouterr().out
    assert main([*words, "optical"]) == 0
    assert "carrier: u_n = eps A(X, T)" in capsys.readouterr().out
    values: Any = {"m1": 1, "m2": 4, "K2": 1, "K3": 0, "K4": 1}
    fields = carrier_fields(envelope(LATTICES["mass_dimer"], k=pi, **values), **values)
    leading = [[t.value for t in part if (t.power, t.harmonic) == (1, 1)] for part in fields.parts]
    assert leading == [[], [1]]


def test_a_true_resonance_at_the_zone_boundary_is_reported_as_one(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """2 omega(pi) = omega(2 pi) of the optical branch where one mass is three times the other."""
    numbers = "m1=1,m2=3,K2=1,K3=0,K4=1"
    assert main(["mass_dimer", "--envelope", "k=pi", "--set", numbers]) == 2
    assert "where 4 omega(k)^2 = omega(2k)^2" in capsys.readouterr().err


def test_formulas_at_the_zone_boundary_say_of_which_wave_they_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Catches: formulas of one wave under the name of a branch that depends on the constants."""
    output = []
    for branch in ("acoustic", "optical"):
        assert main(["mass_dimer", "--envelope", "k=pi", "--branch", branch]) == 0
        output.append(capsys.readouterr().out)
    assert "carrier: u_n = " in output[0]
    assert "of the wave with omega^2 = 2 K2/m1, one of 2" in output[0]
    assert "carrier: v_n = " in output[1]
    assert "of the wave with omega^2 = 2 K2/m2, one of 2" in output[1]


@pytest.mark.parametrize("name", ["klein_gordon", "pinned dimer", "optical"])
def test_at_k_zero_the_envelope_is_the_limit(name: str) -> None:
    """Catches: an oscillation in step refused, or a pole left in what is regular there."""
    pinned = {
        "fields": ["u", "v"],
        "masses": ["1", "3"],
        "spring": [
            {"between": ["u[n]", "v[n]"], "force": "x + x**2"},
            {"between": ["v[n]", "u[n+1]"], "force": "2*x - x**3"},
        ],
        "site": [{"field": "u", "force": "x/3 + x**2 + x**3"}],
    }
    lattice, values, branch = {
        "klein_gordon": (LATTICES["klein_gordon"], {"K2": 1, "g1": 2, "g2": 1, "g3": 1}, 0),
        "pinned dimer": (lattice_of(pinned), {}, 0),
        "optical": (LATTICES["mass_dimer"], {"m1": 1, "m2": 4, "K2": 1, "K3": 1, "K4": 1}, 1),
    }[name]
    given: Any = values
    at = envelope(lattice, k=0, branch=branch, **given).coefficients(**given)
    near = envelope(lattice, branch=branch, **given).coefficients(Rational(1, 10**6), **given)
    for part in ("omega", "v", "p", "q", "mean", "second", "a3", "a1", "a2", "detuning"):
        assert abs(getattr(at, part) - getattr(near, part)) < 1e-4, part
    assert at.v == at.a3 == 0


def test_formulas_at_k_zero_are_those_of_a_single_oscillator() -> None:
    """u'' = -g1 u - g2 u^2 - g3 u^3 in step: Lindstedt's frequency, omega = sqrt(g1)."""
    found = envelope(LATTICES["klein_gordon"], k=0).expressions
    g2, g3 = Symbol("g2", real=True), Symbol("g3", real=True)
    expected = (10 * g2**2 / (3 * omega**2) - 3 * g3) / (2 * omega)
    assert simplify(found["q"] - expected) == 0


def test_a_wave_without_frequency_is_refused_with_what_to_do() -> None:
    refused = r"omega > 0, got omega = 0 at k = 0.* .*--envelope"
    with pytest.raises(EnvelopeError, match=refused):
        envelope(LATTICES["fput"], k=0)
    values: Any = {"m1": 1, "m2": 2, "K2": 1, "K3": 0, "K4": 1}
    found = envelope(LATTICES["mass_dimer"], k=0, **values)
    with pytest.raises(EnvelopeError, match=refused):
        found.coefficients(**values)


@pytest.mark.slow
@pytest.mark.parametrize("words", [["k=1", "--branch", "optical"], ["k", "--order", "3"]])
def test_formulas_beyond_the_budget_ask_for_numbers(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """Catches: minutes of silence, for a formula of hundreds of pages."""
    assert main(["dimer", "--envelope", *words]) == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert error.startswith("error: formulas must have at most 2500 terms, got ")
    assert "give numbers for some of H2, H3, H4, K2, K3, K4, m1, m2, such as H2=1" in error


def test_long_formulas_at_the_zone_boundary_are_given() -> None:
    """Catches: minutes of simplification where nothing is to be simplified."""
    found = envelope(LATTICES["dimer"], k=pi).expressions_of(("v", "p", "q"))
    assert found["v"] == 0


@pytest.mark.parametrize("seed", family((3, 7, 66, 93, 168, 282, 331, 337), quick=(66, 331)))
def test_random_carriers_are_those_of_an_eigenproblem(seed: int) -> None:
    """Springs, masses and wavenumbers that leave fields at rest or branches closed."""
    assert judged(random_case(seed)) == ""
