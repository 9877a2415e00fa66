"""Losses of sites and bonds: where they enter, where they are refused, and the checks of them."""

import cmath
from dataclasses import replace
from math import isnan
from typing import Any

import pytest
from sympy import Integer, pi

from longwave.derive import (
    LATTICES,
    EnvelopeError,
    Lattice,
    ReductionError,
    Scaling,
    Stencil,
    checks_of_envelope,
    checks_of_reduction,
    dispersion_relation,
    envelope,
    find_scaling,
    on_site,
    reduce,
)
from longwave.derive.__main__ import main
from longwave.derive.dispersion import agrees_with_reduction
from longwave.derive.symbols import eps, k, x, ybar

LOSSES = {"site": "eps^3*gamma", "bond": "eps*eta"}
STRAIN, ALPHA, DIMER = (LATTICES[name] for name in ("fput_strain", "alpha_fput", "mass_dimer"))


def test_a_lattice_without_losses_is_what_it_was() -> None:
    """The text of all lattices would get a term ``+ 0 x'`` otherwise."""
    for lattice in LATTICES.values():
        assert lattice.with_losses() == lattice == lattice.with_losses(site=0, bond="0")
        assert lattice.with_losses(**LOSSES).with_losses() == lattice


def test_the_equation_of_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fput_strain", "--losses", "site=eps^3*gamma,bond=eps*eta"]) == 0
    out = capsys.readouterr().out
    for line in (
        "  y_n'' = F(y_{n+1}) - 2 F(y_n) + F(y_{n-1}) - eps^3 gamma y_n'",
        "  F(x) = K2 x + K3 x^2 + K4 x^3 + eps eta x'",
        "  Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX + (gamma/2) Y - (eta/2) Y_XX = 0",
    ):
        assert line in out.splitlines()


@pytest.mark.parametrize("amplitude", [0, 1])
def test_strain_and_displacement_have_one_equation(amplitude: int) -> None:
    """A strain feels what the losses of the two displacements leave: D of the dashpots' forces."""
    moved = reduce(LATTICES["fput"].with_losses(**LOSSES), Scaling(amplitude))
    strained = reduce(STRAIN.with_losses(**LOSSES), Scaling(amplitude + 1))
    assert moved.pde.text() == strained.pde.text()
    assert "- (eta/2) Y_XX" in moved.pde.text()


@pytest.mark.parametrize(
    ("lattice", "losses"),
    [
        (STRAIN, LOSSES),
        (DIMER, {"site": {"v": "eps^3*gamma"}, "bond": {2: "eps*eta"}}),
        (LATTICES["local_resonators"], {"bond": {1: "eps*eta", 2: "theta"}}),
        pytest.param(LATTICES["square"], LOSSES, marks=pytest.mark.slow),
        (ALPHA, {"bond": "eta"}),
    ],
)
def test_the_checks_know_losses(lattice: Lattice, losses: dict[str, Any]) -> None:
    found = find_scaling(lattice.with_losses(**losses))[0]
    checks = checks_of_reduction(found)
    assert all(check.passed for check in checks), [check.text() for check in checks]
    assert ("complex frequency" in [check.name for check in checks]) == (lattice.dimension == 1)


@pytest.mark.parametrize("name", ["alpha_fput", "next_nearest", "klein_gordon", "granular"])
def test_the_complex_frequency_is_a_root_of_the_lattice(name: str) -> None:
    """A wave exp(i (k n - omega t)) put into the equations of motion, with losses of order one.

    A tie to the site has a dashpot here, too.
    """
    lattice = LATTICES[name].with_losses(site="gamma/8", bond="eta/8")
    bonds = (replace(bond, loss=lattice.bonds[0].loss) for bond in lattice.bonds)
    lattice = replace(lattice, bonds=tuple(bonds))
    at = {symbol: 1 + i / 8 for i, symbol in enumerate(lattice.constants)} | {k: 0.7, ybar: 0}
    omega = complex(dispersion_relation(lattice).omega.subs(at))
    forces = sum(
        (complex(bond.stiffness(Integer(0)).subs(at)) - 1j * omega * float(bond.loss.subs(at)))
        * entry.weight * part.weight * cmath.exp(0.7j * (entry.shift[0] + part.shift[0]))
        for bond in lattice.bonds for entry in bond.action for part in bond.stretch
    )  # fmt: skip
    [site] = lattice.losses
    assert omega.imag < 0 < omega.real
    assert -(omega**2) == pytest.approx(forces + 1j * omega * float(site.subs(at)), rel=1e-12)


