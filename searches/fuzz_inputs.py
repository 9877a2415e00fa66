"""Hostile inputs: files made from shipped ones by mutations, and command lines from the grammar."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from io import BytesIO
from random import Random
from typing import Any

import click

from searches.fuzz_mutations import (
    NUMBERS,
    TEXTS,
    change_bytes,
    change_json,
    change_toml,
    few,
)
from searches.fuzz_seeds import LATTICES, PROBLEMS, SMALL_SCENE, certificates, run_files, seeds


@dataclass(frozen=True)
class FuzzCase:
    """Words of the command line, and the files of the folder in which it is called."""

    kind: str
    words: tuple[str, ...]
    files: Mapping[str, bytes] = field(default_factory=dict)


def scene(draw: Random) -> FuzzCase:
    """Return a scene of the paper's chain, run or drawn."""
    return _with_scene(draw, "scene")


def lattice_scene(draw: Random) -> FuzzCase:
    """Return a scene on any lattice, run or drawn."""
    return _with_scene(draw, "lattice scene")


def _with_scene(draw: Random, kind: str) -> FuzzCase:
    content = change_toml(draw, draw.choice(seeds(kind)))
    words = ["run", "hostile.toml"]
    if draw.random() < 0.15:
        words += [draw.choice(["--tolerance", "--engine"]), draw.choice(option_texts())]
    if draw.random() < 0.15:
        words += ["--output", draw.choice(outputs())]
    if draw.random() < 0.03:
        words[0] = draw.choice(["plot", "converge"])
    return FuzzCase(kind, tuple(words), {"hostile.toml": content})


def lattice(draw: Random) -> FuzzCase:
    """Return a lattice's file, derived."""
    content = change_toml(draw, draw.choice(seeds("lattice")))
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


