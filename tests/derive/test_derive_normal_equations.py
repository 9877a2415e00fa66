"""Every map to a normal form, put into the reduced equation: a multiple of the normal form is left.

U is a polynomial whose derivatives at the origin are independent symbols, so that an identity at
the origin is one for every U.
"""

from collections.abc import Callable, Mapping
from functools import cache
from itertools import product
from math import factorial
from typing import Any

import pytest
from sympy import Expr, I, Rational, S, Symbol, expand, pi, simplify, sqrt, symbols

from longwave.derive import LATTICES, NormalForm, Scaling, SlowVariable, envelope, reduce
from longwave.derive.models.lattices import H2
from longwave.derive.normal_form import NORMAL_EQUATIONS, normal_form_of
from longwave.derive.symbols import K2, K3, K4, c

X, Z, T = symbols("X Z T", real=True)
Shape = Callable[[Expr, Expr, Expr], Expr]


def unknown(name: str, across: int = 0, along: int = 2, **kind: bool) -> Shape:
    """Return a polynomial of these degrees across, along and (1) in time, with free derivatives."""
    indices = list(product(range(along + 1), range(across + 1), range(2)))
    jets = {key: Symbol(name + "_".join(map(str, key)), **kind) for key in indices}

    def value(x: Expr, z: Expr, t: Expr) -> Expr:
        return sum(
            (
                v * x**i * z**j * t**m / (factorial(i) * factorial(j))
                for (i, j, m), v in jets.items()
            ),
            S.Zero,
        )

    return value


def reduced(coefficients: Mapping[str, Expr], Y: Expr) -> Expr:
    """Return the reduced equation's left-hand side."""
    terms = {
        "Y_X": lambda: Y.diff(X),
        "Y Y_X": lambda: Y * Y.diff(X),
        "Y^2 Y_X": lambda: Y**2 * Y.diff(X),
        "Y_XX": lambda: Y.diff(X, 2),
        "Y_XXX": lambda: Y.diff(X, 3),
        "Y_5X": lambda: Y.diff(X, 5),
    }
    flow = Y.diff(T) + sum(v * terms[n]() for n, v in coefficients.items() if n != "Y_ZZ")
    if "Y_ZZ" in coefficients:
        return flow.diff(X) + coefficients["Y_ZZ"] * Y.diff(Z, 2)
    return flow


NORMAL: dict[str, Callable[[Expr, Expr, Expr], dict[str, Expr]]] = {
    "KdV": lambda s, r, _: {"Y Y_X": S(6), "Y_XXX": S(1)},
    "mKdV": lambda s, r, _: {"Y^2 Y_X": 6 * s, "Y_XXX": S(1)},
    "Gardner": lambda s, r, _: {"Y Y_X": S(6), "Y^2 Y_X": 6 * s, "Y_XXX": S(1)},
    "Kawahara": lambda s, r, _: {"Y Y_X": S(6), "Y_XXX": s, "Y_5X": S(-1)},
    "modified Kawahara": lambda s, r, _: {"Y^2 Y_X": 6 * r, "Y_XXX": s, "Y_5X": S(-1)},
    "fifth-order KdV": lambda s, r, _: {"Y Y_X": S(6), "Y_5X": S(-1)},
    "fifth-order mKdV": lambda s, r, _: {"Y^2 Y_X": 6 * r, "Y_5X": S(-1)},
    "KdV-Burgers": lambda s, r, _: {"Y Y_X": S(6), "Y_XX": S(-1), "Y_XXX": s},
    "mKdV-Burgers": lambda s, r, _: {"Y^2 Y_X": 6 * r, "Y_XX": S(-1), "Y_XXX": s},
    "KP": lambda s, r, _: {"Y Y_X": S(6), "Y_XXX": S(1), "Y_ZZ": 3 * s},
    "generalised KP": lambda s, r, _: {"Y^2 Y_X": 6 * r, "Y_XXX": S(1), "Y_ZZ": 3 * s},
}
"""The normal forms, written here again."""

