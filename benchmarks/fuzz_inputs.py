"""Hostile inputs: files made from shipped ones by mutations, and command lines from the grammar.

Everything is drawn from a `random.Random`: one that is seeded, one of hypothesis
(``st.randoms(use_true_random=False)``, which shrinks), or one that reads a fuzzer's bytes.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import click

HOUSE = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class FuzzCase:
    """Words of the command line, and the files of the folder in which it is called."""

    kind: str
    words: tuple[str, ...]
    files: Mapping[str, bytes] = field(default_factory=dict)


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
    """Values as they stand in a TOML file, right or wrong."""
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


SMALL_SCENE = """\
title = "small"
wave = "soliton_sech"
eps = 0.1
t0 = -10
snapshots = [0, 10]
observables = ["strain", "error_curve"]
curve_points = 11
tolerance = 1e-3

[lattice]
K2 = 1
K3 = 0
K4 = 1

[parameters]
A = 1

[domain]
compared = 40
"""

STATED_SCENE = """\
title = "stated"
wave = "rogue_cn"
eps = 0.1
t0 = -5
snapshots = [-5, 0, 5]
observables = ["strain", "error_curve", "time_step_error", "domain_error"]
curve_points = 11
look_points = 5

[lattice]
K2 = 1
K4 = 1

[parameters]
k = 0.5

[scheme]
name = "kahan_li_8"
step = 0.5

[domain]
kind = "ring"
sites = 256
compared = 50
"""

LATTICES = (
    """\
name = "mass_in_mass"
title = "Mass in mass"
fields = ["u", "v"]
masses = ["m1", "m2"]
positive = ["K2", "g", "m1", "m2"]

[[spring]]
between = ["u[n]", "u[n+1]"]
force = "K2*x + K4*x**3"

[[spring]]
between = ["u[n]", "v[n]"]
force = "g*x"
""",
    """\
name = "strain"
fields = ["y"]
positive = ["K2"]

[[bond]]
stretch = "y[n]"
action = {y = "F[n+1] - 2*F[n] + F[n-1]"}
force = "K2*x + K3*x**2 + eps*K4*x**3"
""",
    """\
name = "site"
fields = ["u"]
masses = ["1"]
positive = ["K", "h"]

[[spring]]
between = ["u[n]", "u[n+2]"]
force = "K*tanh(x)"

[[site]]
field = "u"
force = "h*sin(x)"
""",
    """\
name = "plane"
fields = ["u"]
positive = ["a", "b"]

[[spring]]
between = ["u[n, m]", "u[n+1, m]"]
force = "a*x + a*x**2"

[[spring]]
between = ["u[n, m]", "u[n, m+1]"]
force = "b*x"
""",
)

PROBLEMS = """\
[[problem]]
name = "KdV soliton"
equation = "u_t + 6*u*u_x + u_xxx"
solution = "u = 2*k**2*sech(k*(x - 4*k**2*t))**2"
parameters = "k: k>0"
domain = "t > 0"
source = "free text"
expect = "PROVED"

[[problem]]
name = "wrong speed"
variant_of = "KdV soliton"
solution = "u = 2*k**2*sech(k*(x - 2*k**2*t))**2"
note = "the speed"
expect = "REFUTED"

