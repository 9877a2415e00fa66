"""Random chains with ends, losses, dashpots, forces and contacts, against an integrator not ours.

A chain of the catalogue, from rest or from random data, with what drives it drawn anew: fast and
slow, short and steady. The true error is measured against SciPy's DOP853, which is given the
equations of each cell with its walls; an estimate is honest where it is no less. Each is run a
second time for its energy, the work done on it and its heat: against SciPy's, and against each
other, for what is gained must be what was done less what was lost.

With ``--pushed`` walls are pushed further than a bond is long, or pulled, against power laws and
laws with poles; bonds may be cut at an end or as a defect. Each is run to two tolerances, and a
refusal is told where the reference runs.

    python -m searches.driven_chains [--count 2000] [--seed 0] [--pushed]
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from longwave.derive import LATTICES
from longwave.derive.lattice_file import lattice_of
from longwave.lattice import (
    DrivenChain,
    SiteForce,
    State,
    Trajectory,
    driven_chain,
    integrate,
)
from longwave.lattice.energy_balance import EnergyBalance
from longwave.lattice.integration import CellEngine, StateComparison
from longwave.lattice.numeric_lattice import NumericBond, numeric_lattice
from longwave.lattice.refine import Refined, refine
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.lattice.time_integral import Integral
from longwave.scenes.description.time_functions import time_function
from longwave.support.request_limits import OverBudgetError

Array = NDArray[np.float64]
T = TypeVar("T")
CHAINS = ("beta_fput", "alpha_fput", "toda", "klein_gordon", "mass_dimer", "granular")
FINER = 1e-8
"""Absolute tolerance of the reference, in units of the one that is asked for."""

LEAST = 1e-15
"""The same at least, in units of the case's size: a digit beyond doubles is none."""

LONGEST_STEP, SHORT_STEP = 0.1, 0.003
"""Of the reference, which must not step over what is short; where contacts open, as its own
estimate does not see that (with 0.1 it was off by 2e-7 at a tolerance of 1e-12)."""

REFUSALS = ("times must end", "tolerance must satisfy", "measured values must be dense")
"""How what cannot be run is refused."""

NEAR = 0.5
"""Errors above this share of their estimate are told."""


@dataclass(frozen=True)
class DrivenCase:
    """A chain, its start, its end, the tolerance, and the size of what acts."""

    name: str
    chain: DrivenChain
    ends: tuple[Any, Any]
    state: State
    end: float
    tolerance: float
    size: float = 1.0
    mass_factors: Mapping[int, list[float]] = field(default_factory=dict)
    spring_factors: Mapping[int, list[float]] = field(default_factory=dict)


def drawn(seed: int) -> DrivenCase:
    """Return the case of that seed."""
    random = np.random.default_rng(seed)
    name = str(random.choice(CHAINS))
    free = {
        str(symbol): 1 if symbol.is_positive else round(float(random.uniform(-0.3, 1.0)), 3)
        for symbol in LATTICES[name].constants
    }
    lattice = numeric_lattice(LATTICES[name], free)
    fields, cells = len(lattice.fields), int(random.choice([4, 9, 33, 64]))
    size = 10.0 ** random.uniform(-3.0, -0.5)
    end, tolerance = 10.0 ** random.uniform(0.0, 1.3), size * 10.0 ** random.uniform(-6.0, -1.0)

    def drive() -> Any:
        return time_function("drive", _drive(random, size * 10.0 ** random.uniform(-1.0, 1.0), end))

    def shaken() -> Any:
        return drive() if random.random() < 0.6 else Integral.of(drive(), 0.0, end)

    kinds: list[Callable[[], tuple[Any, Any]]] = [
        lambda: (None, None),
        lambda: ("fixed", "fixed"),
        lambda: ("free", "fixed"),
        lambda: ("free", "free"),
        lambda: (shaken(), "fixed"),
        lambda: (shaken(), shaken()),
        lambda: (shaken(), "free"),
    ]
    ends = kinds[random.integers(len(kinds))]()
    masses = _factors(random, range(cells), fields)
    springs = _factors(
        random, range(-1 if ends[0] not in (None, "free") else 0, cells), len(lattice.bonds)
    )
    chain = driven_chain(
        lattice,
        cells,
        left=ends[0],
        right=ends[1],
        losses=_rates(random, fields),
        dashpots=_rates(random, len(lattice.bonds)),
        forces=[
            SiteForce(int(random.integers(cells)), drive(), int(random.integers(fields)))
            for _ in range(random.integers(3))
        ],
        mass_factors=masses,
        spring_factors=springs,
    )
    moving = random.choice([0.0, size])
    state = State(0.0, *(moving * random.standard_normal((2, fields, cells))))
    return DrivenCase(name, chain, ends, state, float(end), float(tolerance), size, masses, springs)


