"""The waves of any lattice, linearised: what turns fields into them and forces into their drive.

With f = E a, E the eigenvectors of the dynamical matrix, each normal coordinate of each wave number
is an oscillator a'' = -w^2 a + drive. Of masses and springs the matrix is Hermitian once it is
weighted with the masses; of strains it need not be.

Where w is nearly 0, as for a chain that is pushed as a whole, there is no oscillation to be exact
about: a small ``lifted`` w is taken there, and the difference stays with the forces. An unstable
wave has an imaginary w, and needs nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.numeric_lattice import Entry, NumericLattice

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

HERMITIAN = 1e-12
"""How far a weighted matrix may be from its own adjoint, in units of its largest entry."""

SKEW = 1e6
"""Largest condition number of eigenvectors: beyond, they are too nearly the same."""


@dataclass(frozen=True)
class NormalModes:
    """Frequencies ``w`` (branches, modes), eigenvectors (fields, branches, modes), their inverse.

    ``excess`` is w^2 less what the matrix says, 0 where ``w`` was not lifted.
    """

    w: Complex
    vectors: Complex
    inverse: Complex
    excess: Complex

    def coordinates(self, fields: Complex) -> Complex:
        """The normal coordinates of fields, (fields, modes) to (branches, modes)."""
        return _times(self.inverse, fields)

    def fields(self, coordinates: Complex) -> Complex:
        """The fields of normal coordinates."""
        return _times(self.vectors, coordinates)


def normal_modes(
    lattice: NumericLattice, wavenumbers: Array, slopes: list[float], least: float
) -> NormalModes:
    """The waves of these numbers, shape (modes, axes), about bonds of these ``slopes``.

    Frequencies below ``least`` are lifted to it. Raises ValueError for a lattice of strains some of
    whose waves do not part into oscillators.
    """
    matrices = lattice.dynamical_matrix(wavenumbers, slopes)
    count = len(lattice.fields)
    if count == 1:
        squares = matrices[:, :, 0].T
        vectors = inverse = np.ones((1, 1, len(wavenumbers)), dtype=np.complex128)
    else:
        squares, vectors, inverse = _diagonal(lattice, matrices)
    lifted = np.where(np.abs(squares) < least**2, least**2, squares)
    return NormalModes(np.sqrt(lifted), vectors, inverse, lifted - squares)


def _diagonal(lattice: NumericLattice, matrices: Complex) -> tuple[Complex, Complex, Complex]:
    """Eigenvalues, eigenvectors and their inverse, modes along the last axis."""
    root = np.sqrt(np.array(lattice.masses))
    weighted = root[:, None] * matrices / root
    skew = weighted - np.conj(np.swapaxes(weighted, -1, -2))
    if np.max(np.abs(skew)) <= HERMITIAN * np.max(np.abs(weighted)):
        values, turned = np.linalg.eigh(weighted)
        squares = values.astype(np.complex128)
        back = np.conj(np.swapaxes(turned, -1, -2))
    else:
        squares, turned = np.linalg.eig(weighted)
        if np.max(np.linalg.cond(turned)) > SKEW:
            raise ValueError(
                f"lattice must have waves that are oscillators, got {lattice.name}, some of whose "
                "waves grow like t (declare it in displacements, or integrate it site by site)"
            )
        back = np.linalg.inv(turned)
    vectors, inverse = turned / root[:, None], back * root
    return squares.T, np.moveaxis(vectors, 0, -1), np.moveaxis(inverse, 0, -1)


def multipliers(entries: tuple[Entry, ...], wavenumbers: Array, fields: int) -> Complex:
    """What a bond's stretch, or action, multiplies waves of each field with: (fields, modes)."""
    found = np.zeros((fields, len(wavenumbers)), dtype=np.complex128)
    for entry in entries:
        turn = wavenumbers @ np.array(entry.shift, dtype=np.float64)
        found[entry.field] += entry.weight * np.exp(1j * turn)
    return found


def _times(matrices: Complex, vectors: Complex) -> Complex:
    product: Complex = np.einsum("ijk,jk->ik", matrices, vectors)
    return product
