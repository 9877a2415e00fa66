"""Time-stepping schemes as tables, and how large a step they bear.

Drift-kick splittings of y'' = f(y) use that the kinetic energy is quadratic. They need satisfy the
Nystroem conditions only, which are fewer than a general composition's; their free weights are spent
on a small error. Long waves are nearly linear, so most of that error is a wrong speed: a higher
phase-lag order removes it. At a sup error of 1e-6 of Y2 the method of order 6 and phase-lag order 8
evaluates the force half as often as Blanes and Moan's of order 6, and a quarter as often as Kahan
and Li's of order 8 (`benchmarks/same_lattice.py`).

A table is checked for its shape and its consistency when it is declared, for the order that it
claims by `lattice.schemes.order.check_order`.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lattice.kernels import blocked, plain
from lattice.model import Model

Array = NDArray[np.float64]
Exact = tuple[Fraction, ...]


class NystroemTable(NamedTuple):
    """A step h of y'' = f(y), exactly: g_i = f(y + nodes_i h s + h^2 sum_j inner_ij g_j),
    then y += h s + h^2 sum outer_i g_i and s += h sum weights_i g_i."""

    nodes: Sequence[Fraction]
    inner: Sequence[Sequence[Fraction]]
    outer: Sequence[Fraction]
    weights: Sequence[Fraction]


class Scheme:
    """A time-stepping scheme: its table, and how a ring is advanced by it.

    ``name`` is the name by which a scene asks for it, ``order`` that of convergence in the step,
    ``reference`` says where the coefficients come from. Tables are values: equal ones have equal
    hashes.
    """

    name: str
    order: int
    reference: str

    @property
    def rounding(self) -> float:
        """The defect allowed to the conditions: what the digits that are given leave."""
        return 0.0

    @property
    def stages(self) -> int:
        """Force evaluations per step."""
        raise NotImplementedError

    def table(self) -> NystroemTable:
        """The scheme as an explicit Nystroem method."""
        raise NotImplementedError

    def advance(self, y: Array, s: Array, h: float, steps: int, model: Model) -> None:
        """Advance the ring (y, s) in place by ``steps`` steps of length ``h``."""
        raise NotImplementedError

    def oscillator(self, z: Array) -> Array:
        """One step of y'' = -y with the steps ``z``, as matrices of shape (len(z), 2, 2)."""
        raise NotImplementedError


class DriftKick(Scheme):
    """A step of drifts y += drift h s and kicks s += kick h f(y), in turn, one more drift."""

    @cached_property
    def exact(self) -> tuple[Exact, Exact]:
        """Drifts and kicks in units of the step, exactly."""
        raise NotImplementedError

    def __post_init__(self) -> None:
        for weights in self.exact:
            defect = float(abs(sum(weights) - 1))
            if defect > self.rounding:
                raise ValueError(
                    f"the weights of {self.name} must sum to 1 to {self.rounding:g}, got a defect "
                    f"of {defect:.1e} (check the digits)"
                )

    @cached_property
    def drifts(self) -> Array:
        """Drift lengths in units of the step."""
        return _floats(self.exact[0])

    @cached_property
    def kicks(self) -> Array:
        """Kick lengths in units of the step."""
        return _floats(self.exact[1])

    @property
    def stages(self) -> int:
        """Force evaluations per step."""
        return len(self.exact[1])

    def table(self) -> NystroemTable:
        """The scheme as an explicit Nystroem method."""
        drifts, kicks = self.exact
        nodes = list(accumulate(drifts))[:-1]
        inner = [
            [b * (c - d) for b, d in zip(kicks[:i], nodes, strict=False)]
            for i, c in enumerate(nodes)
        ]
        return NystroemTable(
            nodes, inner, [b * (1 - c) for b, c in zip(kicks, nodes, strict=True)], kicks
        )

    def advance(self, y: Array, s: Array, h: float, steps: int, model: Model) -> None:
        """Advance the ring (y, s) in place by ``steps`` steps of length ``h``."""
        advance = _fastest(y.size, self.stages)
        advance(y, s, self.drifts * h, self.kicks * h, steps, *model.kernel)

    def oscillator(self, z: Array) -> Array:
        """One step of y'' = -y with the steps ``z``, as matrices of shape (len(z), 2, 2)."""
        step = np.tile(np.eye(2), (len(z), 1, 1))
        for drift, kick in zip(self.drifts, [*self.kicks, 0.0], strict=True):
            step[:, 0] += drift * z[:, None] * step[:, 1]
            step[:, 1] -= kick * z[:, None] * step[:, 0]
        return step


def _fastest(size: int, stages: int) -> Callable[..., None]:
    """The fastest kernel that a ring's size admits."""
    if not blocked.fits(size, stages):
        return plain.advance_plain
    return blocked.advance_on_two_cores if blocked.pays(size) else blocked.advance_blocked


