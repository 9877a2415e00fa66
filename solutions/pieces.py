"""Evaluation of many points in pieces: bounded memory, and less work where nothing changes."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

PIECE = 65_536
"""Number of points evaluated at once, so that rows and work arrays take a few megabytes."""

SAMPLED_POINTS = np.unique(
    np.append(np.arange(64) * 0.6180339887498949 % 1.0 * PIECE, PIECE - 1).astype(int)
)
"""Indices of irregularly spaced points in a piece, whose rows are compared."""

NEGLIGIBLE_CHANGE = 1e-20
"""Largest change between sampled points that counts as none, relative to ``units``."""


def in_pieces(
    rows: Callable[..., Array],
    points: tuple[Array, ...],
    is_far: Callable[..., bool],
    units: ArrayLike,
) -> Array:
    """Compute ``rows(*points)``, of shape (rows, *shape of the points), piece by piece.

    A piece is filled with constant rows if ``is_far(*its points)`` and the rows at sampled points
    agree to a tiny fraction of ``units``, the magnitude of each row elsewhere.

    >>> step = lambda x: np.stack([np.tanh(x), 1.0 / np.cosh(np.clip(x, -300.0, 300.0)) ** 2])
    >>> x = np.arange(4.0 * PIECE) - PIECE
    >>> result = in_pieces(step, (x,), lambda x: abs(x).min() > 60.0, [1.0, 1.0])
    >>> float(abs(result - step(x)).max()) < 1e-20
    True
    """
    if points[0].size < PIECE:
        return rows(*points)
    flat = [axis.reshape(-1) for axis in points]
    result = np.empty((0, 0))
    for start in range(0, flat[0].size, PIECE):
        piece = [axis[start : start + PIECE] for axis in flat]
        constant_rows = _constant_rows(rows, piece, np.asarray(units)) if is_far(*piece) else None
        piece_rows = rows(*piece) if constant_rows is None else constant_rows
        if not result.size:
            result = np.empty((len(piece_rows), flat[0].size), piece_rows.dtype)
        result[:, start : start + PIECE] = piece_rows
    return result.reshape(-1, *points[0].shape)


def _constant_rows(rows: Callable[..., Array], piece: list[Array], units: Array) -> Array | None:
    """Return the rows (rows, 1) common to all sampled points of a piece; None if they differ."""
    if piece[0].size < PIECE:
        return None
    sampled = rows(*(axis[SAMPLED_POINTS] for axis in piece))
    changes = np.abs(sampled - sampled[:, :1]).max(axis=1)
    return sampled[:, :1] if np.all(changes <= NEGLIGIBLE_CHANGE * units) else None
