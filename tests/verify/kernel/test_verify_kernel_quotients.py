"""Long quotients: at how many values they are put in, and what is found there."""

from __future__ import annotations

from typing import Any

import pytest
from flint import fmpq, fmpq_poly

from longwave.verify.kernel import CertificateError, check_certificate, opened, quotients
from longwave.verify.kernel.check import registered
from longwave.verify.kernel.nodes import Nodes
from longwave.verify.kernel.quotients import (
    _Partials,
    _rows,
    _slope,
    _value,
    long_quotient,
    shape,
)
from longwave.verify.kernel.reading import Scope, formula
from longwave.verify.kernel.ring import Ring
from searches.forged_proofs import Proof, certificate, signed


def scope_of() -> Scope:
    scope = Scope(Nodes(), unknowns=["u"])
    scope.variables = [scope.declare(letter, "real") for letter in "xt"]
    return scope


SHAPES = {
    "2": (0, {0}), "u": (1, {0}), "u_x": (2, {1}), "u_xt": (3, {0}), "u_xxx": (4, {1}),
    "u*u_x": (3, {1}), "u_x*u_x": (4, {0}), "u**3": (3, {0}), "u_x**3": (6, {1}),
    "u_x + u": (2, {0, 1}), "(u_x + u)*u": (3, {0, 1}), "(u_x + u)**2": (4, {0, 1}),
    "3*u": (1, {0}), "u_t + 6*u*u_x + u_xxx": (4, {1}), "u - 1": (1, {0}),
    "x*u": None, "sqrt(u)": None, "u**(-1)": None, "u**0": None, "exp(u)": None, "u[x+1, t]": None,
    "diff(u**2, x)": None, "u + x": None, "(u + x)**2": None, "k*u": None, "u**(3/2)": None,
    "diff(u[x, t+1], x)": None,
}  # fmt: skip


@pytest.mark.parametrize("text", SHAPES)
def test_the_shape_of_an_equation(text: str) -> None:
    scope = scope_of()
    found, expected = shape(scope.nodes, formula(scope, text)), SHAPES[text]
    assert found == (None if expected is None else (expected[0], frozenset(expected[1])))


def test_a_polynomial_by_rows_has_its_values_and_slopes() -> None:
    x, t = Ring(2).generators
    rows = _rows(3 * x**2 * t + 5 * t**3 - x + 7, 0, 1)
    assert rows == [fmpq_poly([7, -1]), fmpq_poly([0, 0, 3]), fmpq_poly([]), fmpq_poly([5])]
    assert _value(rows, 2) == fmpq_poly([47, -1, 6])
    assert _slope(rows, 2) == fmpq_poly([60, 0, 3])
    assert _slope(rows[:1], 2) == 0
    swapped = _rows(3 * x**2 * t - x, 1, 0)
    assert swapped == [fmpq_poly([]), fmpq_poly([-1]), fmpq_poly([0, 3])]


def test_an_equation_at_a_value_is_a_numerator_over_a_power() -> None:
    """For U = N/D with N = x + t, D = 1 + x**2 + t, xi along x and tau along t and twice x."""
    scope = scope_of()
    x_symbol, t_symbol = scope.variables
    rates = {x_symbol: (fmpq(1), fmpq(0)), t_symbol: (fmpq(2), fmpq(1))}
    x, t = Ring(2).generators
    N, D = x + t, 1 + x**2 + t
    made = _Partials(scope.nodes, _rows(N, 0, 1), _rows(D, 0, 1), 3, rates)

    def jet(a: int, b: int) -> Any:
        numerator, power = N, 1
        for place, count in ((1, b), (0, a)):
            for _ in range(count):
                name = f"g{place}"
                numerator = numerator.derivative(name) * D - power * numerator * D.derivative(name)
                power += 1
        return numerator

    ux, uxx, ut = jet(1, 0), jet(2, 0), 2 * jet(1, 0) + jet(0, 1)
    expected = {
        "u": (N, 1), "u_x": (ux, 2), "u_xx": (uxx, 3), "u_t": (ut, 2), "5": (N * 0 + 5, 0),
        "u_xt": (2 * uxx + jet(1, 1), 3), "u_xxt": (2 * jet(3, 0) + jet(2, 1), 4),
        "u*u_x": (N * ux, 3), "u_x**3": (ux**3, 6), "u_xx + u": (uxx + N * D**2, 3),
        "u_t - u_x + 2": (ut - ux + 2 * D**2, 2),
    }  # fmt: skip
    for text, (numerator, power) in expected.items():
        value, below = made.value(formula(scope, text))
        assert (value, below) == (_value(_rows(numerator, 0, 1), 3), power), text
    with pytest.raises(CertificateError, match="at most one derivative in t"):
        made.value(formula(scope, "u_tt"))