@dataclass(frozen=True)
class Composition(DriftKick):
    """A symmetric composition of Stoermer-Verlet steps with the weights ``gammas``.

    ``half`` holds the weights up to the middle one, as decimal literals of 26 digits. Raises
    ValueError if they do not sum to 1.
    """

    name: str
    order: int
    half: tuple[str, ...]
    reference: str
    rounding = 1e-24

    @property
    def gammas(self) -> tuple[str, ...]:
        """All weights, first to last."""
        return self.half + self.half[-2::-1]

    @cached_property
    def exact(self) -> tuple[Exact, Exact]:
        """Drifts, half of each kick on either side of it, and kicks, exactly."""
        kicks = tuple(map(Fraction, self.gammas))
        ends = [Fraction(0), *kicks, Fraction(0)]
        return tuple((a + b) / 2 for a, b in pairwise(ends)), kicks


@dataclass(frozen=True)
class Splitting(DriftKick):
    """A symmetric splitting; decimal literals or fractions up to the middle.

    ``drift_half`` holds the drifts up to the middle, ``kick_half`` the kicks. With one drift more
    than kicks the last drift is the middle of the step, with as many the last kick is.
    ``phase_order`` is the phase-lag order where it exceeds the order. Raises ValueError if the
    drifts or the kicks do not sum to 1.
    """

    name: str
    order: int
    drift_half: tuple[str, ...]
    kick_half: tuple[str, ...]
    reference: str
    phase_order: int = 0

    def __post_init__(self) -> None:
        if len(self.drift_half) - len(self.kick_half) not in (0, 1):
            raise ValueError(
                f"drift_half must have as many weights as kick_half or one more, got "
                f"{len(self.drift_half)} and {len(self.kick_half)} in {self.name} "
                "(give each up to the middle of the step)"
            )
        super().__post_init__()

    @property
    def rounding(self) -> float:
        """Defect allowed: a hundred units in the last place of the shortest decimal."""
        literals = self.drift_half + self.kick_half
        decimals = [len(literal.partition(".")[2]) for literal in literals if "." in literal]
        return 10.0 ** (2.0 - min(decimals)) if decimals else 0.0

    @cached_property
    def exact(self) -> tuple[Exact, Exact]:
        """Drifts and kicks, exactly."""
        middle_is_kick = len(self.kick_half) == len(self.drift_half)
        drifts = _mirrored(self.drift_half, not middle_is_kick)
        return drifts, _mirrored(self.kick_half, middle_is_kick)


def _mirrored(half: tuple[str, ...], once: bool) -> Exact:
    """``half`` and its reflection; the last entry stands ``once`` or twice."""
    return tuple(map(Fraction, half + half[::-1][once:]))


