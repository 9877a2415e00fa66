"""The catalogue of lattices: its reductions against results found without this program.

What no table of known results holds is checked by plane waves, manufactured waves and the static
stress law (`derive.checks`).
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from sympy import Expr, Integer, Rational, Symbol, expand, simplify, sqrt, symbols

from longwave.derive import (
    LATTICES,
    Lattice,
    Reduction,
    Scaling,
    SlowVariable,
    find_scaling,
    reduce,
)
from longwave.derive.checks import checks_of_reduction
from longwave.derive.lattice import spring
from longwave.derive.lattice_file import read_lattice
from longwave.derive.models.lattices import H2, H3
from longwave.derive.symbols import K2, K3, c, eps, x

C, S = symbols("C S", real=True)
drift = Symbol("v", real=True)
ALONG = (SlowVariable("X", 1, (1, 0), c), SlowVariable("Z", 2, (0, 1), Integer(0)))
OBLIQUE = (SlowVariable("X", 1, (C, S), c), SlowVariable("Z", 2, (-S, C), drift))


def test_numbers_may_be_put_in_beforehand() -> None:
    """Numbers for which dispersion vanishes need a slower time than T = eps^3 t."""
    values = {"K2": "4/3", "K3": "1", "K4": "0", "L2": "-1/12", "L3": "0", "L4": "0"}
    exact = {name: Rational(text) for name, text in values.items()}
    numeric = LATTICES["next_nearest"].with_values(exact)
    [found] = find_scaling(numeric)
    assert (found.pde.kind, found.scaling.amplitude) == ("fifth-order KdV", 4)
    small = exact | {"K2": exact["K2"] + eps**2 / 3, "L2": exact["L2"] - eps**2 / 12}
    [found] = find_scaling(LATTICES["next_nearest"].with_values(small))
    assert found.coefficients().terms == {
        "Y Y_X": 1,
        "Y_XXX": -Rational(1, 24),
        "Y_5X": -Rational(1, 180),
    }


def test_balances_are_found_about_a_mean() -> None:
    values = {"K2": Integer(1), "K3": -Rational(1, 2), "K4": Integer(1)}
    lattice = LATTICES["fput_strain"].with_values(values)
    kinds = {mean: find_scaling(lattice, mean)[0].pde.kind for mean in (0, Rational(1, 6))}
    assert kinds == {0: "KdV", Rational(1, 6): "mKdV"}


@pytest.mark.parametrize("values", [{"K9": Integer(1)}, {"K2": Integer(0)}])
def test_a_value_that_fits_no_constant_is_refused(values: dict[str, Expr]) -> None:
    with pytest.raises(ValueError, match=r"must (be among K2|satisfy K2 > 0)"):
        LATTICES["fput"].with_values(values)


def without(lattice: Lattice, values: dict[Symbol, Expr]) -> Lattice:
    """Return the lattice with values in place of constants."""
    bonds = tuple(replace(bond, force=bond.force.subs(values)) for bond in lattice.bonds)
    return replace(lattice, bonds=bonds)


def test_the_static_stretch_of_the_other_spring_is_slaved() -> None:
    """The effective quadratic term vanishes where K3/K2^3 + H3/H2^3 = 0, not where K3 = 0."""
    reduction = reduce(LATTICES["dimer"], Scaling(0), 4)
    [condition] = reduction.conditions
    assert expand(condition.expression - (H3 * K2**3 + H2**3 * K3)) == 0


KINDS = {
    "fput_strain": ["KdV", "mKdV"],
    "next_nearest": ["KdV", "mKdV", "fifth-order KdV"],
    "next_nearest_degenerate": ["fifth-order KdV"],
    "next_nearest_degenerate_odd": ["fifth-order mKdV"],
    "alpha_fput": ["KdV"],
    "beta_fput": ["mKdV"],
    "mass_dimer": ["KdV", "mKdV"],
    "local_resonators": ["KdV", "mKdV"],
    "toda": ["KdV"],
    "granular": ["KdV", "mKdV"],
    "lennard_jones": ["KdV"],
    "square": ["KP-II", "generalised KP-II"],
}


@pytest.mark.parametrize("name", KINDS)
def test_balances_are_found(name: str) -> None:
    assert {reduction.pde.kind for reduction in find_scaling(LATTICES[name])} >= set(KINDS[name])


def test_a_pinned_lattice_has_no_long_wave() -> None:
    with pytest.raises(ValueError, match=r"no scaling fits klein_gordon: .* \(pinned: "):
        find_scaling(LATTICES["klein_gordon"])


def test_next_nearest_springs_turn_the_kp_equation() -> None:
    """KP-I where the dispersion K2 + 16 L2 is negative."""
    L2 = Symbol("L2", real=True)
    second = spring(L2 * x, ((0, 0), 0), ((2, 0), 0))
    square = LATTICES["square"]
    lattice = replace(square, bonds=(*square.bonds, second))
    reduction = reduce(lattice, Scaling(1, ALONG), 5)
    assert reduction.pde.kind == "KP-I or KP-II"
    found = reduction.coefficients(K2=4, K3=1, H2=1, L2=-Rational(1, 2))
    assert found.dispersive == Rational(4 - 8, 24) / sqrt(2)
    negative = without(lattice, {L2: -K2 / 8})
    assert reduce(negative, Scaling(1, ALONG), 5).pde.kind == "KP-I"


def test_a_transverse_variable_must_drift() -> None:
    still = (OBLIQUE[0], replace(OBLIQUE[1], speed=Integer(0)))
    with pytest.raises(ValueError, match="let the transverse variable drift"):
        reduce(LATTICES["square"], Scaling(0, still), 4)


def test_forces_are_expanded_as_far_as_the_orders_ask() -> None:
    granular = reduce(LATTICES["granular"], Scaling(1))
    A, d = symbols("A d", positive=True)
    found = granular.coefficients()
    assert simplify(found.c**2 - 3 * A * sqrt(d) / 2) == 0
    assert simplify(found.terms["Y Y_X"] + 3 * A / (8 * sqrt(d) * found.c)) == 0
    at = granular.coefficients(A=2, d=9)
    assert at.c == 3
    assert at.terms["Y Y_X"] == -Rational(1, 12)
    with pytest.raises(ValueError, match="constants must be among A, d, got 'F1'"):
        granular.coefficients(F1=1)


def test_toda_has_no_obstruction_and_granular_chains_have() -> None:
    assert reduce(LATTICES["toda"], Scaling(1), 11).obstruction is None
    found = reduce(LATTICES["granular"], Scaling(1), 11).obstruction
    assert found is not None
    assert found[0] == 6


CHECKED = [
    *(("fput_strain", scaling) for scaling in (Scaling(), Scaling(2, background=((0, K3 / 7),)))),
    *((name, Scaling(0)) for name in ("mass_dimer", "dimer", "local_resonators")),
    *((name, Scaling(1)) for name in ("mass_dimer", "local_resonators")),
    *((name, Scaling(1)) for name in ("triatomic", "toda", "granular", "lennard_jones")),
    ("square", Scaling(1, OBLIQUE)),
    ("next_nearest", Scaling(4, time=5)),
    ("next_nearest_degenerate", Scaling(4, time=5)),
    ("next_nearest_degenerate_odd", Scaling(2, time=5)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "scaling"), CHECKED, ids=lambda value: str(value)[:40])
def test_the_lattice_itself_agrees(name: str, scaling: Scaling) -> None:
    orders = scaling.leading_order + (0 if name == "dimer" else 2)
    for check in checks_of_reduction(reduce(LATTICES[name], scaling, orders)):
        assert check.passed, check.text()


def test_a_law_that_depends_on_eps_has_no_static_one(tmp_path: Path) -> None:
    path = tmp_path / "scaled.toml"
    path.write_text(
        """
