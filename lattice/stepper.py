"""Time stepping: advancing a ring by a scheme, and stepping a state through given times."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from longwave.lattice.dynamics import Dynamics
from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.schemes import Scheme
from longwave.lattice.state import BlowUp, Domain, State
from longwave.support.checkpoint import Memory, fitting
from longwave.support.real_arrays import Array


def advance(
    scheme: Scheme, f: Array, v: Array, h: float, steps: int, lattice: NumericLattice
) -> None:
    """Advance (fields, *cells) in place by ``steps`` steps ``h``, with the fastest kernel."""
    Dynamics(lattice).advance(scheme, f, v, h, steps)


CHUNK = 64
"""Largest number of steps between two stops; a chunk that blew up is repeated step by step."""

LEAST_CHUNK = 8
"""Default least number of steps between two stops: checking a large ring costs as much as a
step."""

MAX_EVALUATIONS = 3e8
"""Largest number of force evaluations between two stops, a fraction of a second, so that Ctrl-C
acts soon."""


@dataclass
class FixedDomain(Domain):
    """The ring of all sites of a state, which does not move."""

    state: State

    def start(self) -> State:
        """Return the state itself, which is advanced in place."""
        return self.state


class Stepper:
    """Advances ``state`` in place, following the domain and checking for a blow-up.

    Between two requested times, or moves of the domain, the steps are equal and not longer than
    ``step``, so that those times are hit exactly. ``amplitude`` is the largest stretch of the wave
    at the start; None, without a wave, allows strains of any size. At most ``chunk`` steps lie
    between two stops; the default depends on `MAX_EVALUATIONS` and `LEAST_CHUNK`. ``ranges`` are
    the ranges of stretches and fields at all stops so far, on any site (`Dynamics.ranges`).
    ``blow_up`` is set when the march had to stop; ``steps`` counts the steps.
    """

    def __init__(
        self,
        state: State,
        scheme: Scheme,
        lattice: NumericLattice,
        domain: Domain,
        step: float,
        amplitude: float | None,
        chunk: int | None = None,
    ) -> None:
        self.state: State = state
        self.scheme = scheme
        self.dynamics = Dynamics(lattice)
        self.domain: Domain = domain
        self.step = step
        self.steps = 0
        self._amplitude = amplitude
        self._between: tuple[float, int] | None = None
        usual = min(CHUNK, int(MAX_EVALUATIONS / (scheme.stages * state.size)))
        self._chunk = chunk or max(LEAST_CHUNK, usual)
        self.ranges = self.dynamics.ranges(state)
        self.blow_up: BlowUp | None = self._find_blow_up()

    def stops(self, times: Sequence[float]) -> Iterator[State]:
        """Yield the state at all ``times``, at the domain's moves and every few steps.

        Ends after a blow-up.
        """
        moves = {t for t in self.domain.moves if self.state.t < t < times[-1]}
        for t in sorted(moves.union(times)):
            yield from self._stops_until(t)
            if self.blow_up is not None:
                return

    def memory(self, arrays: bool = True) -> Memory:
        """Return the data from which `recall` resumes, with the state's arrays if ``arrays``."""
        state = {"t": self.state.t} if not arrays else vars(self.state)
        progress = {name: getattr(self, name) for name in ("steps", "ranges", "_between")}
        return progress | {"state": state, "domain": self.domain.memory()}

    def recall(self, memory: Memory) -> None:
        """Continue from the stop at which a stepper with the same arguments returned ``memory``."""
        for name in ("steps", "ranges", "_between"):
            setattr(self, name, memory[name])
        for name, value in memory["state"].items():
            setattr(self.state, name, fitting(value, vars(self.state)[name]))
        self.domain.recall(memory["domain"], self.state.t)

    def _stops_until(self, t: float) -> Iterator[State]:
        """Yield the state at every stop up to time ``t``."""
        begin, done = self._between or (self.state.t, 0)
        steps = math.ceil((t - begin) / self.step * (1.0 - 1e-12))
        if steps == 0 and self.blow_up is None:
            yield self.state
        while done < steps and self.blow_up is None:
            h = (t - begin) / steps
            chunk = min(steps - done, self._chunk)
            self._advance(h, chunk, t if done + chunk == steps else begin + (done + chunk) * h)
            done += chunk
            self._between = (begin, done) if done < steps else None
            if self.blow_up is None:
                yield self.state

    def _advance(self, h: float, steps: int, t: float) -> None:
        """Advance by ``steps`` steps ``h``, to time ``t``; after a blow-up, repeat them singly."""
        state, begin = self.state, self.state.t
        before = [values.copy() for values in (*state.arrays, self.ranges)] if steps > 1 else []
        f, v = state.arrays
        self.dynamics.advance(self.scheme, f, v, h, steps, begin)
        state.t = t
        blow_up = self._find_blow_up()
        if blow_up is None:
            self.steps += steps
            if t in self.domain.moves:
                self.blow_up = self.domain.follow(state)
            self.domain.fade(state)
            return
        self.blow_up = blow_up if steps == 1 else None
        if steps > 1:
            for values, saved in zip((*state.arrays, self.ranges), before, strict=True):
                values[:] = saved
            state.t = begin
            for step in range(1, steps + 1):
                if self.blow_up is None:
                    self._advance(h, 1, t if step == steps else begin + step * h)

    def _find_blow_up(self) -> BlowUp | None:
        """Extend ``ranges`` to the state; return a blow-up at any site, or None."""
        current = self.dynamics.ranges(self.state)
        self.ranges[:, 0] = np.fmin(self.ranges[:, 0], current[:, 0])
        self.ranges[:, 1] = np.fmax(self.ranges[:, 1], current[:, 1])
        blow_up = self.dynamics.find_blow_up(self.state, current, self._amplitude)
        return None if blow_up is None else self.domain.locate(blow_up, self.state)
