"""Linear algebra for the few fields of a cell, over any field of exact elements."""

from collections.abc import Sequence
from typing import Any

Column = list[Any]
Matrix = Sequence[Column]


def determinant(matrix: Matrix) -> Any:
    """Return the determinant, expanded along the first row."""
    if len(matrix) == 1:
        return matrix[0][0]
    total = matrix[0][0].field.zero
    for j, value in enumerate(matrix[0]):
        if value:
            minor = determinant([[*row[:j], *row[j + 1 :]] for row in matrix[1:]])
            total = total + value * minor * (-1) ** j
    return total


def inverse(matrix: Matrix) -> list[Column]:
    """Return the inverse, by cofactors; the determinant must be nonzero."""
    full_determinant, count = determinant(matrix), len(matrix)
    if count == 1:
        return [[1 / full_determinant]]

    def cofactor(i: int, j: int) -> Any:
        return determinant(without(matrix, i, j)) * (-1) ** (i + j)

    return [[cofactor(i, j) / full_determinant for i in range(count)] for j in range(count)]


def without(matrix: Matrix, row: int | None, column: int | None) -> list[Column]:
    """Return the matrix without one row and one column; None removes nothing."""
    return [[v for j, v in enumerate(r) if j != column] for i, r in enumerate(matrix) if i != row]


def null_space(matrix: Matrix) -> list[Column]:
    """Return a basis of the null space; each vector's first nonzero entry is 1.

    >>> from sympy import Symbol
    >>> from longwave.derive.algebra.rational_functions import RationalFunctions
    >>> k = RationalFunctions((Symbol("k"),))(Symbol("k"))
    >>> null_space([[k, -k], [-k, k]])
    [[1, 1]]
    """
    count, field = len(matrix), matrix[0][0].field
    rows = [[*row] for row in matrix]
    pivots: list[int] = []
    for column in range(count):
        row_index = next((i for i in range(len(pivots), count) if rows[i][column]), None)
        if row_index is None:
            continue
        top = len(pivots)
        rows[top], rows[row_index] = rows[row_index], rows[top]
        rows[top] = [value / rows[top][column] for value in rows[top]]
        for i in range(count):
            if i != top and rows[i][column]:
                factor = rows[i][column]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[top], strict=True)]
        pivots.append(column)
    basis = []
    for free in (j for j in range(count) if j not in pivots):
        vector = [field.zero] * count
        vector[free] = field.one
        for row, pivot in zip(rows, pivots, strict=False):
            vector[pivot] = -row[free]
        first = next(value for value in vector if value)
        basis.append([value / first for value in vector])
    return basis


def transposed(matrix: Matrix) -> list[Column]:
    """Return the transposed matrix."""
    return [list(column) for column in zip(*matrix, strict=True)]


def combined(weights: Column, rows: Sequence[Any], nothing: Any) -> Any:
    """Return the sum of rows times weights; ``nothing`` is the zero of the rows' type."""
    pairs = zip(weights, rows, strict=True)
    return sum((weight * row for weight, row in pairs if weight and row), nothing)
