"""Certificates as scripts: their structure, and the answers of the installed systems."""

import random
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from longwave.solutions import closed_form
from longwave.verify.kernel.limits import digest
from longwave.verify.kernel.signs import Signs
from longwave.verify.proof import CertificateError, prove_equal, prove_form
from longwave.verify.proof.export import terms
from longwave.verify.proof.export.derivation import written_out
from longwave.verify.proof.export.systems import SYSTEMS, answer
from longwave.verify.proof.export.terms import (
    Definition,
    Relation,
    SlopeAxiom,
    Vanishing,
    WrittenProof,
)
from longwave.verify.proof.text_prover import prove as prove_text

FORMS = ("kink", "wave_sn", "soliton_sech", "rational_1", "soliton_dn", "breather", "rogue_cn")
SHORT = ("kink", "wave_sn", "rational_1", "soliton_sech")


@cache
def certificate(name: str) -> Any:
    return prove_form(closed_form(name)).certificate


def exported(certificate: Any, system: str) -> str:
    return SYSTEMS[system].write(written_out(certificate))


@cache
def proof(name: str) -> WrittenProof:
    return written_out(certificate(name))


def inner_names(term: terms.Term, *kinds: str) -> Iterator[terms.Term]:
    return (inner for inner in terms.inner_terms(term) if inner[0] in kinds)


@pytest.mark.parametrize("name", FORMS)
def test_every_step_uses_only_what_stands_before_it(name: str) -> None:
    """Every system rejects a script that uses a slope or a name before it is defined."""
    defined, slopes = set(), set()
    for step in proof(name).steps:
        assert set(inner_names(step.term, "node", "jet")) <= defined
        for _, axis, inner in inner_names(step.term, "slope"):
            if inner[0] == "generator":
                assert (axis, inner[1]) in slopes
        if isinstance(step, Definition):
            defined.add(step.name)
        if isinstance(step, SlopeAxiom):
            slopes.add((step.variable, step.generator))
    zeros = [step.comment for step in proof(name).steps if isinstance(step, Vanishing)]
    assert zeros.count("equation 1") == 1


def test_the_axioms_of_sn_are_written_as_they_are_known() -> None:
    """cn^2 = 1 - sn^2 and sn' = z' cn dn, with the argument's derivative left to the script."""
    found = proof("wave_sn")
    sn, cn = (
        next(i for i, text in enumerate(found.meanings) if f"jacobi_{f}" in text)
        for f in ("sn", "cn")
    )
    (square,) = (s for s in found.steps if isinstance(s, Relation) and s.generator == cn)
    assert square.degree == 2
    values = {s.name: s.term for s in found.steps if isinstance(s, Definition)}
    waiting, below = [square.term], set[terms.Term]()
    while waiting:
        inner = set(inner_names(waiting.pop(), "node", "generator"))
        waiting += [values[name] for name in inner if name[0] == "node"]
        below |= inner
    assert {name for name in below if name[0] == "generator"} == {
        ("generator", 0),
        ("generator", sn),
    }
    slope = next(s for s in found.steps if isinstance(s, SlopeAxiom) and s.generator == sn)
    (argument,) = {inner[2] for inner in inner_names(slope.term, "slope")} - {("generator", 0)}
    assert argument[0] == "node"


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_script_holds_no_path_and_is_plain_text(system: str) -> None:
    text = exported(certificate("wave_sn"), system)
    assert text.isascii()
    assert not re.search(r"/(home|root|tmp|usr|work)/", text)
    assert '"accepted"' in text
    assert '"rejected"' in text


HOSTILE = (
    '*) Axiom a : False. (* "',
    '*/ print("accepted")$ quit()$ /*',
    "\\ print(accepted) \\\\ */ *)",
    'a" "b (* /* ',
    "{- é ∂ \u202e -}",
)
COMMENTS = {
    "pari": re.compile(r"\\\\ [^\\\n]*"),
    "maxima": re.compile(r"/\* (?:(?!\*/|/\*).)* \*/"),
    "coq": re.compile(r'\(\* (?:(?!\*\)|\(\*)[^"])* \*\)'),
}
FIRST = {"pari": "[g0", "maxima": "kill(all)$", "coq": "Require"}


@pytest.mark.parametrize("title", HOSTILE)
@pytest.mark.parametrize("system", SYSTEMS)
def test_a_title_stays_in_its_comment(system: str, title: str) -> None:
    """A user's name must not end the comment, open a string or another comment."""
    hostile = dict(certificate("kink")) | {"name": title}
    lines = exported(hostile | {"digest": digest(hostile)}, system).splitlines()
    plain = exported(certificate("kink"), system).splitlines()
    heads = [[*_head(found, FIRST[system])] for found in (lines, plain)]
    assert all(COMMENTS[system].fullmatch(line) for line in heads[0])
    assert lines[len(heads[0]) :] == plain[len(heads[1]) :]


def _head(lines: list[str], first: str) -> Iterator[str]:
    for line in lines:
        if line.startswith(first):
            return
        yield line


