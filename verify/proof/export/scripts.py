"""Write scripts for PARI/GP and Maxima: calls of a few functions that the script defines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from . import terms


@dataclass(frozen=True)
class Language:
    """Syntax that differs between PARI/GP and Maxima."""

    comment: Callable[[str], str]
    engine: str
    head: Callable[[terms.WrittenProof], list[str]]
    body: Callable[[list[str]], list[str]]
    say: str


def script(proof: terms.WrittenProof, language: Language) -> str:
    """Return a self-contained script that prints "accepted" or "rejected"."""
    lines = [
        *(language.comment(line) for line in terms.plain_lines(proof)),
        *language.head(proof),
        terms.engine_text(language.engine),
        *(language.say.format(line) for line in terms.premise_lines(proof)),
        *language.body([_step(step) for step in proof.steps]),
    ]
    return "\n".join(lines) + "\n"


CALLS: dict[str, Callable[..., str]] = {
    "number": "num({})".format,
    "generator": "gen({})".format,
    "node": 'get("n{}")'.format,
    "jet": 'get("u{}")'.format,
    "power": "pow({}, {})".format,
    "slope": lambda axis, inner: (
        f"derOf({axis + 1}, {inner[4:]}"
        if inner.startswith("get(")
        else f"der({axis + 1}, {inner})"
    ),
    "sum": lambda *parts: f"add({', '.join(parts)})",
    "product": lambda *parts: f"mul({', '.join(parts)})",
    "minus": "neg({})".format,
    "inverse": "inv({})".format,
}
"""Format of each kind of term as a call; the derivative of a named element is ``derOf``."""

POLYNOMIAL: dict[str, Callable[..., str]] = {
    "number": "({})".format,
    "generator": "g{}".format,
    "sum": lambda *parts: f"({' + '.join(parts)})",
    "product": lambda *parts: "*".join(parts),
    "power": "{}^{}".format,
}
"""Syntax of polynomials in the generators, the same in both systems."""


def _denominators(proof: terms.WrittenProof) -> str:
    return ", ".join(terms.spelled(term, POLYNOMIAL) for term in proof.denominators)


def _step(step: terms.Step) -> str:
    if isinstance(step, terms.Vanishing):
        return f"vanish({terms.spelled(step.term, CALLS)})"
    value = terms.spelled(step.term, CALLS)
    value = value if step.below is None else f"cut({value}, {list(step.below)})"
    match step:
        case terms.Definition():
            return f'put("{terms.name_of(step.name)}", {value})'
        case terms.Relation():
            return f"rule({step.generator}, {step.degree}, {value})"
        case terms.SlopeAxiom():
            return f"slope({step.variable + 1}, {step.generator}, {value})"
        case terms.Rate():
            return f'rate({step.variable + 1}, "{terms.name_of(step.name)}", {value})'


def _pari_head(proof: terms.WrittenProof) -> list[str]:
    count = len(proof.meanings)
    roots = {step.generator for step in proof.steps if isinstance(step, terms.Relation)}
    order = [*sorted(roots, reverse=True), *(i for i in range(count) if i not in roots)]
    axes = len(proof.variables)
    return [
        f"[{', '.join(f'g{i}' for i in order)}];",
        f"G = [{', '.join(f'g{i}' for i in range(count))}];",
        f"F = [{_denominators(proof)}];",
        f"R = []; V = Map(); N = Map(); S = matrix({axes}, #G); W = matrix({axes}, max(#F, 1));",
    ]


def _pari_body(steps: list[str]) -> list[str]:
    return [
        "run() = {",
        *(f"{step};" for step in steps),
        "}",
        'answer(e) = if(setsearch(["e_MEM", "e_STACK"], errname(e)), "no answer", "rejected");',
        'iferr(run(); print("accepted"), e, print(answer(e)))',
    ]


def _maxima_head(proof: terms.WrittenProof) -> list[str]:
    names = ", ".join(f"g{i}" for i in range(len(proof.meanings)))
    return [
        "kill(all)$",
        f"G : [{names}]$",
        f"ratvars({names})$",
        f"F : map(rat, [{_denominators(proof)}])$",
        "ruleList : []$",
    ]


def _maxima_body(steps: list[str]) -> list[str]:
    body = ",\n".join(steps)
    return [
        f"run() := (\n{body},\ntrue)$",
        'print(if errcatch(run()) = [true] then "accepted" else "rejected")$',
    ]


PARI = Language(lambda line: f"\\\\ {line}", "engine.gp", _pari_head, _pari_body, 'print("{}")')
MAXIMA = Language(
    lambda line: f"/* {line} */", "engine.mac", _maxima_head, _maxima_body, 'print("{}")$'
)