ORIGIN = {X: 0, Z: 0, T: 0}
LONG = ("KP", "generalised KP", "Kawahara")
"""Long to expand; what the sign of their nonlinear term and a drift do is seen in KdV, too."""

CASES = [
    pytest.param(
        name, signs, drift, marks=[pytest.mark.slow] * (name in LONG and (drift or signs[0] < 0))
    )
    for name in NORMAL
    for signs in product((1, -1), repeat=len(NORMAL_EQUATIONS[name].terms))
    for drift in ((False, True) if name in ("KdV", "Gardner", "KP") else (False,))
]


@cache
def normal_side(name: str, s: Expr, r: Expr) -> Expr:
    """Return the normal form's left-hand side of any solution, at the origin."""
    return reduced(NORMAL[name](s, r, S.One), unknown("u", *degrees(name))(X, Z, T)).subs(ORIGIN)


def degrees(name: str) -> tuple[int, int]:
    """Return the orders of the equation's derivatives, across and along."""
    terms = NORMAL_EQUATIONS[name].terms
    if "Y_ZZ" in terms:
        return 2, 4
    return 0, 5 if "Y_5X" in terms else 3


@pytest.mark.parametrize(("name", "signs", "drift"), CASES)
def test_the_map_takes_the_equation_to_its_normal_form(
    name: str, signs: tuple[int, ...], drift: bool
) -> None:
    entry = NORMAL_EQUATIONS[name]
    sizes = symbols("p q g", positive=True)
    coefficients: dict[str, Expr] = {
        term: sign * size for term, sign, size in zip(entry.terms, signs, sizes, strict=False)
    }
    if drift:
        coefficients["Y_X"] = Symbol("mu", real=True)
    form = normal_form_of(c, coefficients)
    assert (form.equation, form.c) == (name, c)
    U = unknown("u", *degrees(name))
    mapped = form.h * U(form.a * (X - form.drift * T), form.e * Z, form.b * T)
    left = reduced(coefficients, mapped).subs(ORIGIN)
    right = normal_side(name, form.s, form.r)
    factor = form.h * form.b * form.a ** int("Y_ZZ" in entry.terms)
    assert simplify(expand(left - factor * right)) == 0
    assert {form.s, form.r} <= {1, -1}


@pytest.mark.parametrize("signs", list(product((1, -1), repeat=2)))
def test_the_map_takes_the_envelope_to_its_normal_form(signs: tuple[int, int]) -> None:
    p, q = (sign * size for sign, size in zip(signs, symbols("p q", positive=True), strict=True))
    form = normal_form_of(c, {"A_XX": p, "|A|^2 A": q})
    re, im = unknown("f", real=True), unknown("g", real=True)

    def wave(x: Expr, t: Expr) -> tuple[Expr, Expr]:
        values = re(x, S.Zero, t), im(x, S.Zero, t)
        return values[0] + I * values[1], values[0] ** 2 + values[1] ** 2

    U, squared = wave(X, T)
    V, size = wave(form.a * X, form.b * T)
    A, mapped = form.h * V, form.h**2 * size
    left = (I * A.diff(T) + p * A.diff(X, 2) + q * mapped * A).subs(ORIGIN)
    right = (I * U.diff(T) + U.diff(X, 2) + 2 * form.s * squared * U).subs(ORIGIN)
    assert expand(left - form.h * form.b * right) == 0
    assert form.s == signs[0] * signs[1]


ALONG = SlowVariable("X", 1, (1, 0), c)


def test_lattices_have_their_normal_forms() -> None:
    """KdV and KP with a = 1; the names of the slow variables do not matter."""
    kdv = reduce(LATTICES["fput"], Scaling(1), 5).normal_form()
    assert (kdv.equation, kdv.a, kdv.b) == ("KdV", 1, sqrt(K2) / 24)
    assert simplify(kdv.h - K2 / (4 * K3)) == 0
    across = (ALONG, SlowVariable("W", 2, (0, 1), S.Zero))
    kp = reduce(LATTICES["square"], Scaling(1, across), 5).normal_form()
    assert (kp.equation, kp.s) == ("KP", 1)
    assert simplify(kp.e**2 - K2 / (4 * H2)) == 0


