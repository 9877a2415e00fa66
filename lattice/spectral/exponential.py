"""Exponential integrators of p' = L p + N(p), L diagonal, and their phi functions.

    phi_0(z) = exp(z),    phi_{m+1}(z) = (phi_m(z) - 1/m!)/z,    phi_m(0) = 1/m!

The recurrence loses digits near 0. Where |z| < SERIES_RADIUS the highest function is summed as its
power series, and the others follow by the recurrence in reverse, which loses none.

Over a step the linear part is exact. The Adams method, of order 4, replaces N by the polynomial
through its last values: the predictor uses ``PAST_VALUES`` of them, the corrector one more, at the
predicted point (Hochbruck and Ostermann, BIT 51 (2011) 889). It evaluates N once a step. The
Runge-Kutta method ETDRK4 (Cox and Matthews, J. Comput. Phys. 176 (2002) 430), which computes the
first values, evaluates it four times.

The step is fixed, so that the error is a smooth function of it, and a run with a shorter step shows
it. Times that are not whole steps are reached by an extra shorter step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from longwave.support.compiled.jit import complexes, njit
from longwave.support.real_arrays import Array, Complex

if TYPE_CHECKING:
    from longwave.support.checkpoint import Memory

SERIES_RADIUS = 2.0
"""Least abs(z) for which the recurrence is used."""

SERIES_TERMS = 26
"""Number of terms of the series: SERIES_RADIUS^SERIES_TERMS/SERIES_TERMS! is below rounding."""


def phi_functions(z: Complex, highest: int) -> list[Complex]:
    """Return phi_0 .. phi_highest at the points ``z`` (any shape).

    >>> [round(float(value[0].real), 12) for value in phi_functions(np.zeros(1, complex), 2)]
    [1.0, 1.0, 0.5]
    """
    z = np.asarray(z, dtype=np.complex128)
    near = np.abs(z) < SERIES_RADIUS
    values = _upwards(np.where(near, SERIES_RADIUS, z), highest)
    for value, close in zip(values, _downwards(z[near], highest), strict=True):
        value[near] = close
    values[0] = np.exp(z)
    return values


def _upwards(z: Complex, highest: int) -> list[Complex]:
    """Return phi_0 .. phi_highest by the recurrence."""
    values = [np.exp(z)]
    for m in range(highest):
        values.append((values[m] - 1.0 / math.factorial(m)) / z)
    return values


def _downwards(z: Complex, highest: int) -> list[Complex]:
    """Return phi_0 .. phi_highest: the last one as a series, the others by reverse recurrence."""
    top = np.zeros_like(z)
    for j in reversed(range(SERIES_TERMS)):
        top = top * z + 1.0 / math.factorial(highest + j)
    values = [top]
    for m in reversed(range(highest)):
        values.append(z * values[-1] + 1.0 / math.factorial(m))
    return values[::-1]


def moment_weights(z: Complex, nodes: Array) -> Complex:
    """Return weights w_j(z) with int_0^1 exp((1 - u) z) f(u) du = sum_j w_j f(nodes_j).

    Exact for polynomials f of degree < len(nodes). Shape (len(nodes), *z.shape).
    """
    count = len(nodes)
    lagrange = np.linalg.inv(np.vander(nodes, count, increasing=True).T)
    functions = phi_functions(z, count)
    moments = np.stack([math.factorial(m) * functions[m + 1] for m in range(count)])
    return np.tensordot(lagrange, moments, axes=1)


Nonlinearity = Callable[[Complex], Complex]


class ExponentialRungeKutta:
    """ETDRK4 with step ``h`` for p' = L p + N(p), L diagonal; four evaluations of N per step."""

    def __init__(self, linear: Complex, nonlinearity: Nonlinearity, h: float) -> None:
        self._nonlinearity = nonlinearity
        self._half, half_phi = phi_functions(linear * (h / 2), 1)
        self._inner = half_phi * (h / 2)
        self._whole, one, two, three = phi_functions(linear * h, 3)
        self._first = h * (one - 3 * two + 4 * three)
        self._middle = h * (2 * two - 4 * three)
        self._last = h * (4 * three - two)

    def step(self, p: Complex) -> Complex:
        """Return the solution one step after ``p``."""
        n0 = self._nonlinearity(p)
        a = self._half * p + self._inner * n0
        na = self._nonlinearity(a)
        nb = self._nonlinearity(self._half * p + self._inner * na)
        nc = self._nonlinearity(self._half * a + self._inner * (2 * nb - n0))
        return self._whole * p + self._first * n0 + self._middle * (na + nb) + self._last * nc


Table = tuple[Complex, Complex, Complex]

