"""Each limit at its edge: what has just so much is read, what has one more is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from flint import fmpq

from longwave.verify.kernel import (
    CertificateError,
    check,
    check_certificate,
    denominators,
    nodes,
    reading,
)
from longwave.verify.kernel import __main__ as command
from longwave.verify.kernel.exponential_rules import fraction_of_turn
from longwave.verify.kernel.limits import within
from longwave.verify.kernel.nodes import Nodes, integer, listed, number
from longwave.verify.kernel.reading import Scope, axiom, formula, rational
from longwave.verify.kernel.ring import Ring
from longwave.verify.kernel.root_rules import whole
from longwave.verify.kernel.statement import read_statement
from searches.forged_proofs import Data, Proof, certificate, signed


def test_a_limit_is_the_most_that_is_allowed() -> None:
    assert within("it", 3, 3) == 3
    with pytest.raises(CertificateError, match="it must be at most 3, got 4"):
        within("it", 4, 3)


def read(text: str) -> int:
    scope = Scope(Nodes())
    scope.variables = [scope.declare("n", "integer"), scope.declare("x", "real")]
    scope.unknowns = ["u"]
    scope.declare("f", "function")
    return formula(scope, text)


TEXTS: list[tuple[str, int, str, str, str]] = [
    # limit, value, what is read, what is not, what is said
    ("NODES", 1, "x*x*x*x*x", "-x*x*x*x*x", "the words of a text must be at most 10, got 11"),
    ("ORDER", 2, "u_xx", "u_xxx", "the order of a derivative must be at most 2, got 3"),
    ("ORDER", 2, "diff(x, x, x)", "diff(x, x, x, x)", "no function of 4 arguments is called diff"),
    ("ORDER", 1, "f''(x)", "f'''(x)", "the order of a derivative must be at most 2, got 3"),
    ("DIGITS", 3, "123", "1234", "digits of a number must be at most 3, got 4"),
    ("DIGITS", 3, "63*65", "64*64", "the bits of a number must be at most 12, got 13"),
    ("DIGITS", 3, "1/63/65", "1/64/64", "the bits of a number must be at most 12, got 13"),
    ("EXPONENT", 3, "x**3", "x**4", "exponents must be at most 3, got 4"),
    ("EXPONENT", 3, "x**-3", "x**-4", "exponents must be at most 3, got 4"),
    ("EXPONENT", 3, "x**(1/3)", "x**(1/4)", "the degree of a root must be at most 3, got 4"),
    ("NAME", 3, "abc", "abcd", "the length of a name must be at most 3, got 4"),
    ("SHIFT", 3, "u[n + 3]", "u[n + 4]", "a shift must be at most 3, got 4"),
    ("SHIFT", 3, "u[n - 3]", "u[n - 4]", "a shift must be at most 3, got 4"),
    ("NESTING", 3, "((x))", "(((x)))", "brackets in brackets must be at most 3, got 4"),
    ("NESTING", 3, "((x)) + ((x))", "exp(exp(exp(x)))", "brackets in brackets must be at most 3"),
]


@pytest.mark.parametrize("case", TEXTS, ids=lambda case: case[3])
def test_a_text_at_a_limit(
    case: tuple[str, int, str, str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    limit, value, good, bad, message = case
    read(good)
    read(bad)
    monkeypatch.setattr(reading, limit, value)
    read(good)
    with pytest.raises(CertificateError, match=message):
        read(bad)


def test_a_place_has_five_digits() -> None:
    scope = Scope(Nodes())
    places = [scope.nodes.rational(n) for n in range(12)]
    assert [formula(scope, text, places) for text in ("#0", "#11", "#00011")] == [
        places[0],
        places[11],
        places[11],
    ]
    for text in ("#12", "#000011", "#0 1", "#99999"):
        with pytest.raises(CertificateError, match="expected"):
            formula(scope, text, places)


def made(count: int) -> Callable[[], object]:
    def grow() -> None:
        table = Nodes()
        for n in range(count):
            table.rational(n)

    return grow


def deep(levels: int) -> Callable[[], object]:
    def grow() -> None:
        table = Nodes()
        node = table.rational(1)
        for _ in range(levels - 1):
            node = table.add("exp", node)

    return grow


@pytest.mark.parametrize(
    ("limit", "value", "good", "bad", "message"),
    [
        ("NODES", 2, made(4), made(5), "the number of nodes must be at most 4, got 5"),
        ("DEPTH", 3, deep(3), deep(4), "the depth of a formula must be at most 3, got 4"),
        ("DIGITS", 3, lambda: number("1/2"), lambda: number("1/23"), "digits of a number"),
    ],
)
def test_a_table_of_nodes_at_a_limit(
    limit: str,
    value: int,
    good: Callable[[], object],
    bad: Callable[[], object],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bad()
    monkeypatch.setattr(nodes, limit, value)
    good()
    with pytest.raises(CertificateError, match=message):
        bad()


def test_a_list_at_its_limit() -> None:
    assert listed([1, 2], 2, "it") == listed([1, 2], 2, "it", exactly=True) == [1, 2]
    with pytest.raises(CertificateError, match="the length of it must be at most 2, got 3"):
        listed([1, 2, 3], 2, "it")
    for length in (1, 3):
        with pytest.raises(CertificateError, match=f"it must be a list of {length}"):
            listed([1, 2], length, "it", exactly=True)
    for value in ((1, 2), {}, "ab"):
        with pytest.raises(CertificateError, match=r"it must be a list$"):
            listed(value, 9, "it")


def test_an_integer_is_shown_where_it_is_short() -> None:
    assert [integer(n, 0, 3, "it") for n in (0, 3)] == [0, 3]
    for value, shown in ((4, "4"), (10**9 - 1, "999999999"), (10**9, "int"), (-(10**9), "int")):
        with pytest.raises(CertificateError, match=f"it must be .* from 0 to 3, got {shown}$"):
            integer(value, 0, 3, "it")


SIMPLE = ("u - x", "u = x", ["x"], {"x": "1"})


def accepted_at(
    monkeypatch: pytest.MonkeyPatch,
    module: ModuleType,
    limit: str,
    edge: int,
    data: Data,
    message: str,
) -> None:
    """Accept a certificate where a limit is at an edge, and refuse it where it is below."""
    assert check_certificate(data)
    monkeypatch.setattr(module, limit, edge)
    assert check_certificate(data)
    monkeypatch.setattr(module, limit, edge - 1)
    with pytest.raises(CertificateError, match=message):
        check_certificate(data)


def with_forms(number_of: int, names: str = "xyz") -> Data:
    proof = Proof()
    one, zero = proof.place("1"), proof.place("0")
    letters = [proof.place(letter) for letter in names[:number_of]]
    rows = [[[one if i == j else zero for j in letters], zero] for i in letters]
    data = proof.data([], dict.fromkeys(names, "1"), more=[["forms", letters, rows]])
    data["generators"] += [["atom", proof.place(letter)] for letter in names[number_of:]]
    statement = {"variables": [*names], "equations": ["u - x"], "solutions": ["u = x"]}
    return signed(statement, proof, data)


def with_parts(number_of: int) -> Data:
    proof = Proof()
    same = proof.data(["x"], {"x": "1"})
    places = [proof.place(f"x**{n + 2}") for n in range(number_of)]
    parts = [[place, place, same] for place in places]
    more = [["part", n] for n in range(number_of)]
    data = proof.data([], {"x": "1"}, parts=parts)
    data["generators"] = [["atom", proof.place("x")], *more]
    return signed({"equations": ["u - x"], "solutions": ["u = x"]}, proof, data)


def many_formulas(count: int) -> Data:
    proof = Proof()
    data = proof.data(["x"], {"x": "1"})
    for n in range(count - len(proof.formulas)):
        proof.place(str(n))
    return signed({"equations": ["u - x"], "solutions": ["u = x"]}, proof, data)


def named(name: str) -> Data:
    data = certificate(*SIMPLE) | {"name": name}
    return data | {"digest": check.digest(data)}


@pytest.mark.parametrize(
    ("limit", "edge", "data", "message"),
    [
        ("NAME", 6, named("attack"), "the name must be a short printable text"),
        ("FORMS", 3, with_forms(3), "no generator is written"),
        ("GENERATORS", 3, with_forms(3), "generators must be at most 2, got 3"),
        ("GENERATORS", 3, with_forms(2), "generators must be at most 2, got 3"),
        ("GENERATORS", 4, with_forms(0), "length of generators must be at most 3, got 4"),
        ("PARTS", 2, with_parts(2), "the length of parts must be at most 1, got 2"),
        ("NODES", 5, many_formulas(5), "the length of formulas must be at most 4, got 5"),
    ],
)
def test_a_certificate_at_a_limit(
    limit: str, edge: int, data: Data, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    accepted_at(monkeypatch, check, limit, edge, data, message)


def test_hints_are_at_most_as_many_as_nodes(monkeypatch: pytest.MonkeyPatch) -> None:
    proof = Proof()
    atoms = ["x", "y", "z"]
    data = proof.data(atoms, dict.fromkeys("xyz", "1"))
    proof.formulas = atoms
    statement = {"variables": ["x", "y", "z"], "equations": ["u - x"], "solutions": ["u = x"]}
    accepted_at(
        monkeypatch, check, "NODES", 3, signed(statement, proof, data), "the length of .* at most 2"
    )


def test_a_part_has_no_parts_of_its_own() -> None:
    proof = Proof()
    place = proof.place("x**2")
    same = proof.data(["x"], {"x": "1"})
    inner = proof.data(["x"], {"x": "1"}, parts=[[place, place, same]])
    data = proof.data(["x"], {"x": "1"}, parts=[[place, place, inner]], more=[["part", 0]])
    bad = signed({"equations": ["u - x"], "solutions": ["u = x"]}, proof, data)
    with pytest.raises(CertificateError, match="the length of parts must be at most 0, got 1"):
        check_certificate(bad)


@pytest.mark.parametrize("number_of", [-1, 1])
def test_a_part_is_one_of_those_that_are_given(number_of: int) -> None:
    data = with_parts(1)
    data["proof"]["generators"][1] = ["part", number_of]
    with pytest.raises(CertificateError, match="no generator is written"):
        check_certificate(data | {"digest": check.digest(data)})


def test_the_branches_of_a_denominator_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    u = "1/(2 + abs(x) + x**(1/3))"
    data = certificate(f"u - {u}", f"u = {u}", ["x", "abs(x)", "x**(1/3)"], {"x": "1/2"})
    message = "the branches of a denominator must be at most 5, got 6"
    accepted_at(monkeypatch, denominators, "BRANCHES", 6, data, message)


def test_a_file_at_its_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "c.json"
    path.write_text("[7, 8]", encoding="utf-8")
    monkeypatch.setattr(command, "FILE_BYTES", 6)
    assert command.certificates(str(path)) == [7, 8]
    path.write_text("[]", encoding="utf-8")
    assert command.certificates(str(path)) == [[]]
    monkeypatch.setattr(command, "FILE_BYTES", 1)
    with pytest.raises(CertificateError, match="the file must have at most 1 bytes"):
        command.certificates(str(path))


def statement(**parts: list[str]) -> dict[str, list[str]]:
    kept = {"variables": ["x"], "equations": ["u"], "solutions": ["u = 1"], "parameters": []}
    return {**kept, "domain": [], **parts}


MANY: list[tuple[Callable[[int], dict[str, list[str]]], int, str]] = [
    (lambda n: {"variables": [f"x{i}" for i in range(n)]}, 8, "1 to 8 variables"),
    (lambda n: {"equations": ["u"] * n}, 8, "1 to 8 equations"),
    (lambda n: {"solutions": ["u = 1", *(f"v{i} = 1" for i in range(n - 1))]}, 8, "1 to 8 equa"),
    (lambda n: {"domain": ["x > 0"] * n}, 400, "the length of domain must be at most 400, got 401"),
]


@pytest.mark.parametrize("case", MANY, ids=lambda case: case[2])
def test_a_statement_at_a_limit(
    case: tuple[Callable[[int], dict[str, list[str]]], int, str],
) -> None:
    parts, limit, message = case
    read_statement(Nodes(), statement(**parts(limit)))
    with pytest.raises(CertificateError, match=message):
        read_statement(Nodes(), statement(**parts(limit + 1)))


def test_a_coefficient_in_an_argument_at_its_limit() -> None:
    assert [whole(fmpq(n)) for n in (1000, -1000)] == [1000, -1000]
    for value in (fmpq(1001), fmpq(-1001)):
        with pytest.raises(CertificateError, match="coefficients must be at most 1000, got 1001"):
            whole(value)
    with pytest.raises(CertificateError, match="must be integers"):
        whole(fmpq(1, 2))


def test_a_share_of_a_turn_has_a_small_denominator() -> None:
    table = Nodes()
    shares = {text: fraction_of_turn(table, axiom(table, text)) for text in (
        "I*pi/60", "I*pi/61", "I*pi", "2*pi*I/3", "pi/3", "I/3", "I*I*pi", "I*pi*pi", "-I*pi/7",
    )}  # fmt: skip
    assert shares == {
        "I*pi/60": fmpq(1, 60), "I*pi/61": None, "I*pi": 1, "2*pi*I/3": fmpq(2, 3), "pi/3": None,
        "I/3": None, "I*I*pi": None, "I*pi*pi": None, "-I*pi/7": fmpq(-1, 7),
    }  # fmt: skip


def test_digits_and_powers_of_ten() -> None:
    assert rational("1e-3") == fmpq(1, 1000)
    assert rational("12.50e1") == 125
    assert rational(".5E+1") == 5


def test_an_equation_may_be_as_deep_as_the_table_allows() -> None:
    """Its images are made from the inside out, so that Python's own stack does not end it."""
    levels, names = 24, [f"p{n}" for n in range(9)]
    parameters, inner = [], "x"
    for name in names:
        for _ in range(levels):
            inner = f"(x + 2*({inner}))"
        parameters.append(f"{name} = {inner}")
        inner = name
    more: dict[str, Any] = {"parameters": parameters}
    data = certificate(f"u - x + 0*{names[-1]}", "u = x", ["x"], {"x": "1"}, more)
    assert "equation: u - x" in check_certificate(data)


