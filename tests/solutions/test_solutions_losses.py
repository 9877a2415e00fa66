"""Waves of lattices with losses: shocks of the catalogue, and the decay of its solitons."""

from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp

from longwave.derive import LATTICES, Reduction, Scaling, reduce
from longwave.derive.amplitude_law import AmplitudeLaw, crest, first_crest, slow_time
from longwave.solutions import Wave, closed_form

LOSSES = {"site": "eps^3*gamma", "bond": "eps*eta"}


def left_side(wave: Wave, reduction: Reduction, values: dict[str, Any], X: Any, T: Any) -> Any:
    """Return ``Y_T + ...`` of the reduced equation at the wave, to 40 digits."""
    with mpmath.workdps(40):
        jets = [mpmath.mpf(jet) for jet in wave.mp_jets(X, T, 3, 40)]
        total = mpmath.mpf(wave.mp(X, T, 40)[2])
        found = reduction.coefficients(**values)
        for name, size in found.terms.items():
            product = mpmath.fprod(jets[jet[0]] for jet in found.monomials[name])
            total += mpmath.mpf(size.evalf(40)) * product
        return total


SHOCKS: list[tuple[str, str, Scaling, dict[str, Any], dict[str, Any]]] = [
    ("kdv_burgers_shock", "alpha_fput", Scaling(1), {"K2": 4, "K3": -3, "eta": "1/5"}, {}),
    (
        "kdv_burgers_shock", "alpha_fput", Scaling(1),
        {"K2": 1, "K3": 1, "eta": "1/4"}, {"U_0": -0.25},
    ),
    (
        "mkdv_burgers_shock", "fput_strain", Scaling(),
        {"K2": 1, "K3": 0, "K4": -2, "eta": "1/8"}, {"kappa": 0.75},
    ),
]  # fmt: skip


@pytest.mark.parametrize(("name", "lattice", "scaling", "values", "parameters"), SHOCKS)
def test_a_lattice_with_dashpots_has_the_shock(
    name: str, lattice: str, scaling: Scaling, values: dict[str, Any], parameters: dict[str, Any]
) -> None:
    damped = LATTICES[lattice].with_losses(bond="eps*eta")
    found = reduce(damped, scaling, scaling.leading_order)
    wave = Wave(closed_form(name), found.normal_form(**values), **parameters)
    for X, T in ((0.0, 0.0), (0.75, -1.5), (-2.0, 3.0)):
        assert abs(left_side(wave, found, values, X, T)) < 1e-35
    stiffer = {**values, "eta": 3}
    assert abs(left_side(wave, found, stiffer, 0.75, -1.5)) > 1e-5


@pytest.mark.parametrize(("name", "lattice", "scaling", "values", "parameters"), SHOCKS)
def test_far_fields_are_where_the_shock_goes(
    name: str, lattice: str, scaling: Scaling, values: dict[str, Any], parameters: dict[str, Any]
) -> None:
    damped = LATTICES[lattice].with_losses(bond="eps*eta")
    form = closed_form(name)
    normal = reduce(damped, scaling, scaling.leading_order).normal_form(**values)
    wave = Wave(form, normal, **parameters)
    at = form.check(parameters)
    for side, X in ((form.far_fields.left, -1e4), (form.far_fields.right, 1e4)):
        expected = float((normal.h * side).xreplace(at))
        assert wave(np.array([X]), 0.0).Y[0] == pytest.approx(expected, abs=1e-13)


def test_dashpots_without_dispersion_of_this_sign_have_no_such_shock() -> None:
    """mKdV-Burgers with K4 > 0: the undercompressive shock is of the other sign."""
    found = reduce(LATTICES["fput_strain"].with_losses(bond="eps*eta"), orders=5)
    normal = found.normal_form(K2=1, K3=0, K4=1, eta=1)
    assert (normal.equation, normal.s, normal.r) == ("mKdV-Burgers", 1, 1)
    with pytest.raises(ValueError, match="r must be -1 for mkdv_burgers_shock, got 1"):
        Wave(closed_form("mkdv_burgers_shock"), normal)


