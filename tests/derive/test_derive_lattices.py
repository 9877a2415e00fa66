"""Reductions of random lattices with one field, against what is known without the expansion.

The static stress law gives all terms without further derivatives: a long wave on the strain E moves
at sqrt(sigma'(E)/m).  A plane wave put into the linear lattice gives all linear terms.
"""

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy import Expr, Integer, Poly, Rational, S, Symbol, cos, expand, log, series, sin, sqrt

from longwave.derive import (
    LATTICES,
    Bond,
    Lattice,
    Reduction,
    ReductionError,
    Scaling,
    SlowVariable,
    Stencil,
    reduce,
)
from longwave.derive.lattice import on_site, spring
from longwave.derive.symbols import K2, K3, K4, X, c, eps, k, x, ybar

FPUT = LATTICES["fput_strain"]
Y = Symbol("Y", real=True)
d, k3, S2 = (Symbol(name, real=True) for name in ("d", "k3", "S2"))
L2, L3, L4 = (Symbol(name, real=True) for name in ("L2", "L3", "L4"))

Forces = Mapping[int, Expr]
"""Range of the springs, in bonds, and their force law."""


def chain(forces: Forces, mass: Expr = S.One) -> Lattice:
    """Return the lattice in the strain: the spring from n to n + r pulls at both its ends."""
    bonds = []
    for reach, force in forces.items():
        stretch = tuple(Stencil((i,)) for i in range(reach))
        ends = {1: 1, 1 - reach: -1, -reach: 1}
        ends[0] = ends.get(0, 0) - 1
        bonds.append(Bond(stretch, force, tuple(Stencil((i,), w) for i, w in ends.items())))
    return Lattice("chain", "chain in the strain", ("y",), (mass,), tuple(bonds))


def stress_slope(forces: Forces, strain: Expr) -> Expr:
    """Return sigma'(E): each spring of range r is stretched by r E and pulls on r cells."""
    return sum(r**2 * force.diff(x).subs(x, r * strain) for r, force in forces.items())


def plane_wave(forces: Forces, strain: Expr) -> Expr:
    """Return m omega^2 of exp(i (k n - omega t)) about a uniform strain."""
    return sum(
        4 * force.diff(x).subs(x, r * strain) * sin(r * k / 2) ** 2 for r, force in forces.items()
    )


class Case(NamedTuple):
    """A random lattice, an ansatz that fits it, and the numbers of its constants."""

    forces: Forces
    mass: Expr
    scaling: Scaling
    mean: Expr
    values: Mapping[str, Expr]


small = st.fractions(-3, 3, max_denominator=4).map(lambda q: Rational(q.numerator, q.denominator))


@st.composite
def cases(draw: Any) -> Case:
    """Draw cases of KdV, mKdV and Gardner scalings, of one or two ranges, in both directions."""
    kind = draw(st.sampled_from(["kdv", "mkdv", "gardner", "mean"]))
    reaches = draw(st.sampled_from([(1,), (1, 2), (1, 3), (2, 3)]))
    quadratic = {"mkdv": Integer(0), "gardner": eps}.get(kind, Integer(1))
    forces = {}
    for reach in reaches:
        slope = K2 if reach == reaches[0] else draw(small)
        forces[reach] = slope * x + draw(small) * quadratic * x**2 + draw(small) * x**3
        forces[reach] += draw(small) * x**5
    mean = draw(small) * (eps if kind in ("gardner", "mkdv") else int(kind == "mean"))
    background = () if kind == "kdv" else ((0, mean),)
    direction = draw(st.sampled_from([1, -1]))
    speed = draw(st.sampled_from([c, -c, Symbol("v", positive=True)]))
    scaling = Scaling(
        amplitude=1 if kind in ("mkdv", "gardner") else 2,
        space=(SlowVariable("X", 1, (direction,), speed),),
        background=background,
    )
    return Case(forces, draw(small.map(abs).filter(bool)), scaling, mean, {"K2": Integer(9)})


def speed_expansion(case: Case, speed: Expr, order: int) -> Expr:
    """Return the speed of a long wave on the background plus eps^p Y, minus c, to ``eps^order``."""
    strain = case.mean + eps**case.scaling.amplitude * Y
    squared = expand(stress_slope(case.forces, strain).subs(K2, case.values["K2"]) / case.mass)
    rest = squared - squared.subs(eps, 0)
    root = speed * (1 + rest / (2 * speed**2) - rest**2 / (8 * speed**4))
    return sum(expand(root - speed).coeff(eps, i) * eps**i for i in range(order + 1))