[[problem]]
name = "for which c"
equation = ["u_t + c*u_x"]
solution = "u = sin(x - b*t)"
solve = "c"
"""


@cache
def seeds(kind: str) -> tuple[str, ...]:
    """The files that are changed; what is shipped takes longer than what is made to be small."""
    folders = {"scene": "verify/comparison/scenes", "lattice scene": "verify/lattices/scenes"}
    if kind == "lattice":
        return LATTICES
    if kind == "problem":
        return PROBLEMS, *(text for file in _library() for text in file)
    found = sorted((HOUSE / folders[kind]).glob("*.toml"))
    texts = [path.read_text(encoding="utf-8") for path in found]
    small = [SMALL_SCENE, STATED_SCENE] if kind == "scene" else []
    return *(small * 6), *texts


def _library() -> Iterator[list[str]]:
    """The published problems, three a text."""
    for path in sorted((HOUSE / "solutions" / "library").glob("*.toml")):
        tables = re.split(r"^(?=\[\[problem\]\])", path.read_text(encoding="utf-8"), flags=re.M)
        yield ["".join(tables[i : i + 3]) for i in range(1, len(tables), 3)]


PROVED = (
    "kink",
    "soliton_sech",
    "rational_2",
    "kdv_soliton",
    "rogue_cn",
    "wave_cn",
    "nls_peregrine",
)
"""Closed forms whose certificates are changed; so are those of `STATED`, all within a second."""

STATED = (
    ("u_t + 6*u*u_x + u_xxx", "u = 2*k**2*sech(k*(x - 4*k**2*t))**2", "k: k>0"),
    ("diff(u, t, t) = u_xx - sin(u)", "u = 4*atan(exp((x - v*t)/sqrt(1 - v**2)))", "v: -1<v<1"),
    ("I*psi_t + psi_xx + 2*abs(psi)**2*psi", "psi = a*sech(a*x)*exp(I*a**2*t)", "a: a>0"),
    ("diff(u[n], t, t) = u[n+1] - 2*u[n] + u[n-1]", "u[n] = cos(k*n - 2*sin(k/2)*t)", "k: 0<k<1"),
)


@cache
def certificates() -> tuple[str, ...]:
    """Certificates of closed forms and of statements in text, as JSON."""
    from longwave import prove
    from verify.proof.catalogue_proofs import prove_named

    named = [[prove_named(name).certificate] for name in PROVED]
    stated = [list(prove(*texts[:2], parameters=texts[2]).certificates) for texts in STATED]
    return tuple(json.dumps(one) for one in named + stated if one)


# --- changes of texts -----------------------------------------------------------------------------


def changed_toml(draw: Random, text: str, count: int | None = None) -> bytes:
    """A TOML text after some changes of its lines, and sometimes of its bytes."""
    lines = text.splitlines()
    for _ in range(_few(draw) if count is None else count):
        draw.choice(LINE_CHANGES)(draw, lines)
    found = "\n".join(lines).encode("utf-8", "surrogatepass")
    return changed_bytes(draw, found) if draw.random() < 0.1 else found


def _few(draw: Random) -> int:
    return draw.choice([1, 1, 1, 2, 2, 3, 5])


def _pairs(lines: list[str]) -> list[int]:
    return [i for i, line in enumerate(lines) if re.match(r"\s*[\w\"'.-]+\s*=", line)] or [0]


def _place(draw: Random, lines: list[str]) -> int:
    if not lines:
        lines.append("")
    return draw.randrange(len(lines))


def _other_value(draw: Random, lines: list[str]) -> None:
    _place(draw, lines)
    place = draw.choice(_pairs(lines))
    key = lines[place].partition("=")[0]
    lines[place] = f"{key}= {draw.choice(toml_values())}"


def _other_number(draw: Random, lines: list[str]) -> None:
    """A number, wherever it stands: within a list, a formula, a key."""
    place = _place(draw, lines)
    found = list(re.finditer(r"\d+(?:\.\d+)?(?:e-?\d+)?", lines[place]))
    if found:
        one = draw.choice(found)
        new = draw.choice(NUMBERS) if draw.random() < 0.5 else f"{one[0]}e{draw.randint(-12, 12)}"
        lines[place] = lines[place][: one.start()] + new + lines[place][one.end() :]


def _other_word(draw: Random, lines: list[str]) -> None:
    """A part of a text, such as a name in a formula."""
    place = _place(draw, lines)
    found = list(re.finditer(r"[A-Za-z_]+|[-+*/()\[\]]", lines[place]))
    if found:
        one = draw.choice(found)
        new = draw.choice([*TEXTS, "(", ")", "*", "**", "-", "+", "/", "[", "]"])
        new = _toml_text(new)[1:-1]
        lines[place] = lines[place][: one.start()] + new + lines[place][one.end() :]


def _other_key(draw: Random, lines: list[str]) -> None:
    _place(draw, lines)
    place = draw.choice(_pairs(lines))
    value = lines[place].partition("=")[2]
    keys = ("sites", "step", "order", "k", "\u00e9", '""', "a.b", "name", "'\x1b'", "x" * 5000, "1")
    lines[place] = f"{draw.choice(keys)} ={value}"


def _missing(draw: Random, lines: list[str]) -> None:
    del lines[_place(draw, lines)]


def _doubled(draw: Random, lines: list[str]) -> None:
    place = _place(draw, lines)
    lines.insert(_place(draw, lines), lines[place])


def _swapped(draw: Random, lines: list[str]) -> None:
    first, second = _place(draw, lines), _place(draw, lines)
    lines[first], lines[second] = lines[second], lines[first]


def _inserted(draw: Random, lines: list[str]) -> None:
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


def _truncated(draw: Random, lines: list[str]) -> None:
    place = _place(draw, lines)
    lines[place] = lines[place][: draw.randint(0, len(lines[place]))]
    if draw.random() < 0.5:
        del lines[place + 1 :]


LINE_CHANGES = (
    *(_other_value,) * 5,
    *(_other_number,) * 4,
    *(_other_word,) * 2,
    *(_other_key, _missing, _doubled, _swapped, _inserted, _truncated),
)


def changed_bytes(draw: Random, content: bytes) -> bytes:
    """Some bytes flipped, cut off, doubled, or a mark put in front."""
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


def changed_json(draw: Random, value: Any, depth: int = 0) -> Any:
    """Plain data with one place changed."""
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
            copy[key] = changed_json(draw, copy[key], depth + 1)
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


# --- kinds ----------------------------------------------------------------------------------------


def scene(draw: Random) -> FuzzCase:
    """A scene of the paper's chain, run or drawn."""
    return _with_scene(draw, "scene")


