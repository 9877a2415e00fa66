"""The error figure: the paper's relative sup norm over integer sites."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def relative_sup_error(numeric: Array, analytic: Array, background: Array) -> float:
    """max |analytic - numeric| / max |analytic - background| over the compared sites.

    All three are strains at the same integer sites. With the bare wave of the same phase as
    ``background`` this is the paper's eq. (16); with the wave's true far field it is the second
    figure for waves on periodic backgrounds. A sup over sites depends on where the crest falls
    between them: the paper's scenes have it on site 0.

    Raises ValueError if shapes differ, no site is compared, a value is not finite, or the wave is
    its own background.

    >>> relative_sup_error(np.array([1.0, 4.5]), np.array([1.0, 5.0]), np.array([1.0, 1.0]))
    0.125
    """
    if not numeric.shape == analytic.shape == background.shape:
        shapes = f"{numeric.shape}, {analytic.shape}, {background.shape}"
        raise ValueError(f"compared arrays must have one shape, got {shapes} (take the same sites)")
    if numeric.size == 0:
        raise ValueError("compared arrays must hold a site, got none (compare at least one)")
    deviation = float(np.max(np.abs(analytic - numeric)))
    amplitude = float(np.max(np.abs(analytic - background)))
    if not (np.isfinite(deviation) and np.isfinite(amplitude)):
        raise ValueError(
            "the compared strains must be finite, got NaN or infinity (did the run blow up?)"
        )
    if amplitude == 0.0:
        raise ValueError(
            "background must differ from the wave at some site, got the wave itself "
            "(a bare wave has no relative error)"
        )
    return deviation / amplitude