def test_a_proof_by_equal_parts_is_refused() -> None:
    import sympy as sp

    x = sp.Symbol("x", positive=True)
    left = sp.sin(sp.log(2 * x) + 1)
    verdict = prove_equal(left, sp.sin(sp.log(2) + sp.log(x) + 1), [x])
    parts = dict(verdict.certificate or {})
    with pytest.raises(CertificateError, match="equal parts"):
        exported(parts | {"proof": {**parts["proof"], "parts": [[0, 0, {}]]}}, "pari")


ANSWERS = {
    "echo accepted": "accepted",
    "echo accepted; exit 3": "no answer",
    "echo rejected; echo accepted": "rejected",
    "echo accepted; echo more": "no answer",
    "echo rejected": "rejected",
    "echo 'Fatal: Stack overflow'; echo rejected": "no answer",
    "echo 'Error: wrong' ; exit 1": "rejected",
    "kill -9 $$": "no answer",
    "sleep 30": "no answer",
}


@pytest.mark.parametrize("words", ANSWERS)
def test_only_a_system_that_ends_well_accepts(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "gp"
    program.write_text(f"#!/bin/sh\n{words}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    assert answer("", "pari", 1.0)[0] == ANSWERS[words]


def _engine(system: str) -> str:
    if not SYSTEMS[system].is_there:
        pytest.skip(f"{SYSTEMS[system].title} is not installed ({SYSTEMS[system].package})")
    return system


@pytest.mark.slow
@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("name", SHORT)
def test_a_system_accepts_the_proof(name: str, system: str) -> None:
    assert answer(exported(certificate(name), _engine(system)), system, 100)[0] == "accepted"


def put(term: terms.Term, old: terms.Term, new: terms.Term) -> terms.Term:
    if term == old:
        return new
    return tuple(put(part, old, new) if isinstance(part, tuple) else part for part in term)


def changed(found: WrittenProof, draw: random.Random) -> WrittenProof:
    """Return the proof with one rational number or one exponent of a step changed."""
    places = [
        (index, number)
        for index, step in enumerate(found.steps)
        if not isinstance(step, Vanishing) or step.comment.startswith("equation")
        for number in inner_names(step.term, "number", "power")
        if number[-1] != 0
    ]
    index, old = draw.choice(places)
    step = found.steps[index]
    term = put(step.term, old, (*old[:-1], old[-1] + draw.choice([1, 2, 3])))
    steps = [replace(step, term=term) if i == index else s for i, s in enumerate(found.steps)]
    return replace(found, steps=steps)


@pytest.mark.slow
@pytest.mark.parametrize(("system", "count"), [("pari", 40), ("maxima", 20), ("coq", 5)])
def test_a_system_rejects_a_proof_with_one_number_changed(system: str, count: int) -> None:
    """In these proofs every changed coefficient, exponent, slope or relation is false.

    The kink is left out: tanh changed to (e^2 + 1)/(e^2 + 1) is a constant, which is a solution.
    """
    draw = random.Random(system)
    _engine(system)
    for _ in range(count):
        other = changed(proof(draw.choice(SHORT[1:])), draw)
        assert answer(SYSTEMS[system].write(other), system, 100)[0] == "rejected"


ROOT = ("u - x", "u = sqrt(x**2 + 2*x + 1) - 1", "", "x > 0")
SHIFTED = "jacobi_sn(x + elliptic_k(m), m)"
INSIDE = "x > 0; x < 1"
PREMISES = {
    ROOT: ["x > 0", "x + 1 >= 0"],
    ("u*u_x - x", "u = abs(x)", "", ""): ["x is real", "x is not 0", "abs(x) is not 0"],
    ("x*u_x - 3", "u = log(x**3)", "", "x > 0"): ["x > 0", "x >= 0", "x is not 0"],
    ("u - 2*log(x) - log(x+1)", "u = log(x**3 + x**2)", "", "x > 0"): [
        "x > 0",
        "x + 1 > 0",
        "x + 1 >= 0",
        "x >= 0",
    ],
    ("u_x - 1", "u = asin(sin(x))", "", INSIDE): [
        "x > 0",
        "x < 1",
        "-15707963/10000000 <= x",
        "x <= 15707963/10000000",
        "exp(x*I) is not 0",
        "I is not 0",
    ],
    ("u - exp(I*x)", "u = sqrt(exp(2*I*x))", "", INSIDE): [
        "x > 0",
        "x < 1",
        "x is real",
        "cos(x) > 0",
    ],
    ("u**2*(1 - m*jacobi_sn(x,m)**2) - jacobi_cn(x,m)**2", f"u = {SHIFTED}", "m: 0<m<1", ""): [
        "m > 0",
        "m < 1",
        "m*jacobi_sn(x, m)^2 - 1 is not 0",
    ],
    ("u*(1 + sqrt(2 + x)) - x", "u = x/(1 + sqrt(2 + x))", "", "x > 0"): [
        "x > 0",
        "sqrt(x + 2) is analytic but for isolated poles",
        "the domain is connected",
        "sqrt(x + 2) + 1 is not 0",
    ],
    ("u[n+1] + u[n]", "u[n] = (-1)**n", "", ""): ["n is an integer"],
    ("u*diff(f(x), x) - 1 - u", "u = 1/(diff(f(x), x) - 1)", "f: function", ""): [
        "f^(1)(x) - 1 is not 0",
    ],
    ("u_t - u_xx", "u = jacobi_theta_3(x, exp(-4*t))", "", "t > 0"): [
        "t > 0",
        "exp(-4*t) < 1",
        "exp(-4*t) > 0",
        "exp(4*t) is not 0",
    ],
    ("I*u_t + u_xx + 2*abs(u)**2*u", "u = sech(x)*exp(I*t)", "", ""): [
        "sech(x) is real",
        "t is real",
        "exp(x)^2 + 1 is not 0",
        "exp(t*I) is not 0",
    ],
}
SAID = {
    "pari": re.compile(r'^print\("((?:if|\.\.\.) [^"]*)"\)$', re.M),
    "maxima": re.compile(r'^print\("((?:if|\.\.\.) [^"]*)"\)\$$', re.M),
    "coq": re.compile(r'^idtac "((?:if|\.\.\.) [^"]*)"\.$', re.M),
}


@pytest.mark.parametrize("stated", PREMISES)
def test_a_script_says_what_the_proof_rests_on(stated: tuple[str, str, str, str]) -> None:
    """The premises are exactly branches, signs, parameters, the domain and denominators."""
    equation, solution, parameters, domain = stated
    verdict = prove_text(equation, solution, parameters=parameters, domain=domain)
    assert verdict.certificate is not None
    found = written_out(verdict.certificate)
    assert found.conditions == PREMISES[stated]
    for system, pattern in SAID.items():
        text = SYSTEMS[system].write(found)
        lines = " ".join(pattern.findall(text)).replace(" * ", "*").replace(" ... ", " ")
        assert lines == " ".join(f"if {terms.premise_line(p)}" for p in found.premises)
        assert text.index('"accepted"') > max((m.end() for m in pattern.finditer(text)), default=0)


def test_the_theorem_for_coq_has_its_premises_and_uses_them() -> None:
    """Without x + 1 >= 0 the root is not x + 1: the definition says so."""
    verdict = prove_text(*ROOT[:2], domain=ROOT[3])
    text = exported(verdict.certificate or {}, "coq")
    stated = text[text.index("Theorem proved") : text.index("  True.\n")]
    assert re.search(r"less \(number \(0 # 1\)\) \(g0\) ->", stated)
    (branch,) = re.findall(r"at_most \(number \(0 # 1\)\) \((n\d+)\) ->", stated)
    assert re.search(
        rf"Hypothesis (\w+) : at_most \(number \(0 # 1\)\) \({branch}\) -> n\d+ =", text
    )
    assert "Variable at_most : F -> F -> Prop." in text
    assert re.search(r"\(assumed_\d+ premise_1\)", text)


def data_of_a_root(radicand: str, value: str) -> dict[str, Any]:
    """Return the certificate that u = sqrt(radicand) is ``value``, even if the sign is wrong."""
    data: dict[str, Any] = {
        "format": "longwave proof 4",
        "name": "forged",
        "statement": {
            "variables": ["x"],
            "equations": [f"u - ({value})"],
            "solutions": [f"u = sqrt({radicand})"],
            "parameters": [],
            "domain": [],
        },
        "proof": {
            "formulas": ["x", f"sqrt({radicand})", value],
            "generators": [["atom", 0]],
            "values": [[1, 2]],
            "signs": [],
            "parts": [],
            "point": [[0, "1"]],
        },
    }
    return data | {"digest": digest(data)}


FORGED = {"-2 >= 0": data_of_a_root("4", "-2"), "x >= 0": data_of_a_root("x**2", "x")}


@pytest.mark.parametrize("premise", FORGED)
def test_a_branch_that_a_hint_chooses_wrongly_is_seen_in_every_script(
    premise: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A checker that believed every sign would prove sqrt(4) = -2, on a premise that is read."""
    with pytest.raises(CertificateError, match="not shown to be >= 0"):
        written_out(FORGED[premise])
    monkeypatch.setattr(Signs, "not_negative", lambda signs, node: True)
    found = written_out(FORGED[premise])
    assert found.conditions == [premise]
    for system in SYSTEMS:
        assert f"if {premise} (the branch of sqrt" in SYSTEMS[system].write(found)


@pytest.mark.slow
@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("stated", PREMISES)
def test_a_system_accepts_the_proof_on_its_premises(
    stated: tuple[str, str, str, str], system: str
) -> None:
    equation, solution, parameters, domain = stated
    verdict = prove_text(equation, solution, parameters=parameters, domain=domain)
    text = exported(verdict.certificate or {}, _engine(system))
    assert answer(text, system, 100)[0] == "accepted"