def force_law(draw: Random) -> FuzzCase:
    """Return points of a force law, fitted."""
    rows = [re.split("([,;])", row) for row in draw.choice(seeds("force law")).splitlines()]
    for _ in range(few(draw)):
        row, likely = draw.choice(rows), f"{draw.uniform(-2, 2):.3g}"
        hostile = draw.random() < 0.3
        row[2 * draw.randrange((len(row) + 1) // 2)] = (
            draw.choice((*NUMBERS, *TEXTS)) if hostile else likely
        )
    content = "\n".join(map("".join, rows)).encode("utf-8", "surrogatepass")
    if draw.random() < 0.2:
        content = change_bytes(draw, content)
    words = ["fit", "hostile.csv"]
    for option, texts in FITTING.items():
        if draw.random() < 0.25:
            words += [option, draw.choice(texts if draw.random() < 0.7 else option_texts())]
    if draw.random() < 0.2:
        words += ["--plot", draw.choice(outputs())]
    if draw.random() < 0.5:
        words += ["--output", "chain.toml"]
    return FuzzCase("force law", tuple(words), {"hostile.csv": content})


FITTING = {
    "--law": ("hertz", "table", "K2*x + K4*x**3", "a*tanh(b*x) + c*sin(b*x)", "x", "K", "1/x"),
    "--fix": ("K2=1", "a=2", "d=0", "b=1/0"),
    "--units": ("mm,N", "mm", "N,N"),
}


def problem(draw: Random) -> FuzzCase:
    """Return a file of problems, decided within 0.4 s each."""
    content = change_toml(draw, draw.choice(seeds("problem")))
    words = ["prove", "hostile.toml", "--limit", "0.4"]
    if draw.random() < 0.3:
        words.append(draw.choice(["--latex", "--json"]))
    if draw.random() < 0.1:
        words += ["--output", draw.choice(outputs())]
    return FuzzCase("problem", tuple(words), {"hostile.toml": content})


def certificate(draw: Random) -> FuzzCase:
    """Return a certificate to be checked, with a fitting digest, so that the rest is read."""
    from longwave.verify.kernel.limits import digest

    data: Any = json.loads(draw.choice(certificates()))
    for _ in range(few(draw)):
        data = change_json(draw, data)
    for one in data if isinstance(data, list) else [data]:
        if isinstance(one, dict) and draw.random() < 0.95:
            one["digest"] = digest(one)
    text = json.dumps(data)
    if draw.random() < 0.02:
        text = draw.choice(["[" * 100_000, "{" + '"a":' * 9 + "1", "[" + "1," * 10**6 + "1]"])
    content = text.encode("utf-8", "surrogatepass")
    if draw.random() < 0.05:
        content = change_bytes(draw, content)
    words = ["check", "hostile.json"]
    if draw.random() < 0.2:
        words += ["--export", draw.choice(["pari", "maxima", "coq"]), "--output", "s.txt"]
    if draw.random() < 0.3:
        words.append("--json")
    return FuzzCase("certificate", tuple(words), {"hostile.json": content})


def sweep(draw: Random) -> FuzzCase:
    """Return a sweep's file, run by one worker."""
    content = change_toml(draw, draw.choice(seeds("sweep")))
    words = ["sweep", "hostile.toml", "--processes", "1"]
    if draw.random() < 0.1:
        words += [draw.choice(["--store", "--output", "--scheduler"]), draw.choice(outputs())]
    return FuzzCase("sweep", tuple(words), {"hostile.toml": content})


def run_file(draw: Random) -> FuzzCase:
    """Return the file of a run with other attributes, variables or bytes: run anew, or drawn."""
    content = draw.choice(run_files())
    if draw.random() < 0.8:
        content = _changed_run(draw, content)
    if draw.random() < 0.3:
        content = change_bytes(draw, content)
    words = draw.choice([["run", "hostile.nc"], ["plot", "hostile.nc", "--output", "out.png"]])
    if words[0] == "plot" and draw.random() < 0.8:
        words += ["--kind", draw.choice(["snapshots", "space_time", "spectra", "errors", "crest"])]
    return FuzzCase("run file", tuple(words), {"hostile.nc": content})


def _changed_run(draw: Random, content: bytes) -> bytes:
    import h5py

    image = BytesIO(content)
    with h5py.File(image, "r+") as file:
        for _ in range(few(draw)):
            try:
                draw.choice(RUN_CHANGES)(draw, file)
            except (ValueError, TypeError, OSError, LookupError, RuntimeError, ArithmeticError):
                continue  # what the library itself does not write
    return image.getvalue()


def _other_attribute(draw: Random, file: Any) -> None:
    place = file if draw.random() < 0.7 else file[draw.choice(sorted(file))]
    name = draw.choice([*sorted(place.attrs), "json_attributes", "_FillValue", "units", "scale"])
    place.attrs[name] = draw.choice([*RUN_VALUES, *TEXTS])


def _other_scene(draw: Random, file: Any) -> None:
    file.attrs["scene"] = change_toml(draw, str(file.attrs["scene"])).decode("utf-8", "replace")


def _without(draw: Random, file: Any) -> None:
    place = file.attrs if draw.random() < 0.5 else file
    del place[draw.choice(sorted(place))]


def _other_variable(draw: Random, file: Any) -> None:
    name = draw.choice(sorted(file))
    if draw.random() < 0.3:
        file.move(name, draw.choice(["strain", "time", "site", "x", "\u00e9"]))
        return
    if draw.random() < 0.4:
        file[name][...] = draw.choice([float("nan"), float("inf"), 1e300, -1, 0])
        return
    del file[name]
    shape = draw.choice([(), (0,), (1,), (3,), (2, 2), (10**7,)])
    file.create_dataset(name, shape=shape, dtype=draw.choice(["f4", "f8", "i1", "i8", "c16", "S3"]))


RUN_VALUES: tuple[object, ...] = (
    0,
    -1,
    2**63 - 1,
    1.5,
    float("nan"),
    [],
    [1, 2],
    [0.0] * 9000,
    b"\xff\xfe",
    True,
)

RUN_CHANGES = (_other_attribute,) * 4 + (_other_scene,) * 3 + (_without,) + (_other_variable,) * 2


NAMED = {"small.toml": SMALL_SCENE, "lattice.toml": LATTICES[0], "problems.toml": PROBLEMS}
"""Files that command lines can name."""


def outputs() -> tuple[str, ...]:
    """Return paths for results: good ones, and ones that cannot be written."""
    return (
        *("out.nc", "out.json", "out.png", "out.pdf", "out.svg", "out", ".", "..", "/", "", "-"),
        *("no/out.nc", "hostile.toml", "small.toml", "/dev/full", "/dev/null", "/proc/out.nc"),
        *("x" * 300, "out\n.nc", "\x1b[31m.nc", "é.nc", "out.nc/", "~/out.nc", "out.tar", "%d.png"),
    )


@cache
def option_texts() -> tuple[str, ...]:
    """Draw the values of an option."""
    texts = tuple(text for text in TEXTS if "\x00" not in text and len(text) < 5000)
    return (*NUMBERS, *texts, "K2=1", "m1=1,m2=3", "m1=", "=", "K2=1/0", "k=pi", "10,20", "30,20")


@cache
def commands() -> tuple[tuple[tuple[str, ...], click.Command], ...]:
    """Return every command with the words that lead to it."""
    from longwave.cli.command_tree import longwave

    def below(words: tuple[str, ...], one: click.Command) -> Iterator[Any]:
        yield words, one
        if isinstance(one, click.Group):
            for name, inner in one.commands.items():
                yield from below((*words, name), inner)

    return tuple(below((), longwave))


LASTING = ("report", "explore", "recheck", "verify", "library")
"""Commands that take long or until they are stopped; drawn less often."""


def command_line(draw: Random) -> FuzzCase:
    """Return words of the tree in their order, with what they do not expect."""
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
    "force law": force_law,
    "problem": problem,
    "certificate": certificate,
    "sweep": sweep,
    "run file": run_file,
    "command line": command_line,
}


def case_of(kind: str, seed: int, index: int) -> FuzzCase:
    """Return the case of that number; it does not depend on the others.

    >>> case_of("scene", 1, 5) == case_of("scene", 1, 5)
    True
    """
    return KINDS[kind](Random(f"{seed}:{kind}:{index}"))
