"""Linear forms, generators and what images are made of."""

from __future__ import annotations

import random
from collections.abc import Sequence

import pytest
from flint import fmpq

from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.field import Field, Hints, solved
from longwave.verify.kernel.nodes import Nodes
from longwave.verify.kernel.reading import Scope, formula
from longwave.verify.kernel.ring import Derivation, Element, Ring
from longwave.verify.kernel.table import RULES
from searches.forged_proofs import Data, Proof, signed
from tests.verify.kernel.test_verify_kernel_attacks import refused


def test_linear_equations_are_solved() -> None:
    draw, ring = random.Random(2), Ring(1)
    g = ring.generator(0)
    matrices = [[[0, 1], [1, 0]], [[0, 2, 1], [3, 0, 1], [0, 0, 5]], [[7]]]
    for _ in range(5):
        matrices.append([[draw.randint(-3, 3) + 10 * (i == j) for j in range(3)] for i in range(3)])
    for matrix in matrices:
        values = [g**n + ring.number(n) for n in range(len(matrix))]
        table = []
        for row in matrix:
            entries = [ring.number(entry) for entry in row]
            right = ring.number(0)
            for entry, value in zip(entries, values, strict=True):
                right = right + entry * value
            table.append([*entries, right])
        for found, value in zip(solved(table), values, strict=True):
            assert (found - value).is_zero
    dependent = [[ring.number(n) for n in row] for row in ([1, 2, 3], [2, 4, 6])]
    with pytest.raises(CertificateError, match="linear forms must be independent"):
        solved(dependent)


def with_forms(letters: str, rows: Sequence[tuple[Sequence[str], str]], equation: str) -> Data:
    proof = Proof()
    places = [proof.place(letter) for letter in letters]
    table = [[[proof.place(f) for f in factors], proof.place(shift)] for factors, shift in rows]
    data = proof.data([], {"x": "1", "t": "2"}, more=[["forms", places, table]])
    data["generators"].append(["atom", proof.place("exp(x - 3*t)")])
    statement = {"variables": ["x", "t"], "solutions": ["u = exp(x - 3*t)"]}
    return signed({**statement, "equations": [equation]}, proof, data)


def test_generators_may_be_linear_forms() -> None:
    rows = [(("1", "-3"), "0"), (("2", "1"), "5")]
    for equation, right in (("u_t + 3*u_x", True), ("u_t + 2*u_x", False)):
        data = with_forms("xt", rows, equation)
        if right:
            assert equation in check_certificate(data)
        else:
            refused(data, "the residual is not 0")
    swapped = [(("0", "1"), "1/2"), (("2", "0"), "0")]
    assert check_certificate(with_forms("xt", swapped, "u_t + 3*u_x + x*0"))
    refused(with_forms("xt", rows[:1], "u_t + 3*u_x"), "no generator is written|cannot be read")


@pytest.mark.parametrize("factor", ["1", "2", "1 + k**2", "1/(1 + k)"])
def test_a_generator_may_be_a_multiple_of_a_root(factor: str) -> None:
    def states(equation: str) -> Data:
        proof = Proof()
        root = proof.place("sqrt(x/(1 + x))")
        row = [[proof.place(factor)], proof.place("0")]
        atoms = [["atom", proof.place(name)] for name in ("x", "k")]
        data = proof.data([], {"x": "1", "k": "1/3"}, more=[*atoms, ["forms", [root], [row]]])
        solution = f"u = ({factor})*sqrt(x/(1 + x))"
        statement = {"equations": [equation], "solutions": [solution], "parameters": ["k: real"]}
        return signed(statement, proof, data)

    square = f"u**2*(1 + x) - ({factor})**2*x"
    assert square in check_certificate(states(square))
    assert check_certificate(states(f"2*u*u_x*(1 + x)**2 - ({factor})**2"))
    refused(states(f"u**2*(1 + x) - 3*({factor})**2*x"), "the residual is not 0")


def test_a_derivation_follows_the_rules_of_products_and_quotients() -> None:
    ring = Ring(2)
    x, y = ring.generators
    one = ring.number(1)
    slopes = {0: one, 1: Element(ring, y) / Element(ring, x + 1)}
    slope = Derivation(ring, slopes)

    a = Element(ring, x**2 * y + 3) / Element(ring, (x + 1) ** 2 * (y - 2))
    b = Element(ring, y**3 - x) / Element(ring, y)
    assert (slope(a * b) - (slope(a) * b + a * slope(b))).is_zero
    assert (slope(a / b) - (slope(a) * b - a * slope(b)) / (b * b)).is_zero
    assert (slope(a + b) - slope(a) - slope(b)).is_zero
    assert (slope(Element(ring, x**3)) - Element(ring, 3 * x**2)).is_zero
    assert (slope(Element(ring, y)) - slopes[1]).is_zero
    assert slope(ring.number(fmpq(2, 3))).is_zero
    still = Derivation(ring, {0: ring.number(0), 1: one})
    assert still(Element(ring, x)).is_zero
    assert still.slopes.keys() == {1}


def test_a_field_walks_over_what_has_an_image_and_over_even_powers_of_moduli() -> None:
    scope = Scope(Nodes())
    x = scope.node("x")
    field = Field(scope.nodes, 2, [x], {}, Hints({}, {}), RULES)
    field.register(x)
    field.register(scope.nodes.add("I"))
    for exponent, image in ((2, "1 + x**2"), (4, "(1 + x**2)**2"), (-2, "1/(1 + x**2)")):
        node = formula(scope, f"abs(1 + I*x)**({exponent})")
        field.walk([node])
        assert field.equal(node, formula(scope, image))
    field.walk([])
    for text in ("abs(1 + I*x)", "abs(1 + I*x)**3"):
        with pytest.raises(CertificateError, match="no generator for a Abs"):
            field.walk([formula(scope, text)])
    assert field.moves(formula(scope, "x + 1")) is True
    assert field.moves(formula(scope, "pi")) is False


def test_a_variable_that_is_an_integer_moves_nothing() -> None:
    scope = Scope(Nodes())
    n = scope.declare("n", "integer")
    field = Field(scope.nodes, 1, [n], {}, Hints({}, {}), RULES)
    assert field.moves(n) is False
