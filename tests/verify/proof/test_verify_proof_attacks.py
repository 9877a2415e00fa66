"""Hand-made certificates of false statements, and of statements that print as others."""

from typing import Any

import pytest
import sympy as sp
from flint import fmpq
from verify.proof.checker import CertificateError, check_certificate
from verify.proof.checker.check import Branches, registered
from verify.proof.checker.limits import digest
from verify.proof.checker.nodes import Nodes
from verify.proof.checker.statement import read_statement

from verify.proof import prove
from verify.verdict import Outcome

Data = dict[str, Any]
Terms = list[list[Any]]


class Table:
    """Nodes of a certificate; equal ones are written once."""

    def __init__(self) -> None:
        self.nodes: list[list[Any]] = []
        self.x = self("symbol", "x", "real")
        self.zero, self.minus, self.i = (
            self("number", "0"),
            self("number", "-1"),
            self("constant", "I"),
        )

    def __call__(self, *node: Any) -> int:
        if list(node) not in self.nodes:
            self.nodes.append(list(node))
        return self.nodes.index(list(node))

    def power(self, base: int, exponent: str) -> int:
        return self("Pow", base, exponent)

    def difference(self, left: int, right: int) -> int:
        return self("Add", left, self("Mul", self.minus, right))


def certificate(
    table: Table,
    formula: int,
    equation: Terms,
    generators: list[list[Any]],
    point: dict[int, str],
    domain: Terms | None = None,
    variables: list[int] | None = None,
    unknowns: list[list[Any]] | None = None,
    **hints: list[list[Any]],
) -> Data:
    empty: Data = {name: [] for name in ("sums", "values", "logs", "signs", "parts")}
    body: Data = {
        "format": "longwave proof 2",
        "name": "attack",
        "nodes": table.nodes,
        "statement": {
            "variables": variables or [table.x],
            "unknowns": unknowns or [["u", formula]],
            "equations": [equation],
            "domain": domain or [],
        },
        "proof": {
            "generators": generators,
            "point": [[symbol, value] for symbol, value in point.items()],
            **empty,
            **hints,
        },
    }
    return body | {"digest": digest(body)}


def equals(right: int) -> Terms:
    return [["1", [], [[0, [0]]]], ["-1", [right], []]]


def test_a_witness_of_a_sign_must_be_real() -> None:
    """-x**2 is (i x)**2, which is no square of a real number: sqrt(x**4) is not -x**2."""
    n = Table()
    root = n.power(n.power(n.x, "4"), "1/2")
    value = n("Mul", n.minus, n.power(n.x, "2"))
    witness = n.power(n("Mul", n.i, n.x), "2")
    data = certificate(
        n,
        root,
        equals(value),
        [["atom", n.x], ["atom", n.i]],
        {n.x: "1"},
        values=[[root, value]],
        signs=[[value, witness]],
    )
    with pytest.raises(CertificateError, match="not shown to be >= 0"):
        check_certificate(data)


@pytest.mark.parametrize("domain", ["", "0 < x**2", "0 <= |x| - x"])
def test_a_denominator_that_vanishes_on_a_half_line(domain: str) -> None:
    """|x| - x is 0 for x > 0; divided by it, |x| would be -x everywhere."""
    n = Table()
    root, square = n("Abs", n.x), n.power(n.x, "2")
    gap = n.difference(root, n.x)
    even = n.power(gap, "2")
    other = n("Mul", root, even, n.power(even, "-1"))
    value, target = n("Mul", n.minus, n.x), n.power(square, "1/2")
    stated = {
        "": [],
        "0 < x**2": [["<", n.zero, square]],
        "0 <= |x| - x": [["<=", n.zero, gap]],
    }
    data = certificate(
        n,
        target,
        equals(value),
        [["atom", n.x], ["atom", root]],
        {n.x: "-1"},
        stated[domain],
        values=[[target, value]],
        signs=[[value, other]],
    )
    with pytest.raises(CertificateError, match=r"a denominator|the point|<= must be"):
        check_certificate(data)


def test_a_slope_that_divides_by_a_function_that_is_zero_on_a_part() -> None:
    """u = sqrt(|x| + x + |y| + y) is 0 where x, y < 0, but (|x| - x)(|y| - y) is not."""
    n = Table()
    y = n("symbol", "y", "real")
    roots = n("Abs", n.x), n("Abs", y)
    left, right = n("Add", roots[0], n.x), n("Add", roots[1], y)
    u = n.power(n("Add", left, right), "1/2")
    inverse = n.power(n.x, "-1")
    equation = [
        ["1", [left], [[0, [1, 0]]]],
        ["1", [right], [[0, [1, 0]]]],
        ["-1/2", [left, inverse], [[0, [0, 0]]]],
        ["1", [n.difference(roots[0], n.x), n.difference(roots[1], y)], []],
    ]
    atoms = [["atom", node] for node in (n.x, y, *roots, u)]
    data = certificate(n, u, equation, atoms, {n.x: "1", y: "1"}, variables=[n.x, y])
    with pytest.raises(CertificateError, match=r"a denominator is not shown"):
        check_certificate(data)


