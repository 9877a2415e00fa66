"""Random lattices and data, run to random tolerances, and judged against an integrator apart.

The reference is SciPy's DOP853 on `NumericLattice.acceleration`: it shares no line with a kernel.
Its own error is what a tenth of its tolerance changes; where that is not small beside the estimate,
a case says nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.force_program import ForceProgram
from longwave.lattice.integration import Judged, integrate
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice
from longwave.lattice.state import State
from longwave.support.request_limits import Cancelled

Array = NDArray[np.float64]
Random = np.random.Generator

SIZES = (1, 2, 3, 4, 5, 8, 16, 31, 33, 64, 100)
REFUSED = ("times must end", "tolerance must satisfy", "state must have")
"""How refusals begin that are right wherever they are said."""

SURE = 0.05
"""Share of the estimate up to which the reference may err."""

DEAREST = 400_000
"""Accelerations that a reference may take."""


@dataclass(frozen=True)
class ChainCase:
    """A lattice, a state, times, a tolerance, and whether fields or stretches are judged."""

    lattice: NumericLattice
    state: State
    times: Array
    tolerance: float
    of_fields: bool

    def judged(self, f: Array) -> Array:
        """Return the part of the fields that is judged."""
        return f if self.of_fields else np.array(self.lattice.stretches(f))


@dataclass(frozen=True)
class EstimateVerdict:
    """``ratio``: the true error in units of the estimate, nan where nothing can be said."""

    kind: Literal["sound", "too small", "refused", "undecided"]
    ratio: float = math.nan
    reason: str = ""


def random_case(seed: int) -> ChainCase:
    """Return the case of that number."""
    random = np.random.default_rng(seed)
    size = 10.0 ** random.uniform(-2, 1)
    lattice = random_chain(random, size)
    shape = len(lattice.fields), int(random.choice(SIZES))
    highest = lattice.highest_frequency([abs(slope) for slope in lattice.rest_slopes()]) or 1.0
    f = size * random.choice([0.0, 0.1, 0.3]) * random.standard_normal(shape)
    v = size * random.choice([0.0, 0.1, 0.3]) * random.standard_normal(shape) * highest
    if random.random() < 0.3:
        f, v = f + 10.0 * size, v + highest * size * random.uniform(-1.0, 1.0)
    t0, duration = float(random.choice([0.0, -3.7, 1e3])), 10.0 ** random.uniform(-1, 2) / highest
    times = t0 + np.sort(random.uniform(0.0, duration, random.choice([1, 2, 5])))
    tolerance = 10.0 ** random.uniform(-9, -3) * size
    return ChainCase(lattice, State(t0, f, v), times, tolerance, random.random() < 0.3)


def random_chain(random: Random, size: float, reach: int = 3) -> NumericLattice:
    """Draw a chain of one to three fields whose nonlinear forces matter at that stretch."""
    fields = int(random.choice([1, 1, 2, 3]))
    masses = 10.0 ** random.uniform(-1, 1, fields) if random.random() < 0.7 else np.ones(fields)
    unit = 10.0 ** random.uniform(-2, 2)
    bonds = [_bond(random, fields, reach, size, unit) for _ in range(random.integers(1, 5))]
    names = ("u", "v", "w")[:fields]
    return NumericLattice("random", names, tuple(masses.tolist()), tuple(bonds))


def _bond(random: Random, fields: int, reach: int, size: float, unit: float) -> NumericBond:
    """Draw a spring, a tie to the site, a bending stiffness, or strains' second difference."""
    first, second = (int(field) for field in random.integers(0, fields, 2))
    here, there = 0, int(random.integers(-reach, reach + 1))
    stencils = {
        "spring": {(there, second): 1.0, (here, first): -1.0},
        "site": {(here, first): 1.0},
        "bend": {(1, first): 1.0, (here, first): -2.0, (-1, first): 1.0},
        "sum": {(there, second): 1.0, (here, first): 2.0},
    }
    kind = str(random.choice(["spring", "spring", "spring", "site", "bend", "sum", "strain"]))
    force = random_force(random, size, unit * 10.0 ** random.uniform(-1, 0.5))
    if kind == "strain":
        stretch = {(here, first): 1.0, (there, first): 1.0 if random.random() < 0.5 else 0.0}
        action = {
            (s + e, first): w * x for s, w in _second.items() for (e, _), x in stretch.items()
        }
        action = {(-shift, field): weight for (shift, field), weight in action.items()}
    else:
        stretch = stencils[kind]
        action = {(-shift, field): -weight for (shift, field), weight in stretch.items()}
    offset = size * random.uniform(-0.5, 0.5) if random.random() < 0.3 else 0.0
    return NumericBond(_entries(stretch), _entries(action), force, offset)


