"""Envelope equations against closed forms found without this program, and against themselves."""

import math
from dataclasses import replace
from typing import Any

import pytest
from sympy import Integer, Rational, Symbol, acos, cos, pi, simplify, sin, sqrt

from longwave.derive import (
    LATTICES,
    EnvelopeError,
    checks_of_envelope,
    envelope,
    modulation_map,
    on_site,
)
from longwave.derive.carrier_envelope import Envelope, omega
from longwave.derive.models.lattices import cubic, g1, g2, g3
from longwave.derive.symbols import K2, k, x
from tests.derive.large_cells import four_masses
from tests.families import family

FPUT = LATTICES["fput_strain"]
s, C = sin(k / 2), cos(k / 2)


@pytest.fixture(scope="module")
def strain() -> Envelope:
    return envelope(FPUT)


@pytest.mark.parametrize("name", ["fput_strain", "fput", "klein_gordon", "toda"])
def test_a_shifted_carrier_gives_the_next_order(name: str) -> None:
    checks = list(checks_of_envelope(envelope(LATTICES[name])))
    assert len(checks) == 3
    assert all(check.passed for check in checks)


def test_a_mistake_in_the_next_order_is_detected(strain: Envelope) -> None:
    broken = replace(strain)
    wrong: dict[str, Any] = {**strain.parts, "a2": strain.parts["a2"] * 101 / 100}
    broken.__dict__["parts"] = wrong
    assert [check.passed for check in checks_of_envelope(broken)] == [True, True, False]


def test_toda_is_defocusing_at_every_wavenumber() -> None:
    """p q = -1/8 in the strain for force exp(x) - 1, and so -omega^2/8 in the displacement."""
    found = envelope(LATTICES["toda"])
    b = Symbol("b", positive=True)
    product = found.expressions["p"] * found.expressions["q"]
    assert simplify(product + omega**2 * b**2 / 8) == 0


@pytest.mark.slow
def test_equal_masses_in_turn_are_a_chain() -> None:
    """Cells of two: wavenumber and space count double, the displacement is the same."""
    constants: Any = {"K2": 1, "K3": Rational(1, 4), "K4": 1}
    chain = envelope(LATTICES["fput"]).coefficients(Rational(1, 2), **constants)
    dimer = envelope(LATTICES["mass_dimer"], m2=1, **constants)
    cells = dimer.coefficients(1, m1=1, m2=1, **constants)
    powers = {"omega": 0, "v": 1, "p": 2, "q": 0, "a3": 3, "a1": 1, "a2": 1, "second": 0}
    for name, power in powers.items():
        got, expected = getattr(cells, name) * 2**power, getattr(chain, name)
        assert abs(got - expected) < 1e-12, name


def test_the_optical_branch_of_a_dimer() -> None:
    """Its frequency and group velocity from the closed dispersion relation."""
    constants: Any = {"K2": 1, "K3": Rational(1, 4), "K4": 1, "m1": 1, "m2": 4}
    found = envelope(LATTICES["mass_dimer"], branch="optical", **constants)
    numbers = found.coefficients(1, "optical", **constants)

    def frequency(wavenumber: float) -> float:
        return math.sqrt(5 / 4 + math.sqrt(25 / 16 - math.sin(wavenumber / 2) ** 2))

    assert abs(numbers.omega - frequency(1)) < 1e-14
    assert abs(numbers.v - (frequency(1.0001) - frequency(0.9999)) / 2e-4) < 1e-7
    acoustic = found.coefficients(1, "acoustic", **constants)
    assert acoustic.omega < 1 < numbers.omega


def test_at_the_zone_boundary_the_next_order_vanishes() -> None:
    found = envelope(FPUT, k=pi)
    assert found.expressions["v"] == found.expressions["a1"] == found.expressions["a2"] == 0
    numbers = found.coefficients(K2=4, K3=1, K4=2)
    assert numbers.p == -0.5
    assert abs(numbers.q - (2 / 4) * (4 / 4 - 6)) < 1e-14
    assert numbers == envelope(FPUT).coefficients(pi, K2=4, K3=1, K4=2)


def test_at_a_wavenumber_the_coefficients_are_those_of_all_wavenumbers(strain: Envelope) -> None:
    found = envelope(FPUT, k=2 * pi / 3)
    for name, value in found.expressions.items():
        assert k not in value.free_symbols
        assert simplify(value - strain.expressions[name].subs(k, 2 * pi / 3)) == 0, name
    assert all(check.passed for check in checks_of_envelope(found))


