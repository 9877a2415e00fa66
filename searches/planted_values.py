"""The search for values that `--solve` misses: random ansaetze, some values of which are planted.

    python -m searches.planted_values --count 1000 --seed 0

A value is missed if the answer says "only if" or "no value" and has it in no case and in nothing
that is left out.  A case that is called proved is tried, too, and a condition on it must fail
somewhere.  The judge is mpmath.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

from longwave.derive.algebra.formula_text import FormulaError
from longwave.support.processes import OutOfTime, time_limit
from longwave.verify.proof.conditions import ConditionalVerdict
from longwave.verify.proof.text_prover import prove
from longwave.verify.verdict import Outcome
from searches.texts.mp_values import CLOSE, FAR, Residuals, holds, mp, value
from searches.texts.planted import Planted, planted

LIMIT = 60.0
"""Seconds of processor time for an answer."""

SAMPLES, POINTS = 3, 3
"""Values of free constants, and points of the variables, that are looked at."""

VARIABLES = ("x", "t", "n")

AGREE = 1e-9

FINDINGS = ("MISSED", "FALSE", "IDLE", "ERROR")

TRIED = 200
"""Values of constants at which a condition that is printed must fail once."""


def judged(given: Planted, seed: int = 0, limit: float = LIMIT) -> tuple[str, str]:
    """Return the judgement on an answer in a word, and the reason."""
    draw = random.Random(repr(given) + str(seed))
    samples = [sample for sample in _samples(given, draw) if _holds(given, sample, draw)]
    try:
        with time_limit(limit):
            verdict = prove(
                list(given.equations),
                list(given.solutions),
                parameters=given.parameters,
                domain=given.domain,
                solve=given.solve,
            )
    except OutOfTime:
        return "SLOW", f"no answer in {limit:g} s"
    except FormulaError as error:
        return "refused", str(error).splitlines()[0]
    except Exception as error:  # an error is a finding, not the end of the search
        return "ERROR", f"{type(error).__name__}: {' '.join(str(error).split())}"
    assert isinstance(verdict, ConditionalVerdict)
    wrong = _false_case(given, verdict, draw)
    if wrong:
        return "FALSE", f"{verdict.detail}: {wrong}"
    if idle := _idle_condition(given, verdict, draw):
        return "IDLE", f"{verdict.detail}: {idle} holds always"
    if not samples:
        return "not planted", verdict.detail
    missed = [sample for sample in samples if not _covered(verdict, sample)]
    exclusive = verdict.outcome is Outcome.REFUTED or verdict.complete
    if missed and exclusive:
        where = ", ".join(f"{name} = {mp.nstr(v, 8)}" for name, v in missed[0].items())
        return "MISSED", f"{verdict.outcome} {verdict.detail}: it holds at {where}"
    if missed:
        return "not found, not excluded", verdict.detail
    return "only if" if exclusive else "found, others not excluded", verdict.detail


def _samples(given: Planted, draw: random.Random) -> Iterator[dict[str, Any]]:
    """Yield values of all constants, the planted ones among them."""
    for _ in range(SAMPLES):
        free = {n: _drawn(b, draw) for n, b in given.bounds.items() if n not in VARIABLES}
        yield free | {name: value(text, free) for name, text in given.values.items()}


def _drawn(bounds: tuple[float, float], draw: random.Random) -> Any:
    return mp.mpf(draw.randint(1, 9999)) / 10000 * (bounds[1] - bounds[0]) + bounds[0]


def _points(given: Planted, draw: random.Random) -> Iterator[dict[str, Any]]:
    for place in range(2 * POINTS):
        low, high = given.bounds.get("n", (0, 0))
        sites = {"n": low + place % (int(high - low) + 1)} if "n" in given.bounds else {}
        plain = {n: _drawn(b, draw) for n, b in given.bounds.items() if n in ("x", "t")}
        yield plain | sites


def _holds(given: Planted, constants: Mapping[str, Any], draw: random.Random) -> bool:
    """Return whether the residual vanishes at the points where it has a value."""
    residuals = Residuals(given.equations, given.solutions)
    found = []
    for point in _points(given, draw):
        with suppress(ZeroDivisionError, ValueError):
            found.append(residuals.largest({**point, **constants}))
    return bool(found) and all(size < CLOSE for size in found)


def _covered(verdict: ConditionalVerdict, sample: Mapping[str, Any]) -> bool:
    """Return whether constants lie in a case, or where the answer says that it leaves out."""
    if any(_in_case(case, sample) for case in verdict.json()["cases"]):
        return True
    for words in verdict.left_out:
        found = [holds(part, sample) for part in words.split(" and ")]
        if all(one is not False for one in found):
            return True
    return False


def _in_case(case: Mapping[str, Any], sample: Mapping[str, Any]) -> bool:
    with suppress(ZeroDivisionError):
        values = {name: value(text, sample) for name, text in case["values"].items()}
        near = all(abs(v - sample[n]) < AGREE * (1 + abs(v)) for n, v in values.items())
        implicit = all(abs(value(text, sample)) < AGREE for text in case["unsolved"])
        return near and implicit and all(holds(words, sample) for words in case["where"])
    return False


def _false_case(given: Planted, verdict: ConditionalVerdict, draw: random.Random) -> str:
    """Return a proved case with constants of it with which the residual does not vanish."""
    residuals = Residuals(given.equations, given.solutions)
    for case in verdict.json()["cases"]:
        if case["verdict"] != Outcome.PROVED or case["unsolved"]:
            continue
        for _ in range(SAMPLES):
            bounds = {**dict.fromkeys(given.values, (-2, 2)), **given.bounds}
            free = {n: _drawn(b, draw) for n, b in bounds.items() if n not in case["values"]}
            for point in _points(given, draw):
                with suppress(ZeroDivisionError, ValueError):
                    whole = {**free, **point}
                    values = {name: value(text, whole) for name, text in case["values"].items()}
                    whole |= values
                    known = all(holds(words, whole) for words in case["where"])
                    if known and residuals.largest(whole) > FAR:
                        values_text = {name: mp.nstr(v, 8) for name, v in whole.items()}
                        return f"the case {case['values']} fails at {values_text}"
    return ""


def _idle_condition(given: Planted, verdict: ConditionalVerdict, draw: random.Random) -> str:
    """Return a condition of an answer that holds at all constants that are drawn."""
    bounds = {**dict.fromkeys(given.values, (-2, 2)), **given.bounds}
    tried = [{n: _drawn(b, draw) for n, b in bounds.items()} for _ in range(TRIED)]
    for name in bounds:
        if f"{name}: {name}>0" in given.parameters:
            tried = [{**one, name: mp.mpf(10) ** draw.uniform(-3, 3)} for one in tried]
    for words in {words for case in verdict.json()["cases"] for words in case["where"]}:
        with suppress(ZeroDivisionError):
            if "!=" not in words and all(holds(words, constants) for constants in tried):
                return words
    return ""


def statement_text(given: Planted) -> str:
    """Return the statement as it is typed."""
    parts = [f"--equation {text!r}" for text in given.equations]
    parts += [f"--solution {text!r}" for text in given.solutions]
    options = {"parameters": given.parameters, "domain": given.domain, "solve": given.solve}
    return " ".join([*parts, *(f"--{key} {text!r}" for key, text in options.items() if text)])


def search(seed: int, start: int, count: int, minutes: float) -> Counter[str]:
    """Return the answers by their judgement; print findings."""
    end, found = time.monotonic() + 60 * minutes, Counter[str]()
    for index in range(start, start + count):
        if time.monotonic() > end:
            break
        given = planted(seed, index)
        word, reason = judged(given, seed)
        found[word] += 1
        if word in FINDINGS or word in ("SLOW", "not planted"):
            print(
                f"{word} {index} ({given.kind}): {reason}\n    {statement_text(given)}", flush=True
            )
    return found


def main() -> int:
    """Read the options, search, print; 1 if there is a finding."""
    parser = argparse.ArgumentParser(description="The search for values that are missed.")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=600.0)
    options = parser.parse_args()
    found = search(options.seed, options.start, options.count, options.minutes)
    print(
        f"{sum(found.values())} ansaetze: "
        + ", ".join(f"{n} {w}" for w, n in sorted(found.items()))
    )
    return int(any(found[word] for word in FINDINGS))


if __name__ == "__main__":
    sys.exit(main())