def test_a_small_mean_drifts() -> None:
    """y = eps (b + Y): the Gardner equation with a term in Y_X."""
    b = Symbol("b", positive=True)
    cubic = reduce(LATTICES["fput_strain"], Scaling(background=((1, b),)), 5)
    form = cubic.normal_form(K2=1, K4=2, b=Rational(1, 3))
    assert (form.equation, form.drift, form.s) == ("Gardner", Rational(1, 3), 1)


def test_a_vanishing_coefficient_is_another_equation_or_none() -> None:
    b = Symbol("b", real=True)
    small = reduce(LATTICES["fput_strain"], Scaling(background=((1, b),)), 5)
    assert small.normal_form(K2=1, K4=2, b=0) == small_normal_form()
    with pytest.raises(ValueError, match="of Y Y_X must not vanish, got 0, which leaves Y_XXX"):
        reduce(LATTICES["fput"], Scaling(1), 5).normal_form(K2=1, K3=0)
    with pytest.raises(ValueError, match=r"with a normal form, got Y_XXX \(KdV: Y Y_X, Y_XXX;"):
        reduce(LATTICES["fput"], Scaling(2), 6).normal_form(K2=1)


def small_normal_form() -> NormalForm:
    return reduce(LATTICES["fput_strain"], orders=5).normal_form(K2=1, K4=2)


def test_an_envelope_has_an_exact_normal_form_or_digits() -> None:
    values: Any = {"K2": 1, "K3": Rational(1, 4), "K4": 1}
    chain = envelope(LATTICES["fput"])
    exact = chain.normal_form(pi / 3, **values)
    numbers = chain.coefficients(pi / 3, **values)
    assert exact.digits is None
    assert (exact.b, exact.s, exact.a) == (-S(1) / 8, -1 if numbers.q > 0 else 1, 1)
    assert abs(float(exact.h) - abs(2 * numbers.p / numbers.q) ** 0.5) < 1e-15
    assert abs(float(exact.c) - numbers.v) < 1e-15
    dimer = envelope(LATTICES["mass_dimer"], m2=1, **values)
    cells = dimer.normal_form(2 * pi / 3, "acoustic", m1=1, m2=1, **values)
    assert cells.digits == 60
    for got, expected in ((4 * cells.b, exact.b), (2 * cells.c, exact.c), (2 * cells.h, exact.h)):
        assert abs((got - expected).evalf(70)) < 1e-59
    assert chain.normal_form().b == chain.expressions["p"]


def test_an_envelope_without_nonlinearity_is_refused() -> None:
    with pytest.raises(ValueError, match=r"of \|A\|\^2 A must not vanish, got 0"):
        envelope(LATTICES["fput"]).normal_form(1, K2=1, K3=0, K4=0)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "equation": ({"equation": "Burgers"}, "equation must be a known one"),
    "r": ({"r": 2}, "r must be 1 or -1, got 2"),
    "h": ({"h": 0}, "h must not be 0"),
    "h text": ({"h": "x"}, "h must be a rational number"),
    "e": ({"equation": "KP"}, "e must not be 0"),
}


@pytest.mark.parametrize("name", WRONG)
def test_an_invalid_map_is_refused(name: str) -> None:
    change, message = WRONG[name]
    with pytest.raises(ValueError, match=message):
        NormalForm(1, 1, 1, 1, **change)


def test_a_map_shows_itself() -> None:
    form = normal_form_of(S(2), {"Y Y_X": S(3), "Y_XXX": S(1), "Y_X": S(5)})
    assert repr(form) == "NormalForm(a=1, b=1, s=1, c=2, equation=KdV, h=2, drift=5)"
    assert form.map_text == "Y(X, T) = h U(a (X - drift T), b T)"
    assert list(form.values) == ["a", "b", "h", "drift"]
    assert K4 not in form.a.free_symbols
    assert form._repr_latex_().count("$") == 2
