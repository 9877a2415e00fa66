"""Integrals from 0: what is too far away is refused."""

import numpy as np
import pytest

from longwave.solutions.quadrature import integral_from_zero


@pytest.mark.parametrize("width", [1e-9, 1e-18, 1e-300])
def test_points_that_are_too_many_panels_apart_are_refused(width: float) -> None:
    with pytest.raises(ValueError, match=r"^points must span at most"):
        integral_from_zero(np.cos, np.array([-7.0, 15.0]), width)
