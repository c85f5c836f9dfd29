"""EWA splatting (Zwicker et al. 2001) of Gaussians, as in Kerbl et al. 2023, in float64."""

from __future__ import annotations

import math

import numpy as np

from fsel.core.compiled import inlined, reordered, reordered_part
from fsel.reconstruct.gaussians.parameters import COLOR, LOGIT, MOST, basis

LOW_PASS = 0.3  # pixels^2 added to the projected variances
LEAST_ALPHA = 1 / 255  # below it a Gaussian adds nothing to a pixel
FAINTEST = math.log(LEAST_ALPHA)
BEYOND = 0.3  # half fields of view past the edge where the linearised projection stays as it is

# columns of a projected Gaussian: the pixel, the exponent's three coefficients and its value in
# the middle, the colour, twice the exponent's range, half the extents, mixed over vertical term
U, V, XX, XY, YY, PEAK, RED, RANGE, HALF_X, HALF_Y, LEAN = 0, 1, 2, 3, 4, 5, 6, 9, 10, 11, 12
COLUMNS = 16  # one cache line of float32


@reordered
def project(table, degree, factor, lens, rows, source):
    """Project the visible Gaussians; return how many they are, and their (n,) float32 depths.

    Args:
        table: (n, c) parameters, see `table`.
        degree: of the harmonics in use.
        factor: (n,) factors of the opacities; zero hides a Gaussian.
        lens: a camera's 22 numbers: pose rows (12), centre (3), fx, fy, cx, cy, width, height,
            nearest depth. A tuple: an array would keep loops from being vectorised.
        rows: (n, COLUMNS), filled for the visible ones.
        source: (n,) int32, filled with their rows of `table`.
    """
    depth = np.empty(len(table), np.float32)
    width, height, near = lens[19], lens[20], lens[21]
    count = 0
    for i in range(len(table)):
        point = float(table[i, 0]), float(table[i, 1]), float(table[i, 2])
        x, y, z = seen(point, lens)
        if z < near or factor[i] <= 0:
            continue
        opacity = factor[i] / (1 + math.exp(-table[i, LOGIT]))
        if opacity <= LEAST_ALPHA:
            continue
        r = rotation(
            (float(table[i, 6]), float(table[i, 7]), float(table[i, 8]), float(table[i, 9]))
        )[0]
        sizes = math.exp(table[i, 3]), math.exp(table[i, 4]), math.exp(table[i, 5])
        a, b, c = flattened(lens, x, y, z, r, sizes)[0]
        spread = 2 * math.log(opacity / LEAST_ALPHA)
        u, v = lens[15] * x / z + lens[17], lens[16] * y / z + lens[18]
        half_x, half_y = math.sqrt(spread * a), math.sqrt(spread * c)
        if u + half_x < 0.5 or u - half_x > width - 0.5:
            continue
        if v + half_y < 0.5 or v - half_y > height - 0.5:
            continue
        rows[count, U], rows[count, V], rows[count, RANGE] = u, v, spread
        rows[count, PEAK] = 0.5 * spread + FAINTEST
        rows[count, HALF_X], rows[count, HALF_Y], rows[count, LEAN] = half_x, half_y, b / a
        inverse = 1 / (a * c - b * b)
        rows[count, XX], rows[count, YY] = -0.5 * c * inverse, -0.5 * a * inverse
        rows[count, XY] = b * inverse
        source[count], depth[count] = i, z
        count += 1
    _shade(table, degree, lens, rows, source[:count])
    return count, depth


@inlined
def seen(point, lens):
    """Return a position in the camera's axes."""
    x, y, z = point
    return (
        lens[0] * x + lens[1] * y + lens[2] * z + lens[3],
        lens[4] * x + lens[5] * y + lens[6] * z + lens[7],
        lens[8] * x + lens[9] * y + lens[10] * z + lens[11],
    )


