"""Vector functions of generated code against mpmath and the C library.

Catches: a wrong polynomial coefficient, a rounding error that is left out where it counts, a range
that ends too early, wrong special values, lanes that differ, wrong products of halves.
"""

import ctypes
import platform
import re
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import mpmath
import numpy as np
import pytest
from llvmlite import binding, ir

from longwave.lattice.force_program import UNARY, ForceProgram
from longwave.lattice.kernels import vector_functions
from longwave.lattice.kernels.lane_code import LaneCode
from longwave.lattice.kernels.row_code import passage_text
from longwave.lattice.kernels.streams import stage_plan
from longwave.lattice.kernels.vector_functions import (
    FUNCTIONS_OF_LANES,
    LARGEST_ANGLE,
    LARGEST_EXPONENT,
    SERIES,
    Lanes,
    fitted,
    power,
)
from longwave.lattice.numeric_lattice import Array, Entry, NumericBond, NumericLattice
from longwave.support.compiled import native_code
from longwave.support.compiled.subnormals import flushed_subnormals

ALLOWED = 2.0
"""Largest error allowed, in units in the last place."""

POINTS = 20_000

EXPONENTS = (1.4, -1.4, 1.0 / 3.0, 1e-3, -2.7, 65.0, -66.0, 123.25, 2000.5)
"""Exponents, some whole or half, beyond those computed by products."""

LARGEST, TINY = float(np.finfo(float).max), float(np.finfo(float).tiny)

_engines: list[Any] = []