def lattice_scene(draw: Random) -> FuzzCase:
    """A scene on any lattice, run or drawn."""
    return _with_scene(draw, "lattice scene")


def _with_scene(draw: Random, kind: str) -> FuzzCase:
    content = changed_toml(draw, draw.choice(seeds(kind)))
    words = ["run", "hostile.toml"]
    if draw.random() < 0.15:
        words += [draw.choice(["--tolerance", "--engine"]), draw.choice(option_texts())]
    if draw.random() < 0.15:
        words += ["--output", draw.choice(outputs())]
    if draw.random() < 0.03:
        words[0] = draw.choice(["plot", "converge"])
    return FuzzCase(kind, tuple(words), {"hostile.toml": content})


def lattice(draw: Random) -> FuzzCase:
    """A lattice's file, derived."""
    content = changed_toml(draw, draw.choice(seeds("lattice")))
    words = ["derive", "hostile.toml"]
    if draw.random() < 0.2:
        words += ["--envelope", draw.choice(["k", "k=pi", "k=1/2", "k=0", *option_texts()])]
    if draw.random() < 0.3:
        words.append(draw.choice(["--latex", "--json"]))
    if draw.random() < 0.2:
        option = draw.choice(["--set", "--order", "--amplitude", "--time", "--background", "--map"])
        words += [option, draw.choice(option_texts())]
    if draw.random() < 0.1:
        words.insert(1, "check")
    return FuzzCase("lattice", tuple(words), {"hostile.toml": content})


def problem(draw: Random) -> FuzzCase:
    """A file of problems, decided within a second each."""
    content = changed_toml(draw, draw.choice(seeds("problem")))
    words = ["prove", "hostile.toml", "--limit", "1"]
    if draw.random() < 0.3:
        words.append(draw.choice(["--latex", "--json"]))
    if draw.random() < 0.1:
        words += ["--certificate", draw.choice(outputs())]
    return FuzzCase("problem", tuple(words), {"hostile.toml": content})


def certificate(draw: Random) -> FuzzCase:
    """A certificate, checked; its digest is made to fit, so that more than this is looked at."""
    from verify.proof.checker.limits import digest

    data: Any = json.loads(draw.choice(certificates()))
    for _ in range(_few(draw)):
        data = changed_json(draw, data)
    for one in data if isinstance(data, list) else [data]:
        if isinstance(one, dict) and draw.random() < 0.95:
            one["digest"] = digest(one)
    text = json.dumps(data)
    if draw.random() < 0.02:
        text = draw.choice(["[" * 100_000, "{" + '"a":' * 9 + "1", "[" + "1," * 10**6 + "1]"])
    content = text.encode("utf-8", "surrogatepass")
    if draw.random() < 0.05:
        content = changed_bytes(draw, content)
    words = ["verify", "check-certificate", "hostile.json"]
    if draw.random() < 0.2:
        words = ["prove", "--certificate", "hostile.json"]
        if draw.random() < 0.5:
            words += ["--export", draw.choice(["pari", "maxima", "coq"]), "--output", "s.txt"]
    if draw.random() < 0.3:
        words.append("--json")
    return FuzzCase("certificate", tuple(words), {"hostile.json": content})


# --- command lines --------------------------------------------------------------------------------

NAMED = {"small.toml": SMALL_SCENE, "lattice.toml": LATTICES[0], "problems.toml": PROBLEMS}
"""Files that command lines can name."""


