"""Write Coq scripts: a theorem about every field of characteristic 0 with derivations.

The theorem is written twice: as formulas of the field for the reader, and as data for the engine,
whose correctness the script proves.  Coq checks that the two agree.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce as fold

from flint import fmpq

from . import terms

PREDICATES = ("less", "at_most", "real", "is_integer", "analytic", "connected")
"""Relations that become predicate variables in the script; ``not_zero`` is written ``<> 0``."""


def _rational(value: fmpq) -> str:
    return f"({value.p} # {value.q})"


def _nested(joined: str) -> Callable[..., str]:
    """Return a function that nests any number of parts to the right by a two-part format."""
    return lambda *parts: fold(lambda text, part: joined.format(part, text), reversed(parts))


FORMULAS: dict[str, Callable[..., str]] = {
    "number": lambda value: f"number {_rational(value)}",
    "generator": "g{}".format,
    **{kind: f"{letter}{{}}".format for kind, letter in terms.LETTERS.items()},
    "minus": "- ({})".format,
    "inverse": "/ ({})".format,
    "power": "power ({}) {}".format,
    "slope": "D {} ({})".format,
    "sum": lambda *parts: _nested("{} + ({})")(*map("({})".format, parts)),
    "product": lambda *parts: _nested("{} * ({})")(*map("({})".format, parts)),
}

DATA: dict[str, Callable[..., str]] = {
    "number": lambda value: f"(Num {_rational(value)})",
    "generator": lambda place: f"(Gen {place + 1})",
    "minus": "(Neg {})".format,
    "inverse": "(Inv {})".format,
    "power": "(Pow {} {})".format,
    "slope": "(Der {} {})".format,
    "sum": _nested("(Sum {} {})"),
    "product": _nested("(Prod {} {})"),
}
"""Format of each kind of term as the engine's data; nodes and jets are list positions."""

CONJUNCTION = _nested("(conj {} {})")
"""Function that joins proofs into a proof of their conjunction; the last proof is ``I``."""


def coq_script(proof: terms.WrittenProof) -> str:
    """Return a self-contained script; Coq prints "accepted" when it has checked the theorem."""
    comments = (f"(* {line} *)" for line in terms.plain_lines(proof))
    return "\n".join([*comments, terms.engine_text("engine.v"), *_Theorem(proof).lines()]) + "\n"


def formula(term: terms.Term) -> str:
    """Return a term as a formula of the field."""
    return terms.spelled(term, FORMULAS)


class _Theorem:
    """Proof-specific part of a script."""

    def __init__(self, proof: terms.WrittenProof) -> None:
        self._proof = proof
        defined = [step.name for step in proof.steps if isinstance(step, terms.Definition)]
        self._places = {name: place for place, name in enumerate(defined, 1)}
        self._data = {
            **DATA,
            "node": lambda place: f"(Nam {self._places['node', place]})",
            "jet": lambda place: f"(Nam {self._places['jet', place]})",
        }
        self._assumptions: list[str] = []
        self._labels: list[str] = []
        self._claims: list[str] = []

    def lines(self) -> list[str]:
        """Return the lines with the variables, assumptions, claims and the proof."""
        proof = self._proof
        steps = [self._step(step) for step in proof.steps]
        below_data = [terms.spelled(term, DATA) for term in proof.denominators]
        below = [f"premise_{i}" for i, p in enumerate(proof.premises) if p.relation == "not_zero"]
        generators = [f"g{place}" for place in range(len(proof.meanings))]
        names = [terms.name_of(name) for name in self._places]
        free = [terms.name_of(("free", place)) for place in proof.free]
        return [
            f"Variables {' '.join([*generators, *names, *free])} : F.",
            *self._predicates(),
            *self._assumptions,
            f"Definition denominators : list ex := {_list(below_data)}.",
            f"Definition steps : list step := {_list(steps)}.",
            "Lemma checked : accepts denominators steps = true.",
            "Proof.",
            "  tryif abstract (vm_cast_no_check (eq_refl true)) then idtac",
            '  else (idtac "rejected"; fail 1 "rejected").',
            "Qed.",
            "Theorem proved :",
            *self._premises(),
            *(f"  ({claim}) /\\" for claim in self._claims),
            "  True.",
            "Proof.",
            f"  intros {' '.join(f'premise_{i}' for i, _ in enumerate(proof.premises))}.",
            f"  exact (accepted (listed {_list(generators)}) (listed {_list(names)})",
            f"    denominators steps checked {CONJUNCTION(*below, 'I')}",
            f"    {CONJUNCTION(*self._labels, 'I')}).",
            "Qed.",
            "End Soundness.",
            "Print Assumptions proved.",
            "Goal True.",
            *(f'idtac "{line}".' for line in terms.premise_lines(proof)),
            'idtac "accepted". exact I. Qed.',
        ]

    def _predicates(self) -> list[str]:
        """Return the declaration of a predicate variable for each kind of premise."""
        stated = (p for p in self._proof.premises if p.relation in PREDICATES)
        arities = {premise.relation: len(premise.terms) for premise in stated}
        return [f"Variable {name} : {'F -> ' * count}Prop." for name, count in arities.items()]

    def _premises(self) -> list[str]:
        """Return the premises of the theorem, each under a comment in words."""
        lines = []
        for premise in self._proof.premises:
            lines += [f"  (* {line} *)" for line in terms.plain(terms.premise_line(premise))]
            lines.append(f"  {_proposition(premise)} ->")
        return lines

    def _assume(self, statement: str, guards: Sequence[int] = ()) -> None:
        """Add an equation as hypothesis, guarded by the premises that it depends on."""
        name = f"assumed_{len(self._assumptions)}"
        under = [f"{_proposition(self._proof.premises[place])} -> " for place in guards]
        self._assumptions.append(f"Hypothesis {name} : {''.join(under)}{statement}.")
        label = " ".join([name, *(f"premise_{place}" for place in guards)])
        self._labels.append(f"({label})" if guards else label)

    def _step(self, step: terms.Step) -> str:
        """Return the data of a step; record its assumption or claim as a formula."""
        written, data = formula(step.term), terms.spelled(step.term, self._data)
        match step:
            case terms.Definition():
                guards = self._proof.guards.get(step.name, ())
                self._assume(f"{terms.name_of(step.name)} = {written}", guards)
                return f"Def {self._places[step.name]} {data} {_powers(step.below)}"
            case terms.Relation():
                self._assume(f"power g{step.generator} {step.degree} = {written}")
                return f"Rel {step.generator + 1} {step.degree - 1} {data}"
            case terms.SlopeAxiom():
                self._assume(f"D {step.variable} g{step.generator} = {written}")
                place = step.generator + 1
                return f"Slo {step.variable} {place} {data} {_powers(step.below)}"
            case terms.Rate():
                self._claims.append(f"D {step.variable} {terms.name_of(step.name)} = {written}")
                place = self._places[step.name]
                return f"Rat {step.variable} {place} {data} {_powers(step.below)}"
            case terms.Vanishing():
                self._claims.append(f"{written} = 0")
                return f"Zer {data}"


def _proposition(premise: terms.Premise) -> str:
    if premise.relation == "not_zero":
        return f"{formula(premise.terms[0])} <> 0"
    return " ".join([premise.relation, *(f"({formula(term)})" for term in premise.terms)])


def _list(items: list[str]) -> str:
    return f"[{'; '.join(items)}]"


def _powers(below: terms.Powers) -> str:
    return "None" if below is None else f"(Some {_list([str(n) for n in below])}%nat)"
