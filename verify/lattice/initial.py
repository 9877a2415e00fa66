"""The wave of a scene, and the lattice's initial data made from it."""

from functools import cache
from typing import Protocol

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

import derive
from solutions import ClosedForm, Wave, WaveValues, closed_form
from solutions.exact import exact_number
from verify.lattice.quantity import exact_quantity
from verify.lattice.scene import Scene

Array = NDArray[np.float64]


class _InitialVelocity(Protocol):
    def __call__(self, Y_X: Array, Y_T: Array, c: float, eps: float) -> Array: ...


def build_wave(scene: Scene) -> Wave:
    """The scene's wave with its numbers in.

    Raises ValueError for an unknown wave, a parameter outside its domain, K3 != 0 and K4 of the
    wrong sign for the wave's equation.
    """
    values = dict(scene.parameters)
    form = closed_form(scene.wave, values)
    _check_reduction(scene, form)
    modulus = exact_number("k", values["k"]) if "k" in values else None
    exact = {name: exact_quantity(name, value, modulus) for name, value in values.items()}
    return Wave(form, derive.mkdv_normal_form(scene.K2, scene.K4), **exact)


def _check_reduction(scene: Scene, form: ClosedForm) -> None:
    if scene.K3 != 0:
        raise ValueError(
            f"K3 must be 0 for an mKdV wave, got {scene.K3:g} "
            "(order eps^4 of the reduction reads K3 (Y^2)_XX = 0)"
        )
    if scene.K4 * form.equation.s <= 0:
        sign = ">" if form.equation.s > 0 else "<"
        raise ValueError(
            f"K4 must satisfy K4 {sign} 0 for {form.name}, got {scene.K4:g} "
            f"(it solves the {form.equation.name} equation)"
        )


@cache
def _initial_velocity() -> _InitialVelocity:
    expression = derive.initial_velocity()
    symbols = {symbol.name: symbol for symbol in expression.free_symbols}
    arguments = [symbols[name] for name in ("Y_X", "Y_T", "c", "eps")]
    function: _InitialVelocity = sp.lambdify(arguments, expression, "numpy")
    return function


def initial_data(wave: Wave, scene: Scene, sites: ArrayLike) -> tuple[Array, Array]:
    """Strain y_n = eps Y and velocity s_n of the ansatz at the sites (any real), at time t0."""
    value = wave.at(sites, scene.t0, scene.eps)
    return lattice_data(value, scene.constants.sound_speed(), scene.eps)


def lattice_data(value: WaveValues, c: float, eps: float) -> tuple[Array, Array]:
    """Strain and velocity of the ansatz where the wave has the given values; c is sqrt(K2)."""
    return eps * value.Y, _initial_velocity()(value.Y_X, value.Y_T, c, eps)


def rigid_offsets(scene: Scene, speed: float, sites: NDArray[np.int64], t: float) -> Array:
    """Sites at time t, from the place that began at c t0 and moves at ``speed``."""
    begin = scene.constants.sound_speed() * scene.t0
    return np.asarray((sites - begin) - speed * (t - scene.t0), dtype=np.float64)


def rigid_data(wave: Wave, scene: Scene, speed: float, offsets: ArrayLike) -> tuple[Array, Array]:
    """Strain and velocity of the initial strain that moves rigidly at ``speed``.

    Far from the crest, on a constant background, this is what the lattice itself does with the
    wave's algebraic tail, which is long and weak; ``speed`` is the sound speed there, ``offsets``
    are as `rigid_offsets` gives them.
    """
    X = scene.eps * np.asarray(offsets, dtype=np.float64)
    value = wave(X, scene.eps**3 * scene.t0)
    rest = np.zeros_like(X)
    velocity = _initial_velocity()(value.Y_X, rest, speed, scene.eps)
    return scene.eps * value.Y, velocity