@pytest.mark.parametrize(
    ("lattice", "scaling"),
    [(STRAIN, Scaling()), (ALPHA, Scaling(1))],
)
def test_linear_waves_of_lattice_and_equation_agree(lattice: Lattice, scaling: Scaling) -> None:
    found = reduce(lattice.with_losses(**LOSSES), scaling, scaling.leading_order)
    assert agrees_with_reduction(found.lattice, found)
    for other in ({"site": "2*eps^3*gamma"}, {"bond": "3*eps*eta"}, {"bond": 0}):
        assert not agrees_with_reduction(lattice.with_losses(**{**LOSSES, **other}), found)


def test_finite_losses_have_frequencies_without_an_equation(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["alpha_fput", "--losses", "site=1/10,bond=eta"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert "  Gamma(k) = 1/10 + 4 eta sin(k/2)^2" in out
    assert "  omega = sqrt(-Gamma(k)^2/4 + 4 K2 sin(k/2)^2) - i Gamma(k)/2" in out
    assert out[-1].startswith("no reduced equation: no scaling fits alpha_fput: site loss must")
    assert main(["mass_dimer", "--losses", "site=1/10"]) == 2


def test_frequencies_are_printed_with_losses(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["granular", "--losses", "bond=eps*eta", "--order", "5"]) == 0
    out = capsys.readouterr().out
    assert "  omega = sqrt(6) sqrt(A) d^(1/4) sin(k/2) - i Gamma(k)/2 + O(Gamma(k)^2)" in out
    assert "- i (eps eta k^2/2) of long waves" in out
    assert "  same as the reduced equation's linear part: yes" in out


@pytest.mark.parametrize("losses", [{"site": "2*eps^3*gamma"}, {"bond": "3*eps*eta"}])
def test_the_checks_detect_other_losses(losses: dict[str, str]) -> None:
    """The checks read the lattice: one whose losses are not those of the equation differs."""
    found = reduce(ALPHA.with_losses(**LOSSES), Scaling(1), 5)
    other = replace(found, lattice=ALPHA.with_losses(**{**LOSSES, **losses}))
    failed = [check.name for check in checks_of_reduction(other) if not check.passed]
    assert failed == ["dispersion determinant", "manufactured wave", "complex frequency"]


@pytest.mark.parametrize(
    ("losses", "words"),
    [
        (
            {"site": "eps^2*gamma"},
            r"equation, eps\^5, got eps\^2 gamma, which dominates at eps\^4 \(write eps\^3 times a "
            r"constant, or take T = eps\^2 t\)",
        ),
        ({"bond": "eta"}, r"got eta, which dominates at eps\^4 \(write eps times a constant, or"),
        ({"site": 1}, r"got 1, which dominates at eps\^2 \(write eps\^3 times a constant\)"),
    ],
)
def test_losses_that_dominate_are_refused(losses: dict[str, str], words: str) -> None:
    with pytest.raises(ReductionError, match=words):
        reduce(STRAIN.with_losses(**losses))


def test_a_dashpot_of_a_tie_is_refused_as_a_loss() -> None:
    """A tie that is declared with one: the linear term Y_X is of a bond, no site has a loss."""
    tied = replace(ALPHA, bonds=(*ALPHA.bonds, replace(on_site(Integer(0) * x), loss=eps**2)))
    with pytest.raises(ReductionError, match=r"bond loss must enter at .* got eps\^2, which"):
        reduce(tied, Scaling(1))


def test_losses_of_later_orders_are_reported(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fput_strain", "--losses", "site=eps^4*gamma,bond=eps*eta"]) == 0
    out = capsys.readouterr().out
    assert "  site loss eps^4 gamma does not enter at this order" in out.splitlines()
    assert "bond loss" not in out


def test_a_tie_to_the_site_has_no_dashpot() -> None:
    """Its dashpot is the site's loss; a spring inside of a cell has one of its own."""
    tied = LATTICES["klein_gordon"].with_losses(bond="eta")
    assert [bool(bond.loss) for bond in tied.bonds] == [True, False]
    inner = LATTICES["local_resonators"].with_losses(bond="eta")
    assert [bool(bond.loss) for bond in inner.bonds] == [True, True]


def test_constants_of_losses_have_values() -> None:
    damped = ALPHA.with_losses(site="eps^3*gamma*K2")
    found = reduce(damped, Scaling(1)).coefficients(K2=4, K3=1, gamma="1/2")
    assert found.terms["Y"] == 1
    assert str(damped.with_values({"gamma": 3}).losses) == "(3*K2*eps**3,)"


@pytest.mark.parametrize(
    ("losses", "words"),
    [
        ("site=-1", "site must satisfy site >= 0, got -1"),
        ("bond=eps*x", "constants must have names other than"),
        ("bond=1/eps", "bond must be a rational function of symbols and a polynomial in eps"),
        ("bond=eps+", "bond: expected a number, a name or '('"),
        ("bond=__import__", "bond: "),
        ("drag=1", "--losses must name site and bond"),
        ("site=1,site.u=2", "each once, got 'site.u'"),
        ("site.w=1", "site must be a loss of u, v, got one of 'w'"),
        ("bond.3=1", "bond must be a loss of 1, 2, got one of '3'"),
        ("site", "--losses must be NAME=VALUE, got 'site'"),
    ],
)
def test_wrong_losses_are_one_line(
    losses: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["mass_dimer", "--losses", losses]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert words in err


ENVELOPE = {"site": "eps^2*gamma", "bond": "eps^2*eta"}


@pytest.mark.parametrize("name", ["fput_strain", "fput", "klein_gordon", "granular"])
def test_an_envelope_of_equal_masses_decays_at_half_the_loss(name: str) -> None:
    """Site losses alone; the other coefficients stay those without them."""
    found = envelope(LATTICES[name].with_losses(site="eps^2*gamma")).expressions
    assert str(found["loss"]) == "gamma/2"
    bare = envelope(LATTICES[name]).expressions
    assert all(found[key] == bare[key] for key in ("v", "p", "q", "mean", "second", "detuning"))
    assert "a3" not in found


def test_a_dashpot_damps_by_the_rate_of_its_stretch() -> None:
    found = envelope(STRAIN.with_losses(bond="eps^2*eta"), k=pi / 2)
    assert str(found.expressions["loss"]) == "eta"
    numbers = found.coefficients(K2=1, K3=0, K4=1, eta="1/4")
    assert numbers.loss == 0.25
    assert isnan(numbers.a3)
    with pytest.raises(ValueError, match="must have no losses for a normal form"):
        found.normal_form(K2=1, K3=0, K4=1, eta=1)


@pytest.mark.parametrize("branch", ["acoustic", "optical"])
def test_the_envelope_decays_as_the_lattice(branch: str) -> None:
    """Only one of the two masses is damped, so that each branch has its own rate."""
    lattice = DIMER.with_losses(site={"u": "eps^2*gamma"}, bond={2: "eps^2*eta"})
    given = {name: i for i, name in enumerate(("K2", "K3", "K4", "m1", "m2"), 1)}
    found = envelope(lattice, branch=branch, **given)
    assert [check.passed for check in checks_of_envelope(found)] == [True, True]
    vars(found)["parts"] = {**found.parts, "loss": found.parts["loss"] * 2}
    assert [check.passed for check in checks_of_envelope(found)] == [False, True]


def test_losses_of_an_envelope_have_an_order(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(EnvelopeError, match=r"got eps gamma, which dominates at eps\^2 \(write"):
        envelope(STRAIN.with_losses(site="eps*gamma"))
    losses = "site=eps^2*gamma,bond=eps^3*eta"
    assert main(["fput_strain", "--envelope", "k=pi", "--losses", losses]) == 0
    out = capsys.readouterr().out.splitlines()
    assert "i A_T + p A_XX + q |A|^2 A + i loss A = 0 at k = pi:" in out
    assert "  bond loss eps^3 eta does not enter at this order" in out
    assert "  loss = gamma/2" in out


def test_odd_terms_without_losses_are_refused_as_they_were() -> None:
    """A force without reaction has them, too; no loss is to be named then."""
    one_sided = replace(STRAIN.bonds[0], action=(Stencil((1,)), Stencil((0,), -1)))
    with pytest.raises(ReductionError, match=r"order eps\^2 must be a multiple of Y_XX alone"):
        reduce(replace(STRAIN, bonds=(one_sided,)))
