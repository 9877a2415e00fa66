"""The problems that all contenders solve, and their reference solutions."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longwave import derive
from longwave.derive import LATTICES
from longwave.lattice import SiteForce, State, driven_chain
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.kernels.streams import varied_stage_plan
from longwave.lattice.model import Model
from longwave.lattice.numeric_lattice import NumericLattice, numeric_lattice
from longwave.lattice.schemes import Composition
from longwave.scenes.description.time_functions import time_function
from longwave.solutions import Wave, closed_form

Array = NDArray[np.float64]

SITES, DURATION, T0, EPS = 4096, 500.0, -250.0, 0.05
CONSTANTS = Model(4.0, 0.0, 1.0)


class Tenth(Composition):
    """A composition whose digits are good for doubles."""

    rounding = 1e-17


SOFRONIOU_SPALETTA = Tenth(
    "sofroniou_spaletta_10",
    10,
    (
        "0.078795722521686419263907679337684", "0.31309610341510852776481247192647",
        "0.027918383235078066109520273275299", "-0.22959284159390709415121339679655",
        "0.13096206107716486317465685927961", "-0.26973340565451071434460973222411",
        "0.074973343155891435666137105641410", "0.11199342399981020488957508073640",
        "0.36613344954622675319314812353150", "-0.39910563013603589787862981058340",
        "0.10308739852747107731580277001372", "0.41143087395589023782070411897608",
        "-0.0048663605831352617621956593099771", "-0.39203335370863990644808193642610",
        "0.051942502962449647037182904015976", "0.050665090759924496335874344156866",
        "0.049674370639729879054568800279461", "0.049317735759594537917680008339338",
    ),
    "Sofroniou, Spaletta 2005, 35 stages",
)  # fmt: skip


@dataclass(frozen=True)
class Problem:
    """A lattice, what it starts from, and its equations as a user of a library writes them.

    ``start`` are positions and velocities, of shape (fields, *cells). ``acceleration`` is given
    NumPy or what stands for it, positions, velocities and the time. Errors are of the stretches,
    in units of ``unit``. ``target`` is the error to be reached, ``references`` are the steps
    that a reference takes.
    """

    lattice: NumericLattice
    start: Callable[[], tuple[Array, Array]]
    acceleration: Callable[[Any, Any, Any, Any], Any]
    duration: float = DURATION
    unit: float = EPS
    target: float = 1e-6
    references: int = 2000

    def advanced(self, scheme: Any, count: int, f: Array, v: Array) -> None:
        """Advance positions and velocities in place to the end."""
        ring, cells = self.lattice.with_walls(State(0.0, f, v)), f.shape[1]
        Dynamics(self.lattice).advance(scheme, ring.f, ring.v, self.duration / count, count)
        f[:], v[:] = ring.f[:, :cells], ring.v[:, :cells]

    def stretches(self, f: Array) -> Array:
        """Return the stretches, whose errors are measured."""
        return np.array(self.lattice.stretches(self.lattice.with_walls(State(0.0, f, f)).f))

    def error(self, f: Array, exact: Array) -> float:
        """Return the sup over cells of the stretches' difference, in the unit."""
        return float(np.abs(self.stretches(f) - self.stretches(exact)).max()) / self.unit

    def reference(self, f: Array, v: Array) -> Array:
        """Return positions at the end, to 1e-9 units; to 1e-5 where contacts open."""
        f, v = f.copy(), v.copy()
        self.advanced(SOFRONIOU_SPALETTA, self.references, f, v)
        return f

    @property
    def operations(self) -> int:
        """Arithmetic instructions of the kernel a cell and stage."""
        ordered, variation, _ = self.lattice.cellwise
        return varied_stage_plan(ordered, variation).flow.operations


