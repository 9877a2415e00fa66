"""Sine, cosine, exponential, logarithm, tanh and sech of the machine against 60 digits."""

from typing import Any

import numpy as np
import pytest
from mpmath import MPContext

from longwave.solutions.run.bytecode import Code, Operation, Value
from longwave.solutions.run.doubledouble import Array
from longwave.solutions.run.machine import run_pairs

ctx = MPContext()
ctx.dps = 60


def of(operation: Operation, numbers: Array, low: Array) -> Array:
    """Return the values with low parts and bounds."""
    code, out = Code(inputs=1), np.empty((1, 3, numbers.size))
    bytecode = code.assemble([Value(code, 0).apply(operation).number])
    run_pairs(bytecode, np.empty((0, 2)), np.stack([numbers, low, 0 * low])[None], out)
    return out[0]


def check(operation: Operation, numbers: Array, exact: Any, digits: float, rng: Any) -> None:
    low = numbers * rng.uniform(-1e-17, 1e-17, numbers.size)
    for high, rest, *found in zip(numbers, low, *of(operation, numbers, low), strict=True):
        expected = exact(ctx.mpf(high) + rest)
        error = abs(ctx.mpf(found[0]) + found[1] - expected)
        assert error <= digits * abs(expected)
        assert error <= found[2]


def test_sine_and_cosine(rng: np.random.Generator) -> None:
    numbers = np.concatenate([[0.0, 0.79, -0.79, 1e-200], rng.uniform(-0.79, 0.79, 300)])
    check(Operation.SINE, numbers, ctx.sin, 1e-31, rng)
    check(Operation.COSINE, numbers, ctx.cos, 1e-31, rng)


def test_tanh_keeps_its_digits_near_zero_and_near_one(rng: np.random.Generator) -> None:
    near, far = 10.0 ** rng.uniform(-200, 0, 150), rng.uniform(-300, 300, 150)
    numbers = np.concatenate([[0.0], near, far])
    check(Operation.TANH, numbers, ctx.tanh, 2e-31, rng)


def test_exponential_and_sech(rng: np.random.Generator) -> None:
    numbers = np.concatenate([10.0 ** rng.uniform(-200, 0, 150), rng.uniform(-600, 600, 150)])
    check(Operation.EXPONENTIAL, numbers, ctx.exp, 1e-28, rng)
    check(Operation.SECH, numbers, ctx.sech, 1e-28, rng)
    check(Operation.LOGARITHM, np.abs(numbers), ctx.log, 1e-28, rng)


@pytest.mark.parametrize("operation", [Operation.EXPONENTIAL, Operation.SECH])
def test_they_end_at_zero(operation: Operation) -> None:
    numbers = -np.geomspace(709, 1e300, 130)
    value, _, bound = of(operation, numbers, 0 * numbers)
    assert np.all(value == 0.0)
    assert np.all((bound > 0) & (bound < 1e-280))


def test_choose_takes_one_or_the_other() -> None:
    code, out = Code(inputs=3), np.empty((1, 3, 2))
    odd, one, other = (Value(code, place) for place in range(3))
    bytecode = code.assemble([one.apply(Operation.CHOOSE, other, odd).number])
    inputs = np.array([[[1.0, 0.0]] + [[0, 0]] * 2, [[2, 3], [4, 5], [6, 7]], [[np.nan, 9]] * 3])
    run_pairs(bytecode, np.empty((0, 2)), inputs, out)
    assert out[0].tolist() == [[2, 9], [4, 9], [6, 9]]