PUSHED: dict[str, tuple[str, ...]] = {
    "power law": ("-(1 - x)**1.4",),
    "steep power law": ("-(1 - x)**3.5",),
    "contacts": ("-contact(1 - x)**(7/5)",),
    "Lennard-Jones": ("2*((1/(1 + x))**7 - (1/(1 + x))**13)",),
    "Toda": ("exp(x) - 1",),
    "pulled Toda": ("1 - exp(-x)",),
    "quartic": ("x + 2*x**3",),
    "tied": ("x + x**3", "x + 0.7*x**3"),
    "next nearest": ("-(1 - x)**1.4", "-0.3*(2 - x)**1.4"),
}
"""Forces between neighbours, and those to a site's place or between neighbours but one."""


def pushed(seed: int) -> DrivenCase:
    """Return a case in which a wall goes further than a bond is long."""
    random = np.random.default_rng(seed)
    name = str(random.choice(list(PUSHED)))
    near, *others = PUSHED[name]
    tables: dict[str, Any] = {"fields": ["u"]}
    tables["spring"] = [{"between": ["u[n]", "u[n+1]"], "force": near}]
    for force in others:
        if name == "tied":
            tables["site"] = [{"field": "u", "force": force}]
        else:
            tables["spring"].append({"between": ["u[n]", "u[n+2]"], "force": force})
    lattice = numeric_lattice(lattice_of(tables, name), {})
    longest = 8.0 if name == "contacts" else 40.0  # of which the reference takes short steps
    cells, end = int(random.choice([12, 33, 64])), float(random.uniform(5.0, longest))
    speed = float(random.uniform(1.0, 0.35 * cells)) / end
    speed = min(speed, 0.5) * float(random.choice([-1.0, 1.0, 1.0, 1.0]))

    def moved(velocity: float) -> Any:
        texts = (f"{velocity}", f"{velocity}*tanh(t)", f"{2 * velocity}*sin(t)**2")
        return Integral.of(time_function("drive", str(random.choice(texts))), 0.0, end)

    kinds: list[Callable[[], tuple[Any, Any]]] = [
        lambda: (moved(speed), "fixed"),
        lambda: ("fixed", moved(-speed)),
        lambda: (moved(speed), moved(-0.7 * speed)),
        lambda: (moved(speed), "free"),
        lambda: ("free", moved(-speed)),
    ]
    ends = kinds[random.integers(len(kinds))]()
    springs: dict[int, list[float]] = {}
    if random.random() < 0.3:
        springs[int(random.integers(1, cells - 2))] = [0.0] * len(lattice.bonds)
    chain = driven_chain(
        lattice,
        cells,
        left=ends[0],
        right=ends[1],
        losses=_rates(random, 1),
        dashpots=_rates(random, len(lattice.bonds)),
        spring_factors=springs,
    )
    state = State(0.0, *np.zeros((2, 1, cells)))
    tolerance = 10.0 ** random.uniform(-9.0, -3.0)
    return DrivenCase(name, chain, ends, state, end, tolerance, 1.0, {}, springs)


def _factors(
    random: np.random.Generator, numbers: Sequence[int], count: int
) -> dict[int, list[float]]:
    """Draw up to two defects."""
    return {
        int(random.choice(numbers)): (10.0 ** random.uniform(-1.0, 1.0, count)).tolist()
        for _ in range(random.integers(3))
    }


def _rates(random: np.random.Generator, count: int) -> list[float]:
    return [float(random.choice([0.0, 10.0 ** random.uniform(-3.0, 0.3)])) for _ in range(count)]


