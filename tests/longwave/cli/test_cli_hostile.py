"""Hostile certificates: refused in one line, within seconds, with little memory."""

import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from longwave.__main__ import main
from longwave.cli import certificates as limits
from longwave.cli.certificates import run_limited
from longwave.verify.kernel import check_certificate
from longwave.verify.kernel.limits import digest
from longwave.verify.proof import CertificateError, prove_form

Data = dict[str, Any]
Output = pytest.CaptureFixture[str]
SECONDS = 5


@pytest.fixture(scope="module")
def good() -> str:
    from longwave.solutions import closed_form

    return json.dumps(dict(prove_form(closed_form("kink")).certificate or {}) | {"name": "mine"})


def tower(data: Data) -> None:
    """Return a certificate with 9**9**9**9, built from integer exponents."""
    add(data, "f0 = 9", *(f"f{k + 1} = f{k}**999" for k in range(6)), "f6")


def add(data: Data, *texts: str) -> None:
    """Add definitions, and multiply the formula by the last one."""
    *definitions, factor = texts
    data["statement"]["parameters"] += definitions
    data["statement"]["solutions"][0] += f" + {factor}"


def chain(data: Data, count: int, text: str) -> None:
    data["statement"]["parameters"].append("f0 = X")
    names = [f"f{k + 1} = " + text.replace("_", f"f{k}") for k in range(count)]
    data["proof"]["formulas"] = names if count > 300 else data["proof"]["formulas"]
    add(data, *names[:300], f"f{min(count, 300)}")


def squares(data: Data) -> None:
    """Return (1 + X + T + ...)**2 squared ten times: more than 3e5 terms."""
    first = "f0 = 1 + X + T + a + c"
    add(data, first, *(f"f{k + 1} = f{k}**9" for k in range(10)), "f10")


def equation(data: Data, text: str) -> None:
    data["statement"]["equations"][0] += f" + {text}"


def hint(data: Data, text: Any) -> None:
    data["proof"]["formulas"].append(text)


ATTACKS: dict[str, Callable[[Data], Any]] = {
    "a hundred thousand jets": lambda d: equation(d, "*".join(["U_T"] * 10**5)),
    "63 jets": lambda d: equation(d, "*".join(["U_T"] * 63)),
    "a huge power of a jet": lambda d: equation(d, "U_T**1000000000"),
    "a sum of jets to a power": lambda d: equation(d, "(U + U_X + U_T + X)**60"),
    "order 13": lambda d: equation(d, "U_" + "X" * 13),
    "order 12": lambda d: equation(d, "U_" + "X" * 12),
    "a derivative in a parameter": lambda d: equation(d, "diff(U, a)"),
    "brackets in brackets": lambda d: equation(d, "sin(" * 10**5 + "X"),
    "minus signs": lambda d: equation(d, "-" * 10**5 + "X"),
    "powers of powers": lambda d: equation(d, "2**" * 10**5 + "2"),
    "a sum nested in sin": lambda d: chain(d, 10**5, "sin(_)"),
    "a deep sum": lambda d: chain(d, 10**5, "_ + _"),
    "300 times sin": lambda d: chain(d, 300, "sin(_)"),
    "exp of exp": lambda d: chain(d, 60, "exp(_)"),
    "a surrogate in a name": lambda d: add(d, "\ud800"),
    "a line in a text": lambda d: add(d, "a\nb"),
    "a surrogate as its name": lambda d: d.update(name="\ud800"),
    "a name that is a list": lambda d: d.update(name=[["x"]]),
    "power 1e8": lambda d: add(d, "X**100000000"),
    "power -1e8": lambda d: add(d, "X**(-100000000)"),
    "a root of degree 1e8": lambda d: add(d, "X**(1/100000000)"),
    "power 999": lambda d: add(d, "(1 + X + T)**999"),
    "a tower": tower,
    "a huge polynomial": squares,
    "a hundred thousand digits": lambda d: add(d, "9" * 10**5),
    "digits after digits": lambda d: add(d, "1e999*" * 10**4 + "1"),
    "unequal digits": lambda d: add(d, "\u0663"),
    "a division by 0": lambda d: add(d, "1/0"),
    "0 to the power -1": lambda d: add(d, "0**(-1)"),
    "a hundred thousand terms": lambda d: add(d, "+".join(["X"] * 10**5)),
    "a formula that is a number": lambda d: hint(d, 0.5),
    "a place ahead": lambda d: hint(d, "#1000000"),
    "a place of many digits": lambda d: hint(d, "#" + "9" * 10**5),
    "a place that is no integer": lambda d: hint(d, "#0.5"),
    "an unknown function": lambda d: hint(d, "eval(X)"),
    "formulas that are none": lambda d: d["proof"].update(formulas=None),
    "a proof that is none": lambda d: d.update(proof=7),
    "hints of hints": lambda d: d["proof"].update(values=[[0, [[[], []]]]]),
    "a hundred thousand generators": lambda d: d["proof"].update(generators=[["atom", 0]] * 10**5),
    "generators of nothing": lambda d: d["proof"].update(generators=[[]]),
    "a part of itself": lambda d: d["proof"].update(generators=[["part", 0]], parts=[[0, 0, {}]]),
    "a point that is text": lambda d: d["proof"].update(point="1/2"),
    "no variables": lambda d: d["statement"].update(variables=[]),
    "a variable that is a list": lambda d: d["statement"].update(variables=[[]]),
    "a statement that is a list": lambda d: d.update(statement=[1, 2]),
}


