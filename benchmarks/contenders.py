"""The contenders: each maps a resolution and the initial data to processor seconds and the strain.

A resolution is a number of steps, or the reciprocal of a tolerance: more of it, smaller error.
Optional peers raise ImportError or OSError where they are absent. Seconds are processor time of the
process, all its threads together; what a method does before its first step is not counted.
"""

import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from problem import CONSTANTS, DURATION, EPS, SITES, Array
from scipy.integrate import solve_ivp

from lattice.schemes import Scheme
from lattice.stepper import advance

Contender = Callable[[float, Array, Array], tuple[float, Array]]


def stencil_contender(scheme: Scheme) -> Contender:
    """The project's engine with one of its schemes."""

    def run(steps: float, y: Array, s: Array) -> tuple[float, Array]:
        y, s, count = y.copy(), s.copy(), round(steps)
        begin = time.process_time()
        advance(scheme, y, s, DURATION / count, count, CONSTANTS)
        return time.process_time() - begin, y

    return run


def _rate(state: Array) -> Array:
    y, s = state.reshape(2, -1)
    force = y * (CONSTANTS.K2 + CONSTANTS.K4 * y * y)
    return np.concatenate([s, np.roll(force, 1) - 2.0 * force + np.roll(force, -1)])


def numpy_rk4(h: float, count: int, y: Array, s: Array) -> tuple[float, Array]:
    """Processor seconds of ``count`` steps of the classical scheme in NumPy, and the strain."""
    state = np.concatenate([y, s])
    begin = time.process_time()
    for _ in range(count):
        k1 = _rate(state)
        k2 = _rate(state + 0.5 * h * k1)
        k3 = _rate(state + 0.5 * h * k2)
        k4 = _rate(state + h * k3)
        state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return time.process_time() - begin, state[: y.size]


def run_numpy_rk4(steps: float, y: Array, s: Array) -> tuple[float, Array]:
    """The classical scheme in NumPy."""
    return numpy_rk4(DURATION / round(steps), round(steps), y, s)


def run_scipy(sharpness: float, y: Array, s: Array) -> tuple[float, Array]:
    """SciPy's DOP853."""
    start = np.concatenate([y, s])
    begin = time.process_time()
    solution = solve_ivp(
        lambda _, state: _rate(state),
        (0.0, DURATION),
        start,
        method="DOP853",
        rtol=1.0 / sharpness,
        atol=EPS / sharpness,
    )
    return time.process_time() - begin, np.asarray(solution.y[:SITES, -1])


def boost_contender(folder: Path) -> Contender:
    """Boost odeint's RKN composition (McLachlan, order 4), compiled into ``folder``."""
    program = folder / "boost_ring"
    source = Path(__file__).with_name("boost_ring.cpp")
    command = ["g++", "-O3", "-march=native", "-o", str(program), str(source)]
    done = subprocess.run(command, capture_output=True, check=False)
    if done.returncode:
        raise OSError("boost_ring.cpp does not compile (apt install libboost-dev)")

    def run(steps: float, y: Array, s: Array) -> tuple[float, Array]:
        data, result, count = folder / "in.bin", folder / "out.bin", round(steps)
        np.concatenate([y, s]).tofile(data)
        call = [
            str(program),
            str(SITES),
            repr(DURATION / count),
            str(count),
            str(data),
            str(result),
        ]
        seconds = subprocess.run(call, check=True, capture_output=True, text=True).stdout
        return float(seconds), np.fromfile(result)

    return run


def diffrax_contender() -> Contender:
    """Diffrax' Dopri8 under XLA, on one thread."""
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)
    jnp = jax.numpy

    def rate(_t: object, state: tuple[jax.Array, jax.Array], _: object) -> tuple[jax.Array, ...]:
        y, s = state
        force = y * (CONSTANTS.K2 + CONSTANTS.K4 * y * y)
        return s, jnp.roll(force, 1) - 2.0 * force + jnp.roll(force, -1)

    @jax.jit
    def solve(tolerance: float, y: jax.Array, s: jax.Array) -> jax.Array:
        control = diffrax.PIDController(rtol=tolerance, atol=tolerance * EPS)
        term, method = diffrax.ODETerm(rate), diffrax.Dopri8()
        options = {"stepsize_controller": control, "max_steps": 100_000}
        solution = diffrax.diffeqsolve(term, method, 0.0, DURATION, 0.1, (y, s), **options)
        return solution.ys[0][-1]

    solve(1e-3, np.zeros(SITES), np.zeros(SITES)).block_until_ready()

    def run(sharpness: float, y: Array, s: Array) -> tuple[float, Array]:
        begin = time.process_time()
        result = np.asarray(solve(1.0 / sharpness, y, s))
        return time.process_time() - begin, result

    return run


def heyoka_contender() -> Contender:
    """heyoka.py's adaptive Taylor method; its program is made once for each tolerance."""
    import heyoka  # type: ignore[import-untyped]

    y, s = ([heyoka.expression(f"{name}{i}") for i in range(SITES)] for name in "ys")
    force = [strain * (CONSTANTS.K2 + CONSTANTS.K4 * strain * strain) for strain in y]
    bends = [force[i - 1] - 2.0 * force[i] + force[(i + 1) % SITES] for i in range(SITES)]
    system = [*zip(y, s, strict=True), *zip(s, bends, strict=True)]
    made: dict[float, heyoka.taylor_adaptive] = {}

    def run(sharpness: float, y: Array, s: Array) -> tuple[float, Array]:
        start = np.concatenate([y, s])
        if sharpness not in made:
            options = {"tol": 1.0 / sharpness, "compact_mode": True}
            made[sharpness] = heyoka.taylor_adaptive(system, list(start), **options)
        program = made[sharpness]
        program.time, program.state[:] = 0.0, start
        begin = time.process_time()
        program.propagate_until(DURATION)
        return time.process_time() - begin, program.state[:SITES].copy()

    return run
