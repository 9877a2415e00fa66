"""Where plane waves of a lattice are unstable: the envelope's coefficients on whole grids.

The coefficients are derived once, for all wavenumbers and for those constants that vary; arrays are
put into them.
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

VANISHING = 1e-13
"""A denominator so small, beside the sum of its terms without their signs, is taken for 0."""


@dataclass(frozen=True)
class ModulationGrid:
    """The NLS equation ``i A_T + p A_XX + q |A|^2 A = 0`` on a grid; all arrays have one shape.

    ``growth_rate``: the largest in T of the plane wave, 0 where that is stable.  All are NaN at a
    resonance, and where the lattice is unstable itself.
    """

    k: Array
    omega: Array
    p: Array
    q: Array
    growth_rate: Array

    @property
    def product(self) -> Array:
        """p q: positive where plane waves are unstable, and solitons bright."""
        return self.p * self.q


def modulation_grid(
    lattice: Lattice,
    k: ArrayLike,
    branch: str | int = 0,
    amplitude: float = 1.0,
    **constants: ArrayLike,
) -> ModulationGrid:
    """p, q and growth rates where wavenumber and constants are arrays that fit together.

    ``amplitude``: |A| of the plane wave.  The wavenumbers are in 0 < k <= pi.  Raises ValueError
    for constants that are missing or unknown, and where there is no NLS equation at all.

    >>> from longwave.derive import LATTICES
    >>> K3 = np.array([[0.0], [0.6], [1.0]])
    >>> found = modulation_grid(LATTICES["fput"], [1.0, 2.0, 3.0], K2=1, K3=K3, K4=1)
    >>> np.where(found.product > 0, "+", "-").tolist()
    [['+', '+', '+'], ['-', '+', '+'], ['-', '-', '-']]
    """
    angle = real_array("every k", k)
    if not np.all((angle > 0) & (angle <= np.pi)):
        raise ValueError(f"k must satisfy 0 < k <= pi, got {angle.min():g} .. {angle.max():g}")
    fixed = {n: exact(n, np.asarray(v).item()) for n, v in constants.items() if np.ndim(v) == 0}
    moving = {n: real_array(f"every {n}", v) for n, v in constants.items() if n not in fixed}
    found = envelope(lattice, branch=branch, **({} if lattice.definitions else fixed))
    return _grid(found, _values(found, fixed, moving), angle, amplitude)


def scene_modulation(scene: Scene, k: Array, amplitude: float) -> ModulationGrid:
    """The same of a scene's lattice, constants and branch, over wavenumbers in 0 < k <= pi.

    Raises ValueError as the scene's derivation does.
    """
    from longwave.scenes.starts.lattice_derivation import scene_envelope

    found, numbers = scene_envelope(scene.changed(carrier=1))
    fixed = {str(symbol): value for symbol, value in found.constants.items()} | {**numbers}
    return _grid(found, _values(found, fixed, {}), k, amplitude)


def _grid(
    found: Envelope, values: Mapping[str, Any], angle: Array, amplitude: float
) -> ModulationGrid:
    shape = np.broadcast_shapes(angle.shape, *(np.shape(v) for v in values.values()))
    z, w = map(str, found.carrier.field.symbols[:2])
    point = {**values, z: np.exp(1j * np.broadcast_to(angle, shape).astype(np.longdouble))}
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        squared = _frequency_squared(found, point, shape)
        omega = np.sqrt(np.where(squared > 0, squared, np.nan))
        point[w] = 1j * omega
        p, q = ((_at(found.parts[name], point) / 1j).real for name in ("p", "q"))
        lost = np.isnan(_at(found.carrier.second_harmonic, point))
        p, q = (np.where(lost, np.nan, value).astype(float) for value in (p, q))
        rate = np.where(p * q > 0, np.abs(q) * amplitude**2, 0 * p * q)
    return ModulationGrid(np.broadcast_to(angle, shape), omega.astype(float), p, q, rate)


def _values(
    found: Envelope, fixed: Mapping[str, Expr], moving: Mapping[str, Array]
) -> dict[str, Any]:
    """The constants of the expansion by name, those that the lattice defines by others too."""
    definitions = found.carrier.lattice.definitions
    basic = {str(s) for _, value in definitions for s in value.free_symbols}
    if basic & moving.keys():
        raise ValueError(
            f"constants must be numbers where the force is no polynomial, got an array for "
            f"{min(basic & moving.keys())} (take one grid for each value)"
        )
    names = {*map(str, found.lattice.constants), *basic} - {str(s) for s, _ in definitions}
    given = {**fixed, **moving}
    for name in sorted(names ^ given.keys()):
        what = "be given, got none" if name in names else "be a constant of the lattice, got it"
        raise ValueError(f"{name} must {what} (they are {', '.join(sorted(names))})")
    symbols = {s: fixed[str(s)] for _, value in definitions for s in value.free_symbols}
    made = {str(s): value.xreplace(symbols) for s, value in definitions}
    numbers = {n: np.longdouble(str(v.evalf(25))) for n, v in {**fixed, **made}.items()}
    return {**numbers, **{n: v.astype(np.longdouble) for n, v in moving.items()}}


def _sum(terms: Any, names: list[str], point: Mapping[str, Any]) -> tuple[Any, Any]:
    """A polynomial at the point, and the sum of its terms without their signs."""
    total, size = np.clongdouble(0), np.longdouble(0)
    for exponents, value in terms:
        term: Any = np.longdouble(value)
        for name, power in zip(names, exponents, strict=True):
            term = term * point[name] ** power if power else term
        total, size = total + term, size + np.abs(term)
    return total, size


def _at(element: RationalFunction, point: Mapping[str, Any]) -> Any:
    """A rational function at the point; NaN where its denominator vanishes."""
    names = [str(symbol) for symbol in element.field.symbols]
    above, _ = _sum(element.terms(), names, point)
    below, size = _sum(element.terms(below=True), names, point)
    return above / np.where(np.abs(below) <= VANISHING * size, np.nan, below)


def _frequency_squared(found: Envelope, point: Mapping[str, Any], shape: tuple[int, ...]) -> Any:
    """omega^2 of the branch, a root of the dispersion relation."""
    names = [str(symbol) for symbol in found.carrier.field.symbols]
    parts: dict[int, Any] = {}
    for exponents, value in found.carrier.relation.terms():
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
    roots = np.sort_complex(np.linalg.eigvals(companion))[..., found.branch]
    return np.where(np.abs(roots.imag) <= 1e-6 * np.abs(roots), roots.real, np.nan)