IN_THE_COMMAND = (
    "a surrogate in a name",
    "a line in a text",
    "a surrogate as its name",
    "a name that is a list",
    "a hundred thousand digits",
    "a tower",
    "a deep sum",
    "unequal digits",
    "hints of hints",
)
"""Attacks on the command that the default suite makes: on what it prints, and on its limits."""


def seconds_of_children() -> float:
    usage = os.times()
    return usage.children_user + usage.children_system


def attacked(text: str, attack: str) -> str:
    data = json.loads(text)
    ATTACKS[attack](data)
    return json.dumps(data | {"digest": digest(data)})


@pytest.mark.parametrize(
    "attack",
    [pytest.param(a, marks=[pytest.mark.slow] * (a not in IN_THE_COMMAND)) for a in ATTACKS],
)
def test_a_hostile_certificate_is_refused_in_one_line(
    attack: str, good: str, tmp_path: Path, capsys: Output
) -> None:
    path = tmp_path / "c.json"
    path.write_text(attacked(good, attack), encoding="utf-8")
    start = seconds_of_children()
    assert main(["check", str(path)]) == 1
    assert seconds_of_children() - start < SECONDS + 1
    output = capsys.readouterr()
    assert output.err.count("\n") == 1
    assert output.err.startswith(f"{path}: rejected: ")
    assert "Traceback" not in output.err
    assert output.out == ""


@pytest.mark.parametrize("attack", ATTACKS)
def test_the_checker_itself_stays_within_its_budget(attack: str, good: str) -> None:
    """The checker's own limits are tested without those of the process."""
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
    assert main(["check", str(path)]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "rejected" in error


def test_a_long_file_is_not_read(tmp_path: Path, capsys: Output) -> None:
    path = tmp_path / "c.json"
    with path.open("wb") as file:
        file.truncate(2**32)
    assert main(["check", str(path)]) == 1
    assert "at most 8000000 bytes" in capsys.readouterr().err


@pytest.mark.slow
def test_endless_work_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    def endless() -> str:
        while True:
            pass

    monkeypatch.setattr(limits, "MOST_SECONDS", 1)
    with pytest.raises(CertificateError, match="more than 1 s"):
        run_limited(endless)


def test_unlimited_memory_is_refused() -> None:
    with pytest.raises(CertificateError, match="500 MB"):
        run_limited(lambda: str(len(bytearray(2 * 10**9))))


def test_a_result_within_the_limits_is_returned() -> None:
    assert run_limited(lambda: "ä\nb") == "ä\nb"