fields = ["y"]
[[bond]]
stretch = "y[n]"
action = {y = "F[n+1] - 2*F[n] + F[n-1]"}
force = "K2*x + K3*x**2 + eps*K4*x**3"
"""
    )
    found = checks_of_reduction(reduce(read_lattice(path), Scaling(2), 6))
    assert [check.name for check in found] == ["dispersion determinant", "manufactured wave"]
    assert all(check.passed for check in found)


def tampered(reduction: Reduction, change: str) -> Reduction:
    """Return the reduction with a relative error of 1/100 in one of its parts."""
    factor = reduction.pde.flow.field(101) / 100
    if change == "slaved":
        share, series = reduction.slaved["v"]
        wrong = replace(series, parts={o: factor * p for o, p in series.parts.items()})
        return replace(reduction, slaved={**reduction.slaved, "v": (share, wrong)})
    if change == "flow":
        return replace(reduction, pde=replace(reduction.pde, flow=factor * reduction.pde.flow))
    order, equation = next(
        item for item in reduction.orders.items() if len(item[1].polynomial.terms) > 1
    )
    wrong_order = replace(equation, polynomial=factor * equation.polynomial)
    return replace(reduction, orders={**reduction.orders, order: wrong_order})


@pytest.mark.parametrize(("change", "names"), [
    ("slaved", ["manufactured wave"]),
    ("flow", ["static stress law"]),
    ("order", ["dispersion determinant", "manufactured wave"]),
])  # fmt: skip
def test_a_mistake_is_detected(change: str, names: list[str]) -> None:
    reduction = tampered(reduce(LATTICES["mass_dimer"], Scaling(1)), change)
    differing = [check.name for check in checks_of_reduction(reduction) if not check.passed]
    assert differing == names


def test_units_are_stated() -> None:
    assert reduce(LATTICES["mass_dimer"], Scaling(0), 4).units.startswith("Y = W_X: u is W")
    assert "less its mean" in reduce(LATTICES["fput_strain"]).units


def test_small_constants_are_data() -> None:
    """K3 = eps k3 in the displacement: the Gardner equation."""
    k3: Any = Symbol("k3", real=True)
    lattice = without(LATTICES["fput"], {K3: eps * k3})
    reduction = reduce(lattice, Scaling(0), 4)
    assert reduction.pde.kind == "Gardner"
    assert reduction.coefficients().terms["Y Y_X"].subs(c, sqrt(K2)) == k3 / sqrt(K2)
