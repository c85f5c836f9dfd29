"""A hierarchy of boxes around triangles, and the first triangle that each ray meets.

A ray library chooses its instructions by the processor, so that its last bits differ between
machines; here every operation rounds as it is written. Rays are followed eight at a time, which
pays where neighbours are close together, as those of an image are.

Sources: boxes split by the surface area heuristic over bins (I. Wald, On fast construction of
SAH-based bounding volume hierarchies, 2007); triangles by T. Möller and B. Trumbore, Fast, minimum
storage ray-triangle intersection, 1997.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fsel.core.compiled import exact, exact_part

BINS = 12
LEAF = 4  # triangles that are not split further
LANES = 8  # rays followed together
SLACK = np.float32(1 + 1e-6)  # a flat box must not hide the triangle in it by rounding
STEEPEST = np.float32(1e30)  # one over a direction's smallest part
# where a packet of rays has their origins, directions, one over these, how far they still reach,
# where they enter a box, and the triangles that they met
X, Y, Z, DX, DY, DZ, OX, OY, OZ, REACH, ENTRY, MET = range(0, 12 * LANES, LANES)


class Hierarchy(NamedTuple):
    """Boxes around boxes around triangles."""

    low: np.ndarray  # (n, 3) float32 least corners of the boxes; the first one holds all
    high: np.ndarray  # (n, 3) float32 greatest corners
    first: np.ndarray  # (n,) int32 the first of a box's two boxes in a row, or of its triangles
    filled: np.ndarray  # (n,) int32 number of its triangles, 0 where it holds boxes
    corners: np.ndarray  # (t, 9) float32 a corner of each triangle and the two edges from it
    numbers: np.ndarray  # (t,) int32 the triangles' numbers


def build(triangles: np.ndarray) -> Hierarchy:
    """Sort (t, 3, 3) float32 triangles into boxes."""
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    order, boxes, first, count = _split(low, high, (low + high) / 2)
    a, b, c = triangles[order].transpose(1, 0, 2)
    corners = np.hstack([a, b - a, c - a])
    n = len(first)
    return Hierarchy(boxes[:n, :3].copy(), boxes[:n, 3:].copy(), first, count, corners, order)


def first_hit(tree: Hierarchy, origins, rays) -> tuple[np.ndarray, np.ndarray]:
    """Return (n,) int32 triangles that (n, 3) float32 rays meet first, -1 for none, and (n,)
    float32 distances in ray lengths; of two at one distance the smaller number is met."""
    reach = np.full(len(rays), np.inf, np.float32)
    return _trace(*tree, origins, rays, reach, False), reach


def occluded(tree: Hierarchy, origins, rays, reach) -> np.ndarray:
    """Return (n,) bool: whether (n, 3) rays meet anything nearer than (n,) float32 distances."""
    return _trace(*tree, origins, rays, reach.copy(), True) >= 0


@exact
def _split(low, high, middle):
    """Triangles' order, and boxes (n, 6), (n,) first and (n,) count, as in `Hierarchy`."""
    total = len(low)
    order = np.arange(total).astype(np.int32)
    boxes = np.empty((2 * total, 6), np.float32)
    first, count = np.zeros(2 * total, np.int32), np.zeros(2 * total, np.int32)
    bins, filled, behind = np.empty((BINS, 6), np.float32), np.empty(BINS, np.int64), np.empty(BINS)
    first[0], count[0], used = 0, total, 1
    box = 0
    while box < used:  # boxes are split in the order in which they were made
        begin, end = first[box], first[box] + count[box]
        _empty(boxes[box])
        for i in order[begin:end]:
            _extend(boxes[box], low[i], high[i])
        if count[box] > LEAF:
            rows = order[begin:end]
            cut = begin + _halve(low, high, middle, rows, bins, filled, behind)
            first[used], count[used] = begin, cut - begin
            first[used + 1], count[used + 1] = cut, end - cut
            first[box], count[box] = used, 0
            used += 2
        box += 1
    return order, boxes, first[:used].copy(), count[:used].copy()


@exact_part
def _empty(box):
    for c in range(3):
        box[c], box[3 + c] = np.inf, -np.inf


@exact_part
def _extend(box, low, high):
    for c in range(3):
        box[c], box[3 + c] = min(box[c], low[c]), max(box[3 + c], high[c])


@exact_part
def _surface(box):
    """Half of a box's surface."""
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x


@exact_part
def _halve(low, high, middle, rows, bins, filled, behind):
    """Bring the triangles on one side of a plane across the longest side to the front, and count
    them: at least 1, not all; `bins`, `filled` and `behind` are memory to write to."""
    around = np.empty(6, np.float32)
    _empty(around)
    for i in rows:
        _extend(around, middle[i], middle[i])
    axis = np.argmax(around[3:] - around[:3])
    start, length = around[axis], around[3 + axis] - around[axis]
    if not length > 0:
        return len(rows) // 2
    per = np.float32(BINS) / length
    filled[:] = 0
    for b in range(BINS):
        _empty(bins[b])
    for i in rows:
        b = min(int((middle[i, axis] - start) * per), BINS - 1)
        filled[b] += 1
        _extend(bins[b], low[i], high[i])
    cut = _least_cost(bins, filled, behind)
    front = 0
    for k in range(len(rows)):
        if min(int((middle[rows[k], axis] - start) * per), BINS - 1) < cut:
            rows[front], rows[k] = rows[k], rows[front]
            front += 1
    return front


