"""Functions of vectors against mpmath and the C library.

Catches: a wrong factor of a polynomial, a rounding error that is left out where it counts, a range
that ends too early, special values, lanes that differ from one another, products of halves.
"""

import ctypes
import platform
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import mpmath
import numpy as np
import pytest
from llvmlite import binding, ir

from longwave.lattice.kernels import vector_functions
from longwave.lattice.kernels.row_code import LaneCode
from longwave.lattice.kernels.vector_functions import (
    FUNCTIONS_OF_LANES,
    LARGEST_EXPONENT,
    TURNED,
    Lanes,
    power,
)
from longwave.lattice.model import Array
from longwave.support.compiled import native_code
from longwave.support.compiled.subnormals import flushed_subnormals

ALLOWED = 2.0
"""Largest error, in units in the last place."""

POINTS = 20_000

EXPONENTS = (1.4, -1.4, 1.0 / 3.0, 0.1, -2.7, 6.3, 1e-3, 65.0, -66.0, 123.25)
"""Some that are whole or half, beyond those that products give."""

LARGEST = float(np.finfo(float).max)

_engines: list[Any] = []


def written(word: str, lanes: int, fused: bool, flushed: bool) -> str:
    """A function that puts ``count`` vectors through one of that name, or through a power."""
    module = ir.Module("tried")
    doubles, index = ir.DoubleType().as_pointer(), ir.IntType(64)
    kind = ir.FunctionType(ir.VoidType(), [doubles, doubles, index])
    made = ir.Function(module, kind, "tried")
    builder = ir.IRBuilder(made.append_basic_block())
    code = LaneCode(module, builder, lanes, fused)
    begin, to, count = made.args

    def body() -> None:
        with code.loop(index(0), count) as row:
            x = Lanes(code, code.load(begin, row))
            of = FUNCTIONS_OF_LANES.get(word)
            found = power(x, float(word)) if of is None else of(x)
            code.store(to, row, found.value)

    if flushed:
        with flushed_subnormals(module, builder):
            body()
    else:
        body()
    builder.ret_void()
    return str(module)


def machine(fused: bool, triple: str | None = None) -> Any:
    """The processor at hand, or the least of its kind."""
    native_code.processor()
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    here = triple or binding.get_process_triple()
    target = binding.Target.from_triple(here)
    if triple is None and (fused or platform.machine() not in ("x86_64", "AMD64")):
        features = binding.get_host_cpu_features().flatten()
        return target.create_target_machine(
            cpu=binding.get_host_cpu_name(), features=features, opt=3, jit=True
        )
    return target.create_target_machine(opt=3, jit=True)


def optimized(text: str, processor: Any) -> Any:
    """The module after the passes that the kernels go through."""
    parsed = binding.parse_assembly(text)
    parsed.triple, parsed.data_layout = processor.triple, str(processor.target_data)
    parsed.verify()
    options = binding.create_pipeline_tuning_options(speed_level=1)
    builder = binding.create_pass_builder(processor, options)
    passes = builder.getFunctionPassManager()
    for function in parsed.functions:
        if not function.is_declaration:
            passes.run(function, builder)
    return parsed


