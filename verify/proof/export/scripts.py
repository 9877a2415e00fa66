"""Scripts that compute: PARI/GP and Maxima, in calls of a few functions that they hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .terms import (
    NAMES,
    Definition,
    Powers,
    Rate,
    Relation,
    SlopeAxiom,
    Step,
    Term,
    WrittenProof,
    engine_text,
    name_of,
    plain_lines,
)

CALLS = {"sum": "add", "product": "mul", "minus": "neg", "inverse": "inv"}


@dataclass(frozen=True)
class Language:
    """How a system writes what differs between the two."""

    comment: Callable[[str], str]
    engine: str
    assign: str
    end: str
    derivative: str
    head: Callable[[WrittenProof], list[str]]
    body: Callable[[list[str]], list[str]]


def script(proof: WrittenProof, language: Language) -> str:
    """A self-contained script that prints "accepted" or "rejected"."""
    comments = plain_lines(proof)
    lines = [
        *(language.comment(line) for line in comments),
        *language.head(proof),
        engine_text(language.engine),
        *language.body([_step(step, language) for step in proof.steps]),
    ]
    return "\n".join(lines) + "\n"


def call(term: Term, language: Language) -> str:
    """A term as nested calls."""
    match term:
        case ("number", value):
            return f"num({value})"
        case ("generator", place):
            return f"num(g{place})"
        case (("node" | "jet"), _):
            return name_of(term)
        case ("power", base, exponent):
            return f"pow({call(base, language)}, {exponent})"
        case ("slope", axis, inner):
            if inner[0] in NAMES and inner[0] != "generator":
                name = name_of(inner)
                return f'{language.derivative}({axis + 1}, "{name}", {name})'
            return f"der({axis + 1}, {call(inner, language)})"
    inner_calls = ", ".join(call(part, language) for part in term[1:])
    return f"{CALLS[term[0]]}({inner_calls})"


def infix(term: Term) -> str:
    """A polynomial in the generators as both systems write it."""
    match term:
        case ("number", value):
            return f"({value})"
        case ("generator", place):
            return f"g{place}"
        case ("sum", *parts):
            return "(" + " + ".join(map(infix, parts)) + ")"
        case ("product", *parts):
            return "*".join(map(infix, parts))
        case ("power", base, exponent):
            return f"{infix(base)}^{exponent}"
    raise AssertionError(term[0])


def _step(step: Step, language: Language) -> str:
    written = _cut(call(step.term, language), getattr(step, "below", None))
    match step:
        case Definition():
            return f"{name_of(step.name)} {language.assign} {written}{language.end}"
        case Relation():
            return f"rule(g{step.generator}, {step.degree}, {written}){language.end}"
        case SlopeAxiom():
            return f"slope({step.variable + 1}, {step.generator + 1}, {written}){language.end}"
        case Rate():
            name = name_of(step.name)
            return f'rate({step.variable + 1}, "{name}", {name}, {written}){language.end}'
    return f"vanish({written}){language.end}"


def _cut(text: str, below: Powers) -> str:
    return text if below is None else f"cut({text}, {list(below)})"


def _pari_head(proof: WrittenProof) -> list[str]:
    count = len(proof.meanings)
    roots = {step.generator for step in proof.steps if isinstance(step, Relation)}
    order = [*sorted(roots, reverse=True), *(i for i in range(count) if i not in roots)]
    size = len(proof.variables)
    return [
        f"[{', '.join(f'g{i}' for i in order)}];",
        f"G = [{', '.join(f'g{i}' for i in range(count))}];",
        f"F = [{', '.join(map(infix, proof.denominators))}];",
        f"R = []; N = Map(); S = matrix({size}, #G); W = matrix({size}, max(#F, 1));",
    ]


def _pari_body(steps: list[str]) -> list[str]:
    last = 'iferr(run(); print("accepted"), err, print("rejected"))'
    return ["run() = {", *steps, "}", last]


def _maxima_head(proof: WrittenProof) -> list[str]:
    names = ", ".join(f"g{i}" for i in range(len(proof.meanings)))
    return [
        "kill(all)$",
        f"G : [{names}]$",
        f"ratvars({names})$",
        f"F : map(rat, [{', '.join(map(infix, proof.denominators))}])$",
        "ruleList : []$",
    ]


def _maxima_body(steps: list[str]) -> list[str]:
    last = 'print(if errcatch(run()) = [] then "rejected" else "accepted")$'
    body = ",\n".join(step.removesuffix("$") for step in steps)
    return [f"run() := (\n{body})$", last]


PARI = Language(lambda line: f"\\\\ {line}", "engine.gp", "=", ";", "derOf", _pari_head, _pari_body)
MAXIMA = Language(
    lambda line: f"/* {line} */", "engine.mac", ":", "$", "der_of", _maxima_head, _maxima_body
)