PAST_VALUES = 3
"""Number of past values of N in the predictor. With 5 and more, waves at the zone boundary grow."""

ORDER = PAST_VALUES + 1
"""Order of the Adams method."""

STEP_SLACK = 1e-9
"""Distance, in steps, within which a time counts as the end of a whole step."""


_jit = partial(njit, cache=True, fastmath={"contract"})


@_jit(examples=[(complexes(2), complexes(2), complexes(3), complexes(2), complexes(2))])
def _predict(factor: Complex, p: Complex, weights: Complex, past: Complex, out: Complex) -> None:
    """Compute into ``out`` the solution predicted after a step from N's ``past`` values."""
    for branch in range(p.shape[0]):
        for k in range(p.shape[1]):
            value = factor[branch, k] * p[branch, k]
            for j in range(past.shape[0]):
                value += weights[j, branch, k] * past[j, k]
            out[branch, k] = value


@_jit(examples=[(complexes(3), complexes(1), complexes(2), complexes(2))])
def _correct(weights: Complex, newest: Complex, past: Complex, p: Complex) -> None:
    """Add the corrector's change to p, in place."""
    for branch in range(p.shape[0]):
        for k in range(p.shape[1]):
            change = weights[0, branch, k] * newest[k]
            for j in range(past.shape[0]):
                change += weights[j + 1, branch, k] * past[j, k]
            p[branch, k] += change


class ExponentialAdams:
    """Solution of p' = L p + N(p) from ``p`` at time 0, in steps of ``h`` > 0.

    ``linear`` and ``p`` have the shape (branches, modes), N(p) the shape (modes,): one nonlinearity
    drives all branches. The past values for the first step come from ETDRK4, run backwards.

    ``p`` is the solution at time ``steps * h``; ``evaluations`` is the number of evaluations of N.
    """

    def __init__(self, linear: Complex, nonlinearity: Nonlinearity, p: Complex, h: float) -> None:
        if not h > 0:
            raise ValueError(f"h must satisfy h > 0, got {h:g} (the step goes forward)")
        self.p, self.h = p, h
        self.steps = 0
        self._linear, self._nonlinearity = linear, nonlinearity
        self._past = np.empty((PAST_VALUES, linear.shape[1]), dtype=np.complex128)
        # past values of N by ETDRK4, backwards in time
        method = ExponentialRungeKutta(linear, nonlinearity, -h)
        for j in range(PAST_VALUES):
            self._past[j] = nonlinearity(p)
            if j + 1 < PAST_VALUES:
                p = method.step(p)
        self.evaluations = PAST_VALUES + 4 * (PAST_VALUES - 1)
        self._whole = self._table(1.0)

    def step(self) -> None:
        """Advance by one step."""
        self.p, newest = self._part(self._whole)
        self._past[1:] = self._past[:-1].copy()
        self._past[0] = newest
        self.steps += 1

    def memory(self) -> Memory:
        """Return the data from which `recall` resumes between two steps."""
        return {name: getattr(self, name) for name in ("p", "steps", "evaluations", "_past")}

    def recall(self, memory: Memory) -> None:
        """Restore the solution from the `memory` of one with the same arguments."""
        from longwave.support.checkpoint import fitting

        for name in ("p", "steps", "evaluations", "_past"):
            setattr(self, name, fitting(memory[name], getattr(self, name)))

    def whole_steps(self, t: float) -> int:
        """Return how many more whole steps fit before the time ``t``."""
        return int(np.floor(t / self.h + STEP_SLACK)) - self.steps

    def solution_at(self, t: float) -> Complex:
        """Return the solution at a time less than one step after ``p``, which does not change."""
        fraction = t / self.h - self.steps
        return self.p if abs(fraction) <= STEP_SLACK else self._part(self._table(fraction))[0]

    def _part(self, table: Table) -> tuple[Complex, Complex]:
        """Return the solution after a step with these coefficients, and N at its prediction."""
        factor, predictor, corrector = table
        p = np.empty_like(self.p)
        _predict(factor, self.p, predictor, self._past, p)
        newest = self._nonlinearity(p)
        self.evaluations += 1
        _correct(corrector, newest, self._past, p)
        return p, newest

    def _table(self, fraction: float) -> Table:
        """Return the coefficients of a step of ``fraction * h``."""
        h = fraction * self.h
        z = self._linear * h
        nodes = -np.arange(PAST_VALUES) / fraction
        predictor = h * moment_weights(z, nodes)
        corrector = h * moment_weights(z, np.concatenate([[1.0], nodes]))
        corrector[1:] -= predictor
        return np.exp(z), predictor, corrector
