"""Bytecode: the machines compute what the statements say, in few registers."""

from typing import Any

import numpy as np
import pytest
import sympy as sp

from longwave.solutions.compile.assembler import Assembler
from longwave.solutions.run.bytecode import Bytecode, Operation, allocate
from longwave.solutions.run.doubledouble import split
from longwave.solutions.run.machine import run_pairs

x, y, c = sp.symbols("x y c", positive=True)
CONSTANT = sp.Rational(-7, 3)

EXPRESSIONS = (
    x + y,
    x - y,
    y - x,
    x * y - x,
    sp.exp(-x) - x,
    -x - y,
    x * y,
    2 - x,
    1 - x * y / 3,
    c * x,
    c**2,
    x - c,
    1 / x,
    x**-3,
    x**5,
    sp.sqrt(x),
    y / sp.sqrt(x),
    x ** sp.Rational(3, 2),
    sp.log(x),
    sp.exp(-x),
    sp.exp(x * y),
    sp.tanh(x - y),
    sp.sech(x - y),
    (x - 2 * y + c) ** 2 / (1 + x**2 * y**2) - sp.tanh(x) * y,
)


def assembled(expression: sp.Expr) -> Bytecode:
    assembler = Assembler([x, y])
    return assembler.assemble([assembler.value(expression)])


def points(rng: np.random.Generator) -> Any:
    """Return enough points for more than one block, the last one not full."""
    return np.exp(rng.normal(scale=1.5, size=(2, 300)))


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
@pytest.mark.parametrize("moved", [0.0, 1e-20, 1e-3])
def test_thirty_digits_and_honest_bounds(
    expression: sp.Expr, moved: float, ctx: Any, rng: np.random.Generator
) -> None:
    """Inputs are wrong by up to ``moved``: the bound covers it, and is not far above it."""
    code, high = assembled(expression), points(rng)
    inputs, out = np.stack([high, 1e-17 * high, 0 * high + moved], axis=1), np.empty((1, 3, 300))
    constants = np.array([split(entry.subs(c, CONSTANT)) for entry in code.pool]).reshape(-1, 2)
    run_pairs(code, constants, inputs, out)
    functions = {name: getattr(ctx, name) for name in ("sqrt", "log", "exp", "tanh", "sech", "mpf")}
    exact = sp.lambdify([x, y], expression.subs(c, CONSTANT), [functions, "mpmath"])
    for i in range(0, 300, 11):
        at = [ctx.mpf(h) + ctx.mpf(low) for h, low, _ in inputs[:, :, i]]
        found, bound = ctx.mpf(out[0, 0, i]) + out[0, 1, i], out[0, 2, i]
        scale = max(1, abs(exact(*at)), *(high[:, i] ** 2))
        assert abs(found - exact(*at)) < min(3e-30 * scale, bound + 1e-58)
        if moved == 0.0:
            assert bound < 1e-26 * scale
        if high[:, i].min() > 2e-3:
            for signs in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
                near = (v + sign * moved for v, sign in zip(at, signs, strict=True))
                assert abs(found - exact(*near)) <= bound * (1 + 1e-9) + 1e-58


def test_one_point_and_a_constant_output() -> None:
    code, out = assembled(c**2), np.empty((1, 3, 1))
    run_pairs(code, np.array([split("49/9")]), np.ones((2, 3, 1)), out)
    assert tuple(out[0, :2, 0]) == split("49/9")


def test_a_power_of_two_is_exact() -> None:
    code = assembled(x / 4 - y)
    assert Operation.SCALE in code.code[:, 0]
    assert Operation.MULTIPLY_CONSTANT not in code.code[:, 0]
    assert Operation.MULTIPLY_CONSTANT in assembled(3 * x).code[:, 0]


def test_nothing_is_known_where_a_divisor_may_be_zero() -> None:
    """Catches a bound that stays finite although 1/x may be anything."""
    out = np.empty((1, 3, 1))
    run_pairs(assembled(1 / x), np.empty((0, 2)), np.array([[[1e-3], [0], [2e-3]]] * 2), out)
    assert not out[0, 2, 0] < np.inf


def test_equal_operations_are_shared_and_dead_ones_dropped() -> None:
    assembler = Assembler([x, y])
    assembler.define(sp.Symbol("unused"), x**7 + y)
    z = sp.Symbol("z")
    assembler.define(z, x * y)
    code = assembler.assemble([assembler.value(z + 1), assembler.value(x * y - 1)])
    assert len(code.code) == 3


def test_constant_statements_fold_into_the_pool() -> None:
    assembler = Assembler([x])
    k = sp.Symbol("k")
    assembler.define(k, c * c + 1)
    assert assembler.assemble([assembler.value(k * x)]).pool == (c**2 + 1,)


def test_no_instruction_writes_what_it_reads() -> None:
    operands = [(0, 1), (2, 0), (3, 2), (4, 3), (5, 1)]
    live, place, count = allocate(2, operands, [6])
    assert live == [0, 1, 2, 3, 4]
    assert count < 7
    for index, used in enumerate(operands):
        assert place[2 + index] not in {place[value] for value in used}


def test_unknown_operations_are_refused() -> None:
    with pytest.raises(ValueError, match="with an instruction, got sin"):
        assembled(sp.sin(x))
    with pytest.raises(ValueError, match="multiples of 1/2, got 1/3"):
        assembled(sp.cbrt(x))