ODD = "+".join(f"{n + 1}*x**{2 * n}*t**{(4 * n) % 6}" for n in range(20))
THIRD = "+".join(f"{n + 1}*x**{n}*t**{-n % 3}" for n in range(20))
MIXED = "+".join(f"{n + 1}*x**{n}*t**{(3 * n) % 7}" for n in range(20))


@pytest.mark.parametrize(
    ("formula_of", "equation", "values"),
    [
        (MIXED, "u - u", range(-3, 4)),  # d = 6, top = 1
        (MIXED, "u_x - u_x", range(-6, 7)),  # top = 2
        (MIXED, "u*u_x - u*u_x", range(-9, 10)),  # top = 3
        (ODD, "u - u", range(3)),  # d = 4, even: from 0
        (ODD, "u_x - u_x", range(5)),
        (ODD, "u_x + u - u_x - u", range(-4, 5)),
        (THIRD, "u - u", range(-1, 2)),  # d = 2, orders of x and t together 0, 3, 6, ...
        (f"({MIXED})/(1 + t**9)", "u - u", range(-5, 6)),
        (f"({ODD})/(1 + x)", "u - u", range(-2, 3)),
    ],
)
def test_a_quotient_is_put_in_at_more_values_than_its_degree(
    formula_of: str, equation: str, values: range, monkeypatch: pytest.MonkeyPatch
) -> None:
    used = []

    class Counted(_Partials):
        def __init__(self, nodes: Any, above: Any, below: Any, t: int, rates: Any) -> None:
            used.append(t)
            super().__init__(nodes, above, below, t, rates)

    monkeypatch.setattr(quotients, "_Partials", Counted)
    statement = {"variables": ["x", "t"]}
    point = {"x": "1", "t": "1"}
    data = certificate(equation, f"u = {formula_of}", ["x", "t"], point, statement)
    assert "u = " in check_certificate(data)
    assert used == list(values)


def test_values_of_a_long_quotient_are_counted_as_work(monkeypatch: pytest.MonkeyPatch) -> None:
    spent = []
    monkeypatch.setattr(Ring, "spend", lambda self, work: spent.append(work))
    statement = {"variables": ["x", "t"]}
    data = certificate("u_x - u_x", f"u = {MIXED}", ["x", "t"], {"x": "1", "t": "1"}, statement)
    check_certificate(data)
    assert 13 * 2 * 20 * 50 in spent


@pytest.mark.parametrize(
    ("solution", "atoms", "found"),
    [
        (MIXED, ["x", "t"], True),
        (MIXED, ["t", "x"], True),
        (MIXED.replace("20*", "0*"), ["x", "t"], False),
        (MIXED.replace("t", "exp(t)"), ["x", "t", "exp(t)"], False),
        (MIXED.replace("t", "exp(x)"), ["x", "exp(x)"], False),
        (MIXED.replace("t", "sqrt(2)"), ["x", "sqrt(2)"], False),
        (MIXED.replace("t", "k"), ["x", "k"], True),
    ],
)
def test_what_is_a_long_quotient(solution: str, atoms: list[str], found: bool) -> None:
    proof = Proof()
    statement = {"variables": ["x", "t"], "equations": ["u - 1"], "solutions": [f"u = {solution}"]}
    data = signed(statement, proof, proof.data(atoms, {"x": "1"}))
    read = opened(data)
    field = registered(read, data["proof"])
    field.walk(read.formulas)
    quotient = long_quotient(field, read)
    assert (quotient is not None) is found
    if quotient is not None:
        _, x, t, rates = quotient
        names = [atoms[x], atoms[t]]
        assert names == (["x", "t"] if "t" in atoms else ["x", "k"])
        slopes = [tuple(int(rate) for rate in rates[v]) for v in read.variables]
        assert slopes == ([(1, 0), (0, 1)] if "t" in atoms else [(1, 0), (0, 0)])


def test_two_unknowns_are_multiplied_out() -> None:
    statement = {"variables": ["x", "t"], "equations": ["u - v"]}
    for last, right in (("", True), (" + 1", False)):
        proof = Proof()
        solutions = [f"u = {MIXED}", f"v = {MIXED}{last}"]
        proof_data = proof.data(["x", "t"], {"x": "1", "t": "1"})
        data = signed({**statement, "solutions": solutions}, proof, proof_data)
        if right:
            assert "v = " in check_certificate(data)
        else:
            with pytest.raises(CertificateError, match="the residual is not 0"):
                check_certificate(data)