def initial(eps: float = EPS, t0: float = T0, sites: int = SITES) -> tuple[Array, Array]:
    """Return the strain and velocity of Y2 at ``t0`` on a ring centred on c t0."""
    wave = Wave(closed_form("rational_2"), derive.mkdv_normal_form(4, 1))
    c = CONSTANTS.sound_speed()
    value = wave.at(np.arange(sites) - sites // 2 + c * t0, t0, eps)
    return eps * value.Y, eps**4 * value.Y_T - c * eps**2 * value.Y_X


WIDTH = 10.0
"""Cells over which the data of the other problems change."""


def hump(*cells: int, places: tuple[float, ...] = (0.0,)) -> tuple[Array, Array]:
    """Return a hump at rest, which splits in two; of fields at these ``places`` in the cell."""
    f = []
    for place in places:
        axes = [(np.arange(count) - count // 2 + place) / WIDTH for count in cells]
        f.append(np.exp(-sum(axis**2 for axis in np.meshgrid(*axes, indexing="ij"))))
    return np.array(f), np.zeros((len(places), *cells))


def strained_wave() -> tuple[Array, Array]:
    """Return the state of `initial` as fields."""
    y, s = initial()
    return y[np.newaxis], s[np.newaxis]


def strained_hump() -> tuple[Array, Array]:
    """Return a strain of that shape and size."""
    f, v = hump(SITES)
    return EPS * f, v


def spring(x: Any, K2: float, K4: float) -> Any:
    """Return the force K2 x + K4 x^3."""
    return x * (K2 + K4 * x * x)


def fput(xp: Any, y: Any, *_: Any) -> Any:
    """Return the FPUT lattice in its strain."""
    force = spring(y, 4.0, 1.0)
    return xp.roll(force, 1) - 2.0 * force + xp.roll(force, -1)


def next_nearest(xp: Any, f: Any, *_: Any) -> Any:
    """Return the FPUT lattice with springs between next-nearest neighbours."""
    y = f[0]
    far = spring(y + xp.roll(y, -1), 1.0, 0.5)
    bend = xp.roll(far, -1) - far - xp.roll(far, 1) + xp.roll(far, 2)
    return xp.stack([fput(xp, y) + bend])


def dimer(xp: Any, f: Any, *_: Any) -> Any:
    """Return a dimer: masses 1 and 2, and two kinds of springs."""
    u, v = f[0], f[1]
    near, far = spring(v - u, 4.0, 1.0), spring(xp.roll(u, -1) - v, 6.0, 0.5)
    return xp.stack([near - xp.roll(far, 1), 0.5 * (far - near)])


SOFT = 0.6
"""Share of the dimer's softer spring in a cell's stretch: with it a long wave has no optical part.
"""


def square(xp: Any, f: Any, *_: Any) -> Any:
    """Return a plane: one displacement a site, springs along both axes."""
    u = f[0]
    along = spring(xp.roll(u, -1, 0) - u, 4.0, 1.0)
    across = spring(xp.roll(u, -1, 1) - u, 3.0, 0.5)
    return xp.stack([along - xp.roll(along, 1, 0) + across - xp.roll(across, 1, 1)])


LOSS, PUSHED = 0.01, (np.arange(SITES) == SITES // 2).astype(float)


def driven(xp: Any, f: Any, v: Any, t: Any) -> Any:
    """Return a chain of displacements between walls, with losses, pushed at one cell."""
    force = spring(xp.diff(f[0], prepend=0.0, append=0.0), 4.0, 1.0)
    return xp.stack([xp.diff(force) - LOSS * v[0] + PUSHED * 0.3 * xp.cos(0.9 * t)])


def hertz(xp: Any, f: Any, *_: Any) -> Any:
    """Return grains that touch and do not press, the first one free, a wall behind the last."""
    contact = xp.maximum(-xp.diff(f[0], prepend=f[0, :1], append=0.0), 0.0)
    return xp.stack([-xp.diff(contact * xp.sqrt(contact))])


def toda(xp: Any, f: Any, *_: Any) -> Any:
    """Return the Toda lattice in its displacement."""
    force = xp.exp(xp.roll(f, -1, 1) - f)
    return force - xp.roll(force, 1, 1)


def struck() -> tuple[Array, Array]:
    """Return a start in which the first grain moves."""
    f, v = np.zeros((2, 1, SITES))
    v[0, 0] = 1.0
    return f, v


def _numbers(name: str, **constants: float) -> NumericLattice:
    return numeric_lattice(LATTICES[name], constants)


PROBLEMS = {
    "fput_strain": Problem(CONSTANTS.lattice, strained_wave, fput),
    "next_nearest": Problem(
        _numbers("next_nearest", K2=4, K3=0, K4=1, L2=1, L3=0, L4=0.5), strained_hump, next_nearest
    ),
    "dimer": Problem(
        _numbers("dimer", m1=1, m2=2, K2=4, K3=0, K4=1, H2=6, H3=0, H4=0.5),
        lambda: hump(SITES // 2, places=(0.0, SOFT)),
        dimer,
        unit=1.0 / WIDTH,
    ),
    "square": Problem(
        _numbers("square", K2=4, K3=0, K4=1, H2=3, H3=0, H4=0.5),
        lambda: hump(64, 64),
        square,
        duration=100.0,
        unit=1.0 / WIDTH,
    ),
    "driven": Problem(
        driven_chain(
            _numbers("beta_fput", K2=4, K4=1),
            SITES,
            left="fixed",
            right="fixed",
            losses=LOSS,
            forces=[SiteForce(SITES // 2, time_function("push", "3*cos(9*t/10)/10"))],
        ),
        lambda: hump(SITES),
        driven,
        unit=1.0 / WIDTH,
    ),
    "toda": Problem(_numbers("toda", a=1, b=1), lambda: hump(SITES), toda, unit=1.0 / WIDTH),
    "hertz": Problem(
        driven_chain(_numbers("granular", A=1, d=0), SITES, left="free", right="fixed"),
        struck,
        hertz,
        unit=1.0,
        target=1e-4,
        references=40_000,
    ),
}
"""All have 4096 fields."""
