"""Random solitary waves: the share that is proved to exist, judged by a solver apart.

The judge solves v^2 f = mu (V'(f) - V'(0)) for the strain itself, in double precision, on a longer
period and at other points; it shares neither the equation nor a line with the prover. A proved
crest that differs from the judge's by more than its error is a wrong certificate.

    python -m searches.exact_solitary_waves [--count 100] [--seed 0]
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from random import Random

import numpy as np
from flint import acb, fmpq
from numpy.typing import NDArray

from longwave.waves.exact_wave import ExactWave
from longwave.waves.kernel.force_text import Force, read_force
from longwave.waves.kernel.periodic import Spring
from longwave.waves.proved import Existence, proved
from longwave.waves.solitary_waves import solitary_certificate

POINTS = 384
LONGER = 1.2
"""Ratio of the judge's period to the prover's."""

TOLERANCE = 1e-9
WANTED_ERROR = 1e-10

Vector = NDArray[np.float64]


def _number(random: Random, low: float, high: float) -> str:
    return f"({random.uniform(low, high):.2f})"


FORCES: Mapping[str, Callable[[Random], str]] = {
    "quadratic": lambda random: f"r + {random.choice('+-')}{_number(random, 0.2, 1)}*r**2",
    "cubic": lambda random: f"r + {_number(random, 0.2, 1)}*r**3",
    "quartic potential": lambda random: (
        f"r + {_number(random, -1, 1)}*r**2 + {_number(random, 0.1, 1)}*r**3"
    ),
    "quintic": lambda random: (
        f"r + {_number(random, 0.2, 1)}*r**2 + {_number(random, -0.2, 0.3)}*r**3"
        f" + {_number(random, 0, 0.3)}*r**5"
    ),
    "Toda": lambda random: f"exp({_number(random, 0.5, 2)}*r) - 1",
    "Morse": lambda random: "exp(-r) - exp(-2*r)",
    "Lennard-Jones": lambda random: "(1 + r)**(-7) - (1 + r)**(-13)",
    "compressed Hertz": lambda random: f"1 - ({_number(random, 0.5, 1.5)} - r)**(3/2)",
    "tanh": lambda random: f"r - {_number(random, 0.55, 0.8)}*tanh(r)",
}


def chain_of(kind: str, random: Random) -> tuple[Spring, ...]:
    """Return a random chain; one of five has springs to second neighbours as well."""
    springs = [
        Spring(1, read_force(FORCES[kind](random).replace("+ +", "+ ").replace("+ -", "- ")))
    ]
    if random.random() < 0.2:
        stiffness = float(springs[0].force.at_rest[1])
        text = f"({random.uniform(-0.05, 0.2) * stiffness:.3f})*r"
        if random.random() < 0.5:
            text += f" + {_number(random, 0, 0.05)}*r**2"
        springs.append(Spring(2, read_force(text)))
    return tuple(springs)


def sound(springs: Sequence[Spring]) -> float:
    """Return the speed of sound."""
    squares = [float(s.force.at_rest[1]) * s.neighbour**2 for s in springs]
    return float(np.sqrt(sum(squares)))


def judged_crest(springs: Sequence[Spring], wave: ExactWave) -> float:
    """Return f(0) of the judge's wave, begun at a hundredth more than the proved one."""
    length = LONGER * float(wave.certificate["half_length"])
    speed = float(Fraction(wave.certificate["speed"]))
    order = np.arange(POINTS)
    x = length * (order + 0.5) / POINTS
    cosines, half = np.cos(np.pi * np.outer(x, order) / length), np.pi * order / length / 2
    weights = np.where(order, 2, 1)
    modes = cosines.T @ (1.01 * wave.at(x)) / POINTS
    for _ in range(30):
        residual, jacobian = speed**2 * modes, speed**2 * np.eye(POINTS)
        for spring in springs:
            m = spring.neighbour
            factor = np.sum([np.cos(half * (2 * i + 1 - m)) for i in range(m)], axis=0)
            synthesis = cosines * (weights * factor)
            values, slopes = np.array([_jet(spring.force, r) for r in synthesis @ modes]).T
            mobility = np.sinc(half / np.pi) ** 2 * factor
            analysis = mobility[:, None] * cosines.T / POINTS
            residual -= analysis @ (values - _jet(spring.force, 0.0)[0])
            jacobian -= analysis @ (slopes[:, None] * synthesis)
        change = np.linalg.solve(jacobian, -residual)
        modes += change
        if np.abs(change).max() < 1e-14:
            break
    return float(weights @ modes)


def _jet(force: Force, r: float) -> tuple[float, float]:
    first, second = force.taylor(acb(r), 2)
    return float(first.real), float(second.real)


def judge(kind: str, random: Random) -> tuple[str, float]:
    """Return what came of a random wave in words, and the seconds that the prover took."""
    springs = chain_of(kind, random)
    ratio = random.uniform(1.02, 1.4)
    speed = Fraction(ratio * sound(springs)).limit_denominator(1000)
    text = f"{kind}, {[(s.neighbour, s.force.text) for s in springs]}, v = {speed}"
    begin = time.process_time()
    wave = proved(
        lambda: solitary_certificate(
            springs, fmpq(speed.numerator, speed.denominator), WANTED_ERROR
        ),
        ExactWave,
    )
    seconds = time.process_time() - begin
    if wave.verdict is not Existence.EXISTS:
        return f"{wave.verdict}: {text}: {wave.reason}", seconds
    difference = abs(judged_crest(springs, wave) - wave.crest.value)
    if not difference < TOLERANCE:
        return f"WRONG: {text}: the crest differs by {difference:.2g}", seconds
    return "EXISTS", seconds


def main(arguments: Sequence[str] | None = None) -> int:
    """Judge random waves of all kinds; return 1 if a proved crest is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    random, kinds = Random(options.seed), list(FORCES)
    results = []
    for i in range(options.count):
        results.append(judge(kinds[i % len(kinds)], random))
        if results[-1][0] != "EXISTS":
            print(f"{results[-1][1]:.1f} s", results[-1][0])
    exist = sum(result == "EXISTS" for result, _ in results)
    wrong = sum(result.startswith("WRONG") for result, _ in results)
    median = statistics.median(seconds for _, seconds in results)
    print(f"{exist} of {options.count} exist, {wrong} wrong, median {median:.2f} s")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
