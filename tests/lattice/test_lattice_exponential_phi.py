"""phi functions against mpmath, and weights against polynomials."""

import mpmath
import numpy as np
import pytest

from longwave.lattice.spectral.exponential import moment_weights, phi_functions


@pytest.mark.parametrize("z", [0j, 1e-9j, 1.9j, 2.0j, 2.1j, 13j, -1 + 1j, -30 + 0j])
def test_phi_against_mpmath(z: complex) -> None:
    context = mpmath.mp.clone()
    context.dps = 30
    for m, value in enumerate(phi_functions(np.array([z]), 5)):
        exact = complex(context.hyp1f1(1, m + 1, context.mpc(z)) / context.factorial(m))
        assert abs(value[0] - exact) < 1e-14 * abs(exact)


def test_weights_are_exact_for_polynomials() -> None:
    nodes = np.array([1.0, 0.0, -0.5, -2.0])
    weights = moment_weights(np.array([0.0 + 0j]), nodes)[:, 0]
    for degree in range(4):
        assert abs(weights @ nodes**degree - 1 / (degree + 1)) < 1e-13
