"""Solutions of i U_tau + U_xixi + 2 s |U|^2 U = 0 and their derivatives, by SymPy."""

from functools import cache
from typing import Any

import numpy as np
from sympy import I, Symbol, exp, lambdify, sech, tanh

from longwave.derive.normal_form import NormalForm

xi, tau = Symbol("xi", real=True), Symbol("tau", real=True)

WAVES = {
    "bright": (1, sech(xi) * exp(I * tau)),
    "dark": (-1, tanh(xi) * exp(-2 * I * tau)),
    "peregrine": (
        1,
        (1 - 4 * (1 + 4 * I * tau) / (1 + 4 * xi**2 + 16 * tau**2)) * exp(2 * I * tau),
    ),
    "plane": (1, exp(2 * I * tau)),
}
"""Waves by name, each with its sign s."""


@cache
def derivatives(name: str, highest: int) -> Any:
    U = WAVES[name][1]
    return lambdify((xi, tau), [U.diff(xi, m) for m in range(highest + 1)], cse=True)


class SymbolicWave:
    """Wave of `WAVES` in the variables of a lattice's envelope equation."""

    def __init__(self, name: str, form: NormalForm, amplitude: float = 1.0) -> None:
        assert form.s == WAVES[name][0], f"{name} needs s = {WAVES[name][0]}"
        self.name, self.amplitude = name, amplitude
        self.a, self.b, self.h = (float(value) for value in (form.a, form.b, form.h))

    def jets(self, X: Any, T: float, highest: int) -> np.ndarray:
        a, b = self.a * self.amplitude, self.b * self.amplitude**2
        at = np.asarray(X, dtype=np.float64)
        found = derivatives(self.name, highest)(a * at, b * T)
        return np.stack(
            [self.h * self.amplitude * a**m * (value + 0j * at) for m, value in enumerate(found)]
        )
