"""The trained parameters of Gaussians, and the spherical harmonics of their colours.

All parameters of a scene are one (n, 11 + 3 (degree + 1)^2) array, a row a Gaussian. The harmonics
have the signs and the order of Kerbl et al. 2023; training stops at degree two, `.ply` at three.
"""

from __future__ import annotations

import numpy as np

from fsel.core.compiled import reordered, reordered_part

MEAN = slice(0, 3)  # position in the normalised frame
SCALE = slice(3, 6)  # logarithms of the standard deviations along the three axes
TURN = slice(6, 10)  # quaternion w, x, y, z, of any length but zero
LOGIT = 10  # of the opacity
COLOR = 11  # first of the harmonics' coefficients: (count, 3), all three channels of one together


def width_of(degree: int) -> int:
    """Return the columns of the table of harmonics to a degree."""
    return COLOR + 3 * (degree + 1) ** 2


def degree_of(table: np.ndarray) -> int:
    """Return the degree of the harmonics that a table holds."""
    return round(((table.shape[1] - COLOR) / 3) ** 0.5) - 1


C0 = 0.28209479177387814  # sqrt(1 / (4 pi))
C1 = 0.4886025119029199  # sqrt(3 / (4 pi))
C2 = (1.0925484305920792, 0.31539156525252005, 0.5462742152960396)
C3 = (
    *(0.5900435899266435, 2.890611442640554, 0.4570457994644658),
    *(0.3731763325901154, 1.445305721320277),
)
MOST = 16  # harmonics to degree three


@reordered
def basis(degree, x, y, z, out):
    """Fill `out` (16,) with the (degree + 1)^2 harmonics of the unit direction x, y, z."""
    out[0] = C0
    if degree > 0:
        out[1], out[2], out[3] = -C1 * y, C1 * z, -C1 * x
    if degree > 1:
        xx, yy, zz = x * x, y * y, z * z
        out[4], out[5], out[7] = C2[0] * x * y, -C2[0] * y * z, -C2[0] * x * z
        out[6], out[8] = C2[1] * (2 * zz - xx - yy), C2[2] * (xx - yy)
        if degree > 2:
            out[9], out[10] = -C3[0] * y * (3 * xx - yy), C3[1] * x * y * z
            out[11] = -C3[2] * y * (4 * zz - xx - yy)
            out[12] = C3[3] * z * (2 * zz - 3 * xx - 3 * yy)
            out[13], out[14] = -C3[2] * x * (4 * zz - xx - yy), C3[4] * z * (xx - yy)
            out[15] = -C3[0] * x * (xx - 3 * yy)


@reordered_part
def slope(degree, x, y, z, w):
    """Return the gradient of `sum(w * basis)` with respect to x, y and z, to degree two."""
    dx, dy, dz = 0.0, 0.0, 0.0
    if degree > 0:
        dx, dy, dz = -C1 * w[3], -C1 * w[1], C1 * w[2]
    if degree > 1:
        dx += C2[0] * (y * w[4] - z * w[7]) + 2 * x * (C2[2] * w[8] - C2[1] * w[6])
        dy += C2[0] * (x * w[4] - z * w[5]) - 2 * y * (C2[2] * w[8] + C2[1] * w[6])
        dz += -C2[0] * (y * w[5] + x * w[7]) + 4 * C2[1] * z * w[6]
    return dx, dy, dz