@inlined
def rotation(turn):
    """Return a quaternion's matrix, row by row, the unit quaternion, and one over its length."""
    w, x, y, z = turn
    scale = 1 / math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w * scale, x * scale, y * scale, z * scale
    matrix = (
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    )  # fmt: skip
    return matrix, (w, x, y, z), scale


@inlined
def tilts(lens, x, y, z):
    """Keep x / z and y / z in the widened field of view, where the projection is linearised."""
    fx, fy, cx, cy = lens[15], lens[16], lens[17], lens[18]
    width, height = lens[19], lens[20]
    aside_x, aside_y = BEYOND * width / (2 * fx), BEYOND * height / (2 * fy)
    tilt_x = min(max(x / z, -cx / fx - aside_x), (width - cx) / fx + aside_x)
    tilt_y = min(max(y / z, -cy / fy - aside_y), (height - cy) / fy + aside_y)
    return tilt_x, tilt_y


@inlined
def flattened(lens, x, y, z, r, sizes):
    """Return the covariance a, b, c on the image, and the two 2x3 matrices behind it, of a `lens`
    of `numbers`, (9,) rotation r and deviations `sizes`."""
    tilt_x, tilt_y = tilts(lens, x, y, z)
    j, k = lens[15] / z, lens[16] / z
    # the projection's derivative in the world's axes, 2x3
    m = (
        j * (lens[0] - tilt_x * lens[8]), j * (lens[1] - tilt_x * lens[9]),
        j * (lens[2] - tilt_x * lens[10]), k * (lens[4] - tilt_y * lens[8]),
        k * (lens[5] - tilt_y * lens[9]), k * (lens[6] - tilt_y * lens[10]),
    )  # fmt: skip
    sx, sy, sz = sizes
    # times the Gaussian's axes, each as long as its standard deviation
    t = (
        sx * (m[0] * r[0] + m[1] * r[3] + m[2] * r[6]),
        sy * (m[0] * r[1] + m[1] * r[4] + m[2] * r[7]),
        sz * (m[0] * r[2] + m[1] * r[5] + m[2] * r[8]),
        sx * (m[3] * r[0] + m[4] * r[3] + m[5] * r[6]),
        sy * (m[3] * r[1] + m[4] * r[4] + m[5] * r[7]),
        sz * (m[3] * r[2] + m[4] * r[5] + m[5] * r[8]),
    )
    a = t[0] * t[0] + t[1] * t[1] + t[2] * t[2] + LOW_PASS
    b = t[0] * t[3] + t[1] * t[4] + t[2] * t[5]
    c = t[3] * t[3] + t[4] * t[4] + t[5] * t[5] + LOW_PASS
    return (a, b, c), m, t


@inlined
def direction(point, lens):
    """Return the unit vector from the camera to the Gaussian, and one over the distance."""
    x, y, z = point[0] - lens[12], point[1] - lens[13], point[2] - lens[14]
    inverse = 1 / math.sqrt(max(x * x + y * y + z * z, 1e-30))
    return x * inverse, y * inverse, z * inverse, inverse


@reordered_part
def _shade(table, degree, lens, rows, source):
    """Fill the colours of the projected Gaussians, seen from the camera."""
    values = np.empty(MOST)
    for n in range(len(source)):
        i = source[n]
        point = float(table[i, 0]), float(table[i, 1]), float(table[i, 2])
        x, y, z, _ = direction(point, lens)
        basis(degree, x, y, z, values)
        red, green, blue = 0.5, 0.5, 0.5
        for k in range((degree + 1) * (degree + 1)):
            red += values[k] * table[i, COLOR + 3 * k]
            green += values[k] * table[i, COLOR + 3 * k + 1]
            blue += values[k] * table[i, COLOR + 3 * k + 2]
        rows[n, RED], rows[n, RED + 1] = max(red, 0.0), max(green, 0.0)
        rows[n, RED + 2] = max(blue, 0.0)
