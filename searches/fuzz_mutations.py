"""Hostile values, and changes of texts, plain data and bytes.

Everything is drawn from a `random.Random`, so that one set of changes serves three drivers: a
seeded generator, whose cases are repeated by their numbers; one of hypothesis
(``st.randoms(use_true_random=False)``), which shrinks; and one that reads the bytes of atheris.
The changes start from valid files. Strategies of hypothesis generate values and change none.
"""

from __future__ import annotations

import json
import re
from random import Random
from typing import Any

NUMBERS = (
    *("0", "-0.0", "-1", "1e-300", "5e-324", "1e-51", "1e-12", "1e12", "1e49", "1e50", "1e300"),
    *("1.7976931348623157e308", "1e999", "-1e999", "nan", "-nan", "inf", "-inf", "2147483647"),
    *("2147483648", "4294967296", "9223372036854775807", "9223372036854775808", "0x7f", "1_000"),
    *("1" + "0" * 400, "0." + "0" * 400 + "1", "1e-7", "100000000", "1000000000", "0.1", "1", "2"),
    *("0.5", "3", "10", "1e-3", "1e-11", "1e3", "-1e9", "99"),
)
"""Of TOML, JSON and options alike, where these have them."""

TEXTS = (
    *("", " ", "x", "..", "/", "/dev/zero", "/nope/x", "-", "--", "-1", "1/0", "9**9**9", "0/0"),
    *("sqrt(-1)", "eps/2", "pi/2", "K/2", "1e999", "nan", "inf", "x**1e9", "exp(exp(exp(exp(9))))"),
    *("(" * 200, "x" * 200, "A" * 100_000, "-" * 3000, "__import__('os')", "().__class__", "\x00"),
    *("\x1b[31m", "\x07", "\u202e", "\ufeff", "\ud7ff", "\U0001f30a", "хx", "²", "∞", "[/nope]"),
    *("[bold]", "{x}", "%s", "${HOME}", "$(touch x)", "\\", "\n", "a\nb", "\t", "'", '"', "\x7f"),
    *(
        "\x85",
        "\u2028",
        "kink",
        "rational_2",
        "rational_99",
        "rational_-1",
        "nls_peregrine",
        "toda",
    ),
    *("mass_dimer", "square", "acoustic", "optical", "K2", "eps", "n", "I", "oo", "zoo", "u[n+1]"),
    *("u[n+999999]", "F[n+1] - 2*F[n]", "F[n+1] + F[n+1]", "x**3", "log(x)", "1/x", "sqrt(x)"),
    *("tan(pi/2 + x)", "abs(x)", "2**0.5", "0.1", "1e5"),
)


def toml_values() -> tuple[str, ...]:
    """Return values as they stand in a TOML file, right or wrong."""
    texts = tuple(_toml_text(text) for text in TEXTS)
    others = (
        *("true", "false", "1979-05-27", "07:32:00", "[]", "{}", "[[]]", "[1, 'a']", "[nan]"),
        *("[0, 0]", "[1, 0]", "[-1e9, 1e9]", "[0, 1e-300]", "[" * 200 + "]" * 200, "{a = {b = 1}}"),
        *("[" * 2000 + "]" * 2000, "[" + "0," * 3000 + "]", "'''x\ny'''", '"""', "'", "="),
        "[" + ", ".join(str(n) for n in range(1000)) + "]",
        *('{name = "x"}', "[{}]", '["u", "u"]', '["u", "v", "w"]', '"\\u0000"', '"\\ud800"'),
        "a.b.c.d", "{" + "a." * 300 + "b = 1}", "1.", ".5", "+1", "1e", "0b11", "0o7",
    )  # fmt: skip
    return NUMBERS + texts + others


def _toml_text(text: str) -> str:
    return json.dumps(text, ensure_ascii=True)


def change_toml(draw: Random, text: str, count: int | None = None) -> bytes:
    """Change some lines of a TOML text, and sometimes its bytes."""
    lines = text.splitlines()
    for _ in range(few(draw) if count is None else count):
        draw.choice(LINE_CHANGES)(draw, lines)
    found = "\n".join(lines).encode("utf-8", "surrogatepass")
    return change_bytes(draw, found) if draw.random() < 0.1 else found


def few(draw: Random) -> int:
    """Return a small number of changes, mostly one."""
    return draw.choice([1, 1, 1, 2, 2, 3, 5])


def _pairs(lines: list[str]) -> list[int]:
    return [i for i, line in enumerate(lines) if re.match(r"\s*[\w\"'.-]+\s*=", line)] or [0]


def _place(draw: Random, lines: list[str]) -> int:
    if not lines:
        lines.append("")
    return draw.randrange(len(lines))


def _change_value(draw: Random, lines: list[str]) -> None:
    _place(draw, lines)
    place = draw.choice(_pairs(lines))
    key = lines[place].partition("=")[0]
    lines[place] = f"{key}= {draw.choice(toml_values())}"


def _change_number(draw: Random, lines: list[str]) -> None:
    """Change a number anywhere: within a list, a formula, a key."""
    place = _place(draw, lines)
    found = list(re.finditer(r"\d+(?:\.\d+)?(?:e-?\d+)?", lines[place]))
    if found:
        one = draw.choice(found)
        new = draw.choice(NUMBERS) if draw.random() < 0.5 else f"{one[0]}e{draw.randint(-12, 12)}"
        lines[place] = lines[place][: one.start()] + new + lines[place][one.end() :]