_second = {1: 1.0, 0: -2.0, -1: 1.0}


def _entries(stencil: dict[tuple[int, int], float]) -> tuple[Entry, ...]:
    return tuple(Entry((shift,), weight, field) for (shift, field), weight in stencil.items())


def random_force(random: Random, size: float, stiffness: float) -> ForceProgram:
    """Return a polynomial of degree up to 7, or one of the functions that lattices have."""
    scale = float(random.choice([0.3, 1.0])) / size
    kind = str(
        random.choice(["polynomial"] * 5 + ["linear", "exp", "sin", "tanh", "hertz", "pull"])
    )
    if kind == "linear":
        return ForceProgram((stiffness,))
    if kind == "polynomial":
        degree = int(random.integers(2, 8))
        others = random.uniform(-1, 1, degree - 1) * (random.random(degree - 1) < 0.5)
        powers = stiffness * others * scale ** np.arange(1.0, degree)
        first = stiffness if random.random() < 0.9 else 0.0
        return ForceProgram((first, *powers.tolist()))
    return _function(kind, stiffness, scale)


def _function(kind: str, stiffness: float, scale: float) -> ForceProgram:
    """Return K/s times exp(s x) - 1, sin(s x), tanh(s x), Hertz' law or Lennard-Jones'."""
    from sympy import Float, Rational, exp, sin, tanh

    from longwave.derive.symbols import x
    from longwave.lattice.force_program import force_program

    s, K = Float(scale), Float(stiffness)
    gap = 10 / s
    laws = {
        "exp": K / s * (exp(s * x) - 1),
        "sin": K / s * sin(s * x),
        "tanh": K / s * tanh(s * x),
        "hertz": Rational(2, 3) * K * gap ** Rational(-1, 2)
        * (gap ** Rational(3, 2) - (gap - x) ** Rational(3, 2)),
        "pull": K * gap / 6 * ((gap / (gap + x)) ** 7 - (gap / (gap + x)) ** 13),
    }  # fmt: skip
    return force_program(laws[kind])


def judge(seed: int) -> EstimateVerdict:
    """Return the case of that number, run and compared."""
    case = random_case(seed)
    fields: Judged | None = (lambda f, v, t: f) if case.of_fields else None
    try:
        run = integrate(case.lattice, case.state, case.times, case.tolerance, judged=fields)
    except ValueError as refusal:
        if not str(refusal).startswith(REFUSED):
            raise
        return EstimateVerdict("refused", reason=str(refusal))
    if run.error_estimate > case.tolerance:
        return EstimateVerdict("too small", math.inf, "the estimate is above the tolerance")
    exact, rough = (reference(case, rtol) for rtol in (1e-13, 1e-12))
    if exact is None or rough is None:
        return EstimateVerdict("undecided", reason="the reference gave up")
    found = [case.judged(f) for f in run.f]
    error = max(_apart(one, case.judged(f)) for one, f in zip(found, exact, strict=True))
    doubt = max(_apart(case.judged(f), case.judged(g)) for f, g in zip(exact, rough, strict=True))
    ratio = error / max(run.error_estimate, 1e-300)
    if ratio > 1.0 and doubt > SURE * run.error_estimate:
        return EstimateVerdict("undecided", ratio, f"the reference is known to {doubt:.2g}")
    return EstimateVerdict("sound" if ratio <= 1.0 else "too small", ratio)


def _apart(one: Array, other: Array) -> float:
    found = float(np.max(np.abs(one - other)))
    return found if math.isfinite(found) else math.inf


def reference(case: ChainCase, rtol: float) -> Array | None:
    """Return fields at the times; None where DOP853 gives up."""
    from scipy.integrate import solve_ivp

    state, shape, calls = case.state, case.state.f.shape, 0

    def rate(_: float, both: Array) -> Array:
        nonlocal calls
        calls += 1
        if calls > DEAREST:
            raise Cancelled
        f, v = both.reshape(2, *shape)
        return np.concatenate([v.ravel(), case.lattice.acceleration(f).ravel()])

    both = np.concatenate([state.f.ravel(), state.v.ravel()])
    unit = float(np.max(np.abs(state.f))) or 1e-3 * float(np.max(np.abs(both))) or 1.0
    rows = []
    # from 0 to each time anew: dense output is less exact, and far from 0 a step loses digits
    for gap in np.diff(case.times, prepend=state.t):
        try:
            with np.errstate(all="ignore"):
                solved = solve_ivp(
                    rate, (0.0, gap), both, "DOP853", rtol=rtol, atol=0.1 * rtol * unit
                )
        except Cancelled:
            return None
        if not solved.success:
            return None
        both = solved.y[:, -1]
        rows.append(both[: both.size // 2].reshape(shape))
    return np.array(rows)