@lru_cache
def tried(
    word: str, lanes: int = 8, fused: bool = True, flushed: bool = False
) -> Callable[[Array], Array]:
    """The machine code of one function, for arrays."""
    native_code.processor()
    native_code._machine()
    processor = machine(fused)
    parsed = optimized(written(word, lanes, fused, flushed), processor)
    engine = binding.create_mcjit_compiler(parsed, processor)
    engine.finalize_object()
    _engines.append(engine)
    prototype = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)
    call = prototype(engine.get_function_address("tried"))

    def run(x: Array) -> Array:
        padded = np.pad(np.asarray(x, float), (0, -len(x) % lanes))
        found = np.empty_like(padded)
        call(padded.ctypes.data, found.ctypes.data, padded.size // lanes)
        return found[: len(x)]

    return run


def exact(word: str, x: Array) -> tuple[Array, Array]:
    """What mpmath gives, as a sum of two doubles."""
    with mpmath.workprec(140):
        if word in FUNCTIONS_OF_LANES:
            of = getattr(mpmath, word)
            if word == "tanh":  # mpmath takes exponentials of any size
                x = np.clip(x, -40.0, 40.0)
        else:
            exponent = mpmath.mpf(float(word))

            def of(value: Any) -> Any:
                return value**exponent

        found = [of(mpmath.mpf(value)) for value in x.tolist()]
        high = [max(-LARGEST, min(float(value), LARGEST)) for value in found]
        low = [float(v - h) for v, h in zip(found, high, strict=True)]
    return np.array(high), np.array(low)


def ulps(word: str, x: Array, found: Array) -> Array:
    """Errors in units in the last place of the exact values; 2^1024 is what infinity stands for."""
    high, low = exact(word, x)
    unit = np.spacing(np.minimum(np.abs(high), np.nextafter(LARGEST, 0.0)))
    over = np.isinf(found)
    with np.errstate(all="ignore"):
        ends = np.copysign(LARGEST, found)
        off = (np.where(over, ends, found) - high - low) / unit + over * np.sign(ends)
        return np.where(over & (low * np.sign(ends) >= unit), 0.0, np.abs(off))


def of_all_sizes(random: np.random.Generator, count: int) -> Array:
    """Positive doubles of all exponents, subnormal ones among them."""
    bits = random.integers(1, 0x7FF0 << 48, count)
    return bits.view(np.float64)


def close_to(places: Array, random: np.random.Generator) -> Array:
    """A few doubles on either side of each place."""
    steps = random.integers(-3, 4, places.size)
    return places + steps * np.spacing(places)


def arguments(word: str, random: np.random.Generator) -> Array:
    """Where a function is tried: all exponents, the ends of ranges, and where it is hard."""
    count = POINTS // 4
    sizes = of_all_sizes(random, count)
    signed = sizes * random.choice([-1.0, 1.0], count)
    if word in ("exp", "sinh", "cosh", "tanh"):
        turns = np.log(2.0) / 2.0 * random.integers(-2150, 2050, count)
        wide, near = random.uniform(-746.0, 710.0, 2 * count), random.uniform(-2.0, 2.0, count)
        small = random.choice([-1.0, 1.0], count) * 2.0 ** random.uniform(-60.0, 5.0, count)
        if word == "exp":
            return np.concatenate([signed, close_to(turns, random), wide, near, small])
        wide = np.clip(wide, -710.4, 710.4)
        turns = np.clip(turns, -710.4, 710.4)
        return np.concatenate([signed, close_to(turns, random), wide, near, small])
    if word in ("sin", "cos", "tan"):
        quarters = np.pi / 2.0 * random.integers(-5300, 5300, count)
        wide, near = random.uniform(-TURNED, TURNED, count), random.uniform(-4.0, 4.0, count)
        small = random.choice([-1.0, 1.0], count) * 2.0 ** random.uniform(-60.0, 13.1, count)
        return np.concatenate([signed, close_to(quarters, random), wide, near, small])
    near = np.concatenate(
        [1.0 + s * 2.0 ** random.uniform(-52.0, -1.0, count) for s in (-1.0, 1.0)]
    )
    roots = close_to(2.0 ** (random.integers(-1000, 1000, count) + 0.5), random)
    if word == "log":
        return np.concatenate([sizes, near, roots])
    ends = 1020.0 / abs(float(word))
    spread = 2.0 ** np.clip(random.uniform(-ends, ends, 2 * count), -1074.0, 1023.9)
    return np.concatenate([sizes, near, roots, spread])


WORDS = (*FUNCTIONS_OF_LANES, *map(str, EXPONENTS))


@pytest.mark.parametrize("word", WORDS)
def test_errors_are_below_two_units_in_the_last_place(word: str) -> None:
    x = arguments(word, np.random.default_rng(17))
    assert x.size >= POINTS
    worst = {}
    for fused in (True, False):
        off = ulps(word, x, tried(word, fused=fused)(x))
        worst[fused] = off.max(), x[off.argmax()]
    print(word, worst)
    assert all(size <= ALLOWED for size, _ in worst.values()), worst
