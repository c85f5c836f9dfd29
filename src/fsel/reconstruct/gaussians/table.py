"""The layout of the trained parameters, and how the kernels are compiled.

All parameters of a scene are one (n, 11 + 3 (degree + 1)^2) array, a row a Gaussian, so that a step
touches the rows of the visible ones only. The kernels work on float32 and on float64 arrays alike:
training uses float32, the tests compare float64 with automatic differentiation.
"""

from __future__ import annotations

import numpy as np

MEAN = slice(0, 3)  # position in the normalised frame
SCALE = slice(3, 6)  # logarithms of the standard deviations along the three axes
TURN = slice(6, 10)  # quaternion w, x, y, z, of any length but zero
LOGIT = 10  # of the opacity
COLOR = 11  # first of the harmonics' coefficients: (count, 3), all three channels of one together


def width_of(degree: int) -> int:
    """Columns of the table of harmonics to a degree."""
    return COLOR + 3 * (degree + 1) ** 2


def degree_of(table: np.ndarray) -> int:
    """Degree of the harmonics that a table holds."""
    return round(((table.shape[1] - COLOR) / 3) ** 0.5) - 1
