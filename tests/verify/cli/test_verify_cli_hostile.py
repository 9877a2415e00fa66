"""Hostile certificates: one line, a few seconds, little memory, whatever is in them."""

import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from verify.__main__ import main
from verify.cli import certificates as limits
from verify.cli.certificates import limited
from verify.kernel import check_certificate
from verify.kernel.limits import digest
from verify.proof import CertificateError, prove_form

Data = dict[str, Any]
Output = pytest.CaptureFixture[str]
SECONDS = 5


@pytest.fixture(scope="module")
def good() -> str:
    from solutions import closed_form

    return json.dumps(dict(prove_form(closed_form("kink")).certificate or {}) | {"name": "mine"})


def tower(data: Data) -> None:
    """9**9**9**9, through integer exponents."""
    add(data, ["number", "9"])
    for _ in range(6):
        add(data, ["Pow", len(data["nodes"]) - 1, "999"])


def add(data: Data, *nodes: list[Any]) -> None:
    """Add nodes and multiply the formula by the last."""
    data["nodes"] += nodes
    formula = data["statement"]["unknowns"][0]
    data["nodes"].append(["Mul", formula[1], len(data["nodes"]) - 1])
    formula[1] = len(data["nodes"]) - 1


def chain(data: Data, count: int, name: str) -> None:
    place = data["statement"]["variables"][0]
    for _ in range(count):
        data["nodes"].append([name, place] if name != "Add" else ["Add", place, place])
        place = len(data["nodes"]) - 1
    data["statement"]["unknowns"][0][1] = place


def squares(data: Data) -> None:
    """(1 + x + t + ...)**2 squared ten times: 3e5 terms and more."""
    variables = data["statement"]["variables"]
    data["nodes"].append(["Add", *range(3), *variables])
    for _ in range(10):
        data["nodes"].append(["Pow", len(data["nodes"]) - 1, "9"])
    data["statement"]["unknowns"][0][1] = len(data["nodes"]) - 1


def jets(data: Data, count: int) -> None:
    data["statement"]["equations"][0].append(["1", [], [[0, [0, 1]]] * count])


def order(data: Data, value: Any) -> None:
    data["statement"]["equations"][0][0][2][0][1][0] = value


ATTACKS: dict[str, Callable[[Data], Any]] = {
    "a million jets": lambda d: jets(d, 10**6),
    "63 jets": lambda d: jets(d, 63),
    "a negative order": lambda d: order(d, -1),
    "a huge order": lambda d: order(d, 10**9),
    "a fractional order": lambda d: order(d, 0.5),
    "a true order": lambda d: order(d, True),
    "order 12": lambda d: order(d, 12),
    "a sum nested in sin": lambda d: chain(d, 10**5, "sin"),
    "a deep sum": lambda d: chain(d, 10**5, "Add"),
    "400 times sin": lambda d: chain(d, 400, "sin"),
    "exp of exp": lambda d: chain(d, 60, "exp"),
    "a surrogate in a name": lambda d: add(d, ["symbol", "\ud800", "real"]),
    "a line in a name": lambda d: add(d, ["symbol", "a\nb", "real"]),
    "a surrogate as its name": lambda d: d.update(name="\ud800"),
    "a name that is a list": lambda d: d.update(name=[["x"]]),
    "power 1e8": lambda d: add(d, ["Pow", 0, "100000000"]),
    "power -1e8": lambda d: add(d, ["Pow", 0, "-100000000"]),
    "a root of degree 1e8": lambda d: add(d, ["Pow", 0, "1/100000000"]),
    "power 999": lambda d: add(d, ["Pow", d["statement"]["unknowns"][0][1], "999"]),
    "a tower": tower,
    "a huge polynomial": squares,
    "a million digits": lambda d: add(d, ["number", "9" * 10**6]),
    "unequal digits": lambda d: add(d, ["number", "٣"]),
    "a division by 0": lambda d: add(d, ["number", "1/0"]),
    "0 to the power -1": lambda d: add(d, ["number", "0"], ["Pow", len(d["nodes"]), "-1"]),
    "a path of zeros": lambda d: add(d, ["Add", *[0] * 10**6]),
    "a polynomial of zeros": lambda d: add(d, ["poly", [["1", [0] * 10**6]], *[0] * 10**6]),
    "huge exponents": lambda d: add(d, ["poly", [["1", [10**9]]], 0]),
    "a place that is no integer": lambda d: add(d, ["Add", 0.5, 0]),
    "a place ahead": lambda d: add(d, ["Add", 10**6, 0]),
    "a place behind": lambda d: add(d, ["Add", -1, 0]),
    "a node that is a number": lambda d: d["nodes"].append(3),
    "an unknown function": lambda d: add(d, ["eval", 0]),
    "nodes that are none": lambda d: d.update(nodes=None),
    "a proof that is none": lambda d: d.update(proof=7),
    "hints of hints": lambda d: d["proof"].update(sums=[[0, [[[], []]]]]),
    "a million generators": lambda d: d["proof"].update(generators=[["atom", 0]] * 10**6),
    "generators of nothing": lambda d: d["proof"].update(generators=[[]]),
    "a part of itself": lambda d: d["proof"].update(
        generators=[["part", 0, 0]], parts=[[0, 0, {}]]
    ),
    "a point that is text": lambda d: d["proof"].update(point="1/2"),
    "no variables": lambda d: d["statement"].update(variables=[]),
    "a statement that is a list": lambda d: d.update(statement=[1, 2]),
}


