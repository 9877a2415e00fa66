"""Settings shared by all tests: fixed seeds, no display, floating-point traps on."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "longwave",
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("longwave")


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers, the same in every run."""
    return np.random.default_rng(20260101)


@pytest.fixture(autouse=True)
def _floating_point_traps() -> Iterator[None]:
    """Overflow, division by zero and NaN raise in NumPy instead of passing silently."""
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        yield