@pytest.mark.slow
@settings(max_examples=6)
@given(cases())
def test_coefficients_are_those_of_stress_law_and_plane_wave(case: Case) -> None:
    scaling, lattice = case.scaling, chain(case.forces, case.mass)
    zero = case.mean.subs(eps, 0)
    squared = stress_slope(case.forces, zero).subs(eps, 0).subs(K2, case.values["K2"]) / case.mass
    reduction = reduce(lattice, scaling, scaling.leading_order)
    if squared <= 0:
        with pytest.raises(ValueError, match="> 0, got"):
            reduction.coefficients(**case.values)
        return
    found = reduction.coefficients(**case.values)
    assert found.c == sqrt(squared) * (-1 if scaling.speed == -c else 1)
    moving = speed_expansion(case, found.c, scaling.time - 1)
    expected = {power: value for (power,), value in Poly(moving / eps**2, Y).terms() if value != 0}
    names = {0: "Y_X", 1: "Y Y_X", 2: "Y^2 Y_X"}
    terms = {name: value for name, value in found.terms.items() if name != "Y_XXX"}
    assert set(terms) == {names[power] for power in expected}
    for power, value in expected.items():
        assert expand(terms[names[power]] - value) == 0
    waves = series(plane_wave(case.forces, zero).subs(eps, 0).subs(K2, 9), k, 0, 6).removeO()
    fourth = expand(waves).coeff(k, 4) / case.mass
    assert expand(found.dispersive + fourth / (2 * found.c)) == 0


def outputs(reduction: Reduction, **values: Expr) -> dict[str, Any]:
    """Return all outputs of a reduction, parsed where they can be."""
    data = json.loads(reduction.json(**values))
    assert reduction.latex(**values).startswith(r"\begin{aligned}")
    assert reduction.pde.text() in reduction.text()
    terms = reduction.coefficients(**values).terms
    assert set(data["coefficients"]["terms"]) == set(terms)
    return data


cubic = K2 * x + K3 * x**2 + K4 * x**3
odd = K2 * x + K4 * x**3
second = L2 * x + L3 * x**2 + L4 * x**3
vanishing = {  # K2 + 16 L2 = eps^2 d, K2 + 4 L2 = S2
    1: (4 * S2 - eps**2 * d) / 3 * x + K3 * x**2 + K4 * x**3,
    2: (eps**2 * d - S2) / 12 * x + L3 * x**2 + L4 * x**3,
}
vanishing_odd = {1: vanishing[1].subs(K3, 0), 2: vanishing[2].subs(L3, 0)}

TABLE = {
    "mKdV": ({1: odd}, Scaling(), 7, "Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX = 0"),
    "KdV": ({1: cubic}, Scaling(2), 8, "Y_T + (K3/c) Y Y_X + (c/24) Y_XXX = 0"),
    "small K3": (
        {1: K2 * x + eps * k3 * x**2 + K4 * x**3},
        Scaling(),
        7,
        "Y_T + (3 K4/(2 c)) Y^2 Y_X + (k3/c) Y Y_X + (c/24) Y_XXX = 0",
    ),
    "mean": (
        {1: cubic},
        Scaling(2, background=((0, ybar),)),
        7,
        "Y_T + ((K3 + 3 K4 ybar)/c) Y Y_X + (c/24) Y_XXX = 0",
    ),
    "inflection": (
        {1: cubic},
        Scaling(background=((0, -K3 / (3 * K4)),)),
        7,
        "Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX = 0",
    ),
    "small mean": (
        {1: odd},
        Scaling(background=((1, ybar),)),
        7,
        "Y_T + (3 K4/(2 c)) Y^2 Y_X + (3 K4 ybar/c) Y Y_X + (3 K4 ybar^2/(2 c)) Y_X "
        "+ (c/24) Y_XXX = 0",
    ),
    "small mean by eps": (
        {1: odd},
        Scaling(background=((0, eps * ybar),)),
        7,
        "Y_T + (3 K4/(2 c)) Y^2 Y_X + (3 K4 ybar/c) Y Y_X + (3 K4 ybar^2/(2 c)) Y_X "
        "+ (c/24) Y_XXX = 0",
    ),
    "next neighbours": (
        {1: cubic, 2: second},
        Scaling(2),
        7,
        "Y_T + ((K3 + 8 L3)/c) Y Y_X + ((c^2 + 12 L2)/(24 c)) Y_XXX = 0",
    ),
    "no dispersion": (
        {1: cubic, 2: second.subs(L2, -K2 / 16)},
        Scaling(4, time=5),
        10,
        "Y_T + ((K3 + 8 L3)/c) Y Y_X - (c/180) Y_5X = 0",
    ),
    "no dispersion, cubic": (
        {1: odd, 2: second.subs({L2: -K2 / 16, L3: 0})},
        Scaling(2, time=5),
        8,
        "Y_T + (3 (K4 + 16 L4)/(2 c)) Y^2 Y_X - (c/180) Y_5X = 0",
    ),
    "Kawahara": (
        vanishing,
        Scaling(4, time=5),
        10,
        "Y_T + ((K3 + 8 L3)/c) Y Y_X + (d/(24 c)) Y_XXX - (c/180) Y_5X = 0",
    ),
    "modified Kawahara": (
        vanishing_odd,
        Scaling(2, time=5),
        8,
        "Y_T + (3 (K4 + 16 L4)/(2 c)) Y^2 Y_X + (d/(24 c)) Y_XXX - (c/180) Y_5X = 0",
    ),
}