def _drive(random: np.random.Generator, size: float, end: float) -> str | dict[str, list[float]]:
    """Draw a formula, or a walk as if it had been measured."""
    if random.random() < 0.7:
        return _formula(random, size)
    times = np.linspace(0.0, end, int(random.integers(6, 60)))
    values = size * np.cumsum(random.standard_normal(times.size))
    return {"t": times.tolist(), "value": values.tolist()}


def _formula(random: np.random.Generator, size: float) -> str:
    """Return a formula that oscillates, is short, is switched on, beats, or is steady."""
    fast, slow = 10.0 ** random.uniform(-1.0, 2.2), 10.0 ** random.uniform(-1.0, 1.3)
    width, when = 10.0 ** random.uniform(-3.0, 0.5), random.uniform(0.0, 10.0)
    return str(
        random.choice(
            [
                f"{size}*sin({fast}*t)",
                f"{size}*exp(-((t - {when})/{width})**2)",
                f"{size}*tanh({slow}*(t - 3))",
                f"{size}*sin({slow}*t)*cos({fast / 8}*t)",
                f"{size}",
            ]
        )
    )


def exact_state(case: DrivenCase) -> Array:
    """Return fields and velocities at the end, (2, fields, cells), by SciPy."""
    return exact_end(case)[0]


def exact_end(case: DrivenCase) -> tuple[Array, Array]:
    """Return the same, and work and heat since the start; nan where SciPy gives up."""
    within = case.chain.driven_within(0.0, case.end)
    opens = any(bond.force.opening is not None for bond in case.chain.bonds)
    longest = min(SHORT_STEP if opens else LONGEST_STEP, within / 4.0)
    begin = np.concatenate([case.state.f.ravel(), case.state.v.ravel(), [0.0, 0.0]])
    finest = max(FINER * case.tolerance, LEAST * case.size)
    words = {"rtol": 1e-13, "atol": finest, "max_step": longest}
    with np.errstate(invalid="ignore"):  # where nothing moves its estimate is 0 / 0
        found = solve_ivp(_slopes(case), (0.0, case.end), begin, method="DOP853", **words)
    end = np.asarray(found.y[:, -1]) if found.success else np.full_like(begin, math.nan)
    return end[:-2].reshape(2, *case.state.f.shape), end[-2:]


def _slopes(case: DrivenCase) -> Callable[[float, Array], Array]:
    """Return the velocities and accelerations of the cells, written between those of their walls.

    Then the rates of work and heat: a wall does what the bonds that it stretches would take. Three
     as many cells as a force reaches stand at either end: what is wrong where they meet is not
    felt.
    """
    lattice, chain, (fields, cells) = case.chain.ordered, case.chain, case.state.f.shape
    masses, rates = np.array(lattice.masses)[:, None], np.array(chain.losses)[:, None]
    heavier, room = np.ones((fields, cells)), 3 * lattice.reach
    for cell, factors in case.mass_factors.items():
        heavier[:, cell] = factors
    masses, rates = masses * heavier, rates / heavier
    stiffer = np.ones((len(lattice.bonds), cells + 2 * room))
    for number, factors in case.spring_factors.items():
        turns = (-cells, 0, cells) if case.ends[0] is None else (0,)  # a ring meets its own cells
        for place in (number + room + turn for turn in turns):
            if 0 <= place < stiffer.shape[1]:
                stiffer[:, place] = factors

    def wide(f: Array, ends: tuple[Any, Any]) -> Array:
        if case.ends[0] is None:
            return np.concatenate([f[:, -room:], f, f[:, :room]], axis=1)
        low, high = (np.full((fields, room), 0.0 if end is None else end) for end in ends)
        return np.concatenate([low, f, high], axis=1)

    def held_by(bond: NumericBond) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return where a bond reaches over an end without a wall, and where it is the chain's."""
        base = np.arange(-room, cells + room)
        met = np.array([base + entry.shift[0] for entry in bond.stretch])
        low, high = met.min(axis=0) < 0, met.max(axis=0) >= cells
        cut = (low & (case.ends[0] == "free")) | (high & (case.ends[1] == "free"))
        if case.ends[0] is None:
            return cut, (base >= 0) & (base < cells)
        return cut, ((met >= 0) & (met < cells)).any(axis=0)

    reached = [held_by(bond) for bond in lattice.bonds]

    def slopes(t: float, state: Array) -> Array:
        f, v = state[:-2].reshape(2, fields, cells)
        work, heat = 0.0, float(np.sum(masses * rates * v * v))
        at = [float(end(np.array(t))) if callable(end) else None for end in case.ends]
        speed = [float(end.slope(np.array(t))) if callable(end) else None for end in case.ends]
        x, rate = wide(f, (at[0], at[1])), wide(v, (speed[0], speed[1]))
        walls = np.zeros_like(rate) if case.ends[0] is None else wide(0.0 * v, (speed[0], speed[1]))
        total = np.zeros_like(x)
        bonds = zip(lattice.bonds, chain.dashpots, reached, stiffer, strict=True)
        for bond, dashpot, (cut, own), factor in bonds:
            with np.errstate(all="ignore"):
                force = bond.force(bond.stretched(x))
            stretching = bond.stretched(rate) - bond.offset
            cut = cut | (factor == 0.0)
            force = factor * np.where(cut, 0.0, force + dashpot * stretching)
            work += float(np.sum((force * (bond.stretched(walls) - bond.offset))[own]))
            heat += float(np.sum((factor * np.where(cut, 0.0, dashpot * stretching**2))[own]))
            for entry in bond.action:
                total[entry.field] += entry.weight * np.roll(force, -entry.shift[0])
        total = total[:, room : room + cells]
        for push in chain.outer_forces:
            value = float(push.value(np.array(t)))
            total[push.field, push.site] += value
            work += value * v[push.field, push.site]
        pulled = (total / masses - rates * v).ravel()
        return np.concatenate([v.ravel(), pulled, [work, heat]])

    return slopes


