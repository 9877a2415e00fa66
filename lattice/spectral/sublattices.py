"""What steps longer than a site's passage cannot tell apart: the lattices of one spectral ring.

A ring of real circumference holds one lattice for each x mod 1, and they do not feel each other.
A wave that is hardly longer than the distance of sites has, by the place of its crest between two
sites, a little more or less energy, which each of the lattices keeps for ever: its waves are a
little larger and faster. In the frame of the wave such a difference turns its phase once a site
(the wave numbers near 2 pi). Steps that do not resolve that average it, whatever their length, and
all waves run alike: a run with a shorter step does not show it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from lattice.model import Constants
from lattice.spectral.ring import RingState, backward, forward

Array = NDArray[np.float64]

DENSITY = 4.5
"""Points per site that hold the energy's waves of numbers near 2 pi: 2 for the strain, as many
again for the cubic part of the force, and some."""

REACH = 4.0
"""Sites over which the energy of a crest is summed: the waves that matter are no longer."""

TURNED = 1.0
"""Longest step, in units of the time in which a wave of number 2 pi turns by one radian, that shows
how the lattices differ."""

ALIKE = 0.2
"""Share of the tolerance that they may differ by, unshown. Over a time in which the nonlinear part
turns the phase of a typical wave by one, their strains part by 0.02 to 0.4 times the spread of
their energies, in units of the largest strain: measured on 30 scenes of all waves, a |y| from 0.3
to 0.63."""

SEAM = 6.0
"""Distance from the seam, in units of REACH, at which it is not felt."""


def telling_step(speed: float) -> float:
    """The longest step that shows how the lattices of a ring differ that moves at ``speed``."""
    return TURNED / (2.0 * math.pi * speed)


def energy_spread(constants: Constants, state: RingState, seam: float) -> float:
    """By how much the energies of a crest differ between the lattices of a ring, relatively.

    ``state`` needs ``DENSITY`` points a site; it is not the wave's within ``seam`` of its ends.

    >>> def spread(width):
    ...     x = 120.0 * (np.arange(600) / 600 - 0.5)
    ...     y = 1.0 / np.cosh(x / width)
    ...     state = RingState(0.0, -60.0, 120.0, y, y * np.tanh(x / width) / width)
    ...     return energy_spread(Constants(1.0, 0.0, 1.0), state, 1.0)
    >>> [f"{spread(width):.0e}" for width in (1.5, 2.0, 3.0)]
    ['2e-04', '3e-06', '7e-10']
    """
    count, length = state.y.size, state.circumference
    k = (2.0 * math.pi / length) * np.arange(count // 2 + 1, dtype=np.float64)
    strain = state.y - float(np.mean(state.y))
    modes = forward(_energy(constants, state, strain, k))
    near = np.zeros(count, dtype=np.complex128)
    near[: k.size] = 2.0 * modes * np.exp(-0.5 * (REACH * (k - 2.0 * math.pi)) ** 2)
    harmonic = np.abs(np.fft.ifft(near, norm="forward"))
    whole = forward(constants.K2 * strain**2) * np.exp(-0.5 * (REACH * k) ** 2)
    largest = float(np.max(backward(whole, count)))
    place = np.abs(np.arange(count) / count - 0.5) * length
    inside = place < 0.5 * length - seam - SEAM * REACH
    if not largest > 0.0 or not np.any(inside):
        return 0.0
    return float(np.max(harmonic[inside])) / largest


def _energy(constants: Constants, state: RingState, strain: Array, k: Array) -> Array:
    """The energy of each site beyond that of the mean strain, whose linear part is conserved."""
    mean = float(np.mean(state.y))
    lift = 2.0 * np.sin(0.5 * k)
    inverse = np.zeros_like(k)
    np.divide(1.0, lift, out=inverse, where=(k > 0.0) & (k < math.pi))
    beyond = k >= math.pi
    inverse[beyond] = lift[beyond] / (lift[beyond] ** 2 + REACH**-2)
    velocity = backward(-1j * inverse * forward(state.s), state.y.size)
    K3, K4 = constants.K3, constants.K4
    quadratic = 0.5 * (constants.K2 + 2.0 * K3 * mean + 3.0 * K4 * mean**2)
    potential = quadratic + strain * ((K3 + 3.0 * K4 * mean) / 3.0 + 0.25 * K4 * strain)
    return potential * strain**2 + 0.5 * velocity**2