def seconds_of_children() -> float:
    usage = os.times()
    return usage.children_user + usage.children_system


def attacked(text: str, attack: str) -> str:
    data = json.loads(text)
    ATTACKS[attack](data)
    return json.dumps(data | {"digest": digest(data)})


@pytest.mark.parametrize("attack", ATTACKS)
def test_a_hostile_certificate_is_refused_in_one_line(
    attack: str, good: str, tmp_path: Path, capsys: Output
) -> None:
    path = tmp_path / "c.json"
    path.write_text(attacked(good, attack), encoding="utf-8")
    start = seconds_of_children()
    assert main(["check-certificate", str(path)]) == 1
    assert seconds_of_children() - start < SECONDS + 1
    output = capsys.readouterr()
    assert output.err.count("\n") == 1
    assert output.err.startswith(f"{path}: rejected: ")
    assert "Traceback" not in output.err
    assert output.out == ""


@pytest.mark.parametrize("attack", ATTACKS)
def test_the_checker_itself_stays_within_its_budget(attack: str, good: str) -> None:
    """Without the limits of the process: budgets come first."""
    data = json.loads(attacked(good, attack))
    start = time.process_time()
    with pytest.raises(CertificateError) as caught:
        check_certificate(data)
    assert time.process_time() - start < SECONDS
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(
    "text",
    [
        "[" * 10**6,
        '{"a":' * 10**5,
        '{"format": NaN}',
        '{"format": Infinity}',
        '{"format": 1, "format": 2}',
        '{"format": ' + "9" * 10**5 + "}",
        '"\\ud800"',
        "\x00" * 1000,
        "[" + "{}," * 1000 + "{}]",
    ],
)
def test_hostile_text_is_refused_in_one_line(text: str, tmp_path: Path, capsys: Output) -> None:
    path = tmp_path / "c.json"
    path.write_text(text, encoding="utf-8")
    assert main(["check-certificate", str(path)]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "rejected" in error


def test_a_long_file_is_not_read(tmp_path: Path, capsys: Output) -> None:
    path = tmp_path / "c.json"
    with path.open("wb") as file:
        file.truncate(2**32)
    assert main(["check-certificate", str(path)]) == 1
    assert "at most 8000000 bytes" in capsys.readouterr().err


def test_work_without_end_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    def endless() -> str:
        while True:
            pass

    monkeypatch.setattr(limits, "SECONDS", 1)
    with pytest.raises(CertificateError, match="more than 1 s"):
        limited(endless)


def test_memory_without_end_is_refused() -> None:
    with pytest.raises(CertificateError, match="500 MB"):
        limited(lambda: str(len(bytearray(2 * 10**9))))


def test_what_is_within_the_limits_is_handed_back() -> None:
    assert limited(lambda: "ä\nb") == "ä\nb"