def balanced(case: DrivenCase, tolerance: float) -> Refined:
    """Return the chain's energy, work and heat at the start and at the end, to that tolerance."""
    chain, times = case.chain, np.array([0.0, case.end])

    def looked(state: State, balance: EnergyBalance | None) -> Array:
        assert balance is not None
        flowed = balance.total
        return np.array([chain.energy(*state.arrays), flowed.work.sum(), flowed.heat.sum()])

    start = chain.with_walls(case.state)
    return refine(
        CellEngine(chain, start, times, REDUCED_PHASE_6, StateComparison(looked), cuts=()),
        tolerance,
    )


def balance_error(case: DrivenCase, found: Refined, exact: tuple[Array, Array]) -> float:
    """Return the largest error of energy, work and heat, and of their balance, which has three."""
    assert found.trial.values is not None
    start, end = found.trial.values
    energy = case.chain.energy(*case.chain.with_walls(State(case.end, *exact[0])).arrays)
    difference = np.abs(end - [energy, *exact[1]]).max()
    return max(float(difference), abs((end - start) @ [1.0, -1.0, 1.0]) / 3.0)


def true_error(case: DrivenCase, run: Trajectory, exact: Array) -> float:
    """Return the largest error of the displacements, or of the stretches of a free chain."""
    difference = run.f[-1] - exact[0]
    if case.ends[0] is None:
        stretched = np.array(case.chain.ordered.stretches(difference))
        return float(np.abs(stretched).max())
    if "free" in case.ends:
        return float(np.abs(np.diff(difference, axis=1)).max())
    return float(np.abs(difference).max())


def attacked(seed: int) -> tuple[float, float, str]:
    """Return true errors of the run and its energies over the estimates, and the case in words.

    An error is nan if the case is refused.
    """
    case = _unless_refused(partial(drawn, seed))
    if case is None:
        return math.nan, math.nan, "a drive that is refused"
    ends = ", ".join("moved" if callable(end) else str(end) for end in case.ends)
    text = f"{case.name}, ends {ends}, to {case.tolerance:.1e} until {case.end:.3g}"
    exact = _unless_refused(partial(exact_end, case))
    if exact is None:
        return math.nan, math.nan, text
    found = (_unless_refused(partial(one, case, exact)) for one in (run_share, balance_share))
    run, balance = (math.nan if share is None else share for share in found)
    return run, balance, text


