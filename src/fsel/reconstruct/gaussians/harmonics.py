"""Real spherical harmonics to degree four, with the signs and the order of Kerbl et al. 2023.

Training and `.ply` files stop at degree two and three; published feed-forward models use four.
"""

from __future__ import annotations

from fsel.core.compiled import reordered

C0 = 0.28209479177387814  # sqrt(1 / (4 pi))
C1 = 0.4886025119029199  # sqrt(3 / (4 pi))
C2 = (1.0925484305920792, 0.31539156525252005, 0.5462742152960396)
C3 = (
    *(0.5900435899266435, 2.890611442640554, 0.4570457994644658),
    *(0.3731763325901154, 1.445305721320277),
)
C4 = (
    *(2.5033429417967046, 1.7701307697799304, 0.9461746957575601),
    *(0.6690465435572892, 0.10578554691520431, 0.47308734787878004, 0.6258357354491761),
)
MOST = 25  # harmonics to degree four


@reordered
def basis(degree, x, y, z, out):
    """Fill `out` (25,) with the (degree + 1)^2 harmonics of the unit direction x, y, z."""
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
        if degree > 3:
            out[16], out[17] = C4[0] * x * y * (xx - yy), -C4[1] * y * z * (3 * xx - yy)
            out[18], out[19] = C4[2] * x * y * (7 * zz - 1), -C4[3] * y * z * (7 * zz - 3)
            out[20] = C4[4] * (zz * (35 * zz - 30) + 3)
            out[21], out[22] = -C4[3] * x * z * (7 * zz - 3), C4[5] * (xx - yy) * (7 * zz - 1)
            out[23] = -C4[1] * x * z * (xx - 3 * yy)
            out[24] = C4[6] * (xx * (xx - 3 * yy) - yy * (3 * xx - yy))


@reordered
def slope(degree, x, y, z, w):
    """Gradient of `sum(w * basis)` with respect to x, y and z, to degree two: what is trained.

    Args:
        w: (9,) gradient with respect to each harmonic.
    """
    dx, dy, dz = 0.0, 0.0, 0.0
    if degree > 0:
        dx, dy, dz = -C1 * w[3], -C1 * w[1], C1 * w[2]
    if degree > 1:
        dx += C2[0] * (y * w[4] - z * w[7]) + 2 * x * (C2[2] * w[8] - C2[1] * w[6])
        dy += C2[0] * (x * w[4] - z * w[5]) - 2 * y * (C2[2] * w[8] + C2[1] * w[6])
        dz += -C2[0] * (y * w[5] + x * w[7]) + 4 * C2[1] * z * w[6]
    return dx, dy, dz
