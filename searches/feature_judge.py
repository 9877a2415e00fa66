"""The opponent of steps: features of forces, drives, walls and losses that runs may step over.

Differential evolution over the place, the width and the height of a feature, and the tolerance, of
chains of 2 to 6 cells: a bump, a wiggle, a step or a corner of a force law, of a force in time, or
of a wall given by its displacement or its velocity, with and without a fast carrier and losses. Its
population moves to where the true error is largest in units of its estimate. The true error is
measured against DOP853 (`searches.feature_reference`), which is given the equations of each cell
and made to see the feature: it is split at its time, or takes no step that passes its stretches.

    python -m searches.feature_judge [--count 20000] [--seed 0]
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from longwave.derive.lattice_file import time_formula
from longwave.lattice import SiteForce, State, driven_chain, integrate
from longwave.lattice.force_program import force_program
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice
from longwave.lattice.time_integral import Integral
from longwave.scenes.description.time_functions import time_function
from searches.feature_reference import KINDS, SHAPES, solved

Array = NDArray[np.float64]

POPULATION, GENERATIONS = 8, 6
"""Members of a family, and how often it is renewed."""

REFERENCE = 1e-12
"""Relative tolerance of the reference."""

SURE = 0.1
"""Share of the estimate that the reference may err, by what looser and finer ones change."""

SHORTER = 0.37
"""Share of its longest steps that those take at most."""

NEAR = 0.3
"""Errors above this share of their estimate are told, and their reference is looked at."""

DEAREST = 1_000_000
"""Evaluations that a reference may take."""

FALSE_REASONS = ("blows up", "flies apart", "run away", "rounding or an instability")
"""What is told of refusals that is false where a reference runs well."""


@dataclass(frozen=True)
class Family:
    """Fixed part of a family: the kind and shape of a feature, and the chain it is in."""

    kind: str
    shape: str
    cells: int
    end: float
    carrier: float
    loss: float
    quartic: float
    free: bool

    @classmethod
    def drawn(cls, random: np.random.Generator) -> Family:
        """Draw a family at random."""
        return cls(
            str(random.choice(KINDS)),
            str(random.choice(SHAPES)),
            int(random.integers(2, 7)),
            float(random.choice([2.0, 5.0, 15.0])),
            float(random.choice([0.0, 0.0, 1.5, 30.0])),
            float(random.choice([0.0, 0.0, 0.1])),
            float(random.choice([0.0, 1.0])),
            bool(random.random() < 0.5),
        )


@dataclass(frozen=True)
class Member:
    """Evolving part: place 0..1, and powers of ten of width, of height and of the tolerance."""

    family: Family
    genes: Array

    @cached_property
    def place(self) -> float:
        """The time or the stretch of the feature."""
        share = float(self.genes[0])
        if self.family.kind == "law":
            return round(0.02 + 0.25 * share, 7)
        return round(self.family.end * (0.1 + 0.8 * share), 7)

    @cached_property
    def width(self) -> float:
        """Its width."""
        low = -4.0 if self.family.kind == "law" else -6.0
        return float(f"{10.0 ** (low + (0.0 - low) * self.genes[1]):.4g}")

    @cached_property
    def height(self) -> float:
        """Its height: the momentum that it gives is bounded, whatever its width."""
        size = 10.0 ** (-5.0 + 5.0 * self.genes[2])
        narrow = self.family.shape in ("bump", "wiggle") and self.family.kind != "displacement"
        return float(f"{size * (min(0.1 / self.width, 1e4) if narrow else 0.3):.4g}")

    @property
    def tolerance(self) -> float:
        """Tolerance of the run."""
        return float(10.0 ** (-9.0 + 6.0 * self.genes[3]))

    def text(self, name: str) -> str:
        """Return the feature as a formula of a variable, with the carrier."""
        at, w, h = f"({name} - {self.place!r})", f"{self.width!r}", f"{self.height!r}"
        found = {
            "bump": f"{h}*exp(-({at}/{w})**2)",
            "wiggle": f"{h}*exp(-({at}/{w})**2)*sin(3*{at}/{w})",
            "step": f"{h}*tanh({at}/{w})",
            "corner": f"{h}*sqrt({at}**2 + {w}**2/10**6)",
        }[self.family.shape]
        carrier = self.family.carrier
        if carrier and self.family.kind != "law":
            found += f" + 0.1*sin({carrier}*{name})"
        return found

    @property
    def numbers(self) -> Array:
        """The feature for the reference: shape, place, width, height and carrier."""
        family = self.family
        carrier = family.carrier if family.kind != "law" else 0.0
        shape = SHAPES.index(family.shape)
        return np.array([shape, self.place, self.width, self.height, carrier])


def _law(member: Member) -> NumericBond:
    text = f"x + {member.family.quartic!r}*x**3"
    if member.family.kind == "law":
        text += f" + {member.text('x')}"
    formula = time_formula("force", text.replace("x", "t").replace("etp", "exp"))
    formula -= formula.subs(next(iter(formula.free_symbols)), 0)
    stretch = (Entry((1,), 1.0, 0), Entry((0,), -1.0, 0))
    action = (Entry((0,), 1.0, 0), Entry((-1,), -1.0, 0))
    return NumericBond(stretch, action, force_program(formula))


def answer(member: Member) -> tuple[Array, float]:
    """Return the program's values at the end, and its estimated error."""
    family = member.family
    lattice = NumericLattice("chain", ("u",), (1.0,), (_law(member),))
    ends: dict[str, object] = {"left": "fixed", "right": "free" if family.free else "fixed"}
    forces = []
    if family.kind == "force":
        forces = [SiteForce(0, time_function("value", member.text("t")))]
    elif family.kind != "law":
        wall = time_function("left", member.text("t"))
        ends["left"] = wall if family.kind == "displacement" else Integral.of(wall, 0.0, family.end)
    else:
        ends["left"] = "free" if family.free else "fixed"
    chain = driven_chain(lattice, family.cells, losses=family.loss, forces=forces, **ends)  # type: ignore[arg-type]
    v = np.zeros((1, family.cells))
    v[0, 0] = 0.3 if family.kind == "law" else 0.0
    state = State(0.0, np.zeros_like(v), v)
    found = integrate(chain, state, [family.end], member.tolerance, judged=lambda f, v, t: f)
    return found.f[-1, 0], found.error_estimate