def module_of(word: str, lanes: int, fused: bool, flushed: bool) -> str:
    """Return a module that applies a function, or a power, to ``count`` vectors."""
    module = ir.Module("compiled_function")
    doubles, index = ir.DoubleType().as_pointer(), ir.IntType(64)
    kind = ir.FunctionType(ir.VoidType(), [doubles, doubles, index])
    made = ir.Function(module, kind, "compiled_function")
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
    """Return this processor's target machine, or that of the least processor of its kind."""
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
    """Return the module after the passes that the kernels go through."""
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
def compiled_function(
    word: str, lanes: int = 8, fused: bool = True, flushed: bool = False
) -> Callable[[Array], Array]:
    """Return the compiled function for arrays."""
    native_code.processor()
    native_code._machine()
    processor = machine(fused)
    parsed = optimized(module_of(word, lanes, fused, flushed), processor)
    engine = binding.create_mcjit_compiler(parsed, processor)
    engine.finalize_object()
    _engines.append(engine)
    prototype = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)
    call = prototype(engine.get_function_address("compiled_function"))

    def run(x: Array) -> Array:
        padded = np.pad(np.asarray(x, float), (0, -len(x) % lanes))
        found = np.empty_like(padded)
        call(padded.ctypes.data, found.ctypes.data, padded.size // lanes)
        return found[: len(x)]

    return run


def exact(word: str, x: Array) -> tuple[Array, Array]:
    """Return mpmath's value as a sum of two doubles.

    Beyond the largest double, that and the rest.
    """
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


def ulps(exactly: tuple[Array, Array], found: Array) -> Array:
    """Return errors in units in the last place of the exact values; infinity stands for 2^1024."""
    high, low = exactly
    unit = np.spacing(np.minimum(np.abs(high), np.nextafter(LARGEST, 0.0)))
    over, ends = np.isinf(found), np.copysign(LARGEST, found)
    with np.errstate(all="ignore"):
        off = (np.where(over, ends, found) - high - low) / unit + over * np.sign(ends)
        return np.where(over & (low * np.sign(ends) >= unit), 0.0, np.abs(off))


def of_all_sizes(random: np.random.Generator, count: int) -> Array:
    """Return positive doubles of all exponents, including subnormal ones."""
    bits = random.integers(1, 0x7FF0 << 48, count)
    return bits.view(np.float64)


def close_to(places: Array, random: np.random.Generator) -> Array:
    """Return a few doubles on either side of each point."""
    steps = random.integers(-3, 4, places.size)
    return places + steps * np.spacing(places)


def arguments(word: str) -> Array:
    """Return test arguments: all exponents, the ends of ranges, and hard cases."""
    random, count = np.random.default_rng(17), POINTS // 4
    sizes, either = of_all_sizes(random, count), random.choice([-1.0, 1.0], count)
    if word in ("exp", "sinh", "cosh", "tanh"):
        turns = np.log(2.0) / 2.0 * random.integers(-2150, 2049, count)
        wide, most = random.uniform(-746.0, 710.4, count), 710.47
        hard = [turns, np.clip(turns, -most, most)][word != "exp"]
    elif word in ("atan", "asinh"):
        ends = np.array([2.0**0.5 - 1.0, 1.0, 2.0**0.5 + 1.0, 2.0**28, 2.0**60])
        hard = random.choice(ends, count) * either
        wide = either * 2.0 ** random.uniform(-3.0, 32.0, count)
    elif word in ("sin", "cos", "tan"):
        hard = np.pi / 2.0 * random.integers(-5300, 5300, count)
        wide = random.uniform(-LARGEST_ANGLE, LARGEST_ANGLE, count)
    else:
        ends = 1020.0 / abs(1.0 if word == "log" else float(word))
        hard = 2.0 ** np.round(np.clip(random.uniform(-ends, ends, count), -1000.0, 1000.0))
        wide = 2.0 ** np.clip(random.uniform(-ends, ends, count), -1074.0, 1023.9)
        near = 1.0 + either * 2.0 ** random.uniform(-52.0, -1.0, count)
        roots = close_to(hard * 2.0**0.5, random)
        return np.concatenate([sizes, close_to(hard, random), roots, wide, near])
    small = either * 2.0 ** random.uniform(-60.0, 3.0, count)
    return np.concatenate([either * sizes, close_to(hard, random), wide, small])


@lru_cache
def reference(word: str) -> tuple[Array, tuple[Array, Array]]:
    """Return arguments and exact values."""
    x = arguments(word)
    assert x.size >= POINTS
    return x, exact(word, x)


WORDS = (*FUNCTIONS_OF_LANES, *map(str, EXPONENTS))


@pytest.mark.parametrize("word", WORDS)
def test_errors_are_below_two_units_in_the_last_place(word: str) -> None:
    """With fused multiply-adds, and on the least processor of the kind."""
    x, exactly = reference(word)
    for fused in (True, False):
        off = ulps(exactly, compiled_function(word, fused=fused)(x))
        assert off.max() <= ALLOWED, (fused, x[off.argmax()], off.max())


@pytest.mark.parametrize("word", WORDS)
def test_subnormal_numbers_are_zeros_where_they_are_flushed(word: str) -> None:
    x, (high, low) = reference(word)
    seen = np.abs(x) >= TINY
    x, high, low = x[seen], high[seen], low[seen]
    found = compiled_function(word, flushed=True)(x)
    off = ulps((high, low), found)
    lost = np.abs(high) <= TINY
    np.testing.assert_array_equal(found[lost & (off > ALLOWED)], 0.0)
    assert off[~lost].max() <= ALLOWED
    small = np.array([5e-324, -5e-324, 2.2e-308, -2.2e-308])
    np.testing.assert_array_equal(
        compiled_function(word, flushed=True)(small), by_numpy(word, 0.0 * small)
    )


def by_numpy(word: str, x: Array) -> Array:
    """Return NumPy's values."""
    with np.errstate(all="ignore"):
        return np.asarray(UNARY[word](x) if word in UNARY else x ** float(word))


ANGLES = LARGEST_ANGLE, np.nextafter(LARGEST_ANGLE, np.inf)

ENDS = {
    "exp": (709.782712893384, 709.7827128933841, -708.3964185322641, -745.1332191019411,
            -745.1332191019412, -745.2, -746.0, -800.0, 800.0),
    "sinh": (710.4758600739439, 710.475860073944, 711.0, -711.0),
    "cosh": (710.4758600739439, 710.475860073944, 711.0, -711.0),
    "tanh": (18.0, 19.0, 19.06, 22.0, -30.0),
    "sin": (*ANGLES, 1e22, -1e22, 6381956970095103.0 * 2.0**797),
    "cos": (*ANGLES, 1e22, -1e22, 6381956970095103.0 * 2.0**797),
    "tan": (*ANGLES, 1e22, -1e22),
}  # fmt: skip
"""Ends of the functions' ranges, and where the C library takes over; the hardest angle of all
doubles."""


@pytest.mark.parametrize("fused", [True, False])
@pytest.mark.parametrize("word", WORDS)
def test_special_values_are_those_of_numpy(word: str, fused: bool) -> None:
    sizes = [0.0, 5e-324, 1e-310, TINY, 0.5, 1.0, 2.0, 1e300, LARGEST, np.inf, np.nan]
    x = np.array([*sizes, *(-size for size in sizes), *ENDS.get(word, ())])
    expected, found = by_numpy(word, x), compiled_function(word, fused=fused)(x)
    plain = np.isfinite(expected) & (expected != 0.0)
    np.testing.assert_array_equal(found[~plain], expected[~plain])
    signed = ~np.isnan(expected)
    np.testing.assert_array_equal(np.signbit(found[signed]), np.signbit(expected[signed]))
    off = np.abs(found[plain] - expected[plain]) / np.spacing(np.abs(expected[plain]))
    assert off.max() <= ALLOWED + 1.0


def test_exact_values_are_exact() -> None:
    """A lattice at rest stays at rest."""
    for word, at, value in (("exp", 0.0, 1.0), ("log", 1.0, 0.0), ("cos", 0.0, 1.0)):
        assert compiled_function(word)(np.array([at])) == [value]
    for exponent in map(str, EXPONENTS):
        assert compiled_function(exponent)(np.array([1.0])) == [1.0]


@pytest.mark.parametrize("word", WORDS)
def test_lanes_change_no_bit(word: str) -> None:
    """This includes lanes next to one for which the C library is called."""
    x = np.concatenate([arguments(word)[::7], [1e9, 2.0, np.nan, 3.0, np.inf]])
    found = compiled_function(word)(x)
    np.testing.assert_array_equal(compiled_function(word, lanes=1)(x), found)
    order = np.random.default_rng(3).permutation(x.size)
    np.testing.assert_array_equal(compiled_function(word)(x[order]), found[order])


@pytest.mark.parametrize("word", WORDS)
def test_odd_functions_keep_the_sign(word: str) -> None:
    signs = {
        "sin": -1.0,
        "tan": -1.0,
        "sinh": -1.0,
        "tanh": -1.0,
        "atan": -1.0,
        "asinh": -1.0,
        "cos": 1.0,
        "cosh": 1.0,
    }
    if word in signs:
        x = arguments(word)[::5]
        np.testing.assert_array_equal(
            compiled_function(word)(-x), signs[word] * compiled_function(word)(x)
        )


TRIED_BY = {
    "exp": "exp", "sinh": "sinh", "cosh": "cosh", "log": "log", "log_rest": "2000.5",
    "sin": "sin", "cos": "cos", "atan": "atan",
}  # fmt: skip


@pytest.mark.parametrize("name", SERIES)
def test_a_wrong_fourteenth_digit_is_detected(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    right = fitted(name)
    wrong = (right[0] * (1.0 + 5e-14), *right[1:])
    monkeypatch.setattr(vector_functions, "fitted", lambda of: wrong if of == name else fitted(of))
    x, exactly = reference(TRIED_BY[name])
    assert ulps(exactly, compiled_function.__wrapped__(TRIED_BY[name])(x)).max() > ALLOWED


@pytest.mark.parametrize("name", SERIES)
def test_errors_of_polynomials_are_below_rounding(name: str) -> None:
    """The errors of the polynomials are relative to the whole function."""
    low, high, _, made = SERIES[name]
    powers = {
        "exp": 2,
        "sinh": 1,
        "cosh": 1,
        "log": 1,
        "log_rest": 2,
        "sin": 1,
        "cos": 2,
        "atan": 1,
    }
    most = 2.0 ** (-66 if name == "log_rest" else -55)
    with mpmath.workdps(60):
        of, factors = made(mpmath), list(map(mpmath.mpf, reversed(fitted(name))))
        for place in np.linspace(0.99 * low, high, 50)[1:]:
            z = mpmath.mpf(float(place))
            off = (mpmath.polyval(factors, z) - of(z)) * z ** powers[name]
            assert abs(off) < most


@pytest.mark.parametrize("word", WORDS)
def test_other_processors_need_no_calls(word: str) -> None:
    """On 64-bit ARM and the least x86-64, only angles beyond the range need the C library."""
    for triple in ("aarch64-unknown-linux-gnu", "x86_64-unknown-linux-gnu"):
        try:
            processor = machine(False, triple)
        except RuntimeError:
            pytest.skip("LLVM is built without the processor")
        fused = triple.startswith("aarch64")
        lines = processor.emit_assembly(optimized(module_of(word, 8, fused, False), processor))
        calls = re.findall(r"^\s+(?:bl|callq)\s+(.*)$|movabsq\s+\$([a-z]\w*),", lines, re.MULTILINE)
        called = {name for call in calls for name in call if name and not name.startswith("*")}
        assert called <= ({word} if word in ("sin", "cos", "tan") else set())


def test_large_exponents_use_the_c_library() -> None:
    assert LARGEST_EXPONENT == 2.0**20
    law = ForceProgram((), (("x", 0.0), ("power", 3e6 + 0.5)))
    text = passage_text(*plan(law))
    assert 'declare double @"pow"' in text


def plan(law: ForceProgram) -> tuple[Any, ...]:
    """Return the arguments of `passage_text` for a chain with that law."""
    bond = NumericBond((Entry((0,), 1.0, 0),), (Entry((0,), 1.0, 0),), law)
    flow, numbers = stage_plan(NumericLattice("compiled_function", ("u",), (1.0,), (bond,)))
    return flow, 8, 1, 256, len(numbers)
