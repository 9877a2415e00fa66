"""The stencil and its peers on the same lattice and data, interleaved in one run.

A ring of 4096 sites, 500 time units, the wave Y2 (K2 = 4, K4 = 1, eps = 0.05) started at t = -250;
the error is the sup over sites of |y - reference| / eps, the reference the 10th-order composition
of Sofroniou and Spaletta. Every contender runs at a step that brings it to about 1e-6. Seconds are
processor time of the calling thread, the least of several rounds; what is printed is ratios.
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import derive
from solutions import Wave, closed_form
from verify.lattice import stencil
from verify.lattice.constants import Constants
from verify.lattice.splitting import BLANES_MOAN_6
from verify.lattice.vector import LANES, OPERATIONS

Array = NDArray[np.float64]

SITES, DURATION, T0, EPS = 4096, 500.0, -250.0, 0.05
CONSTANTS = Constants(4.0, 0.0, 1.0)
ROUNDS = 5
STENCIL_STEPS, BOOST_STEPS = 840, 8400
SCIPY_TOLERANCE = 1e-8

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


def initial() -> tuple[Array, Array]:
    """Strain and velocity at t = T0."""
    wave = Wave(closed_form("rational_2"), derive.mkdv_normal_form(4, 1))
    c = CONSTANTS.sound_speed()
    sites = np.arange(SITES) - SITES // 2 + c * T0
    value = wave.at(sites, T0, EPS)
    return EPS * value.Y, EPS**4 * value.Y_T - c * EPS**2 * value.Y_X


def reference(y: Array, s: Array, steps: int = 2000) -> Array:
    """The strain at the end, to 1e-10 eps."""
    gammas = np.array(SOFRONIOU_SPALETTA + SOFRONIOU_SPALETTA[-2::-1])
    ends = np.concatenate([[0.0], gammas, [0.0]])
    h, y, s = DURATION / steps, y.copy(), s.copy()
    drifts = 0.5 * h * (ends[1:] + ends[:-1])
    stencil.advance_composition(y, s, drifts, h * gammas, steps, *CONSTANTS.kernel)
    return y


def run_stencil(y: Array, s: Array) -> Array:
    """The project's engine."""
    y, s = y.copy(), s.copy()
    BLANES_MOAN_6.advance(y, s, DURATION / STENCIL_STEPS, STENCIL_STEPS, CONSTANTS)
    return y


def _right_side(_t: float, state: Array) -> Array:
    y, s = state.reshape(2, -1)
    force = y * (CONSTANTS.K2 + CONSTANTS.K4 * y * y)
    return np.concatenate([s, np.roll(force, 1) - 2.0 * force + np.roll(force, -1)])


def run_scipy(y: Array, s: Array) -> Array:
    """SciPy's DOP853."""
    start = np.concatenate([y, s])
    tolerances = {"rtol": SCIPY_TOLERANCE, "atol": SCIPY_TOLERANCE * EPS}
    solution = solve_ivp(_right_side, (0.0, DURATION), start, method="DOP853", **tolerances)
    return np.asarray(solution.y[:SITES, -1])


def build_boost(folder: Path) -> Path | None:
    """The compiled C++ program, or None where Boost or a compiler is missing."""
    program = folder / "boost_ring"
    source = Path(__file__).with_name("boost_ring.cpp")
    command = ["g++", "-O3", "-march=native", "-o", str(program), str(source)]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return program


def run_boost(program: Path, y: Array, s: Array) -> tuple[float, Array]:
    """Boost odeint's RKN composition: processor seconds and the strain."""
    data, result = program.with_name("in.bin"), program.with_name("out.bin")
    np.concatenate([y, s]).tofile(data)
    h = str(DURATION / BOOST_STEPS)
    command = [str(program), str(SITES), h, str(BOOST_STEPS), str(data), str(result)]
    seconds = float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return seconds, np.fromfile(result)


@njit(fastmath={"contract"})
def _multiply_add(values: Array, rounds: int) -> None:
    for i in range(0, values.size, 48):
        block = values[i : i + 48].copy()
        for _ in range(rounds):
            for j in range(48):
                block[j] = block[j] * 0.5 + 0.5
        values[i : i + 48] = block


def timed(call: Callable[[], Array]) -> tuple[float, Array]:
    """Processor seconds of this thread, and the result."""
    begin = time.thread_time()
    result = call()
    return time.thread_time() - begin, result


def main() -> int:
    """Print the table."""
    y, s = initial()
    exact = reference(y, s)
    run_stencil(y, s)
    seconds: dict[str, float] = {}
    errors: dict[str, float] = {}

    def note(name: str, spent: float, result: Array) -> None:
        seconds[name] = min(spent, seconds.get(name, np.inf))
        errors[name] = float(np.abs(result - exact).max()) / EPS

    with tempfile.TemporaryDirectory() as folder:
        boost = build_boost(Path(folder))
        for round_ in range(ROUNDS):
            for _ in range(4):
                note("stencil", *timed(lambda: run_stencil(y, s)))
            if boost is not None:
                note("Boost odeint RKN", *run_boost(boost, y, s))
            if round_ < 2:
                note("SciPy DOP853", *timed(lambda: run_scipy(y, s)))
    for name, spent in seconds.items():
        ratio = spent / seconds["stencil"]
        print(f"{name:18s} {spent * 1e3:9.1f} ms  error {errors[name]:.1e}  ratio {ratio:6.1f}")
    evaluations = SITES * STENCIL_STEPS * BLANES_MOAN_6.stages
    rate = OPERATIONS[False, True] * evaluations / seconds["stencil"] / 1e9
    print(
        f"stencil: {OPERATIONS[False, True]} operations a site and stage, {rate:.1f} G/s "
        f"({LANES} lanes)"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
