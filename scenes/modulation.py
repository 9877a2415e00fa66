"""Modulational instability of plane waves: the envelope's coefficients on grids.

The coefficients are derived once, symbolically in the wavenumber and in the constants that vary,
and then evaluated on arrays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sympy import Expr

from longwave.derive import Envelope, Lattice, envelope
from longwave.derive.algebra.exact_numbers import exact
from longwave.derive.algebra.rational_functions import RationalFunction
from longwave.support.real_arrays import real_array

if TYPE_CHECKING:
    from longwave.scenes.description.scene import Scene

Array = NDArray[np.float64]

ZERO_DENOMINATOR = 1e-13
"""Magnitude below which a denominator counts as 0, relative to the sum of its terms' moduli."""


@dataclass(frozen=True)
class ModulationGrid:
    """Coefficients of ``i A_T + p A_XX + q |A|^2 A = 0`` on a grid; all arrays have one shape.

    ``growth_rate`` is the largest growth rate, in T, of a perturbed plane wave; 0 where it is
    stable.  At a resonance p, q and ``growth_rate`` are NaN; where the lattice itself is unstable,
    omega is NaN as well.
    """

    k: Array
    omega: Array
    p: Array
    q: Array
    growth_rate: Array

    @property
    def product(self) -> Array:
        """Product p q: positive where plane waves are unstable and solitons bright."""
        return self.p * self.q


def modulation_grid(
    lattice: Lattice,
    k: ArrayLike,
    branch: str | int = 0,
    amplitude: float = 1.0,
    **constants: ArrayLike,
) -> ModulationGrid:
    """Return p, q and growth rates on a grid of wavenumbers and constants, by broadcasting.

    ``amplitude`` is |A| of the plane wave.  Wavenumbers must satisfy 0 < k <= pi.  Raises
    ValueError for wrong wavenumbers, missing or unknown constants, and a lattice without NLS
    equation.

    >>> from longwave.derive import LATTICES
    >>> K3 = np.array([[0.0], [0.6], [1.0]])
    >>> found = modulation_grid(LATTICES["fput"], [1.0, 2.0, 3.0], K2=1, K3=K3, K4=1)
    >>> np.where(found.product > 0, "+", "-").tolist()
    [['+', '+', '+'], ['-', '+', '+'], ['-', '-', '-']]
    """
    angle = real_array("every k", k)
    if not np.all((angle > 0) & (angle <= np.pi)):
        raise ValueError(
            f"k must satisfy 0 < k <= pi, got {angle.min():g} .. {angle.max():g} (k is the "
            "carrier's wavenumber in radians per cell)"
        )
    fixed = {n: exact(n, np.asarray(v).item()) for n, v in constants.items() if np.ndim(v) == 0}
    varied = {n: real_array(f"every {n}", v) for n, v in constants.items() if n not in fixed}
    derived = envelope(lattice, branch=branch, **({} if lattice.definitions else fixed))
    return _grid(derived, _values(derived, fixed, varied), angle, amplitude)


def scene_modulation(scene: Scene, k: Array, amplitude: float) -> ModulationGrid:
    """Return p, q and growth rates of a scene's lattice at wavenumbers 0 < k <= pi.

    Raises the ValueErrors of `scene_envelope`.
    """
    from longwave.scenes.starts.lattice_derivation import scene_envelope

    derived, numbers = scene_envelope(scene.changed(carrier=1))
    fixed = {str(symbol): value for symbol, value in derived.constants.items()} | {**numbers}
    return _grid(derived, _values(derived, fixed, {}), k, amplitude)


