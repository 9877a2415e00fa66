"""Lowering and tape: what is formed outside the compiled code, and its derivatives."""

import pytest
import sympy as sp

from longwave.solutions import closed_form
from longwave.solutions.compile.lowering import Lowering
from longwave.solutions.compile.tape import tape_of
from longwave.solutions.functions import jacobi_epsilon, jacobi_sn
from longwave.solutions.symbols import k, tau, xi


def test_secular_terms_join_one_phase() -> None:
    lowering = Lowering()
    u = xi - 3 * tau
    lowered = lowering.lower((u + jacobi_epsilon(u, k**2) / k) / 2 - tau)
    slope = (1 + sp.elliptic_e(k**2) / sp.elliptic_k(k**2) / k) / 2
    phases = list(lowering.phases.values())
    found = [ph for ph in phases if sp.expand(ph.p - slope) == 0]
    assert len(found) == 1
    assert sp.expand(found[0].q + 3 * slope + 1) == 0
    assert found[0].symbol in lowered.free_symbols
    assert not lowered.has(xi, tau)


def test_one_jacobi_call_a_phase() -> None:
    lowering = Lowering()
    lowering.lower(closed_form("wave_sn").expression * closed_form("wave_sn").expression.diff(xi))
    assert len(lowering.calls) == 1


def test_sine_and_cosine_share_a_call_at_parameter_zero() -> None:
    lowering = Lowering()
    lowered = lowering.lower(sp.sin(xi + 3 * tau) + sp.cos(xi + 3 * tau))
    (call,) = lowering.calls.values()
    assert call.m == 0
    assert lowered == sum(call.symbols[:2])


def test_jacobi_function_of_a_nonlinear_phase_is_refused() -> None:
    with pytest.raises(ValueError, match="must be linear in xi, tau, zeta, got xi\\*\\*2"):
        Lowering().lower(jacobi_sn(xi**2, k**2))


@pytest.mark.parametrize("power", [-3, -1, 2, 5])
def test_tape_differentiates(power: int) -> None:
    """The lines, substituted back, give SymPy's own derivatives."""
    expression = (2 + sp.tanh(xi - tau) + xi * tau) ** power
    lowering = Lowering()
    tape, outputs = tape_of(lowering, [lowering.lower(expression)], has_across=False)
    point = {xi: sp.Rational(1, 3), tau: sp.Rational(2, 7)}
    known = {ph.symbol: (ph.p * xi + ph.q * tau + ph.r) for ph in lowering.phases.values()}
    values = {symbol: phase.subs(point) for symbol, phase in known.items()}
    values |= {symbol: constant for constant, symbol in lowering.constants.items()}
    for symbol, right in tape.lines:
        values[symbol] = right.xreplace(values)
    expected = (expression, expression.diff(xi), expression.diff(tau))
    for output, exact in zip(outputs, expected, strict=True):
        assert sp.N(output.xreplace(values) - exact.subs(point), 30) == pytest.approx(0, abs=1e-25)