@pytest.mark.parametrize("name", TABLE)
def test_every_known_reduction_has_all_its_outputs(name: str) -> None:
    forces, scaling, orders, equation = TABLE[name]
    reduction = reduce(chain(forces), scaling, orders)
    assert reduction.pde.text() == equation
    assert outputs(reduction)["pde"]["equation"] == equation


def test_waves_to_the_left_mirror_those_to_the_right() -> None:
    """The frame speed -c gave c^2 = K2 - c^2."""
    left = reduce(chain({1: odd}), Scaling(space=(SlowVariable("X", 1, (1,), -c),)))
    right = reduce(chain({1: odd}))
    assert left.speed_squared == K2
    assert "c^2 = K2" in left.text()
    assert "X = eps (n + c t)" in left.text()
    assert outputs(left)["scaling"]["space"][0]["speed"] == "-c"
    mirrored, plain = left.coefficients(K2=4, K4=1), right.coefficients(K2=4, K4=1)
    assert mirrored.c == -plain.c == -2
    assert dict(mirrored.terms) == {name: -value for name, value in plain.terms.items()}


def test_a_condition_that_names_the_speed_is_checked() -> None:
    """K2 = L2 = 1 has dispersion; the ansatz without it holds only where c^2 + 12 L2 = 0."""
    reduction = reduce(chain({1: cubic, 2: second}), Scaling(4, time=5), 10)
    with pytest.raises(ValueError, match=r"must satisfy c\^2 \+ 12 L2 = 0, got"):
        reduction.coefficients(K2=1, L2=1)
    assert reduction.coefficients(K2=16, L2=-1).c ** 2 == 12


def test_a_mean_without_inflection_is_refused() -> None:
    reduction = reduce(chain({1: cubic}), Scaling(background=((0, -K3 / (3 * K4)),)))
    with pytest.raises(ValueError, match=r"must satisfy K4 != 0, got 0"):
        reduction.coefficients(K2=1, K3=1, K4=0)
    with pytest.raises(ValueError, match=r"> 0, got -1/3"):
        reduction.coefficients(K2=1, K3=2, K4=1)


def test_a_term_that_cannot_vanish_is_no_condition() -> None:
    """With p and q positive, (p + q) (Y^2)_XX = 0 has no solution in the constants."""
    p, q = Symbol("p", positive=True), Symbol("q", positive=True)
    with pytest.raises(ReductionError, match="must be solvable by a condition on the constants"):
        reduce(chain({1: K2 * x + (p + q) * x**2}))


HERE = (Stencil((0,)),)
SPRINGS = (spring(K2 * x + K4 * x**3, ((0,), 0), ((1,), 0)),)