def _unless_refused(work: Callable[[], T]) -> T | None:
    """Return the result of the work, None if the chain is refused."""
    try:
        return work()
    except ValueError as refusal:
        if isinstance(refusal, OverBudgetError) or str(refusal).startswith(REFUSALS):
            return None
        raise


def run_share(case: DrivenCase, exact: tuple[Array, Array]) -> float:
    """Return the true error of the displacements in units of its estimate."""
    run = integrate(case.chain, case.state, [case.end], case.tolerance)
    return true_error(case, run, exact[0]) / run.error_estimate


def balance_share(case: DrivenCase, exact: tuple[Array, Array]) -> float:
    """Return the same share for energy, work and heat."""
    start, end = (
        case.chain.energy(*case.chain.with_walls(State(t, *state)).arrays)
        for t, state in ((0.0, case.state.arrays), (case.end, exact[0]))
    )
    size = max(abs(start), abs(end), *np.abs(exact[1]).tolist()) or 1.0
    found = balanced(case, case.tolerance / case.size * size)
    if found.trial.values is None:
        return float("nan")
    return balance_error(case, found, exact) / found.error


@dataclass(frozen=True)
class Pushed:
    """A case in words, the true errors in units of their estimates, and how it was refused."""

    text: str
    shares: tuple[float, ...]
    refusals: tuple[str, ...]


def attacked_by_pushing(seed: int) -> Pushed | None:
    """Return the case at two tolerances, and its energies; None where SciPy gives up."""
    case = pushed(seed)
    ends = ", ".join("moved" if callable(end) else str(end) for end in case.ends)
    cut = ", a bond cut" if case.spring_factors else ""
    text = f"{case.name}, {case.state.f.size} cells, ends {ends}{cut}, until {case.end:.3g}"
    finer = replace(case, tolerance=0.03 * case.tolerance)
    shares, refusals = [], []
    with np.errstate(all="ignore"):
        exact = exact_end(finer)
        if not all(np.isfinite(part).all() for part in exact):
            return None
        for one, share in ((case, run_share), (finer, run_share), (case, balance_share)):
            try:
                shares.append(share(one, exact))
            except ValueError as refusal:
                refusals.append(f"to {one.tolerance:.2g}: {refusal}")
    return Pushed(text, tuple(shares), tuple(refusals))


def push(first: int, count: int) -> int:
    """Attack so many chains by pushing their walls; print what is wrong, and the worst."""
    worst, run, refused = 0.0, 0, 0
    for seed in range(first, first + count):
        found = attacked_by_pushing(seed)
        if found is None:
            continue
        run += 1
        refused += bool(found.refusals)
        largest = float(np.fmax.reduce(found.shares, initial=0.0))
        worst = max(worst, largest)
        if largest > NEAR:
            print(f"seed {seed}: {largest:.2f} of the estimate; {found.text}", flush=True)
        for refusal in found.refusals:
            print(f"seed {seed}: refused {refusal}; {found.text}", flush=True)
    print(
        f"{count} chains, of which {run} run by SciPy, {refused} refused, largest error "
        f"{worst:.3f} of its estimate"
    )
    return int(worst > 1.0)


def main() -> int:
    """Run so many cases; print those that come near their estimate, and the worst."""
    words = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    words.add_argument("--count", type=int, default=2000)
    words.add_argument("--seed", type=int, default=0)
    words.add_argument("--pushed", action="store_true", help="push walls beyond a bond's length")
    options = words.parse_args()
    if options.pushed:
        return push(options.seed, options.count)
    worst, refused = np.zeros(2), 0
    for seed in range(options.seed, options.seed + options.count):
        *found, text = attacked(seed)
        shares = np.array(found)
        refused += bool(np.isnan(shares).any())
        worst = np.fmax(worst, shares)
        if np.fmax.reduce(shares) > NEAR:
            ratios = ", of energies ".join(f"{share:.2f}" for share in shares)
            print(f"seed {seed}: {ratios} of the estimate; {text}", flush=True)
    print(
        f"{options.count} chains, {refused} refused, largest error {worst[0]:.3f} of its estimate, "
        f"of energy, work and heat {worst[1]:.3f}"
    )
    return int(worst.max() > 1.0)


if __name__ == "__main__":
    sys.exit(main())
