"""Certificates that are none: each is refused in one line, whatever it holds."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from functools import cache
from typing import Any

import pytest

from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.limits import digest
from longwave.verify.kernel.nodes import Nodes, integer, number
from longwave.verify.proof.statement_verdict import StatementVerdict
from longwave.verify.proof.text_prover import prove

Data = dict[str, Any]

SOLITON = ("u_t + 6*u*u_x + u_xxx", "u = 2*k**2*sech(k*(x - 4*k**2*t))**2", "k: k>0")


@cache
def text_of(*stated: str) -> str:
    verdict = prove(stated[0], stated[1], parameters=stated[2])
    assert isinstance(verdict, StatementVerdict)
    return json.dumps(verdict.certificates[0])


def sound() -> Data:
    """A certificate that is accepted, to be spoiled."""
    data: Data = json.loads(text_of(*SOLITON))
    return data


def refused(data: Any, words: str = ".") -> None:
    with pytest.raises(CertificateError, match=words) as raised:
        check_certificate(data)
    assert "\n" not in str(raised.value)


def changed(change: Callable[[Data], object]) -> Data:
    data = sound()
    change(data)
    return data | {"digest": digest(data)}


def test_the_one_that_is_spoiled_is_accepted() -> None:
    assert "u_xxx" in check_certificate(sound())
    assert "u_xxx" in check_certificate(changed(lambda data: None))


@pytest.mark.parametrize("data", [None, 3, "text", [], [sound]])
def test_what_is_no_object(data: Any) -> None:
    refused(data, "certificate must be an object")


@pytest.mark.parametrize("key", ["format", "name", "statement", "proof", "digest"])
def test_what_lacks_a_part(key: str) -> None:
    data = sound()
    del data[key]
    if key in ("statement", "proof"):
        data["digest"] = digest(data)
    refused(data, f"the certificate lacks '{key}'")


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("format", "longwave proof 3", "prove the statement again"),
        ("format", "longwave proof 5", "prove the statement again"),
        ("name", "two\nlines", "the name must be"),
        ("name", "n" * 1000, "the name must be"),
        ("name", 3, "the name must be"),
        ("digest", "0" * 64, "the digest does not match"),
    ],
)
def test_what_is_headed_otherwise(key: str, value: Any, words: str) -> None:
    refused(sound() | {key: value}, words)


LISTS = ("formulas", "generators", "values", "signs", "point")
OTHER_KINDS = [
    *((part, value) for part in (*LISTS, "parts") for value in (None, 7, "text", {"a": 1})),
    *((part, value) for part in LISTS for value in ([None], [[]], [[1, 2, 3]], [["x"]])),
]
"""Parts within the proof are looked at where they are used."""


@pytest.mark.parametrize(("part", "value"), OTHER_KINDS)
def test_parts_of_a_proof_that_are_of_another_kind(part: str, value: Any) -> None:
    data = changed(lambda data: data["proof"].__setitem__(part, value))
    with pytest.raises(CertificateError) as raised:
        check_certificate(data)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("part", ["variables", "equations", "solutions", "parameters", "domain"])
@pytest.mark.parametrize("value", [None, 7, "text", [None], [7], [""], ["k"], ["(" * 10_000]])
def test_parts_of_a_statement_that_are_of_another_kind(part: str, value: Any) -> None:
    data = changed(lambda data: data["statement"].__setitem__(part, value))
    with pytest.raises(CertificateError) as raised:
        check_certificate(data)
    assert "\n" not in str(raised.value)


def test_a_proof_without_end() -> None:
    nested: list[Any] = []
    for _ in range(50_000):
        nested = [nested]
    data = sound()
    data["proof"]["parts"] = nested
    with pytest.raises(CertificateError):
        check_certificate(data)


@pytest.mark.parametrize("place", [-1, 99, 10**12, "0", None, 0.5, True])
@pytest.mark.parametrize("part", ["generators", "point", "values"])
def test_places_of_no_formula(part: str, place: Any) -> None:
    def misplaced(data: Data) -> None:
        row = data["proof"][part][-1]
        row[1 if part == "generators" else 0] = place

    refused(changed(misplaced))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (3, "numbers must be text"),
        ("0.5", "numbers must be written"),
        ("1/0", "numbers must have a denominator"),
        ("\u0661", "numbers must be written"),
        ("1" * 100_000, "digits of a number"),
    ],
)
def test_numbers_that_are_none(text: Any, words: str) -> None:
    with pytest.raises(CertificateError, match=words):
        number(text)
    point = changed(lambda data: data["proof"]["point"][0].__setitem__(1, text))
    refused(point, words)


@pytest.mark.parametrize("value", [True, "1", 1.0, -1, 10, 10**12, None])
def test_integers_that_are_none(value: Any) -> None:
    assert integer(9, 0, 9, "it") == 9
    with pytest.raises(CertificateError, match="it must be an integer from 0 to 9"):
        integer(value, 0, 9, "it")


def test_generators_that_are_of_no_kind() -> None:
    def kind(name: str) -> Callable[[Data], object]:
        return lambda data: data["proof"]["generators"][-1].__setitem__(0, name)

    refused(changed(kind("atoms")))
    refused(changed(lambda data: data["proof"]["generators"].pop()))
    refused(changed(lambda data: data["proof"]["generators"].reverse()))
    twice = changed(lambda data: data["proof"]["generators"].append(["atom", 0]))
    refused(twice)


def test_a_point_without_a_value_or_with_one_of_a_formula() -> None:
    refused(changed(lambda data: data["proof"]["point"].pop()))
    exponential = [3, "1/2"]
    data = changed(lambda data: data["proof"]["point"].append(exponential))
    refused(data, "the point must give symbols their values")
    negative = changed(lambda data: data["proof"]["point"][0].__setitem__(1, "-1"))
    refused(negative)


def test_derivatives_along_sites_and_of_formulas_in_solutions() -> None:
    def stated(**parts: list[str]) -> Data:
        data = copy.deepcopy(sound())
        data["statement"] |= {"parameters": [], **parts}
        return data | {"digest": digest(data)}

    lattice = stated(variables=["n"], equations=["diff(u[n], n)"], solutions=["u[n] = 1"])
    refused(lattice)
    own = stated(variables=["x"], equations=["u"], solutions=["u = diff(x**2, x)"])
    refused(own)
    unknown = stated(variables=["x"], equations=["u"], solutions=["u = u"])
    refused(unknown)


def test_integers_follow_from_integers() -> None:
    nodes = Nodes()
    n, x = nodes.add("symbol", "n", "integer"), nodes.add("symbol", "x", "real")
    two, half = nodes.rational(2), nodes.add("number", number("1/2"))
    whole = [n, two, nodes.add("Add", n, two), nodes.add("Mul", n, two)]
    assert all(map(nodes.is_integer, whole))
    assert nodes.is_integer(nodes.add("Pow", n, number("2")))
    others = [x, half, nodes.add("Add", n, x), nodes.add("Pow", n, number("-1")), nodes.add("I")]
    assert not any(map(nodes.is_integer, others))