def _change_word(draw: Random, lines: list[str]) -> None:
    """Change a part of a text, such as a name in a formula."""
    place = _place(draw, lines)
    found = list(re.finditer(r"[A-Za-z_]+|[-+*/()\[\]]", lines[place]))
    if found:
        one = draw.choice(found)
        new = draw.choice([*TEXTS, "(", ")", "*", "**", "-", "+", "/", "[", "]"])
        new = _toml_text(new)[1:-1]
        lines[place] = lines[place][: one.start()] + new + lines[place][one.end() :]


def _rename_key(draw: Random, lines: list[str]) -> None:
    _place(draw, lines)
    place = draw.choice(_pairs(lines))
    value = lines[place].partition("=")[2]
    keys = ("sites", "step", "order", "k", "\u00e9", '""', "a.b", "name", "'\x1b'", "x" * 5000, "1")
    lines[place] = f"{draw.choice(keys)} ={value}"


def _delete_line(draw: Random, lines: list[str]) -> None:
    del lines[_place(draw, lines)]


def _double_line(draw: Random, lines: list[str]) -> None:
    place = _place(draw, lines)
    lines.insert(_place(draw, lines), lines[place])


def _swap_lines(draw: Random, lines: list[str]) -> None:
    first, second = _place(draw, lines), _place(draw, lines)
    lines[first], lines[second] = lines[second], lines[first]


def _insert_line(draw: Random, lines: list[str]) -> None:
    new = (
        *("[lattice]", "[constants]", "[[spring]]", "[[problem]]", "[envelope]", "[long_wave]"),
        *("[sweep]", "[parameters]", "[" + "a." * 100 + "b]", "[[[x]]]", "tolerance = 1e-3", "#"),
        *('order = "corrected"', "half_width = 3", "times = [0, 1]", 'engine = "spectral"', "["),
        *('k = "pi/2"', "background = 1", "amplitude = 2", "time = 3", "sites = 200000000", "\x00"),
        *("look_points = 1000000000", "curve_points = 100000000", "compared = 10000000", "x = 1"),
        *("t0 = -1e9", 'solve = "k, a, b, c"', 'domain = "x < x"', "step = 1e-7", '[""]'),
        "snapshots = [" + ", ".join(str(n) for n in range(2000)) + "]",
    )
    lines.insert(_place(draw, lines), draw.choice(new))


def _truncate_line(draw: Random, lines: list[str]) -> None:
    place = _place(draw, lines)
    lines[place] = lines[place][: draw.randint(0, len(lines[place]))]
    if draw.random() < 0.5:
        del lines[place + 1 :]


LINE_CHANGES = (
    *(_change_value,) * 5,
    *(_change_number,) * 4,
    *(_change_word,) * 2,
    *(_rename_key, _delete_line, _double_line, _swap_lines, _insert_line, _truncate_line),
)


def change_bytes(draw: Random, content: bytes) -> bytes:
    """Change some bytes: flip, cut off or double them, or put a mark in front."""
    kind = draw.randrange(5)
    place = draw.randint(0, len(content))
    if kind == 0:
        return content[:place]
    if kind == 1:
        return b"\xef\xbb\xbf" + content
    if kind == 2:
        return content[:place] + bytes([draw.randrange(256)]) + content[place + 1 :]
    if kind == 3:
        return content[:place] + content[place // 2 :]
    return (
        content[:place] + draw.choice([b"\x00", b"\xff", b"\r", b"\xed\xa0\x80"]) + content[place:]
    )


def change_json(draw: Random, value: Any, depth: int = 0) -> Any:
    """Change one place of plain data."""
    if isinstance(value, dict | list) and value and (depth < 2 or draw.random() < 0.85):
        copy: Any = value.copy()
        keys = list(copy) if isinstance(copy, dict) else list(range(len(copy)))
        key = draw.choice(keys)
        kind = draw.random()
        if kind < 0.04:
            del copy[key]
        elif kind < 0.08 and isinstance(copy, list):
            copy.insert(key, copy[key])
        elif kind < 0.11:
            copy[key] = copy[draw.choice(keys)]
        else:
            copy[key] = change_json(draw, copy[key], depth + 1)
        return copy
    if isinstance(value, int) and draw.random() < 0.7:
        return value + draw.choice([-1, 1, 2, -1000, 10**6])
    return draw.choice(JSON_VALUES)


JSON_VALUES: tuple[Any, ...] = (
    *(None, True, 0, -1, 1, 2, 3, 10**6, 2**63, 10**400, 0.5, 1e300, float("inf"), [], {}, [[]]),
    *("0", "1", "-1", "1/2", "1/0", "9" * 3000, "symbol", "number", "Add", "Mul", "Pow", "exp"),
    *("log", "sqrt", "tanh", "real", "integer", "<", "<=", "atom", "root", "1e9", "kink"),
    *(TEXTS[i] for i in range(0, len(TEXTS), 3)),
    *([0, 0], [0, [0, 0]], ["number", "1"], ["Pow", 0, "1000000"], ["symbol", "x", "real"]),
)
