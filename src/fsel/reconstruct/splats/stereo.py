"""Plane-sweep stereo: the matching cost of a pair of frames, and depth from several pairs.

Planes are uniform in inverse depth. Pair costs are uint8, sums of them int16: half the memory and
twice the lanes of float32.
"""

from __future__ import annotations

import cv2
import numpy as np

from fsel.core.compiled import exact, exact_part

F, S, INT = np.float32, np.int16, np.int32
U = np.uint64

MOST_PLANES = 128  # whose costs, at most 510 each, stay within uint16
OUTSIDE = F(150)  # cost, of 255, where the source frame does not see the point
CONFIDENCE_OFFSET = F(8)  # keeps the confidence of a flat, all-matching pixel near zero


def packed(image):
    """Return (2h, 2w) uint64 of an (h, w, 3) float32 image of whole grey levels at twice its size,
    its three colours 16 exact bits each."""
    levels = np.rint(16 * cv2.resize(image, None, fx=2, fy=2)).astype(np.uint64)
    return levels[..., 0] | levels[..., 1] << U(16) | levels[..., 2] << U(32)


def pair_cost(reference, enlarged, rays, rotation, translation, k, inverse, truncation):
    """Return (h, w, D) uint8 matching costs of an ordered pair of frames; 255 is the truncation.

    Args:
        reference: (h, w, 3) float32 image, grey levels 0..255.
        enlarged: (2h, 2w) uint64, the source image as `packed`, read at the nearest pixel.
        rays: (2, h, w) float32, x/z and y/z of the reference's pixels.
        rotation: (3, 3) float32, reference camera to source camera.
        translation: (3,) float32, world units.
        k: (4,) float32, fx, fy, cx, cy of the source at its own size, pixels.
        inverse: (D,) float32 inverse depths, ascending.
        truncation: mean absolute difference, grey levels, that saturates the cost.
    """
    height, width = reference.shape[:2]
    cost = np.empty((height, width, len(inverse)), np.uint8)
    pose = rotation, translation, k, inverse
    flat = enlarged.ravel(), cost.reshape(height, -1)
    _match_rows(reference, rays, *pose, enlarged.shape, truncation, *flat)
    return cost


@exact
def _match_rows(reference, rays, rotation, translation, k, inverse, shape, truncation, flat, cost):
    """Fill the costs of a pair, (h, w * D)."""
    index, levels = np.empty(cost.shape[1], INT), np.empty(cost.shape[1], U)
    # row by row in three loops: only the middle one, which gathers, does not vectorise
    for y in range(len(cost)):
        _project(rays, y, rotation, translation, k, inverse, shape, index)
        for n in range(len(index)):
            levels[n] = flat[np.uint32(max(index[n], INT(0)))]
        _match(reference[y], levels, index, truncation, cost[y])


@exact_part
def _project(rays, y, rotation, translation, k, inverse, shape, index):
    """Fill the flat pixels of a source image that a row's pixels fall on at each plane, or -1."""
    fx, fy, cx, cy = F(2) * k[0], F(2) * k[1], F(2) * k[2], F(2) * k[3]
    bx = fx * translation[0] + cx * translation[2]
    by = fy * translation[1] + cy * translation[2]
    bz = translation[2]
    limit_x, limit_y, row_length = F(shape[1]), F(shape[0]), INT(shape[1])
    planes = U(len(inverse))
    for x in range(rays.shape[2]):
        rx, ry = rays[0, y, x], rays[1, y, x]
        px = rotation[0, 0] * rx + rotation[0, 1] * ry + rotation[0, 2]
        py = rotation[1, 0] * rx + rotation[1, 1] * ry + rotation[1, 2]
        pz = rotation[2, 0] * rx + rotation[2, 1] * ry + rotation[2, 2]
        ax, ay = fx * px + cx * pz, fy * py + cy * pz
        first = U(x) * planes
        for d in range(planes):
            z = pz + inverse[d] * bz
            w = F(1) / max(z, F(1e-9))
            u = (ax + inverse[d] * bx) * w
            v = (ay + inverse[d] * by) * w
            inside = (z > F(1e-6)) & (u >= F(0)) & (v >= F(0)) & (u < limit_x) & (v < limit_y)
            column = INT(min(max(u, F(0)), limit_x - F(1)))
            row = INT(min(max(v, F(0)), limit_y - F(1)))
            index[first + d] = row * row_length + column if inside else INT(-1)


