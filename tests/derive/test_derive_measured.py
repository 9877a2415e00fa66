"""Measured constants: the tables of a lattice file, and intervals of what is derived from them."""

import json
import math
from pathlib import Path
from typing import Any

import pytest
from sympy import Abs, Symbol, sqrt

from longwave.derive import LATTICES, lattice_of, read_lattice
from longwave.derive.__main__ import main
from longwave.derive.intervals import HALF_WIDTH, SAMPLE_COUNT, Intervals
from longwave.derive.measured import Measured
from longwave.derive.symbols import K2, K4

Output = pytest.CaptureFixture[str]

CHAIN = """
fields = ["u"]
positive = ["K2"]
spring = [{between = ["u[n]", "u[n+1]"], force = "K2*x + K4*x**3"}]
[constants]
K2 = 1.0021
K4 = 0.5
[covariance]
K2 = {K2 = 1e-4, K4 = -1e-3}
K4 = {K2 = -1e-3, K4 = 0.04}
"""
MEASURED = Measured.of(
    {"K2": 1, "K4": "1/2"}, {"K2": {"K2": 0.01, "K4": 0.005}, "K4": {"K2": 0.005, "K4": 0.04}}
)


def tables(**changed: Any) -> dict[str, Any]:
    spring = {"between": ["u[n]", "u[n+1]"], "force": "K2*x + K4*x**3"}
    one: dict[str, Any] = {"K2": 1.0, "K4": 0.5}
    return {"fields": ["u"], "positive": ["K2"], "spring": [spring], "constants": one} | changed