def reference(member: Member, rtol: float, share: float = 1.0) -> Array | None:
    """Return displacements at the end by DOP853; None where it takes too long.

    ``share`` shortens its longest steps.
    """
    family, n = member.family, member.family.cells
    y = np.zeros(2 * n + 1)
    y[n] = 0.3 if family.kind == "law" else 0.0
    found, came = solved(
        y,
        _spans(member, share),
        rtol,
        DEAREST,
        KINDS.index(family.kind),
        family.quartic,
        family.loss,
        family.free,
        member.numbers,
    )
    return np.asarray(found[:n]) if came else None


def _spans(member: Member, share: float) -> Array:
    """Return times between which a reference goes, with its longest step: it sees the feature."""
    family, at, w = member.family, member.place, member.width
    around = np.array([-12.0, -6.0, -3.0, -1.0, 0.0, 1.0, 3.0, 6.0, 12.0])
    if family.shape == "corner":  # which turns within a thousandth of its width
        around = np.union1d(around, np.outer([1e-3, 1e-2, 1e-1], around))
    marks = at + w * around if family.kind != "law" else around[:0]
    marks = np.concatenate([[0.0], marks[(marks > 0.0) & (marks < family.end)], [family.end]])
    begin, end = marks[:-1], marks[1:]
    longest = min(0.5, 2.0 * w if family.kind == "law" else 0.5 / max(family.carrier, 1))
    near = (family.kind != "law") & (begin >= at - 12.5 * w) & (end <= at + 12.5 * w)
    return np.column_stack([begin, end, share * np.where(near, min(longest, w), longest)])


@dataclass(frozen=True)
class Verdict:
    """``ratio``: the true error in units of its estimate; 0 where nothing can be said."""

    kind: str
    ratio: float = 0.0
    reason: str = ""


def judge(member: Member) -> Verdict:
    """Run a member and measure its error."""
    try:
        found, estimate = answer(member)
    except ValueError as refusal:
        exact, rough = (reference(member, rtol) for rtol in (REFERENCE, 10.0 * REFERENCE))
        if exact is None or rough is None:
            return Verdict("both refuse", reason=str(refusal))
        sure = bool(np.abs(exact - rough).max() < SURE * member.tolerance)
        reason = str(refusal)
        lies = any(word in reason for word in FALSE_REASONS) and sure
        return Verdict(
            ("false reason" if lies else "refused") if sure else "both refuse", 0, reason
        )
    exact = reference(member, REFERENCE)
    if exact is None:
        return Verdict("undecided")
    ratio = float(np.abs(found - exact).max()) / estimate
    if ratio > NEAR:
        for rtol in (10.0 * REFERENCE, 0.1 * REFERENCE):
            other = reference(member, rtol, SHORTER)
            if other is None or np.abs(other - exact).max() > SURE * estimate:
                return Verdict("undecided")
    return Verdict("dishonest" if ratio > 1.0 else "sound", ratio)


def evolve(seed: int, tell: Callable[[Member, Verdict], None]) -> None:
    """Evolve a family: its members move to where errors are largest relative to estimates."""
    random = np.random.default_rng(seed)
    family = Family.drawn(random)
    genes, ratios = random.random((POPULATION, 4)), np.zeros(POPULATION)
    for generation in range(GENERATIONS):
        for place in range(POPULATION):
            trial = genes[place]
            if generation:
                a, b, c = genes[random.choice(POPULATION, 3, replace=False)]
                crossed = random.random(4) < 0.8
                trial = np.where(crossed, np.clip(a + 0.7 * (b - c), 0.0, 1.0), trial)
            member = Member(family, trial)
            verdict = judge(member)
            tell(member, verdict)
            if not generation or verdict.ratio >= ratios[place]:
                genes[place], ratios[place] = trial, verdict.ratio


def main() -> int:
    """Evolve families until so many members have been run."""
    words = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    words.add_argument("--count", type=int, default=20_000)
    words.add_argument("--seed", type=int, default=0)
    options = words.parse_args()
    kinds: Counter[str] = Counter()
    worst = [0.0]

    def tell(member: Member, verdict: Verdict) -> None:
        kinds[verdict.kind] += 1
        worst[0] = max(worst[0], verdict.ratio)
        if verdict.kind in ("dishonest", "false reason", "refused") or verdict.ratio > NEAR:
            print(
                f"{verdict.kind} {verdict.ratio:.3g}: {member.family} {member.genes.tolist()} "
                f"{member.text('t')} to {member.tolerance:.2g} {verdict.reason}",
                flush=True,
            )

    seed = options.seed
    while kinds.total() < options.count:
        evolve(seed, tell)
        seed += 1
        print(f"{kinds.total()} runs, {dict(kinds)}, largest ratio {worst[0]:.3g}", flush=True)
    return int(kinds["dishonest"] > 0 or kinds["false reason"] > 0)


if __name__ == "__main__":
    sys.exit(main())
