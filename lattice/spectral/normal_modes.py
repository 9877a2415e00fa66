"""Normal modes of any lattice: the maps between fields, forces and normal coordinates.

With f = E a, E the eigenvectors of the dynamical matrix, each normal coordinate of each wavenumber
is an oscillator a'' = -w^2 a + drive. For masses and springs the matrix is Hermitian once it is
weighted with the masses; for strains it need not be.

Where w is nearly 0, as for the motion of a chain as a whole, there is no oscillation to integrate
exactly. There w is raised to a small value, and the difference stays with the forces. An unstable
wave has an imaginary w, and needs nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from longwave.lattice.numeric_lattice import Entry, NumericLattice
from longwave.support.real_arrays import Array, Complex

HERMITIAN_ERROR = 1e-12
"""Largest relative deviation of a weighted matrix from its adjoint at which it counts as
Hermitian."""

MAX_CONDITION = 1e6
"""Largest accepted condition number of eigenvectors; beyond it they are nearly parallel."""


@dataclass(frozen=True)
class NormalModes:
    """Frequencies ``w`` (branches, modes), eigenvectors (fields, branches, modes), their inverse.

    ``excess`` is w^2 less the matrix's eigenvalue, 0 where ``w`` was not raised.
    """

    w: Complex
    vectors: Complex
    inverse: Complex
    excess: Complex

    def coordinates(self, fields: Complex) -> Complex:
        """Return the normal coordinates of fields, (fields, modes) to (branches, modes)."""
        return _products(self.inverse, fields)

    def fields(self, coordinates: Complex) -> Complex:
        """Return the fields of normal coordinates, (branches, modes) to (fields, modes)."""
        return _products(self.vectors, coordinates)


def normal_modes(
    lattice: NumericLattice, wavenumbers: Array, slopes: list[float], lowest: float
) -> NormalModes:
    """Return the normal modes of these wavenumbers, (modes, axes), for bonds with these ``slopes``.

    Frequencies below ``lowest`` are raised to it. Raises ValueError for a lattice of strains with
    modes that cannot be decoupled.
    """
    matrices = lattice.dynamical_matrix(wavenumbers, slopes)
    count = len(lattice.fields)
    if count == 1:
        squares = matrices[:, :, 0].T
        vectors = inverse = np.ones((1, 1, len(wavenumbers)), dtype=np.complex128)
    else:
        squares, vectors, inverse = _diagonal(lattice, matrices)
    raised = np.where(np.abs(squares) < lowest**2, lowest**2, squares)
    return NormalModes(np.sqrt(raised), vectors, inverse, raised - squares)


def _diagonal(lattice: NumericLattice, matrices: Complex) -> tuple[Complex, Complex, Complex]:
    """Return eigenvalues, eigenvectors and their inverse, modes along the last axis."""
    root = np.sqrt(np.array(lattice.masses))
    weighted = root[:, None] * matrices / root
    skew = weighted - np.conj(np.swapaxes(weighted, -1, -2))
    if np.max(np.abs(skew)) <= HERMITIAN_ERROR * np.max(np.abs(weighted)):
        values, eigenvectors = np.linalg.eigh(weighted)
        squares = values.astype(np.complex128)
        inverse_eigenvectors = np.conj(np.swapaxes(eigenvectors, -1, -2))
    else:
        squares, eigenvectors = np.linalg.eig(weighted)
        if np.max(np.linalg.cond(eigenvectors)) > MAX_CONDITION:
            raise ValueError(
                f"lattice must have normal modes that decouple, got {lattice.name}, some of whose "
                "waves grow like t (declare it in displacements, or integrate it site by site)"
            )
        inverse_eigenvectors = np.linalg.inv(eigenvectors)
    vectors, inverse = eigenvectors / root[:, None], inverse_eigenvectors * root
    return squares.T, np.moveaxis(vectors, 0, -1), np.moveaxis(inverse, 0, -1)


def multipliers(entries: tuple[Entry, ...], wavenumbers: Array, fields: int) -> Complex:
    """Return the Fourier multipliers of a stencil, one for each field and mode: (fields, modes)."""
    result = np.zeros((fields, len(wavenumbers)), dtype=np.complex128)
    for entry in entries:
        phase = wavenumbers @ np.array(entry.shift, dtype=np.float64)
        result[entry.field] += entry.weight * np.exp(1j * phase)
    return result


def _products(matrices: Complex, vectors: Complex) -> Complex:
    """Return the product of a matrix and a vector for each mode."""
    return np.einsum("ijk,jk->ik", matrices, vectors)
