"""Gaussians onto the image plane and the gradients back: EWA splatting (Zwicker et al. 2001) as in
Kerbl et al. 2023. Scalar arithmetic is float64; only what is stored has the arrays' type.
"""

from __future__ import annotations

import math

import numpy as np

from fsel.reconstruct.gaussians.harmonics import basis, slope
from fsel.reconstruct.gaussians.table import COLOR, LOGIT, inlined, jit

LOW_PASS = 0.3  # pixels^2 added to the projected variances
LEAST_ALPHA = 1 / 255  # below it a Gaussian adds nothing to a pixel
FAINTEST = math.log(LEAST_ALPHA)
BEYOND = 0.3  # half fields of view past the edge where the linearised projection stays as it is

# columns of a projected Gaussian: the pixel, the exponent's three coefficients and its value in
# the middle, the colour, twice the exponent's range, half the extents, mixed over vertical term
U, V, XX, XY, YY, PEAK, RED, RANGE, HALF_X, HALF_Y, LEAN = 0, 1, 2, 3, 4, 5, 6, 9, 10, 11, 12
COLUMNS = 16  # one cache line of float32


@jit
def project(table, degree, factor, camera, rows, source):
    """Project the Gaussians that a camera sees.

    Args:
        table: (n, c) parameters, see `table`.
        degree: of the harmonics in use.
        factor: (n,) factors of the opacities; zero hides a Gaussian.
        camera: (22,) float64 pose rows (12), centre (3), fx, fy, cx, cy, width, height, nearest
            depth.
        rows: (n, COLUMNS), filled for the visible ones.
        source: (n,) int32, filled with their rows of `table`.

    Returns:
        How many are visible, and their depths (n,) float32.
    """
    depth = np.empty(len(table), np.float32)
    values = np.empty(16)
    width, height, near = camera[19], camera[20], camera[21]
    count = 0
    for i in range(len(table)):
        x, y, z = _seen(table, i, camera)
        if z < near or factor[i] <= 0:
            continue
        opacity = factor[i] / (1 + math.exp(-table[i, LOGIT]))
        if opacity <= LEAST_ALPHA:
            continue
        a, b, c = _flattened(table, i, camera, x, y, z)[0]
        spread = 2 * math.log(opacity / LEAST_ALPHA)
        u, v = camera[15] * x / z + camera[17], camera[16] * y / z + camera[18]
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
        _shade(table, i, degree, camera, values, rows, count)
        source[count], depth[count] = i, z
        count += 1
    return count, depth


@inlined
def _seen(table, i, camera):
    x, y, z = float(table[i, 0]), float(table[i, 1]), float(table[i, 2])
    return (
        camera[0] * x + camera[1] * y + camera[2] * z + camera[3],
        camera[4] * x + camera[5] * y + camera[6] * z + camera[7],
        camera[8] * x + camera[9] * y + camera[10] * z + camera[11],
    )