@dataclass(frozen=True)
class RungeKutta(Scheme):
    """An explicit Runge-Kutta table (A, b), run in its Nystroem form on y'' = D V'(y).

    The two forms are the same method: y' = s is linear, so its stages can be eliminated. Raises
    ValueError if A is not square and strictly lower triangular or b does not sum to 1.
    """

    name: str
    order: int
    A: tuple[tuple[Fraction, ...], ...]
    b: tuple[Fraction, ...]
    reference: str

    def __post_init__(self) -> None:
        if any(len(row) != len(self.b) for row in (*self.A, self.A)):
            raise ValueError(
                f"A must have {len(self.b)} rows and columns, as many as b, got another shape in "
                f"{self.name} (fill the table with zeros)"
            )
        if any(value for i, row in enumerate(self.A) for value in row[i:]):
            raise ValueError(
                f"A must be strictly lower triangular, got another in {self.name} "
                "(only explicit schemes can be run)"
            )
        if sum(self.b) != 1:
            raise ValueError(f"b must sum to 1, got {sum(self.b)} in {self.name} (check the table)")

    @property
    def stages(self) -> int:
        """Force evaluations per step."""
        return len(self.b)

    def table(self) -> NystroemTable:
        """Nodes A 1, inner weights A A, position weights b A and velocity weights b."""
        A, b = np.array(self.A, dtype=object), np.array(self.b, dtype=object)
        return NystroemTable(A.sum(axis=1).tolist(), (A @ A).tolist(), (b @ A).tolist(), self.b)

    @cached_property
    def _floats(self) -> tuple[Array, ...]:
        return tuple(map(_floats, self.table()))

    def advance(self, y: Array, s: Array, h: float, steps: int, model: Model) -> None:
        """Advance the ring (y, s) in place by ``steps`` steps of length ``h``."""
        plain.advance_nystroem(y, s, *self._floats, h, steps, *model.kernel)

    def oscillator(self, z: Array) -> Array:
        """One step of y'' = -y with the steps ``z``, as matrices of shape (len(z), 2, 2)."""
        generator = np.array([[0.0, 1.0], [-1.0, 0.0]])
        table, weights = _floats(self.A), _floats(self.b)
        step, power = np.tile(np.eye(2), (len(z), 1, 1)), np.eye(2)
        stage = np.ones(self.stages)
        for degree in range(1, self.stages + 1):
            power = power @ generator
            step += (weights @ stage) * z[:, None, None] ** degree * power
            stage = table @ stage
        return step


def _floats(values: Iterable[object]) -> Array:
    return np.asarray(values, dtype=object).astype(np.float64)


SCAN = np.linspace(0.0, 8.0, 80_001)[1:]
"""Steps at which stability is looked at first."""

JURY_SLACK = 1e-12
"""What rounding may add to an eigenvalue on the unit circle."""


def _stable(scheme: Scheme, z: Array) -> NDArray[np.bool_]:
    """Whether both eigenvalues of the step of y'' = -y stay in the unit disc (Jury's test)."""
    step = scheme.oscillator(z)
    trace = step[:, 0, 0] + step[:, 1, 1]
    determinant = step[:, 0, 0] * step[:, 1, 1] - step[:, 0, 1] * step[:, 1, 0]
    inside: NDArray[np.bool_] = (np.abs(trace) <= 1.0 + determinant + JURY_SLACK) & (
        determinant <= 1.0 + JURY_SLACK
    )
    return inside


@cache
def stability_limit(scheme: Scheme) -> float:
    """Largest z = omega h below which y'' = -omega^2 y stays bounded.

    Scanned in steps of 1e-4 up to 8, then refined by bisection.

    >>> from lattice.schemes.catalogue import scheme_named
    >>> round(stability_limit(scheme_named("stoermer_verlet")), 6)
    2.0
    >>> round(stability_limit(scheme_named("rk4")) ** 2, 6)
    8.0
    """
    unstable = np.flatnonzero(~_stable(scheme, SCAN))
    if unstable.size == 0:
        return float(SCAN[-1])
    high = float(SCAN[unstable[0]])
    low = high - float(SCAN[0])
    for _ in range(40):
        middle = 0.5 * (low + high)
        if _stable(scheme, np.array([middle]))[0]:
            low = middle
        else:
            high = middle
    return low


def check_step(step: float, scheme: Scheme, model: Model, strain: Array) -> float:
    """The largest stable step (time units) for waves about any of the given strains.

    Raises ValueError if ``step`` is past it.
    """
    limit = stability_limit(scheme) / model.highest_frequency(strain)
    if step > limit:
        raise ValueError(
            f"step must satisfy step <= {limit:.7g}, got {step:.9g} "
            f"(linear stability limit of {scheme.name} at the zone boundary k = pi; "
            "take a smaller step)"
        )
    return limit