def outputs() -> tuple[str, ...]:
    """Paths for results: good ones, and ones that cannot be written."""
    return (
        *("out.nc", "out.json", "out.png", "out.pdf", "out.svg", "out", ".", "..", "/", "", "-"),
        *("no/out.nc", "hostile.toml", "small.toml", "/dev/full", "/dev/null", "/proc/out.nc"),
        *("x" * 300, "out\n.nc", "\x1b[31m.nc", "é.nc", "out.nc/", "~/out.nc", "out.tar", "%d.png"),
    )


@cache
def option_texts() -> tuple[str, ...]:
    """What may stand behind an option."""
    texts = tuple(text for text in TEXTS if "\x00" not in text and len(text) < 5000)
    return (*NUMBERS, *texts, "K2=1", "m1=1,m2=3", "m1=", "=", "K2=1/0", "k=pi", "10,20", "30,20")


@cache
def commands() -> tuple[tuple[tuple[str, ...], click.Command], ...]:
    """Every command with the words that lead to it."""
    from longwave.command_tree import longwave

    def below(words: tuple[str, ...], one: click.Command) -> Iterator[Any]:
        yield words, one
        if isinstance(one, click.Group):
            for name, inner in one.commands.items():
                yield from below((*words, name), inner)

    return tuple(below((), longwave))


LASTING = ("report", "explore", "recheck")
"""Commands that go on until they are stopped; drawn less often."""


def command_line(draw: Random) -> FuzzCase:
    """Words of the tree in their order, with what they do not expect."""
    path, command = draw.choice(commands())
    if set(path) & set(LASTING) and draw.random() < 0.8:
        path, command = draw.choice(commands())
    words = list(path)
    options = [one for one in command.params if isinstance(one, click.Option)]
    arguments = [one for one in command.params if isinstance(one, click.Argument)]
    for one in arguments:
        for _ in range(draw.choice([0, 1, 1, 1, 2, 3]) if one.nargs != 1 else 1):
            words.append(_argument(draw, one))
    for option in draw.sample(options, min(len(options), draw.choice([0, 1, 1, 2, 3]))):
        words.append(draw.choice(option.opts))
        if not option.is_flag or draw.random() < 0.02:
            words.append(_value(draw, option))
    _disordered(draw, words)
    files = {name: text.encode() for name, text in NAMED.items()}
    return FuzzCase("command line", tuple(word.replace("\x00", "") for word in words), files)


def _disordered(draw: Random, words: list[str]) -> None:
    kind = draw.random()
    if kind < 0.05:
        draw.shuffle(words)
    elif kind < 0.1 and words:
        del words[draw.randrange(len(words))]
    elif kind < 0.15 and words:
        words.insert(draw.randint(0, len(words)), draw.choice(words))
    elif kind < 0.2:
        words.insert(draw.randint(0, len(words)), draw.choice(option_texts()))


def _argument(draw: Random, argument: click.Argument) -> str:
    if isinstance(argument.type, click.Choice) and draw.random() < 0.8:
        return draw.choice(list(argument.type.choices))
    names = (
        *NAMED,
        "nope.toml",
        "kink",
        "soliton_sech",
        "rational_2",
        "toda",
        "fput_strain",
        "check",
    )
    names = (*names, "toda_soliton", "rogue_cn_k_0.5", "kdv_soliton", ".", "/", "scenes", "out.nc")
    return draw.choice(names) if draw.random() < 0.7 else draw.choice(option_texts())


def _value(draw: Random, option: click.Option) -> str:
    if draw.random() < 0.15:
        return draw.choice(option_texts())
    if isinstance(option.type, click.Choice):
        return draw.choice(list(option.type.choices))
    if isinstance(option.type, click.Path) or "output" in (option.name or ""):
        return draw.choice(outputs())
    if option.type in (click.INT, click.FLOAT):
        return draw.choice(NUMBERS)
    return draw.choice((*NUMBERS, *NAMED, "kink", "soliton_sech", *option_texts()))


KINDS: Mapping[str, Callable[[Random], FuzzCase]] = {
    "scene": scene,
    "lattice scene": lattice_scene,
    "lattice": lattice,
    "problem": problem,
    "certificate": certificate,
    "command line": command_line,
}


def case_of(kind: str, seed: int, index: int) -> FuzzCase:
    """The case of that number; it does not depend on the others.

    >>> case_of("scene", 1, 5) == case_of("scene", 1, 5)
    True
    """
    return KINDS[kind](Random(f"{seed}:{kind}:{index}"))