@inlined
def _rotation(table, i):
    """Matrix of row i's quaternion, row by row, the unit quaternion, and one over its length."""
    w, x, y, z = float(table[i, 6]), float(table[i, 7]), float(table[i, 8]), float(table[i, 9])
    scale = 1 / math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w * scale, x * scale, y * scale, z * scale
    matrix = (
        *(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        *(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        *(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return matrix, (w, x, y, z), scale


@inlined
def _tilts(camera, x, y, z):
    """x / z and y / z kept within the widened field of view, where the projection is linearised."""
    fx, fy, cx, cy = camera[15], camera[16], camera[17], camera[18]
    width, height = camera[19], camera[20]
    aside_x, aside_y = BEYOND * width / (2 * fx), BEYOND * height / (2 * fy)
    tilt_x = min(max(x / z, -cx / fx - aside_x), (width - cx) / fx + aside_x)
    tilt_y = min(max(y / z, -cy / fy - aside_y), (height - cy) / fy + aside_y)
    return tilt_x, tilt_y


@inlined
def _flattened(table, i, camera, x, y, z):
    """Covariance a, b, c on the image, and what the gradients need of how it came about."""
    tilt_x, tilt_y = _tilts(camera, x, y, z)
    j, k = camera[15] / z, camera[16] / z
    # the projection's derivative in the world's axes, 2x3
    m = (
        *(j * (camera[0] - tilt_x * camera[8]), j * (camera[1] - tilt_x * camera[9])),
        *(j * (camera[2] - tilt_x * camera[10]), k * (camera[4] - tilt_y * camera[8])),
        *(k * (camera[5] - tilt_y * camera[9]), k * (camera[6] - tilt_y * camera[10])),
    )
    r = _rotation(table, i)[0]
    sx, sy, sz = math.exp(table[i, 3]), math.exp(table[i, 4]), math.exp(table[i, 5])
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
    return (a, b, c), m, t, (sx, sy, sz)


@inlined
def _direction(table, i, camera):
    """Unit vector from the camera to the Gaussian, and one over the distance."""
    x, y, z = table[i, 0] - camera[12], table[i, 1] - camera[13], table[i, 2] - camera[14]
    inverse = 1 / math.sqrt(max(x * x + y * y + z * z, 1e-30))
    return x * inverse, y * inverse, z * inverse, inverse


@inlined
def _shade(table, i, degree, camera, values, rows, n):
    x, y, z, _ = _direction(table, i, camera)
    basis(degree, x, y, z, values)
    red, green, blue = 0.5, 0.5, 0.5
    for k in range((degree + 1) * (degree + 1)):
        red += values[k] * table[i, COLOR + 3 * k]
        green += values[k] * table[i, COLOR + 3 * k + 1]
        blue += values[k] * table[i, COLOR + 3 * k + 2]
    rows[n, RED], rows[n, RED + 1] = max(red, 0.0), max(green, 0.0)
    rows[n, RED + 2] = max(blue, 0.0)


@jit
def backward(table, degree, camera, rows, source, pulls, grad):
    """Add the gradients of the projected Gaussians to those of the parameters.

    Args:
        table, degree, camera: as in `project`.
        rows: (v, COLUMNS) projected Gaussians.
        source: (v,) int32 their rows of `table`.
        pulls: (v, 9) as `rasterize.backward` fills them: gradients with respect to the colour;
            sums over the pixels of the gradient g with respect to the exponent, and of g dx, g dy,
            g dx dx, g dx dy, g dy dy, with dx and dy from the Gaussian to the pixel.
        grad: like `table`, added to.
    """
    values, weights = np.empty(16), np.empty(16)
    for n in range(len(rows)):
        i = source[n]
        _shade_back(table, i, degree, camera, rows, n, pulls, values, weights, grad)
        grad[i, LOGIT] += pulls[n, 3] / (1 + math.exp(table[i, LOGIT]))
        x, y, z = _seen(table, i, camera)
        # the inverse covariance
        a, b, c = -2.0 * rows[n, XX], -1.0 * rows[n, XY], -2.0 * rows[n, YY]
        du, dv = a * pulls[n, 4] + b * pulls[n, 5], b * pulls[n, 4] + c * pulls[n, 5]
        # gradient with respect to the covariance: half of inverse, second moments, inverse
        p, q = a * pulls[n, 6] + b * pulls[n, 7], a * pulls[n, 7] + b * pulls[n, 8]
        r, s = b * pulls[n, 6] + c * pulls[n, 7], b * pulls[n, 7] + c * pulls[n, 8]
        ga, gb, gc = 0.5 * (p * a + q * b), 0.5 * (p * b + q * c), 0.5 * (r * b + s * c)
        dx, dy, dz = _flattened_back(table, i, camera, (x, y, z), (ga, gb, gc), grad)
        j, k = camera[15] / z, camera[16] / z
        dx, dy = dx + du * j, dy + dv * k
        dz -= (du * j * x + dv * k * y) / z
        grad[i, 0] += camera[0] * dx + camera[4] * dy + camera[8] * dz
        grad[i, 1] += camera[1] * dx + camera[5] * dy + camera[9] * dz
        grad[i, 2] += camera[2] * dx + camera[6] * dy + camera[10] * dz


@inlined
def _shade_back(table, i, degree, camera, rows, n, pulls, values, weights, grad):
    x, y, z, inverse = _direction(table, i, camera)
    basis(degree, x, y, z, values)
    red = pulls[n, 0] if rows[n, RED] > 0 else 0.0  # a colour below zero was cut, and does not move
    green = pulls[n, 1] if rows[n, RED + 1] > 0 else 0.0
    blue = pulls[n, 2] if rows[n, RED + 2] > 0 else 0.0
    for k in range((degree + 1) * (degree + 1)):
        at = COLOR + 3 * k
        weights[k] = red * table[i, at] + green * table[i, at + 1] + blue * table[i, at + 2]
        grad[i, at] += values[k] * red
        grad[i, at + 1] += values[k] * green
        grad[i, at + 2] += values[k] * blue
    if degree > 0:
        dx, dy, dz = slope(degree, x, y, z, weights)
        along = dx * x + dy * y + dz * z  # the length of the direction is always one
        grad[i, 0] += (dx - along * x) * inverse
        grad[i, 1] += (dy - along * y) * inverse
        grad[i, 2] += (dz - along * z) * inverse


@inlined
def _flattened_back(table, i, camera, point, pull, grad):
    """Gradients through the covariance: scales and rotation into `grad`, and the point's."""
    x, y, z = point
    ga, gb, gc = pull
    _, m, t, s = _flattened(table, i, camera, x, y, z)
    d = (
        *(2 * (ga * t[0] + gb * t[3]), 2 * (ga * t[1] + gb * t[4]), 2 * (ga * t[2] + gb * t[5])),
        *(2 * (gb * t[0] + gc * t[3]), 2 * (gb * t[1] + gc * t[4]), 2 * (gb * t[2] + gc * t[5])),
    )
    r, turn, shrink = _rotation(table, i)
    for axis in range(3):
        grad[i, 3 + axis] += t[axis] * d[axis] + t[3 + axis] * d[3 + axis]
    _rotation_back(m, d, s, turn, shrink, grad, i)
    first = (d[0] * s[0], d[1] * s[1], d[2] * s[2])
    second = (d[3] * s[0], d[4] * s[1], d[5] * s[2])
    # gradients with respect to the two rows of the projection's derivative, in the world's axes
    n = (
        first[0] * r[0] + first[1] * r[1] + first[2] * r[2],
        first[0] * r[3] + first[1] * r[4] + first[2] * r[5],
        first[0] * r[6] + first[1] * r[7] + first[2] * r[8],
        second[0] * r[0] + second[1] * r[1] + second[2] * r[2],
        second[0] * r[3] + second[1] * r[4] + second[2] * r[5],
        second[0] * r[6] + second[1] * r[7] + second[2] * r[8],
    )
    return _tilt_back(camera, x, y, z, m, n)


@inlined
def _tilt_back(camera, x, y, z, m, n):
    """Gradients of the point from those of the projection's derivative."""
    tilt_x, tilt_y = _tilts(camera, x, y, z)
    j, k = camera[15] / z, camera[16] / z
    pull_x = -j * (n[0] * camera[8] + n[1] * camera[9] + n[2] * camera[10])
    pull_y = -k * (n[3] * camera[8] + n[4] * camera[9] + n[5] * camera[10])
    # each row is proportional to one over the depth
    dz = -(n[0] * m[0] + n[1] * m[1] + n[2] * m[2] + n[3] * m[3] + n[4] * m[4] + n[5] * m[5]) / z
    dx, dy = 0.0, 0.0
    if tilt_x == x / z:
        dx = pull_x / z
        dz -= pull_x * tilt_x / z
    if tilt_y == y / z:
        dy = pull_y / z
        dz -= pull_y * tilt_y / z
    return dx, dy, dz


@inlined
def _rotation_back(m, d, s, turn, shrink, grad, i):
    """Gradient of the quaternion, through its matrix and its normalisation."""
    g = (
        *((m[0] * d[0] + m[3] * d[3]) * s[0], (m[0] * d[1] + m[3] * d[4]) * s[1]),
        *((m[0] * d[2] + m[3] * d[5]) * s[2], (m[1] * d[0] + m[4] * d[3]) * s[0]),
        *((m[1] * d[1] + m[4] * d[4]) * s[1], (m[1] * d[2] + m[4] * d[5]) * s[2]),
        *((m[2] * d[0] + m[5] * d[3]) * s[0], (m[2] * d[1] + m[5] * d[4]) * s[1]),
        (m[2] * d[2] + m[5] * d[5]) * s[2],
    )
    w, x, y, z = turn
    dw = 2 * (x * (g[7] - g[5]) + y * (g[2] - g[6]) + z * (g[3] - g[1]))
    dx = 2 * (y * (g[1] + g[3]) + z * (g[2] + g[6]) + w * (g[7] - g[5]) - 2 * x * (g[4] + g[8]))
    dy = 2 * (x * (g[1] + g[3]) + z * (g[5] + g[7]) + w * (g[2] - g[6]) - 2 * y * (g[0] + g[8]))
    dz = 2 * (x * (g[2] + g[6]) + y * (g[5] + g[7]) + w * (g[3] - g[1]) - 2 * z * (g[0] + g[4]))
    along = dw * w + dx * x + dy * y + dz * z
    grad[i, 6] += (dw - along * w) * shrink
    grad[i, 7] += (dx - along * x) * shrink
    grad[i, 8] += (dy - along * y) * shrink
    grad[i, 9] += (dz - along * z) * shrink