ANSATZ = {
    "speed 2 c": (lambda: _frame(2 * c), "speed of X must be a positive symbol or minus one"),
    "speed 1": (lambda: _frame(Integer(1)), "speed of X must be a positive symbol"),
    "speed 0": (lambda: _frame(Integer(0)), "speed of X must be a positive symbol"),
    "speed root": (lambda: _frame(sqrt(K2)), "speed of X must be a rational function"),
    "speed float": (lambda: _frame(0.5 * c), "speed of X must be exact"),
    "speed with eps": (lambda: _frame(c + eps), "must not depend on eps"),
    "unknown sign": (lambda: _frame(Symbol("v")), "must be a positive symbol"),
    "direction 0": (lambda: SlowVariable("X", 1, (0,), c), "direction of X must not be all 0"),
    "direction": (lambda: SlowVariable("X", 1, (sqrt(2),), c), "direction of X must be a rational"),
    "exponent": (lambda: SlowVariable("X", True, (1,), c), "exponent of X must be an integer"),
    "name": (lambda: SlowVariable("X Y", 1, (1,), c), "name must be one letter"),
    "name T": (lambda: Scaling(space=(SlowVariable("T", 1, (1,), c),)), "other than T and Y"),
    "no space": (lambda: Scaling(space=()), "space must be a tuple of SlowVariable"),
    "amplitude": (lambda: Scaling(amplitude=1.0), "amplitude must be an integer"),
    "mean float": (lambda: Scaling(background=((0, 0.5 * ybar),)), "background must be exact"),
    "mean root": (lambda: Scaling(background=((0, sqrt(K2)),)), "must be a rational function"),
    "mean of X": (lambda: Scaling(background=((0, X),)), "must have names other than"),
    "mean of c": (lambda: Scaling(background=((0, c),)), "must not depend on the speed c"),
    "1/eps": (lambda: Scaling(background=((0, ybar / eps),)), "and a polynomial in eps"),
    "other c": (
        lambda: reduce(chain({1: K2 * x + Symbol("c") * x**3})),
        "must have different names, got c twice",
    ),
    "same c": (lambda: reduce(chain({1: K2 * x + c * x**3})), "speed must not be a constant of"),
    "other x": (lambda: chain({1: K2 * x + Symbol("x") ** 3}), "must have names other than"),
    "force float": (lambda: chain({1: K2 * x + 0.1 * x**3}), r"force must be exact, got .*0\.1"),
    "force root": (lambda: chain({1: K2 * x + sqrt(2) * x**3}), "force must be a rational"),
    "force of a root": (lambda: chain({1: K2 * sqrt(x)}), "force must be real and smooth about"),
    "force of a log": (lambda: chain({1: log(x - 1)}), "force must be real and smooth about"),
    "force of eps": (lambda: chain({1: sin(eps * x)}), "force must be a polynomial in"),
    "pinned": (lambda: reduce(pinned()), "must have one wave of vanishing frequency, got 0"),
    "two chains": (lambda: reduce(two_chains()), "wave of vanishing frequency, got 2"),
    "stretch of order 1": (
        lambda: reduce(chain({1: K2 * sin(x)}), Scaling(0)),
        "force must be a polynomial where the stretch is of order one",
    ),
    "force cos": (lambda: chain({1: K2 * x + cos(K3) * x**3}), "force must be a rational"),
    "force text": (lambda: chain({1: "K2*x"}), "force must be an expression in"),
    "mass 0": (lambda: chain({1: odd}, Integer(0)), "mass must satisfy mass > 0, got 0"),
    "mass nan": (lambda: chain({1: odd}, float("nan")), "mass must be a finite real number"),
    "plane": (
        lambda: reduce(FPUT, Scaling(space=(SlowVariable("X", 1, (1, 0), c),))),
        "direction of X must have 1 entries",
    ),
    "name of lattice": (lambda: reduce("fput_strain"), "lattice must be a Lattice"),
    "orders": (lambda: reduce(FPUT, orders=7.0), "orders must be an integer"),
    "field": (
        lambda: Lattice("a", "a", ("y",), (S.One,), (Bond(HERE, odd, (Stencil((0,), 1, 1),)),)),
        "must name one of 1 fields",
    ),
    "unknown constant": (lambda: reduce(FPUT).coefficients(K5=1), "constants must be among"),
}  # fmt: skip


def pinned() -> Lattice:
    """Return a chain with on-site springs."""
    return Lattice("pinned", "pinned", ("u",), (1,), (*SPRINGS, on_site(K3 * x)))


def two_chains() -> Lattice:
    """Return a lattice of two fields that do not interact."""
    bonds = tuple(spring(K2 * x, ((0,), field), ((1,), field)) for field in (0, 1))
    return Lattice("two", "two chains", ("u", "v"), (1, 2), bonds)


def _frame(speed: Any) -> Scaling:
    return Scaling(space=(SlowVariable("X", 1, (1,), speed),))


@pytest.mark.parametrize("name", ANSATZ)
def test_an_unsupported_lattice_is_refused_in_one_line(name: str) -> None:
    build, message = ANSATZ[name]
    with pytest.raises(ValueError, match=message) as refused:
        build()
    assert "\n" not in str(refused.value)
