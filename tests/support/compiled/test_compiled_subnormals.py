"""Compiled lattice code flushes subnormal numbers to 0; other code does not."""

import threading
from pathlib import Path

import numpy as np
import pytest
from llvmlite import binding, ir

from longwave.lattice import Model, State
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.support.compiled.jit import njit
from longwave.support.compiled.subnormals import ARM_FLUSH, X86_FLUSH, flushed_subnormals

SUBNORMAL = 1e-310


def is_gradual() -> bool:
    """Return whether this thread computes with subnormal numbers."""
    return float(np.float64(2.0) * np.float64(SUBNORMAL)) == 2e-310


@njit(cache=True, subnormals=False)
def _doubled(x, out, fail):
    out[0] = 2.0 * x
    if fail:
        raise ValueError


@njit(cache=True)
def _doubled_gradually(x, out):
    out[0] = 2.0 * x


@pytest.fixture(params=[64, 5], ids=["in rows", "one by one"])
def advanced_positions(request: pytest.FixtureRequest):
    """Return the positions of a chain of tiny strains after some steps."""

    def compute() -> np.ndarray:
        lattice = Model(1.0, 0.0, 1.0).lattice
        f = np.full((1, request.param), SUBNORMAL)
        ring = lattice.with_walls(State(0.0, f, np.zeros_like(f)))
        Dynamics(lattice).advance(REDUCED_PHASE_6, ring.f, ring.v, 0.1, 3)
        return ring.f[0, : request.param]

    return compute


def test_lattice_code_flushes_and_restores(advanced_positions):
    """Catches: a mode that is not set on entry, or is left set on exit."""
    assert is_gradual()
    assert np.all(advanced_positions() == 0.0)
    assert is_gradual()


def test_each_thread_has_its_own_mode(advanced_positions):
    """Catches: a mode set once in the main thread, or leaked from a worker into it."""
    seen = {}

    def work():
        seen["flushed"] = bool(np.all(advanced_positions() == 0.0))
        seen["gradual"] = is_gradual()

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == {"flushed": True, "gradual": True}
    assert is_gradual()


def test_numba_kernels_flush_only_if_declared():
    out = np.ones(1)
    _doubled(SUBNORMAL, out, 0)
    assert out[0] == 0.0
    assert is_gradual()
    _doubled_gradually(SUBNORMAL, out)
    assert out[0] == 2.0 * SUBNORMAL


def test_the_mode_is_restored_after_an_exception():
    with pytest.raises(RuntimeError, match="must raise nothing"):
        _doubled(SUBNORMAL, np.ones(1), 1)
    assert is_gradual()


def test_a_kernel_without_cache_cannot_flush():
    with pytest.raises(ValueError, match="cache must be True if subnormals is False, got False"):
        njit(subnormals=False)(lambda x: x)


def _assembly(triple: str) -> str:
    """Return, as text, the machine code of a function that doubles a number without subnormals."""
    module = ir.Module()
    double = ir.DoubleType()
    function = ir.Function(module, ir.FunctionType(double, [double]), name="doubled")
    builder = ir.IRBuilder(function.append_basic_block())
    with flushed_subnormals(module, builder, triple):
        value = builder.fadd(function.args[0], function.args[0])
    builder.ret(value)
    module.triple = triple
    binding.initialize_all_targets()
    binding.initialize_all_asmprinters()
    machine = binding.Target.from_triple(triple).create_target_machine(opt=0)
    text: str = machine.emit_assembly(binding.parse_assembly(str(module)))
    return text


@pytest.mark.parametrize(
    ("triple", "read", "write", "bits"),
    [
        ("x86_64-unknown-linux-gnu", "stmxcsr", "ldmxcsr", X86_FLUSH),
        ("aarch64-unknown-linux-gnu", "mrs", "msr", ARM_FLUSH),
        ("arm64-apple-darwin", "mrs", "msr", ARM_FLUSH),
    ],
)
def test_code_of_each_processor_reads_sets_and_restores(triple, read, write, bits):
    """Catches: an intrinsic with another name or type on another processor."""
    lines = [line.strip().lower() for line in _assembly(triple).splitlines()]
    told = [line.split()[0] for line in lines if line.split()[:1] in ([read], [write])]
    assert told == [read, write, write]
    assert any(f"{bits}" in line or f"{bits:#x}" in line for line in lines)


def test_other_processors_are_left_alone():
    text = _assembly("powerpc64le-unknown-linux-gnu")
    assert "mxcsr" not in text
    assert "fpcr" not in text


def test_evaluation_of_waves_keeps_subnormals():
    """Catches: flushing in double-double code, whose bounds need gradual underflow."""
    solutions = Path(__file__).parents[3] / "solutions"
    texts = [path.read_text() for path in solutions.rglob("*.py")]
    assert texts
    assert not any("subnormals=False" in text for text in texts)
