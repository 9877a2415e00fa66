"""Stepping a state through the times at which it is wanted."""

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from verify.lattice.blow_up import BlowUp, find_blow_up
from verify.lattice.constants import Constants
from verify.lattice.domain import Domain
from verify.lattice.scheme import Scheme
from verify.lattice.state import State

CHUNK = 64
"""Most steps between two looks at the state; a chunk that blew up is repeated step by step."""


class March:
    """Advances ``state`` in place, following the domain and watching for a blow-up.

    Between two wanted times the steps are equal and not longer than ``step``, so that the wanted
    times are hit exactly. ``blow_up`` is set when the march had to stop; ``steps`` counts.
    """

    def __init__(
        self, state: State, scheme: Scheme, constants: Constants, domain: Domain, step: float
    ) -> None:
        self.state = state
        self.scheme = scheme
        self.constants = constants
        self.domain = domain
        self.step = step
        self.steps = 0
        self._amplitude = float(np.max(np.abs(state.y)))
        self.blow_up: BlowUp | None = find_blow_up(constants, state, self._amplitude)

    def through(self, times: Sequence[float], progress: Callable[[float], None]) -> Iterator[State]:
        """Yield the state at each of the increasing ``times``; stop early at a blow-up.

        ``progress`` is called with the time reached, a few times between two of the ``times``.
        """
        for t in times:
            self._advance_to(t, progress)
            if self.blow_up is not None:
                return
            yield self.state

    def _advance_to(self, t: float, progress: Callable[[float], None]) -> None:
        begin, done = self.state.t, 0
        steps = math.ceil((t - begin) / self.step * (1.0 - 1e-12))
        while done < steps and self.blow_up is None:
            h = (t - begin) / steps
            chunk = min(steps - done, CHUNK, max(1, int(min(self.domain.stay / h, CHUNK))))
            self._advance(h, chunk, t if done + chunk == steps else begin + (done + chunk) * h)
            done += chunk
            progress(self.state.t)

    def _advance(self, h: float, steps: int, t: float) -> None:
        """Advance by a chunk that ends at ``t``; if it blows up, repeat it step by step."""
        state, begin = self.state, self.state.t
        before = state.y.copy(), state.s.copy()
        self.scheme.advance(state.y, state.s, h, steps, self.constants)
        state.t = t
        self.blow_up = find_blow_up(self.constants, state, self._amplitude)
        if self.blow_up is None:
            self.steps += steps
            self.domain.follow(state)
        elif steps > 1:
            state.y[:], state.s[:] = before
            state.t, self.blow_up = begin, None
            for step in range(1, steps + 1):
                if self.blow_up is None:
                    self._advance(h, 1, t if step == steps else begin + step * h)
