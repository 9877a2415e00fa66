"""How fast a lattice comes near its envelope equation: errors over eps at fixed slow time, a rate.

The ring closes: the carrier times the wave goes round it a whole number of times.  Mean strain and
free waves stay on such a ring, so it needs no causal length.  Each error stands beside its own:
what the run's tolerance leaves, and what a ring half as long again changes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Rational, pi

from longwave.derive import Envelope, Lattice, envelope
from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.models.lattices import LATTICES, cell, m1, m2
from longwave.derive.symbols import x
from longwave.lattice import FieldState, integrate
from longwave.scenes.convergence import ConvergenceStudy, ErrorAt, fitted_rate
from longwave.scenes.envelope_data import POWERS, EnvelopeData
from longwave.solutions import Wave, closed_form

Array = NDArray[np.float64]

TOLERANCE = 1e-3
"""Of the stretches along a run, in units of what is expected of the error: eps to a power."""

HIGHEST = 3
"""The power of eps with which errors of the best data fall: G_1 takes the one before."""

LONGER = 1.5
"""How much longer the second ring is."""

SNAPSHOTS = 10
"""Times, in the second half of a run, at which lattice and theory are compared, and again a quarter
of the carrier's period later: errors beat with it."""

CLOSED = 1e-9
"""A ring whose carrier misses less than that of a turn is closed."""


@dataclass(frozen=True)
class EnvelopeCase:
    """A closed form on one lattice, in the slow variables of its envelope equation.

    It is run over ``span``, two times of the normal form, on a ring of that ``length`` in X at
    least, and compared ``within`` that half-width of X about the frame; ``runs`` as the ``lattice``
    of `EnvelopeData`.
    """

    lattice: str
    constants: Mapping[str, Number]
    k: Expr
    form: str
    span: tuple[Number, Number]
    length: float
    within: float
    branch: str | int = 0
    runs: Lattice | None = None
    parameters: Mapping[str, Number] = field(default_factory=dict)

    def envelope(self) -> Envelope:
        """The lattice's envelope equation at these constants."""
        lattice = LATTICES[self.lattice]
        known = {str(symbol) for symbol in lattice.constants}
        inner = {name: value for name, value in self.constants.items() if name in known}
        return envelope(lattice, self.k, self.branch, **inner)


def envelope_study(case: EnvelopeCase, order: str, eps_values: Sequence[float]) -> ConvergenceStudy:
    """Errors of a case at each eps, with data of that order and compared with the same."""
    found = case.envelope()
    errors = tuple(_error(case, found, order, eps) for eps in eps_values)
    own = [error.discretisation for error in errors]
    return ConvergenceStudy(errors, fitted_rate(eps_values, [e.error for e in errors], own))


def _error(case: EnvelopeCase, found: Envelope, order: str, eps: float) -> ErrorAt:
    short, long = (_Run(case, found, order, eps, longer) for longer in (1.0, LONGER))
    pairs = zip(short.differences, long.differences, strict=True)
    changed = max(float(np.max(np.abs(a - b))) for a, b in pairs)
    error = max(float(np.max(np.abs(apart))) for apart in short.differences)
    return ErrorAt(eps, short.cells.size, error, changed + short.own)


class _Run:
    """One ring through all times: lattice less theory at the late ones, and the run's own error."""

    def __init__(
        self, case: EnvelopeCase, found: Envelope, order: str, eps: float, longer: float
    ) -> None:
        form = found.normal_form(None, None, **case.constants)
        wave = Wave(closed_form(case.form), form, **case.parameters)
        v, rate = float(form.c), abs(float(form.b))
        begin, end = (float(tau) / rate / eps**2 for tau in case.span)
        late = np.linspace((begin + end) / 2, end, SNAPSHOTS)
        ends = wave.jets(np.array([-1.0, 1.0]) * case.length / 2, eps**2 * begin, 0)[0]
        count = closing_count(longer * case.length / eps, case.k, ends)
        self.cells = np.arange(count) + np.floor(v * begin - count / 2)
        X = eps * (self.cells - v * begin)
        values = wave.jets(X, eps**2 * begin, 0)[0]
        data = EnvelopeData(
            found,
            case.constants,
            wave,
            eps,
            order,
            mean_square=float(np.mean(np.abs(values) ** 2)),
            interval=(X[0], X[0] + eps * count),
            lattice=case.runs,
        )
        data.start(begin)
        ring = data.ring(self.cells, begin)
        state = FieldState(begin, ring.f, ring.v)
        tolerance = TOLERANCE * eps ** min(POWERS[order] + 1, HIGHEST)
        times = np.sort([late, late + np.pi / 2 / data.carrier.omega], axis=None)
        run = integrate(ring.lattice, state, times, tolerance)
        self.own = run.error_estimate
        self.differences = []
        for t, f in zip(run.times, run.f, strict=True):
            middle, half = round(v * t), int(case.within / eps)
            where = np.arange(middle - half, middle + half + 1)
            places = (where - int(self.cells[0])) % count
            measured = data.measured(f, ring.mean_strain)[:, places]
            self.differences.append(measured - data.strain(where, float(t)))


