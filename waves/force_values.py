"""Values of a force and its derivatives in double precision, for the solvers' approximations."""

from __future__ import annotations

import math

import numpy as np
from flint import acb, arb
from numpy.typing import NDArray

from longwave.waves.kernel.force_text import Force

Vector = NDArray[np.float64]


def taylor_coefficients(force: Force, r: Vector, terms: int) -> Vector:
    """Return Taylor coefficients of a force at the strains ``r``; shape (terms, len(r)).

    >>> from longwave.waves.kernel.force_text import read_force
    >>> taylor_coefficients(read_force("r + r**3"), np.array([0.0, 2.0]), 2).tolist()
    [[0.0, 10.0], [1.0, 13.0]]
    """
    if force.polynomial is not None:
        law = np.polynomial.Polynomial([float(arb(c)) for c in force.polynomial] or [0.0])
        return np.array([law.deriv(i)(r) / math.factorial(i) for i in range(terms)])
    jets = [force.taylor(acb(float(x)), terms) for x in r]
    return np.array([[float(c.real) for c in jet] for jet in jets]).T
