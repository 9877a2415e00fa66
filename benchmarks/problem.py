"""The problem that all contenders solve, and its reference solution."""

import numpy as np
from numpy.typing import NDArray

import derive
from lattice.kernels import blocked
from lattice.model import Model
from solutions import Wave, closed_form

Array = NDArray[np.float64]

SITES, DURATION, T0, EPS = 4096, 500.0, -250.0, 0.05
CONSTANTS = Model(4.0, 0.0, 1.0)

SOFRONIOU_SPALETTA = (
    0.078795722521686419263907679337684, 0.31309610341510852776481247192647,
    0.027918383235078066109520273275299, -0.22959284159390709415121339679655,
    0.13096206107716486317465685927961, -0.26973340565451071434460973222411,
    0.074973343155891435666137105641410, 0.11199342399981020488957508073640,
    0.36613344954622675119314812353150, -0.39910563013603589787862981058340,
    0.10308739852747107731580277001372, 0.41143087395589023782070411897608,
    -0.0048663605831352617621956593099771, -0.39203335370863990644808193642610,
    0.051942502962449647037182904015976, 0.050665090759924496335874344156866,
    0.049674370639729879054568800279461, 0.049317735759594537917680008339338,
)  # fmt: skip
"""The first half of a 10th-order composition of 35 stages (Sofroniou, Spaletta 2005)."""


def initial(eps: float = EPS, t0: float = T0, sites: int = SITES) -> tuple[Array, Array]:
    """Strain and velocity of Y2 at ``t0`` on a ring centred on c t0."""
    wave = Wave(closed_form("rational_2"), derive.mkdv_normal_form(4, 1))
    c = CONSTANTS.sound_speed()
    value = wave.at(np.arange(sites) - sites // 2 + c * t0, t0, eps)
    return eps * value.Y, eps**4 * value.Y_T - c * eps**2 * value.Y_X


def reference(y: Array, s: Array, steps: int = 2000) -> Array:
    """The strain at the end, to 1e-10 eps."""
    gammas = np.array(SOFRONIOU_SPALETTA + SOFRONIOU_SPALETTA[-2::-1])
    ends = np.concatenate([[0.0], gammas, [0.0]])
    h, y, s = DURATION / steps, y.copy(), s.copy()
    drifts = 0.5 * h * (ends[1:] + ends[:-1])
    blocked.advance_blocked(y, s, drifts, h * gammas, steps, *CONSTANTS.kernel)
    return y


def error(y: Array, exact: Array) -> float:
    """Sup over the sites of |y - exact| / eps."""
    return float(np.abs(y - exact).max()) / EPS