def test_values_and_covariance_come_with_the_lattice_and_leave_it_in_symbols(
    tmp_path: Path,
) -> None:
    path = tmp_path / "chain.toml"
    path.write_text(CHAIN, "utf-8")
    found = read_lattice(path)
    assert found.bonds == LATTICES["beta_fput"].bonds
    assert found.measured is not None
    assert found.measured.table == {
        "K2": {"K2": 1e-4, "K4": -1e-3},
        "K4": {"K2": -1e-3, "K4": 0.04},
    }
    assert lattice_of(tables()).measured == Measured.of({"K2": 1.0, "K4": 0.5}, {})
    assert LATTICES["beta_fput"].measured is None


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"constants": {"K2": 1, "K5": 2}}, "constants must be among K2, K4, got 'K5'"),
        ({"constants": {"K2": -1}}, "K2 must satisfy K2 > 0, got -1"),
        ({"constants": {"K4": "eps"}}, "K4 must not depend on eps here"),
        ({"constants": {"K4": math.nan}}, "K4 must be a finite real number"),
        ({"constants": [1]}, "constants must be a table by constants' names"),
        ({"covariance": {"K3": {"K3": 1}}}, "must name constants that have a value, got 'K3'"),
        ({"covariance": {"K2": {"K3": 1}}}, "must name constants that have a value, got 'K3'"),
        ({"covariance": {"K2": 0.1}}, r"K2 in \[covariance\] must be a table"),
        ({"covariance": {"K2": {"K2": 1, "K4": 0.1}, "K4": {"K4": 1}}}, "must be symmetric, got 0"),
        ({"covariance": {"K4": {"K4": -1e-3}}}, "a variance at least 0, got -0.001"),
        ({"covariance": {"K4": {"K4": math.nan}}}, "must be a finite number"),
        ({"covariance": {"K4": {"K4": "0.1"}}}, "must be a finite number"),
        ({"covariance": {"K4": {"K4": 10**400}}}, "got an integer of 1329 bits"),
        (
            {"covariance": {"K2": {"K2": 1, "K4": 1}, "K4": {"K2": 1}}},
            "must be 0 where one of them is exact, got 1",
        ),
        (
            {"covariance": {"K2": {"K2": 1, "K4": 1.1}, "K4": {"K2": 1.1, "K4": 1}}},
            "positive semidefinite, got correlations with the eigenvalue -0.1",
        ),
    ],
)
def test_wrong_tables_are_refused(changed: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        lattice_of(tables(**changed))


def test_a_covariance_that_is_only_semidefinite_is_one() -> None:
    found = Measured.of({"K2": 1, "K4": 1}, {"K2": {"K2": 4, "K4": 2}, "K4": {"K2": 2, "K4": 1}})
    assert all(math.isclose(one - 1, 2 * (two - 1), abs_tol=1e-6) for one, two in found.samples(9))


def test_samples_have_the_covariance() -> None:
    """Catches: eigenvectors for their transposes, variances for deviations."""
    rows = MEASURED.samples(20_000, seed=3)
    means = [sum(column) / len(rows) for column in zip(*rows, strict=True)]
    assert means == pytest.approx([1, 0.5], abs=0.005)
    for i in range(2):
        for j in range(2):
            found = sum((r[i] - means[i]) * (r[j] - means[j]) for r in rows) / len(rows)
            assert found == pytest.approx(MEASURED.covariance[i][j], rel=0.05)


def test_derivatives_give_the_deviation_where_they_are_good() -> None:
    found = Intervals(MEASURED, [K2, K4]).of(K4 - K2)
    deviation = math.sqrt(0.01 + 0.04 - 2 * 0.005)
    assert (found.value, found.sampled, found.lost) == (-0.5, False, 0.0)
    assert found.deviation == pytest.approx(deviation, rel=1e-12)
    assert found.ends == pytest.approx(
        (-0.5 - HALF_WIDTH * deviation, -0.5 + HALF_WIDTH * deviation)
    )


def test_samples_are_taken_where_derivatives_are_not_good() -> None:
    """|K4|^(1/2) with K4 = 0.5 +- 0.2: its quantiles are the roots of K4's own."""
    found = Intervals(MEASURED, [K2, K4]).of(sqrt(Abs(K4)))
    assert found.sampled
    expected = [math.sqrt(0.5 + sign * HALF_WIDTH * 0.2) for sign in (-1, 1)]
    assert found.ends == pytest.approx(expected, abs=0.015)
    assert found.by_derivatives[0] == pytest.approx(
        math.sqrt(0.5) - HALF_WIDTH * 0.1 / math.sqrt(0.5)
    )


def test_samples_without_the_number_are_reported() -> None:
    loose = Measured.of({"K4": 0.2}, {"K4": {"K4": 0.04}})
    real = Symbol("K4", real=True)
    found = Intervals(loose, [real]).of(sqrt(real))
    assert found.lost == pytest.approx(0.159, abs=0.01)
    assert "(none at 0.16 of the samples)" in found.text()
    assert SAMPLE_COUNT >= 10_000


def derived(folder: Path, capsys: Output, text: str, *options: str) -> str:
    path = folder / "chain.toml"
    path.write_text(text, "utf-8")
    assert main([str(path), *options]) == 0
    return capsys.readouterr().out


def test_the_command_gives_coefficients_with_intervals(tmp_path: Path, capsys: Output) -> None:
    """c = sqrt(K2): the deviation is that of K2 over 2 sqrt(K2)."""
    printed = derived(tmp_path, capsys, CHAIN)
    assert "coefficients at K2 = 1.0021, K4 = 1/2:\n" in printed
    assert "  c = 1.0010 +- 0.0050, 0.9913 .. 1.0108\n" in printed
    assert "  a = 1.73 +- 0." in printed
    assert "(sampled; by derivatives 1.0" in printed
    data = json.loads(derived(tmp_path, capsys, CHAIN, "--json"))["intervals"]
    assert data["c"]["deviation"] == pytest.approx(0.01 / 2 / math.sqrt(1.0021), rel=1e-12)
    assert (data["c"]["sampled"], data["a"]["sampled"]) == (False, True)
    gradient = (-0.375 / 1.0021**1.5, 1.5 / math.sqrt(1.0021))
    variance = gradient[0] ** 2 * 1e-4 + gradient[1] ** 2 * 0.04
    variance -= 2 * gradient[0] * gradient[1] * 1e-3
    assert data["Y^2 Y_X"]["deviation"] == pytest.approx(math.sqrt(variance), rel=1e-9)


def test_a_value_of_the_command_line_is_exact(tmp_path: Path, capsys: Output) -> None:
    printed = derived(tmp_path, capsys, CHAIN, "--set", "K4=0.7")
    assert "coefficients at K2 = 1.0021, K4 = 7/10:\n" in printed
    data = json.loads(derived(tmp_path, capsys, CHAIN, "--set", "K4=0.7", "--json"))["intervals"]
    assert data["Y^2 Y_X"]["deviation"] == pytest.approx(1.05 * 0.005 / 1.0021**1.5, rel=1e-3)


def test_missing_intervals_have_a_reason(tmp_path: Path, capsys: Output) -> None:
    with_mass = f'masses = ["m"]\n{CHAIN}'
    assert "(no intervals: m has no value)" in derived(tmp_path, capsys, with_mass)
    assert "  c = 1.0010 +- " in derived(tmp_path, capsys, with_mass, "--set", "m=1")
    ring = 'stretch = "y[n]", action = {y = "F[n+1] - 2*F[n] + F[n-1]"}'
    strain = CHAIN.replace('"u"', '"y"').replace('between = ["u[n]", "u[n+1]"]', ring)
    strain = strain.replace("spring", "bond").replace("K4*x**3", "K3*x**2 + K4*x**3")
    printed = derived(tmp_path, capsys, strain, "--set", "K3=0")
    assert "(no intervals: K2, K4 had to be put in before the expansion)" in printed


def test_an_envelope_has_intervals_too(tmp_path: Path, capsys: Output) -> None:
    """At k = pi: omega = 2 sqrt(K2), q = -12 K4/sqrt(K2)."""
    printed = derived(tmp_path, capsys, CHAIN, "--envelope", "k=pi")
    assert "  omega = 2.0021 +- 0.0100, 1.9825 .. 2.0217\n" in printed
    assert "  v = 0\n" in printed
    data = json.loads(derived(tmp_path, capsys, CHAIN, "--envelope", "k=pi", "--json"))
    intervals = data["intervals"]
    assert intervals["q"]["value"] == pytest.approx(data["numbers"]["q"], rel=1e-12)
    gradient = (3 / 1.0021**1.5, -12 / math.sqrt(1.0021))
    variance = gradient[0] ** 2 * 1e-4 + gradient[1] ** 2 * 0.04
    variance -= 2 * gradient[0] * gradient[1] * 1e-3
    assert intervals["q"]["deviation"] == pytest.approx(math.sqrt(variance), rel=1e-9)
    assert intervals["h"]["sampled"]
    given = derived(tmp_path, capsys, CHAIN, "--envelope", "k=pi", "--set", "K2=1,K4=1/2")
    assert "  omega = 2\n" in given
    assert "+-" not in given


def test_several_fields_in_a_cell_have_envelopes_without_intervals(
    tmp_path: Path, capsys: Output
) -> None:
    dimer = CHAIN.replace('["u"]', '["u", "v"]\nmasses = [1, "m"]')
    dimer = dimer.replace('"u[n+1]"', '"v[n]"')
    other = '{between = ["v[n]", "u[n+1]"], force = "K2*x"}'
    dimer = dimer.replace('x**3"}]', f'x**3"}}, {other}]')
    printed = derived(tmp_path, capsys, dimer, "--envelope", "k=2", "--set", "m=3")
    assert "(no intervals: they are for one field in a cell)" in printed