def test_plane_waves_are_unstable_where_p_q_is_positive() -> None:
    """3 K2 K4 > 2 K3^2 (1 + 1/s^2): only short waves, for these constants."""
    rows = modulation_map(
        FPUT, [Rational(1, 5), 1, 3], amplitude=2.0, K2=1, K3=Rational(1, 4), K4=1
    )
    stable, unstable = rows[0], rows[2]
    assert stable[1] is not None
    assert unstable[1] is not None
    assert stable[2] == 0 < unstable[2] == abs(unstable[1].q) * 4
    assert [wavenumber for wavenumber, _, _ in rows] == [0.2, 1.0, 3.0]


def test_a_modulation_map_is_of_unit_amplitude_unless_another_is_given() -> None:
    values: Any = {"K2": 1, "K3": 0, "K4": 1}
    [(_, numbers, rate)] = modulation_map(FPUT, [3], **values)
    assert numbers is not None
    assert rate == abs(numbers.q) > 0


def test_a_granular_chain_of_equal_beads_has_no_unstable_plane_wave() -> None:
    """For all k, A and d: p q < 0, for its cubic force is negative. So it has no Peregrine wave."""
    found = envelope(LATTICES["granular"])
    constants = dict(found.carrier.lattice.definitions)
    [stiffness] = [value for symbol, value in constants.items() if str(symbol) == "F1"]
    A, d = Symbol("A", positive=True), Symbol("d", positive=True)
    product = found.expressions["p"] * found.expressions["q"]
    product = product.subs(omega, 2 * s * sqrt(stiffness)).subs(constants)
    assert simplify(product + 3 * A * s**2 * (1 + 2 * s**2) / (16 * d ** Rational(3, 2))) == 0
    assert found.coefficients(2, A=1, d=1).is_focusing is False


@pytest.mark.parametrize("K2", [Integer(1), Rational(1, 3)])
def test_a_resonance_is_named(K2: Rational) -> None:
    """omega^2 = 4 K2 sin^2(k/2) + 4 L2 sin^2 k: at k = pi/2, L2 = -K2/4 it is K2, at 2k 4 K2.

    Catches: constants that no float holds, put in to fewer digits than the resonance is sought to.
    """
    lattice = LATTICES["next_nearest"]
    values: Any = {"K2": K2, "K3": 1, "K4": 0, "L2": -K2 / 4, "L3": 0, "L4": 0}
    found = envelope(lattice, **values)
    with pytest.raises(EnvelopeError, match=r"where 4 omega\(k\)\^2 = omega\(2k\)\^2"):
        found.coefficients(pi / 2, **values)
    assert modulation_map(lattice, [pi / 2], **values)[0][1] is None


def test_a_carrier_without_dispersion_is_refused() -> None:
    """p = 0 at one wavenumber of the pinned chain: K2 cos k = v^2."""
    values: Any = {"K2": 1, "g1": 2, "g2": 1, "g3": 1}
    found = envelope(LATTICES["klein_gordon"], **values)
    low, high = Rational(1, 2), Integer(2)
    assert found.coefficients(low, **values).p > 0 > found.coefficients(high, **values).p
    # K2 cos k omega^2 = K2^2 sin^2 k with omega^2 = 4 - 2 cos k
    with pytest.raises(EnvelopeError, match="not be a zero of the dispersion p"):
        found.coefficients(acos(2 - sqrt(3)), **values)


@pytest.mark.parametrize(("name", "at"), [("fput_strain", 1), ("toda", 1)])
def test_a_lattice_in_numbers_has_the_envelope_of_the_one_in_symbols(name: str, at: Any) -> None:
    """It was refused once: nothing was left to solve the dispersion relation for."""
    lattice = LATTICES[name]
    values: Any = {str(symbol): Integer(1 + i) for i, symbol in enumerate(lattice.constants)}
    numeric = envelope(lattice.with_values(values), k=at)
    assert numeric.coefficients() == envelope(lattice, k=at, **values).coefficients(**values)
    assert all(check.passed for check in checks_of_envelope(numeric))
    some = lattice.with_values({n: v for n, v in values.items() if n != "K4"})
    rest: Any = {"K4": values["K4"]} if "K4" in values else {}
    assert envelope(some, k=at).coefficients(**rest) == numeric.coefficients()


def test_a_large_cell_needs_numbers_and_says_so_at_once() -> None:
    """Catches: symbols that take more than a minute without a message."""
    numbers: Any = {"m1": 1, "m2": 2, "m3": 3, "m4": 4, "K2": 1, "K3": Rational(1, 4), "K4": 1}
    with pytest.raises(EnvelopeError, match=r"4 fields must be few, got K2, K3.*as K2=1\)$"):
        envelope(four_masses())
    found = envelope(four_masses(), k=pi, branch="optical", **numbers).coefficients(**numbers)
    assert found.v == 0
    assert found.p * found.q != 0


