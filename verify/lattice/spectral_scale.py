"""Where the search for step and sampling begins: the scales of the data."""

import math

import numpy as np

from solutions import Wave
from verify.lattice.constants import Constants
from verify.lattice.ring_state import RingState, backward, forward

PER_RADIAN = 2.0
"""First sampling: points per unit of the wave's own variable xi."""


def first_density(wave: Wave, eps: float) -> float:
    """Points per site to begin with."""
    return PER_RADIAN * float(wave.normal_form.a) * eps


FEWEST = 16
"""Steps of the first attempt, at least: differences between fewer say nothing about the order. Two
solitons were 1.9e-5 off with 4 steps and 1.6e-5 with 7."""


def first_step(speed: float, duration: float, k: float, turning: float) -> float:
    """The time in which the nonlinear part or dispersion turns a typical wave, or a run's share.

    ``turning`` is the `turning_time` of waves of number ``k``, the `typical_number`. In the
    long-wave limit both are fixed parts of the slow time T, so the number of steps does not depend
    on eps. Dispersion is the faster one for small waves on short ones.
    """
    longest = duration / FEWEST if duration > 0 else 1.0
    return min(longest, turning, 24.0 / (speed * k**3))


def turning_time(constants: Constants, state: RingState, k: float) -> float:
    """The time in which the nonlinear part turns the phase of a wave of number ``k`` by one.

    About a strain y it runs ahead of the mean by (V''(y) - mean)/(2 c) k.
    """
    stiffness = constants.stiffness(state.y)
    spread = float(np.max(np.abs(stiffness - np.mean(stiffness))))
    if spread == 0.0:
        return math.inf
    return 2.0 * constants.sound_speed() / (spread * k)


def typical_number(state: RingState) -> float:
    """The root mean square wave number of the strain's spectrum, its mean apart, or of its flank.

    The spectrum of a kink is that of its far fields, so the steepest slope counts as well, in units
    of the largest strain.
    """
    modes = forward(state.y)
    k = 2.0 * math.pi / state.circumference * np.arange(modes.size)
    power = np.abs(modes[1:]) ** 2
    total = float(np.sum(power))
    if total == 0.0:
        return float(k[1])
    modes[0] = 0.0
    strain, slope = (backward(part, state.y.size) for part in (modes, 1j * k * modes))
    flank = float(np.max(np.abs(slope)) / np.max(np.abs(strain)))
    return max(flank, math.sqrt(float(np.sum(power * k[1:] ** 2)) / total))