@exact_part
def _match(reference, levels, index, truncation, cost):
    """Fill the costs of a row of pixels, whose planes see the given levels of the source."""
    scale = F(255.0) / (F(3 * 16) * truncation)
    planes = U(len(levels) // len(reference))
    for x in range(len(reference)):
        red = INT(F(16) * reference[x, 0])
        green = INT(F(16) * reference[x, 1])
        blue = INT(F(16) * reference[x, 2])
        for n in range(U(x) * planes, U(x + 1) * planes):
            at = levels[n]
            gap = abs(INT(at & U(0xFFFF)) - red) + abs(INT(at >> U(16) & U(0xFFFF)) - green)
            value = min(F(gap + abs(INT(at >> U(32)) - blue)) * scale, F(255))
            cost[n] = np.uint8(INT(value if index[n] >= 0 else OUTSIDE))


def box_filter(cost):
    """Return (h, w, D) uint8 3x3 means over pixels, borders repeated, rounded down."""
    out, rows = np.empty_like(cost), np.empty((cost.shape[1] + 2, cost.shape[2]), np.uint16)
    _box_filter(cost, rows, out)
    return out


@exact
def _box_filter(cost, rows, out):
    height, width, planes = cost.shape
    for y in range(height):
        up, down = max(y - 1, 0), min(y + 1, height - 1)
        for x in range(width):
            for d in range(planes):
                total = np.uint16(cost[up, x, d]) + np.uint16(cost[y, x, d])
                rows[x + 1, d] = np.uint16(total + np.uint16(cost[down, x, d]))
        for d in range(planes):
            rows[0, d], rows[width + 1, d] = rows[1, d], rows[width, d]
        for x in range(width):
            for d in range(planes):
                total = (
                    np.uint32(rows[x, d]) + np.uint32(rows[x + 1, d]) + np.uint32(rows[x + 2, d])
                )
                # 7282 / 65536 is a ninth, exact for sums up to 9 * 255
                out[y, x, d] = np.uint8(np.uint32(total * np.uint32(7282)) >> np.uint32(16))


def merge_costs(costs, count):
    """Return (h, w, D) int16 twice the mean, rounded down, of the better half of the first `count`
    of four uint8 costs, which tolerates occlusion."""
    out = np.empty(costs[0].shape, S)
    _merge_costs(*costs, count, out)
    return out


@exact
def _merge_costs(first, second, third, fourth, count, out):
    height, width, planes = out.shape
    for y in range(height):
        for x in range(width):
            if count == 1:
                for d in range(planes):
                    out[y, x, d] = S(2) * S(first[y, x, d])
            elif count == 2:
                for d in range(planes):
                    p, q = S(first[y, x, d]), S(second[y, x, d])
                    out[y, x, d] = S(min(p, q) + (S(p + q) >> 1))
            elif count == 3:
                for d in range(planes):
                    p, q, r = S(first[y, x, d]), S(second[y, x, d]), S(third[y, x, d])
                    out[y, x, d] = S(p + q + r - max(p, max(q, r)))
            else:
                for d in range(planes):
                    p, q = S(first[y, x, d]), S(second[y, x, d])
                    r, s = S(third[y, x, d]), S(fourth[y, x, d])
                    low, other = min(p, q), min(r, s)
                    runner_up = min(max(low, other), min(max(p, q), max(r, s)))
                    out[y, x, d] = S(min(low, other) + runner_up)


def aggregate(cost, grey, small, large):
    """Return (h, w, D) int16 costs aggregated along four axes (SGM, Hirschmueller, PAMI 2008).

    Args:
        cost: (h, w, D) int16, 0..510.
        grey: (h, w) float32, 0..255; jumps are cheaper across its edges.
        small: penalty of a change by one plane, int16.
        large: penalty of a jump on a flat image, float32; up to 7600 four paths of a cost stay
            within int16.
    """
    height, width, _ = cost.shape
    total, (across, down) = np.zeros_like(cost), np.empty((2, height, width), S)
    _fill_jumps(grey, small, large, across, down)
    for forward in (True, False):
        for jumps, lines, steps, apart, stride in (
            (across, height, width, width, 1),
            (down, width, height, 1, width),
        ):
            flat = cost.ravel(), jumps.ravel(), total.ravel()
            _sweep(*flat, lines, steps, apart, stride, forward, small)
    return total


@exact
def _sweep(costs, jumps, total, lines, steps, apart, stride, forward, small):
    """Add the paths along one axis, in one direction, to the flat sums.

    `jumps` are flat penalties between a pixel and the one before it on its line. Pixels of one line
    lie a `stride` apart, and the lines' first ones so far `apart`.
    """
    # all lines advance together: their steps do not wait for each other. Every sum is cut back to
    # int16 at once, or the loop would not vectorise
    planes = U(len(costs) // len(jumps))
    room = planes + U(2)
    size = lines * int(room)
    old, new, lows = np.empty(size, S), np.empty(size, S), np.empty(lines, S)
    for n in range(size):
        old[n] = new[n] = S(20000)
    for line in range(lines):
        lows[line] = 0
        for d in range(planes):
            old[U(line) * room + d + U(1)] = 0
    for step in range(steps):
        at = step if forward else steps - 1 - step
        edge = at if forward or step == 0 else at + 1
        for line in range(lines):
            jump = jumps[U(line * apart + edge * stride)]
            first = U(line * apart + at * stride) * planes
            before = U(line) * room
            low, lowest = lows[line], S(20000)
            for d in range(planes):
                near = S(min(old[before + d], old[before + d + U(2)]) + small)
                least = min(S(min(old[before + d + U(1)], near) - low), jump)
                reached = S(costs[first + d] + least)
                new[before + d + U(1)] = reached
                lowest = min(lowest, reached)
                total[first + d] = S(total[first + d] + reached)
            lows[line] = lowest
        old, new = new, old


@exact
def _fill_jumps(grey, small, large, across, down):
    """Fill (h, w) int16 penalties of jumps from the pixel before, in rows and in columns."""
    height, width = grey.shape
    least = F(small) + F(1)
    for y in range(height):
        for x in range(width):
            edge = abs(grey[y, x] - grey[y, max(x - 1, 0)])
            penalty = max(least, large / (F(1) + F(0.1) * edge))
            across[y, x] = S(INT(np.rint(penalty))) if x > 0 else S(0)
            edge = abs(grey[y, x] - grey[max(y - 1, 0), x])
            penalty = max(least, large / (F(1) + F(0.1) * edge))
            down[y, x] = S(INT(np.rint(penalty))) if y > 0 else S(0)


def winner(total, cost, inverse):
    """Return (h, w) float32 inverse depths, and confidences 0..1: near zero where planes are alike.

    The least (h, w, D) int16 aggregated cost wins, with a parabola through it; confidence is by the
    matching cost.
    """
    depth, sure = np.empty((2, *total.shape[:2]), F)
    _win(total.ravel(), cost.ravel(), inverse, depth.ravel(), sure.ravel())
    return depth, sure


@exact
def _win(sums, costs, inverse, depth, sure):
    size, planes = len(depth), len(inverse)
    each = U(planes)
    keys, summed = np.empty(size, INT), np.empty(size, np.uint16)
    for p in range(size):
        # a plane's cost and its number in one integer: the least of them is the first minimum
        key, whole = INT(1 << 30), np.uint16(0)
        for d in range(each):
            n = U(p) * each + d
            key = min(key, INT(sums[n]) * INT(MOST_PLANES) + INT(d))
            whole = np.uint16(whole + np.uint16(costs[n]))  # of MOST_PLANES at most
        keys[p], summed[p] = key, whole
    step = (inverse[planes - 1] - inverse[0]) / F(max(planes - 1, 1))
    for p in range(size):
        first, best, low = U(p) * each, keys[p] % INT(MOST_PLANES), keys[p] // INT(MOST_PLANES)
        left = F(sums[first + U(max(best - 1, 0))])
        right = F(sums[first + U(min(best + 1, planes - 1))])
        curve = left + right - F(2) * F(low)
        offset = F(0.5) * (left - right) / curve if curve > 0 else F(0)
        offset = offset if 0 < best < planes - 1 else F(0)
        depth[p] = inverse[best] + offset * step
        mean = F(summed[p]) / F(planes)
        sure[p] = max(F(0), (mean - F(costs[first + U(best)])) / (mean + CONFIDENCE_OFFSET))