def integrals(wave: Wave) -> tuple[Any, Any, Any]:
    """Return the crest of a soliton, and the integrals of Y^2 and of Y_X^2."""
    reach = [-30.0, -5.0, 0.0, 5.0, 30.0]
    squares = [
        mpmath.quad(lambda X, i=i: float(wave(float(X), 0.0)[i]) ** 2, reach) for i in (0, 1)
    ]
    return float(wave(0.0, 0.0).Y), *squares


@pytest.mark.parametrize(
    ("name", "parameter", "lattice", "scaling", "values"),
    [
        ("kdv_soliton", "kappa", "alpha_fput", Scaling(1), {"K2": 4, "K3": 3}),
        ("soliton_sech", "A", "fput_strain", Scaling(), {"K2": 1, "K3": 0, "K4": 2}),
    ],
)
def test_the_catalogues_solitons_decay_by_the_law(
    name: str, parameter: str, lattice: str, scaling: Scaling, values: dict[str, Any]
) -> None:
    """d/dT of the integral of Y^2 along the family, against what losses take from it."""
    losses = {"gamma": 0.5, "eta": 0.25}
    law = reduce(LATTICES[lattice].with_losses(**LOSSES), scaling, 5).amplitude_law(
        **values, **losses
    )
    bare = reduce(LATTICES[lattice], scaling, 5).normal_form(**values)
    family = [Wave(closed_form(name), bare, **{parameter: size}) for size in (0.999, 1, 1.001)]
    (low, less, _), (middle, squares, slopes), (high, more, _) = map(integrals, family)
    assert law is not None
    rate = float(law.rate.subs(crest, middle))
    gained = rate * (more - less) / (high - low)
    lost = losses["gamma"] * squares + losses["eta"] * slopes
    assert float(-gained) == pytest.approx(float(lost), rel=1e-5)


@pytest.mark.parametrize(("lattice", "scaling"), [("alpha_fput", Scaling(1)), ("fput", Scaling(0))])
@pytest.mark.parametrize("kind", ["site", "bond", "both"])
def test_the_law_is_integrated(lattice: str, scaling: Scaling, kind: str) -> None:
    losses = LOSSES if kind == "both" else {kind: LOSSES[kind]}
    law = reduce(LATTICES[lattice].with_losses(**losses), scaling, 5).amplitude_law()
    assert law is not None
    change = law.solution.diff(slow_time) - law.rate.subs(crest, law.solution)
    assert sp.simplify(change) == 0
    assert law.solution.subs(slow_time, 0) == first_crest


def test_known_rates() -> None:
    """Perturbed inverse scattering gives -2 gamma/3 for KdV, -gamma for mKdV."""
    gamma = sp.Symbol("gamma", positive=True)
    for lattice, scaling, law in (
        ("alpha_fput", Scaling(1), AmplitudeLaw(1, 2 * gamma / 3)),
        ("fput_strain", Scaling(), AmplitudeLaw(2, gamma)),
    ):
        found = reduce(LATTICES[lattice].with_losses(site="eps^3*gamma"), scaling, 5)
        assert found.amplitude_law() == law


def test_waves_without_a_decay_law() -> None:
    strain = LATTICES["fput_strain"]
    assert reduce(strain, orders=5).amplitude_law() is None
    damped = reduce(strain.with_losses(site="eps^3*gamma"), orders=5)
    assert damped.amplitude_law(K2=1, K3=0, K4=-1) is None
    assert damped.amplitude_law(K2=1, K3=0, K4=0) is None
    gardner = strain.with_values({"K3": "eps"}).with_losses(site="eps^3*gamma")
    assert reduce(gardner, orders=5).amplitude_law() is None