def _grid(
    derived: Envelope, values: Mapping[str, Any], angle: Array, amplitude: float
) -> ModulationGrid:
    shape = np.broadcast_shapes(angle.shape, *(np.shape(v) for v in values.values()))
    z, w = map(str, derived.carrier.field.symbols[:2])
    point = {**values, z: np.exp(1j * np.broadcast_to(angle, shape).astype(np.longdouble))}
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        squared = _frequency_squared(derived, point, shape)
        omega = np.sqrt(np.where(squared > 0, squared, np.nan))
        point[w] = 1j * omega
        p, q = ((_at(derived.parts[name], point) / 1j).real for name in ("p", "q"))
        is_resonant = np.isnan(_at(derived.carrier.second_harmonic, point))
        p, q = (np.where(is_resonant, np.nan, value).astype(float) for value in (p, q))
        rate = np.where(p * q > 0, np.abs(q) * amplitude**2, 0 * p * q)
    return ModulationGrid(np.broadcast_to(angle, shape), omega.astype(float), p, q, rate)


def _values(
    derived: Envelope, fixed: Mapping[str, Expr], varied: Mapping[str, Array]
) -> dict[str, Any]:
    """Return the values of all constants by name, including those defined by other constants.

    Raises ValueError for missing or unknown constants, and for an array of a constant in a force
    that is not a polynomial.
    """
    definitions = derived.carrier.lattice.definitions
    basic = {str(s) for _, value in definitions for s in value.free_symbols}
    if basic & varied.keys():
        raise ValueError(
            f"constants must be numbers if the force is not a polynomial, got an array for "
            f"{min(basic & varied.keys())} (take one grid for each value)"
        )
    names = {*map(str, derived.lattice.constants), *basic} - {str(s) for s, _ in definitions}
    given = {**fixed, **varied}
    for name in sorted(names ^ given.keys()):
        if name in names:
            problem = f"constant {name} must be given, got none"
        else:
            problem = f"constants must be those of the lattice, got {name}"
        raise ValueError(f"{problem} (they are {', '.join(sorted(names))})")
    symbols = {s: fixed[str(s)] for _, value in definitions for s in value.free_symbols}
    defined = {str(s): value.xreplace(symbols) for s, value in definitions}
    numbers = {n: np.longdouble(str(v.evalf(25))) for n, v in {**fixed, **defined}.items()}
    return {**numbers, **{n: v.astype(np.longdouble) for n, v in varied.items()}}


def _sum(terms: Any, names: list[str], point: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return the sum of a polynomial's ``terms`` at ``point``, and the sum of their moduli."""
    total, magnitude = np.clongdouble(0), np.longdouble(0)
    for exponents, value in terms:
        term: Any = np.longdouble(value)
        for name, power in zip(names, exponents, strict=True):
            term = term * point[name] ** power if power else term
        total, magnitude = total + term, magnitude + np.abs(term)
    return total, magnitude


def _at(element: RationalFunction, point: Mapping[str, Any]) -> Any:
    """Return the value of a rational function at ``point``; NaN where its denominator vanishes."""
    names = [str(symbol) for symbol in element.field.symbols]
    above, _ = _sum(element.terms(), names, point)
    below, magnitude = _sum(element.terms(below=True), names, point)
    return above / np.where(np.abs(below) <= ZERO_DENOMINATOR * magnitude, np.nan, below)


def _frequency_squared(derived: Envelope, point: Mapping[str, Any], shape: tuple[int, ...]) -> Any:
    """Return omega^2 of the envelope's branch from the dispersion relation; NaN where complex."""
    names = [str(symbol) for symbol in derived.carrier.field.symbols]
    parts: dict[int, Any] = {}
    for exponents, value in derived.carrier.relation.terms():
        others = (exponents[0], 0, *exponents[2:])
        term, _ = _sum([(others, value)], names, {**point, names[1]: 1.0})
        half = exponents[1] // 2
        parts[half] = parts.get(half, 0) + (-1) ** half * term
    degree = max(parts)
    rows = [np.broadcast_to((parts.get(i, 0) / parts[degree]).real, shape) for i in range(degree)]
    if degree == 1:
        return -rows[0]
    companion = np.zeros((*shape, degree, degree))
    companion[..., range(1, degree), range(degree - 1)] = 1
    companion[..., -1] = -np.stack(rows, axis=-1).astype(float)
    roots = np.sort_complex(np.linalg.eigvals(companion))[..., derived.branch]
    return np.where(np.abs(roots.imag) <= 1e-6 * np.abs(roots), roots.real, np.nan)
