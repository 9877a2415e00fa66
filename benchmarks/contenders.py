"""The contenders: each maps a resolution and initial data to processor seconds and positions.

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
from problem import Array, Problem
from scipy.integrate import solve_ivp

from longwave.lattice.schemes import Scheme

Contender = Callable[[float, Array, Array], tuple[float, Array]]


def stencil_contender(problem: Problem, scheme: Scheme) -> Contender:
    """Return the contender that is this project's engine with one of its schemes."""

    def run(steps: float, f: Array, v: Array) -> tuple[float, Array]:
        f, v, count = f.copy(), v.copy(), round(steps)
        begin = time.process_time()
        problem.advanced(scheme, count, f, v)
        return time.process_time() - begin, f

    return run


def _rate(problem: Problem, t: float, state: Array, shape: tuple[int, ...]) -> Array:
    f, v = state.reshape(2, *shape)
    return np.concatenate([v.ravel(), problem.acceleration(np, f, v, t).ravel()])


def numpy_rk4(problem: Problem, h: float, count: int, f: Array, v: Array) -> tuple[float, Array]:
    """Return processor seconds of ``count`` classical steps in NumPy, and the positions."""
    shape, state = f.shape, np.concatenate([f.ravel(), v.ravel()])
    begin = time.process_time()
    for t in h * np.arange(count):
        k1 = _rate(problem, t, state, shape)
        k2 = _rate(problem, t + 0.5 * h, state + 0.5 * h * k1, shape)
        k3 = _rate(problem, t + 0.5 * h, state + 0.5 * h * k2, shape)
        k4 = _rate(problem, t + h, state + h * k3, shape)
        state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return time.process_time() - begin, state[: f.size].reshape(shape)


def rk4_contender(problem: Problem) -> Contender:
    """Return the contender that is the classical scheme in NumPy."""
    return lambda steps, f, v: numpy_rk4(
        problem, problem.duration / round(steps), round(steps), f, v
    )


def scipy_contender(problem: Problem) -> Contender:
    """Return the contender that is SciPy's DOP853."""

    def run(sharpness: float, f: Array, v: Array) -> tuple[float, Array]:
        start = np.concatenate([f.ravel(), v.ravel()])
        begin = time.process_time()
        solution = solve_ivp(
            lambda t, state: _rate(problem, t, state, f.shape),
            (0.0, problem.duration),
            start,
            method="DOP853",
            rtol=1.0 / sharpness,
            atol=problem.unit / sharpness,
        )
        return time.process_time() - begin, solution.y[: f.size, -1].reshape(f.shape)

    return run


def boost_contender(problem: Problem, name: str, folder: Path) -> Contender:
    """Return the contender that is Boost odeint, compiled into ``folder``.

    Its RKN composition (McLachlan, order 4), or its Runge-Kutta-Fehlberg 7(8) where forces depend
    on velocities or times.
    """
    program = folder / "boost_lattices"
    source = Path(__file__).with_name("boost_lattices.cpp")
    command = ["g++", "-O3", "-march=native", "-o", str(program), str(source)]
    done = subprocess.run(command, capture_output=True, check=False)
    if done.returncode:
        raise OSError("boost_lattices.cpp does not compile (apt install libboost-dev)")

    def run(steps: float, f: Array, v: Array) -> tuple[float, Array]:
        data, result, count = folder / "in.bin", folder / "out.bin", round(steps)
        np.concatenate([f.ravel(), v.ravel()]).tofile(data)
        numbers = str(f.size), repr(problem.duration / count), str(count)
        call = [str(program), name, *numbers, str(data), str(result)]
        seconds = subprocess.run(call, check=True, capture_output=True, text=True).stdout
        return float(seconds), np.fromfile(result).reshape(f.shape)

    return run


def diffrax_contender(problem: Problem) -> Contender:
    """Return the contender that is Diffrax' Dopri8 under XLA, on one thread."""
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)
    jnp = jax.numpy

    def rate(t: jax.Array, state: tuple[jax.Array, jax.Array], _: object) -> tuple[jax.Array, ...]:
        f, v = state
        return v, problem.acceleration(jnp, f, v, t)

    @jax.jit
    def solve(tolerance: float, f: jax.Array, v: jax.Array) -> jax.Array:
        control = diffrax.PIDController(rtol=tolerance, atol=tolerance * problem.unit)
        term, method = diffrax.ODETerm(rate), diffrax.Dopri8()
        options = {"stepsize_controller": control, "max_steps": 100_000}
        solution = diffrax.diffeqsolve(term, method, 0.0, problem.duration, 0.1, (f, v), **options)
        return solution.ys[0][-1]

    solve(1e-3, *map(np.zeros_like, problem.start())).block_until_ready()

    def run(sharpness: float, f: Array, v: Array) -> tuple[float, Array]:
        begin = time.process_time()
        result = np.asarray(solve(1.0 / sharpness, f, v))
        return time.process_time() - begin, result

    return run


def heyoka_contender(problem: Problem) -> Contender:
    """Return heyoka.py's adaptive Taylor method; it is compiled once for each tolerance."""
    import heyoka  # type: ignore[import-untyped]

    shape = problem.start()[0].shape
    places = range(int(np.prod(shape)))
    f, v = (np.array([heyoka.expression(f"{name}{i}") for i in places]) for name in "fv")
    try:
        positions, velocities = f.reshape(shape), v.reshape(shape)
        pulls = np.asarray(problem.acceleration(np, positions, velocities, heyoka.time)).ravel()
    except TypeError as reason:
        raise ImportError(f"no NumPy function of its expressions ({reason})") from reason
    system = [*zip(f, v, strict=True), *zip(v, pulls, strict=True)]
    integrators: dict[float, heyoka.taylor_adaptive] = {}

    def run(sharpness: float, f: Array, v: Array) -> tuple[float, Array]:
        start = np.concatenate([f.ravel(), v.ravel()])
        if sharpness not in integrators:
            options = {"tol": 1.0 / sharpness, "compact_mode": True}
            integrators[sharpness] = heyoka.taylor_adaptive(system, list(start), **options)
        program = integrators[sharpness]
        program.time, program.state[:] = 0.0, start
        begin = time.process_time()
        program.propagate_until(problem.duration)
        return time.process_time() - begin, program.state[: f.size].reshape(f.shape).copy()

    return run