WRONG: dict[str, tuple[Any, str]] = {
    "k 0": (lambda: envelope(FPUT, k=0), r"omega > 0, got omega = 0 at k = 0 .*long waves"),
    "k 4": (lambda: envelope(FPUT, k=4), "k must satisfy 0 <= k <= pi, got 4"),
    "k text": (lambda: envelope(FPUT, k="pie"), "k: expected a known name, got 'pie'"),
    "branch": (lambda: envelope(FPUT, branch=1), "branch must be acoustic, optical or a number"),
    "branch name": (lambda: envelope(FPUT, branch="upper"), "branch must be acoustic"),
    "lattice": (lambda: envelope("fput"), "lattice must be a Lattice"),
    "axes": (lambda: envelope(LATTICES["square"]), "lattice must have one axis, got 2"),
    "constant": (lambda: envelope(FPUT, K5=1), "constants must be among K2, K3, K4, got 'K5'"),
    "no constant": (lambda: envelope(FPUT).coefficients(1, K2=1), "K3 must be given, got none"),
    "no k": (lambda: envelope(FPUT).coefficients(K2=1, K3=0, K4=1), "k must be given, got none"),
    "unstable": (
        lambda: envelope(LATTICES["klein_gordon"]).coefficients(1, K2=1, g1=-9, g2=0, g3=1),
        "constants must give a real frequency",
    ),
    "sonic vacuum": (
        lambda: envelope(LATTICES["granular"]).coefficients(1, A=1, d=0),
        "d must be positive.*got 0 .*no linear stiffness, a sonic vacuum.*precompress the chain, d",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_carrier_without_envelope_is_refused_in_one_line(name: str) -> None:
    build, message = WRONG[name]
    with pytest.raises(ValueError, match=message) as refused:
        build()
    assert "\n" not in str(refused.value)


def test_a_stiffness_may_be_any_function_of_a_constant() -> None:
    """The dispersion relation is solved for a mass where it is linear in no constant.

    Catches: a lattice refused since a constant enters its stiffness as a square.
    """
    squared = envelope(replace(FPUT, bonds=(replace(FPUT.bonds[0], force=K2**2 * x - x**3),)))
    assert squared.coefficients(1, K2=2) == envelope(FPUT).coefficients(1, K2=4, K3=0, K4=-1)
    assert squared.normal_form(1, K2=2) == envelope(FPUT).normal_form(1, K2=4, K3=0, K4=-1)


def test_outputs(strain: Envelope) -> None:
    assert strain.text().startswith("fput_strain: i A_T + p A_XX + q |A|^2 A = 0, p = -omega/8")
    assert r"i A_T + p A_{XX}" in strain.latex()
    assert str(strain.carrier.fixed) == "K2"
    assert "Envelope(fput_strain" in repr(strain)


def test_a_tie_of_its_own_is_only_data() -> None:
    """The chain with an on-site force of another name is the pinned chain."""
    bonds = (LATTICES["fput"].bonds[0], on_site(cubic(g1, g2, g3)))
    lattice = replace(LATTICES["fput"], bonds=bonds)
    values: Any = {"K2": 1, "g1": 2, "g2": 1, "g3": 1}
    found = envelope(lattice, K3=0, K4=0, **values).coefficients(1, K3=0, K4=0, **values)
    assert found == envelope(LATTICES["klein_gordon"], **values).coefficients(1, **values)


@pytest.mark.parametrize(
    "name", family(["C", "w", "s", "z", "omega", "angle", "mass"], quick=("s", "omega"))
)
def test_a_constant_of_any_name_has_the_same_envelope(name: str) -> None:
    """Catches: a constant taken for the carrier's phase, frequency or sines."""
    renamed = {K2: Symbol(name, positive=True)}
    chain = LATTICES["fput"]
    bonds = tuple(replace(bond, force=bond.force.xreplace(renamed)) for bond in chain.bonds)
    found = envelope(replace(chain, bonds=bonds))
    numbers: dict[str, Any] = {"K3": Rational(1, 3), "K4": 2}
    assert found.coefficients(1, **{name: 3}, **numbers) == envelope(chain).coefficients(
        1, K2=3, **numbers
    )
    assert found.normal_form(1, **{name: 3}, **numbers) == envelope(chain).normal_form(
        1, K2=3, **numbers
    )
    ties = (*chain.bonds, on_site(Symbol(name, positive=True) * x - x**3))
    tied = envelope(replace(chain, bonds=ties))
    known = {Symbol(name, positive=True)}
    assert (omega in tied.expressions["p"].free_symbols - known) is (name != "omega")