def test_the_prover_does_not_take_a_function_that_is_zero_on_a_part() -> None:
    """The same far from the points that a search for a witness tries."""
    x, y = sp.symbols("x y", real=True)
    u, far = sp.Function("u")(x, y), 10**40
    a, b = x + far, y + far
    left, right = sp.Abs(a) + a, sp.Abs(b) + b
    last = (sp.Abs(a) - a) * (sp.Abs(b) - b)
    equation = u.diff(x) * left + u.diff(x) * right - u * left / (2 * a) + last
    assert prove(equation, sp.sqrt(left + right)).outcome is Outcome.UNDECIDED


def test_a_domain_needs_an_inside() -> None:
    """At x = 0 alone sqrt(x**4) is -x**2, but its second derivative is 2."""
    n = Table()
    root = n.power(n.power(n.x, "4"), "1/2")
    value = n("Mul", n.minus, n.power(n.x, "2"))
    domain = [["<=", n.zero, n.x], ["<=", n.x, n.zero]]
    equation: Terms = [["1", [], [[0, [2]]]], ["2", [], []]]
    data = certificate(
        n,
        root,
        equation,
        [["atom", n.x]],
        {n.x: "0"},
        domain,
        values=[[root, value]],
        signs=[[value, n("Mul", n.x, n("Mul", n.minus, n.x))]],
    )
    with pytest.raises(CertificateError, match="the point is not in the domain"):
        check_certificate(data)


def test_an_inequality_is_between_real_numbers() -> None:
    n = Table()
    domain = [["<", n.zero, n("Add", n("number", "1"), n.i)]]
    data = certificate(n, n.x, equals(n.x), [["atom", n.x]], {n.x: "0"}, domain)
    with pytest.raises(CertificateError, match="the point is not in the domain"):
        check_certificate(data)


def test_a_formula_is_defined_somewhere() -> None:
    """exp(x) - exp(2 x/2) is 0, and log(0) has no value."""
    n = Table()
    first = n("exp", n.x)
    second = n("exp", n("Mul", n("number", "1/2"), n("number", "2"), n.x))
    u = n.power(n.difference(first, second), "-1")
    one = n("number", "1")
    rows = [[[one, n.zero], n.zero], [[n.zero, one], n.zero]]
    forms = ["forms", [first, second], rows]
    with pytest.raises(CertificateError, match=r"finite at the point|a denominator"):
        check_certificate(certificate(n, u, equals(u), [forms], {n.x: "0"}))
    n = Table()
    u = n("log", n.zero)
    with pytest.raises(CertificateError, match=r"finite at the point|a denominator"):
        check_certificate(certificate(n, u, equals(u), [["atom", u]], {n.x: "0"}))


def test_a_power_of_a_product_is_printed_as_one() -> None:
    n = Table()
    y = n("symbol", "y", "real")
    u = n("poly", [["1", [2]]], n("Mul", n.x, y))
    square = n("Mul", n.power(n.x, "2"), n.power(y, "2"))
    data = certificate(n, u, equals(square), [["atom", n.x], ["atom", y]], {})
    assert "(1)*(x*y)^2" in check_certificate(data)


@pytest.mark.parametrize("name", ["I", "pi", "exp", "Abs", "u_x"])
def test_a_symbol_is_not_called_like_something_else(name: str) -> None:
    n = Table()
    s = n("symbol", name, "real")
    data = certificate(n, s, [["1", [], [[0, [1]]]]], [["atom", n.x], ["atom", s]], {})
    with pytest.raises(CertificateError, match="name"):
        check_certificate(data)


def test_derivatives_of_two_variables_print_differently() -> None:
    n = Table()
    xx = n("symbol", "xx", "real")
    data = certificate(n, xx, [["1", [], [[0, [2, 0]]]]], [["atom", xx]], {}, variables=[n.x, xx])
    with pytest.raises(CertificateError, match="name"):
        check_certificate(data)