@exact_part
def _least_cost(bins, filled, behind):
    """First bin of the second part, so that surface times triangles is least over both parts."""
    around, n = np.empty(6, np.float32), 0
    _empty(around)
    for b in range(BINS - 1, 0, -1):
        _extend(around, bins[b, :3], bins[b, 3:])
        n += filled[b]
        behind[b] = n * _surface(around) if n else np.inf
    cut, least, n = 1, np.inf, 0
    _empty(around)
    for b in range(1, BINS):
        _extend(around, bins[b - 1, :3], bins[b - 1, 3:])
        n += filled[b - 1]
        cost = n * _surface(around) + behind[b] if n else np.inf
        if cost < least:
            cut, least = b, cost
    return cut


@exact
def _trace(low, high, first, count, corners, numbers, origins, rays, reach, any_will_do):
    """(n,) int32 triangles met; `reach` becomes their distances."""
    met = np.full(len(rays), -1, np.int32)
    packet = np.zeros(12 * LANES, np.float32)
    waiting, distance = np.empty(len(first), np.int32), np.empty(len(first), np.float32)
    for start in range(0, len(rays), LANES):
        filled = min(LANES, len(rays) - start)
        _load(origins, rays, reach, start, filled, packet)
        packet[MET:] = -1
        _descend(low, high, first, count, corners, numbers, packet, waiting, distance, any_will_do)
        for k in range(filled):
            met[start + k], reach[start + k] = np.int32(packet[MET + k]), packet[REACH + k]
    return met


@exact_part
def _load(origins, rays, reach, start, filled, packet):
    """Write rays side by side; a place that is left over reaches nothing."""
    for k in range(LANES):
        i = start + min(k, filled - 1)
        for c in range(3):
            part = rays[i, c]
            packet[X + c * LANES + k], packet[DX + c * LANES + k] = origins[i, c], part
            steep = np.float32(1) / part if part != 0 else STEEPEST
            packet[OX + c * LANES + k] = max(min(steep, STEEPEST), -STEEPEST)
        packet[REACH + k] = reach[i] if k < filled else np.float32(-1)


@exact_part
def _enter(low, high, box, packet):
    """Least distance at which one of the rays enters a box, infinite where none does."""
    x0, y0, z0 = low[box, 0], low[box, 1], low[box, 2]
    x1, y1, z1 = high[box, 0], high[box, 1], high[box, 2]
    for k in range(LANES):
        ax, bx = (x0 - packet[X + k]) * packet[OX + k], (x1 - packet[X + k]) * packet[OX + k]
        ay, by = (y0 - packet[Y + k]) * packet[OY + k], (y1 - packet[Y + k]) * packet[OY + k]
        az, bz = (z0 - packet[Z + k]) * packet[OZ + k], (z1 - packet[Z + k]) * packet[OZ + k]
        near = max(max(min(ax, bx), min(ay, by)), max(min(az, bz), np.float32(0)))
        far = min(min(max(ax, bx), max(ay, by)), min(max(az, bz), packet[REACH + k]))
        packet[ENTRY + k] = near if near <= far * SLACK else np.float32(np.inf)
    least = packet[ENTRY]
    for k in range(1, LANES):
        least = min(least, packet[ENTRY + k])
    return least


@exact_part
def _farthest(packet):
    """Distance beyond which no ray meets anything new."""
    most = packet[REACH]
    for k in range(1, LANES):
        most = max(most, packet[REACH + k])
    return most * SLACK


@exact_part
def _meet(corner, number, packet, any_will_do):
    """Let rays meet a triangle."""
    ax, ay, az = corner[0], corner[1], corner[2]
    ux, uy, uz = corner[3], corner[4], corner[5]
    vx, vy, vz = corner[6], corner[7], corner[8]
    zero, one = np.float32(0), np.float32(1)
    for k in range(LANES):
        dx, dy, dz = packet[DX + k], packet[DY + k], packet[DZ + k]
        px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
        slope = ux * px + uy * py + uz * pz
        over = one / slope if slope != zero else zero  # a parallel ray meets nothing
        sx, sy, sz = packet[X + k] - ax, packet[Y + k] - ay, packet[Z + k] - az
        u = (sx * px + sy * py + sz * pz) * over
        qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
        v = (dx * qx + dy * qy + dz * qz) * over
        t = (vx * qx + vy * qy + vz * qz) * over
        nearer = (t < packet[REACH + k]) | ((t == packet[REACH + k]) & (number < packet[MET + k]))
        hit = (u >= zero) & (v >= zero) & (u + v <= one) & (t > zero) & nearer
        packet[MET + k] = number if hit else packet[MET + k]
        end = np.float32(-1) if any_will_do else t
        packet[REACH + k] = end if hit else packet[REACH + k]


@exact_part
def _descend(low, high, first, count, corners, numbers, packet, waiting, distance, any_will_do):
    """Follow the rays of `packet` through the boxes, the nearer ones first."""
    waiting[0], distance[0], left = 0, _enter(low, high, np.int32(0), packet), 1
    while left:
        left -= 1
        box = waiting[left]
        if distance[left] > _farthest(packet):
            continue
        if count[box]:
            for j in range(first[box], first[box] + count[box]):
                _meet(corners[j], np.float32(numbers[j]), packet, any_will_do)
            continue
        one, other = first[box], np.int32(first[box] + 1)
        near, far = _enter(low, high, one, packet), _enter(low, high, other, packet)
        if near > far:
            one, other, near, far = other, one, far, near
        if far < np.inf:
            waiting[left], distance[left] = other, far
            left += 1
        if near < np.inf:
            waiting[left], distance[left] = one, near
            left += 1