def closing_count(least: float, k: Expr, ends: NDArray[np.complex128]) -> int:
    """The first number of cells from ``least`` on after which carrier and wave come round.

    ``ends`` are values of A one ring apart; where they vanish any number will do.  Raises
    ValueError where no ring closes.

    >>> closing_count(99.0, pi / 2, np.array([1.0, 1.0 + 0j]))
    100
    >>> closing_count(99.0, pi / 2, np.array([-1.0, 1.0 + 0j]))
    102
    """
    counts = int(np.ceil(least)) + np.arange(TRIED)
    if float(np.min(np.abs(ends))) <= GONE:
        return int(counts[0])
    turns = (float(k) * counts + np.angle(ends[1] * np.conj(ends[0]))) / (2 * np.pi)
    closed = counts[np.abs(turns - np.rint(turns)) < CLOSED]
    if not closed.size:
        raise ValueError(
            f"k must close the ring of a wave that does not end, got {k} (take a part of pi with a "
            f"denominator below {TRIED})"
        )
    return int(closed[0])


TRIED = 200
"""Numbers of cells among which one that closes is looked for."""

GONE = 1e-7
"""A wave that small at its ends has no seam to speak of."""

_CUBIC = {"K2": 1, "K3": Rational(1, 4), "K4": 1}
_QUADRATIC = {"K2": 1, "K3": Rational(3, 2), "K4": 1}
_PINNED = {"K2": 1, "g1": 2, "g2": 1, "g3": 1}
_HARD = {"K2": 1, "g1": 2, "g2": 1, "g3": 4}
"""With g3 = 1 the soliton is 1.07 high and its errors, some 100 eps^3, hide their power."""
_DIMER = {"m1": 1, "m2": 4, "K2": 1, "K3": Rational(1, 4), "K4": 1}
_GRAINS = {"m1": 1, "m2": 4, "K2": 1, "K3": -Rational(1, 4), "K4": -Rational(1, 24)}

GRANULAR_DIMER = cell(
    "granular_dimer",
    "two grains in turn under unit precompression, unit stiffness at rest",
    (m1, m2),
    (-Rational(2, 3) * (1 - x) ** Rational(3, 2),) * 2,
)
"""Its optical branch has short focusing waves; equal grains have none."""

_SOLITON, _PEREGRINE = ((0, 4), 40, 8), ((-1, Rational(1, 5)), 60, 5)

ENVELOPE_CASES = {
    "bright, strain": EnvelopeCase("fput_strain", _CUBIC, pi / 2, "nls_bright", *_SOLITON),
    "bright, strain, pi": EnvelopeCase("fput_strain", _CUBIC, pi, "nls_bright", *_SOLITON),
    "bright, displacement": EnvelopeCase("fput", _CUBIC, pi / 2, "nls_bright", *_SOLITON),
    "dark, strain": EnvelopeCase("fput_strain", _QUADRATIC, pi / 2, "nls_dark", (0, 2), 60, 6),
    "dark, Klein-Gordon": EnvelopeCase("klein_gordon", _PINNED, pi / 3, "nls_dark", (0, 2), 60, 6),
    "bright, Klein-Gordon": EnvelopeCase(
        "klein_gordon", _HARD, 2 * pi / 3, "nls_bright", *_SOLITON
    ),
    "Peregrine, strain": EnvelopeCase("fput_strain", _CUBIC, pi / 2, "nls_peregrine", *_PEREGRINE),
    "Peregrine, strain, pi": EnvelopeCase("fput_strain", _CUBIC, pi, "nls_peregrine", *_PEREGRINE),
    "Peregrine, displacement": EnvelopeCase("fput", _CUBIC, pi / 2, "nls_peregrine", *_PEREGRINE),
    "Peregrine, optical dimer": EnvelopeCase(
        "mass_dimer", _DIMER, pi / 4, "nls_peregrine", *_PEREGRINE, branch="optical"
    ),
    "Peregrine, granular dimer": EnvelopeCase(
        "mass_dimer",
        _GRAINS,
        pi,
        "nls_peregrine",
        *_PEREGRINE,
        branch="optical",
        runs=GRANULAR_DIMER,
    ),
}
"""The cases whose rates are measured, by name.

At k = pi leading data have no rate of their own: what they lack is the mean b0 |A|^2 eps^2
(measured 0.0896 to 0.0908 eps^2 of the soliton's 1/11, from eps = 0.1 to 0.025), and the carrier's
error falls as eps^3; their sum looks like 2.5 (soliton) and 2.6 (Peregrine) above eps = 0.02.
"""