def test_a_sine_is_not_positive_where_its_argument_is_zero() -> None:
    """sin((|x| + x)**2) is 0 for x < 0, where sqrt((0 + i y)**2) is not i y for y < 0."""
    n = Table()
    y, size = n("symbol", "y", "real"), n("Abs", n.x)
    z = n.power(n("Add", size, n.x), "2")
    value = n("Add", n("sin", z), n("Mul", n.i, y))
    root = n.power(n.power(value, "2"), "1/2")
    phase = n("exp", n("Mul", n.i, z))
    data = certificate(
        n,
        root,
        [["1", [], [[0, [0, 0]]]], ["-1", [value], []]],
        [["atom", node] for node in (n.x, y, n.i, size, phase)],
        {n.x: "1/2", y: "1"},
        [["<", z, n("number", "3")]],
        [n.x, y],
        values=[[root, value]],
    )
    with pytest.raises(CertificateError, match="not shown to be >= 0"):
        check_certificate(data)


@pytest.mark.parametrize("where", ["radicand", "witness"])
def test_a_root_with_a_pole_under_it_may_change_its_branch(where: str) -> None:
    """x sqrt(1 + 1/x**2) - sqrt(1 + x**2) is 0 for x > 0, but not for x < 0.

    So is sqrt(1 + x**2) sqrt(x**2/(1 + x**2)) - x, whose radicand 1/(1 + 1/x**2) is 0 at 0.
    """
    n = Table()
    one, square = n("number", "1"), n.power(n.x, "2")
    high, steep = n("Add", one, square), n("Add", one, n.power(n.x, "-2"))
    v, signs = n.power(high, "1/2"), []
    if where == "radicand":
        w = n.power(steep, "1/2")
        gap, size = n.difference(n("Mul", n.x, w), v), n("Mul", v, n.power(w, "-1"))
    else:
        radicand = n("Mul", square, n.power(high, "-1"))
        w, signs = n.power(radicand, "1/2"), [[radicand, n.power(steep, "-1")]]
        gap, size = n.difference(n("Mul", v, w), n.x), n("Mul", v, w)
    even = n.power(gap, "2")
    root, value = n.power(square, "1/2"), n("Mul", n.minus, n.x)
    other = n("Mul", size, even, n.power(even, "-1"))
    data = certificate(
        n,
        root,
        equals(value),
        [["atom", node] for node in (n.x, v, w)],
        {n.x: "-1"},
        values=[[root, value]],
        signs=[[value, other], *signs],
    )
    with pytest.raises(CertificateError, match="a denominator is not shown"):
        check_certificate(data)


def test_a_long_formula_is_not_named_as_the_unknown_is() -> None:
    n = Table()
    powers = [n.power(n("Add", n.x, n("number", str(k))), "7") for k in range(9)]
    long = n("Add", *powers)
    square = n.power(long, "2")
    equation: Terms = [["1", [], [[0, [0]]]], ["-1", [long, long], []]]
    data = certificate(n, square, equation, [["atom", n.x]], {n.x: "1"}, unknowns=[["f1", square]])
    assert "where f1 =" not in check_certificate(data)


def test_a_sign_is_tried_with_both_values() -> None:
    """sign x changes its branch at 0, also where abs x is no generator."""
    n = Table()
    sign, square = n("sign", n.x), n("Mul", n.x, n.x)
    data = certificate(n, square, equals(square), [["atom", n.x]], {n.x: "-1"})
    nodes = Nodes(data["nodes"])
    field = registered(nodes, read_statement(nodes, data["statement"]), data["proof"])
    point, place = {nodes.place(n.x): fmpq(-1)}, nodes.place(sign)
    values = [Branches(field, point, {place: fmpq(k, 2)}).ball(place).real for k in (0, 1)]
    assert [bool(value < 0) for value in values] == [True, False]


@pytest.mark.parametrize(("exponent", "degree"), [("2", 1), ("-2", 1), ("3/2", 2)])
def test_a_power_that_stands_for_an_equal_part_has_its_own_slope(
    exponent: str, degree: int
) -> None:
    """x**2 as a generator had the slope x**2/x; that of x**(p/q) is p/q x**(p/q)/x."""
    n = Table()
    power, root = n.power(n.x, exponent), n.power(n.x, f"1/{degree}")
    empty: Data = {name: [] for name in ("sums", "values", "logs", "signs", "parts")}
    same = {"generators": [["atom", n.x]], "point": [[n.x, "1"]], **empty}
    if degree > 1:
        same["generators"].append(["atom", root])

    def slope(factor: str) -> Data:
        value = n("Mul", power, n.power(n.x, "-1"), n("number", factor))
        equation = [["1", [], [[0, [1]]]], ["-1", [value], []]]
        generators = [["atom", n.x], ["part", 0, 0]]
        return certificate(n, power, equation, generators, {n.x: "1"}, parts=[[power, power, same]])

    with pytest.raises(CertificateError, match="the residual is not 0"):
        check_certificate(slope(f"1/{degree}"))
    assert "u_x" in check_certificate(slope(exponent))