def with_generators(count: int) -> Data:
    return certificate(*SIMPLE[:2], ["x", *(f"exp({n})" for n in range(1, count))], {"x": "1"})


def with_branches(count: int) -> Data:
    u = f"1/(2 + x**(1/{count}))"
    return certificate(f"u - {u}", f"u = {u}", ["x", f"x**(1/{count})"], {"x": "1/2"})


def filled(count: int) -> object:
    """A table with so many nodes, all but the last one put there."""
    table = Nodes()
    table.all = [("I",)] * (count - 1)
    return table.rational(1)


def of_degree(degree: int) -> object:
    made = Ring(1)
    return made.product(made.generators[0] ** degree, made.context.constant(1))


ALLOWED: list[tuple[str, int, Callable[[int], object]]] = [
    ("digits of a number", 2000, lambda n: number("1" * n)),
    ("exponents", 1000, lambda n: read(f"x**{n}")),
    ("the length of a name", 60, lambda n: read("k" * n)),
    ("a shift", 1000, lambda n: read(f"u[n + {n}]")),
    ("brackets in brackets", 60, lambda n: read("(" * (n - 1) + "x" + ")" * (n - 1))),
    ("the order of a derivative", 12, lambda n: read("u_" + "x" * n)),
    ("the depth of a formula", 500, lambda n: deep(n)()),
    ("the number of nodes", 40_000, filled),
    ("no generator is written", 4, lambda n: check_certificate(with_forms(n, "vwxyz"))),
    ("the length of parts", 8, lambda n: check_certificate(with_parts(n))),
    ("generators", 64, lambda n: check_certificate(with_generators(n))),
    ("the branches of a denominator", 64, lambda n: check_certificate(with_branches(n))),
    ("the work of polynomial products", 50_000_000, lambda n: Ring(1).spend(n)),
    ("the bits of a coefficient", 1_000_000, lambda n: Ring(1).number(2 ** (n - 1)) ** 1),
    ("degrees", 3_000, of_degree),
]
"""What is said beyond a limit, the limit, and what has so much of it."""


@pytest.mark.parametrize("case", ALLOWED, ids=lambda case: case[0])
def test_a_limit_is_what_it_is_said_to_be(case: tuple[str, int, Callable[[int], object]]) -> None:
    words, limit, take = case
    take(limit)
    with pytest.raises(CertificateError, match=words):
        take(limit + 1)


def test_a_denominator_of_400_terms_or_degree_100_is_split() -> None:
    made = Ring(2)
    x, y = made.generators
    terms = [x**i * y**j for j in range(21) for i in range(20)]
    for count, degree, parts in ((400, 0, 2), (401, 0, 1), (0, 100, 2), (0, 101, 1)):
        inner = sum(terms[1:count], terms[0]) if count else x ** (degree - 1) + y
        assert min(len(made.split(y * inner)[1]), 2) == parts
