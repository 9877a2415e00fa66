"""Exponential Adams methods with one evaluation a step and an embedded error estimate.

    p' = L p + N(p),    L diagonal

Over a step the linear part is exact and N is replaced by the polynomial through its last values:
the predictor uses ``VALUES`` of them, the corrector one more, at the predicted point (Hochbruck and
Ostermann, BIT 51 (2011) 889). The difference of the two is the estimate. N is evaluated once a
step, where ETDRK4 evaluates it four times. The past values may stand at unequal times, so that the
step can change at any step.
"""

from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from verify.exponential.phi import moment_weights
from verify.exponential.runge_kutta import ExponentialRungeKutta

Complex = NDArray[np.complex128]
Array = NDArray[np.float64]
Nonlinearity = Callable[[Complex], Complex]
Norm = Callable[[Complex], float]
Table = tuple[Complex, Complex, Complex]

VALUES = 3
"""Past values of N in the predictor. With 5 and more the waves at the zone boundary grow."""

START = 8
"""The first steps are shorter than the step asked for by this factor."""

CONFIDENCE = 3.0
"""The estimate against the difference of predictor and corrector, so that it bounds the error."""

BLOCK = 16
"""Steps between two looks at the error."""

GROWTH = 8.0
"""The step is doubled when the estimate is below its share by this factor."""

HELPLESS = 0.7
"""Halving the step helps if it reduces the growth of the estimate below this share of it."""

TABLES = 12
"""Coefficient tables kept."""


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _predict(factor: Complex, p: Complex, weights: Complex, past: Complex, out: Complex) -> None:
    for branch in range(p.shape[0]):
        for k in range(p.shape[1]):
            value = factor[branch, k] * p[branch, k]
            for j in range(past.shape[0]):
                value += weights[j, branch, k] * past[j, k]
            out[branch, k] = value


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _correct(
    weights: Complex, newest: Complex, past: Complex, factor: Complex, p: Complex, error: Complex
) -> None:
    """Add the correction to ``p`` and to ``error``, which is carried along by the linear part."""
    for branch in range(p.shape[0]):
        for k in range(p.shape[1]):
            change = weights[0, branch, k] * newest[k]
            for j in range(past.shape[0]):
                change += weights[j + 1, branch, k] * past[j, k]
            error[branch, k] = factor[branch, k] * error[branch, k] + change
            p[branch, k] += change


class ExponentialAdams:
    """A solution of p' = L p + N(p), advanced with steps that halve and double.

    ``linear`` and ``p`` have the shape (branches, modes), N(p) the shape (modes,): one nonlinearity
    drives all branches. ``norm`` gives the size of a change of p in the controlled quantity.

    The corrections of all steps are summed as vectors, carried along by the linear part, so that
    errors which oscillate cancel as they do in the solution; ``norm`` of the sum is the estimate.
    A block of ``BLOCK`` steps in which it grows by more than its share is done again with half the
    step, unless halving no longer helps (waves much faster than the step, whose errors stay
    bounded): then that growth is let pass from there on,
    for steps that are not longer.

    ``estimate`` is the estimate so far, ``steps``, ``evaluations`` and
    ``rejected`` (blocks) count, and ``h`` is the present step.
    """

    def __init__(
        self, linear: Complex, nonlinearity: Nonlinearity, p: Complex, norm: Norm, h: float
    ) -> None:
        self.p = p
        self.h = h / START
        self.steps = self.evaluations = self.rejected = 0
        self.estimate = 0.0
        self._linear, self._nonlinearity, self._norm = linear, nonlinearity, norm
        self._tables: dict[tuple[float, ...], Table] = {}
        self._times = -self.h * np.arange(VALUES)
        self._error = np.zeros_like(p)
        self._refused, self._floor, self._floor_step = np.inf, 0.0, 0.0
        self._past = np.empty((VALUES, linear.shape[1]), dtype=np.complex128)
        self._start()

    def advance(self, duration: float, rate: float) -> None:
        """Advance by exactly ``duration``, keeping the estimated error per unit time at ``rate``.

        Raises FloatingPointError with the time passed if the solution blows up.
        """
        done = 0.0
        while duration - done > 1e-12 * duration:
            kept = (self.p, self._past.copy(), self._times, self._error.copy())
            h, count = self._block(duration - done)
            error = self._run(h, count)
            growth = (error - self.estimate) / (h * count)
            helpless = growth > HELPLESS * self._refused
            allowed = max(rate, self._floor) if h <= self._floor_step else rate
            if not growth <= allowed and not helpless:
                self.p, self._past, self._times, self._error = kept
                self.rejected += 1
                self._refused = growth if growth < np.inf else np.inf
                self.h = h / 2
                if self.h < 1e-9 * duration:
                    raise FloatingPointError(f"the solution blew up after {done:g}")
                continue
            if helpless:
                self._floor, self._floor_step = 2.0 * growth, h
            self._refused = np.inf
            self.estimate = error
            self.steps += count
            done += h * count
            if growth < rate / GROWTH and h == self.h:
                self.h *= 2

    def _block(self, left: float) -> tuple[float, int]:
        """Step and number of steps of the next block; the last ones share what is left."""
        if left > 2 * BLOCK * self.h:
            return self.h, BLOCK
        count = int(np.ceil(left / self.h * (1 - 1e-9)))
        h = left / count
        return h, min(count, BLOCK)

    def _run(self, h: float, count: int) -> float:
        """Take the steps; return the estimated error."""
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(count):
                self._step(h)
            return CONFIDENCE * self._norm(self._error)

    def _start(self) -> None:
        """Fill the past by ETDRK4; time 0 is where it ends, the solution as many steps on."""
        method = ExponentialRungeKutta(self._linear, self._nonlinearity, -self.h)
        p = self.p
        for j in range(VALUES):
            self._past[j] = self._nonlinearity(p)
            if j + 1 < VALUES:
                p = method.step(p)
        self.evaluations += 5 * VALUES

    def _step(self, h: float) -> None:
        factor, predictor, corrector = self._table(h)
        p = np.empty_like(self.p)
        _predict(factor, self.p, predictor, self._past, p)
        newest = self._nonlinearity(p)
        _correct(corrector, newest, self._past, factor, p, self._error)
        self.p = p
        self.evaluations += 1
        self._past[1:] = self._past[:-1].copy()
        self._past[0] = newest
        self._times = np.concatenate([[0.0], self._times[:-1] - h])

    def _table(self, h: float) -> Table:
        nodes = np.round(self._times / h, 9)
        key = (h, *nodes)
        if key not in self._tables:
            if len(self._tables) == TABLES:
                self._tables.pop(next(iter(self._tables)))
            self._tables[key] = self._make(h, nodes)
        return self._tables[key]

    def _make(self, h: float, nodes: Array) -> Table:
        z = self._linear * h
        predictor = h * moment_weights(z, nodes)
        corrector = h * moment_weights(z, np.concatenate([[1.0], nodes]))
        corrector[1:] -= predictor
        return np.exp(z), predictor, corrector
