"""A small part of what `searches/kernel_attacks.py` does, and faults that it must see."""

from dataclasses import replace
from random import Random

import pytest
from flint import fmpq

from longwave.derive.algebra.formula_tree import FormulaTree, Unknown
from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.node_balls import Balls
from longwave.verify.kernel.reading import Scope, TextReader
from longwave.verify.kernel.signs import Signs
from longwave.verify.proof.typed_balls import TypedBalls, TypedPlace
from searches import kernel_attacks
from searches.false_certificates import false_certificates
from searches.text_balls import CannotJudge, TextBalls


@pytest.mark.parametrize(("name", "count"), [("reading", 200), ("signs", 700)])
def test_a_search_finds_nothing(name: str, count: int) -> None:
    counts, failures, _ = kernel_attacks.search(name, count, 1)
    assert not failures, failures[0]
    assert counts.total() >= count


def forgeries(seed: str, inputs: int) -> list[str]:
    """The kinds of the false certificates that are accepted, none of them of a long proof."""
    accepted = []
    for number in range(inputs):
        for kind, data in false_certificates(Random(f"{seed} {number}"), whole=False):
            try:
                check_certificate(data)
            except CertificateError:
                continue
            accepted.append(kind)
    return accepted


def test_no_false_certificate_is_accepted() -> None:
    assert forgeries("quick", 60) == []


def test_the_search_sees_the_ball_of_a_constant_parity(monkeypatch: pytest.MonkeyPatch) -> None:
    """2*(-1)**1 counted as positive."""
    right = Balls._ball

    def ball(self: Balls, node: int) -> object:
        found = right(self, node)
        return found**2 if self._nodes.all[node][0] == "parity" else found

    monkeypatch.setattr(Balls, "_ball", ball)
    assert kernel_attacks.search("signs", 100, 4)[1]


def test_the_search_sees_a_name_that_reads_as_a_derivative(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Scope, "refuse_likeness", lambda self, name: None)
    assert kernel_attacks.search("reading", 100, 10)[1]


def test_the_search_sees_that_a_sign_is_squared_to_one(monkeypatch: pytest.MonkeyPatch) -> None:
    right = TextReader.power

    def power(self: TextReader, base: int, exponent: fmpq) -> int:
        if self._nodes.all[base][0] == "sign" and exponent == 2:
            return self._nodes.rational(1)
        return right(self, base, exponent)

    monkeypatch.setattr(TextReader, "power", power)
    assert kernel_attacks.search("reading", 100, 9)[1]


def test_the_search_sees_trees_without_their_shifts(monkeypatch: pytest.MonkeyPatch) -> None:
    """u[n+1] taken at n."""
    need, value = TypedBalls._need, TypedPlace._value

    def here(formula: FormulaTree) -> FormulaTree:
        return replace(formula, shift=0) if isinstance(formula, Unknown) else formula

    monkeypatch.setattr(TypedBalls, "_need", lambda self, f, tops: need(self, here(f), tops))
    monkeypatch.setattr(TypedPlace, "_value", lambda self, f: value(self, here(f)))
    assert kernel_attacks.search("reading", 100, 9)[1]


def test_the_search_sees_a_root_of_any_real_value(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Signs, "not_negative", Signs.is_real)
    assert kernel_attacks.search("signs", 100, 7)[1]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2**3**2 - 512", 0),
        ("-2**2 + 4", 0),
        ("sign(1 + I)**2 - I", 0),
        ("diff(x**2*y**3, x, y, y) - 12*x*y", 0),
        ("jacobi_sn(x, 1/2)**2 + jacobi_cn(x, 1/2)**2", 1),
        ("u[n + 2] - u_x", 16),
    ],
)
def test_the_second_reader(text: str, value: int) -> None:
    statement = {"variables": ["x", "n"], "parameters": [], "solutions": ["u = x + n**2"]}
    point = {"x": fmpq(1, 1), "n": fmpq(2), "y": fmpq(1, 3)}
    assert TextBalls(statement).value(text, point).contains(value)
    with pytest.raises(CannotJudge):
        TextBalls(statement).value("1/(x - 1)", point)
