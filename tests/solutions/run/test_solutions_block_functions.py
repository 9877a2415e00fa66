"""Sine, cosine and exponential of blocks of double-double numbers against mpmath."""

from typing import Any

import numpy as np
from mpmath import MPContext
from numpy.typing import NDArray

from solutions.run.block_functions import BLOCK, decay, sine_cosine

ctx = MPContext()
ctx.dps = 60
Array = NDArray[np.float64]


def relative(block: Array, i: int, value: Any) -> float:
    """Return the relative error of a block's i-th number, the absolute one of an exact 0."""
    error = abs(ctx.mpf(block[i]) + block[i + BLOCK] - value)
    return float(error / abs(value)) if value else float(error)


def blocks(numbers: Array, rng: np.random.Generator, others: int) -> tuple[Array, ...]:
    """Return the numbers with low parts as one block, and empty blocks."""
    low = numbers * rng.uniform(-1e-17, 1e-17, BLOCK)
    return np.concatenate([numbers, low]), *np.zeros((others, 2 * BLOCK))


def test_sine_and_cosine(rng: np.random.Generator) -> None:
    numbers = np.concatenate([[0.0, 0.79, -0.79, 1e-200], rng.uniform(-0.79, 0.79, BLOCK - 4)])
    v, scratch, sine, cosine = blocks(numbers, rng, 3)
    sine_cosine(v, scratch, sine, cosine)
    for i in range(BLOCK):
        exact = ctx.mpf(v[i]) + v[i + BLOCK]
        assert relative(sine, i, ctx.sin(exact)) < 1e-31
        assert relative(cosine, i, ctx.cos(exact)) < 1e-31


def test_decay(rng: np.random.Generator) -> None:
    """The complement 1 - exp(-w) must keep its digits for small w, and next to 1."""
    half = BLOCK // 2
    numbers = np.concatenate([10.0 ** rng.uniform(-200, 0, half), rng.uniform(0, 600, half)])
    w, scratch, power, fall, rise = blocks(numbers, rng, 4)
    decay(w, scratch, power, fall, rise)
    for i in range(BLOCK):
        exact = ctx.mpf(w[i]) + w[i + BLOCK]
        assert relative(fall, i, ctx.exp(-exact)) < 1e-29
        assert relative(rise, i, -ctx.expm1(-exact)) < 1e-31


def test_decay_ends_at_zero(rng: np.random.Generator) -> None:
    w, scratch, power, fall, rise = blocks(np.geomspace(708.5, 1e300, BLOCK), rng, 4)
    decay(w, scratch, power, fall, rise)
    assert np.all(fall == 0.0)
    assert np.all(rise[:BLOCK] == 1.0)
