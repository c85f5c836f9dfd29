"""Solid procedural textures and shading, evaluated where rays hit."""

from __future__ import annotations

import numpy as np

from fsel.core.compiled import exact, exact_part

F, N = np.float32, np.int64  # a bare number would compile a function anew

PLAIN, NOISE, BRICK, PLANK, TILE, STRIPE, POSTER, BOOKS, LEAVES, COBBLE, RUG, MARBLE = range(12)
SUN_SHARE = F(0.75)
GRAIN = F(1 / 0.13)  # one over metres: dirt and wear that every material has
ZENITH = np.array([0.27, 0.45, 0.76], np.float32)
HORIZON = np.array([0.68, 0.77, 0.84], np.float32)


def material(kind: int, first, second, third, scale: float, seed: int, gloss: float = 0.0):
    """Return one row of the material table: colours are linear RGB in 0..1, scale in metres."""
    return np.array([kind, *first, *second, *third, scale, seed, gloss], np.float32)


@exact_part
def _hash(x, y, z, seed):
    h = np.uint32(x) * np.uint32(374761393) + np.uint32(y) * np.uint32(668265263)
    h += np.uint32(z) * np.uint32(2147483647) + np.uint32(seed) * np.uint32(1274126177)
    h = (h ^ (h >> np.uint32(13))) * np.uint32(1274126177)
    h = h ^ (h >> np.uint32(16))
    return F(h & np.uint32(65535)) * F(1.0 / 65535.0)


@exact_part
def _noise(x, y, z, seed):
    """Trilinear value noise in 0..1."""
    ix, iy, iz = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    fx, fy, fz = x - ix, y - iy, z - iz
    fx, fy, fz = fx * fx * (3 - 2 * fx), fy * fy * (3 - 2 * fy), fz * fz * (3 - 2 * fz)
    total = F(0)
    for dz in range(2):
        wz = fz if dz else F(1) - fz
        for dy in range(2):
            wy = fy if dy else F(1) - fy
            near = _hash(ix, iy + dy, iz + dz, seed)
            away = _hash(ix + 1, iy + dy, iz + dz, seed)
            total += wz * wy * (near + fx * (away - near))
    return total


@exact_part
def _fractal(x, y, z, seed):
    return (
        F(0.55) * _noise(x, y, z, seed)
        + F(0.3) * _noise(x * F(2.1), y * F(2.1), z * F(2.1), seed + 7)
        + F(0.15) * _noise(x * F(4.3), y * F(4.3), z * F(4.3), seed + 13)
    )


@exact_part
def _unit(value):
    return min(max(value, F(0)), F(1))


@exact_part
def _brick(u, v, seed):
    row = int(np.floor(v * F(2)))
    along = u + F(0.5) * (row % 2)
    column = int(np.floor(along))
    mortar = v * F(2) - row < F(0.16) or along - column < F(0.08)
    return _hash(row, column, N(3), seed), F(1) if mortar else F(0), F(1)


@exact_part
def _plank(u, v, seed):
    row = int(np.floor(v))
    grain = _noise(u * F(0.8), v * F(9), F(row * 5), seed)
    board = _hash(row, int(np.floor(u / F(6) + row * F(0.37))), N(1), seed)
    return F(0.5) * board + F(0.5) * grain, F(1) if v - row < F(0.09) else F(0), F(1)


@exact_part
def _tile(u, v, seed):
    row, column = int(np.floor(v)), int(np.floor(u))
    blend = F((row + column) % 2) * F(0.6) + F(0.4) * _hash(row, column, N(2), seed)
    return blend, F(1) if v - row < F(0.06) or u - column < F(0.06) else F(0), F(1)


@exact_part
def _stripe(u, v, seed):
    wave = (u + F(0.12) * _noise(u, v, F(0), seed)) % F(1)
    return F(1) if wave < F(0.5) else F(0), F(0.7) if (v % F(2.7)) < F(0.35) else F(0), F(1)


@exact_part
def _poster(u, v, seed):
    row, column = int(np.floor(v)), int(np.floor(u))
    du = u - column - F(0.3) - F(0.4) * _hash(row, column, N(8), seed)
    dv = v - row - F(0.3) - F(0.4) * _hash(row, column, N(9), seed)
    radius = F(0.15) + F(0.3) * _hash(row, column, N(10), seed)
    third = F(1) if du * du + dv * dv < radius * radius else F(0)
    return _hash(row, column, N(5), seed), third, F(0.6) + F(0.6) * _hash(row, column, N(11), seed)


@exact_part
def _books(u, v, seed):
    column = int(np.floor(u * F(3)))
    row = int(np.floor(v))
    third = F(1) if _hash(column, row, N(6), seed) < F(0.3) else F(0)
    edge = u * F(3) - column
    light = F(0.3) if edge < F(0.12) else F(0.5) + F(0.8) * _hash(column, N(1), N(12), seed)
    return _hash(column, row, N(4), seed), third, light


@exact_part
def _leaves(x, y, z, seed):
    blend = _unit((_fractal(x * F(2), y * F(2), z * F(2), seed) - F(0.3)) * F(2.5))
    third = F(1) if _noise(x * F(3), y * F(3), z * F(3), seed + 3) > F(0.8) else F(0)
    return blend, third, F(0.4) + F(1.1) * _noise(x * F(1.2), y * F(1.2), z * F(1.2), seed + 5)


@exact_part
def _cobble(u, v, seed):
    """Cells of scattered stones: the nearest two decide the stone and the joint."""
    row, column = int(np.floor(v)), int(np.floor(u))
    first, second, tone = F(9), F(9), F(0)
    for r in range(row - 1, row + 2):
        for c in range(column - 1, column + 2):
            du = u - c - F(0.15) - F(0.7) * _hash(r, c, N(1), seed)
            dv = v - r - F(0.15) - F(0.7) * _hash(r, c, N(2), seed)
            away = np.sqrt(du * du + dv * dv)
            if away < first:
                first, second, tone = away, first, _hash(r, c, N(3), seed)
            elif away < second:
                second = away
    return tone, F(1) if second - first < F(0.12) else F(0), F(1.1) - F(0.3) * first


@exact_part
def _rug(u, v, seed):
    """Nested diamonds between bands, as woven."""
    band = int(np.floor(v / F(2)))
    du = abs(u - np.floor(u) - F(0.5))
    dv = abs(v / F(2) - band - F(0.5))
    ring = int(np.floor((du + dv) * F(6)))
    third = F(1) if dv > F(0.43) else F(0)
    light = F(0.75) + F(0.4) * _hash(ring, N(3), N(8), seed)
    return _hash(ring, band % 2, N(7), seed), third, light


@exact_part
def _marble(x, y, z, seed):
    vein = abs((x + z + F(3) * _fractal(x, y, z, seed)) % F(1) - F(0.5)) * F(2)
    return F(1) - vein, F(1) if vein < F(0.12) else F(0), F(1)


@exact_part
def _pattern(kind, x, y, z, u, v, seed):
    """Blend of the first two colours, the third's share, and a brightness."""
    if kind == PLAIN:
        return F(0.6) * _fractal(x, y, z, seed), F(0), F(1)
    if kind == NOISE:
        return _unit((_fractal(x, y, z, seed) - F(0.25)) * F(2)), F(0), F(1)
    if kind == BRICK:
        return _brick(u, v, seed)
    if kind == PLANK:
        return _plank(u, v, seed)
    if kind == TILE:
        return _tile(u, v, seed)
    if kind == STRIPE:
        return _stripe(u, v, seed)
    if kind == POSTER:
        return _poster(u, v, seed)
    if kind == BOOKS:
        return _books(u, v, seed)
    if kind == LEAVES:
        return _leaves(x, y, z, seed)
    if kind == COBBLE:
        return _cobble(u, v, seed)
    if kind == RUG:
        return _rug(u, v, seed)
    return _marble(x, y, z, seed)


@exact_part
def _albedo(point, normal, row, out):
    """The material's colour at a point, flat patterns laid along the nearest axis plane."""
    scale, seed = row[10], int(row[11])
    nx, ny, nz = abs(normal[0]), abs(normal[1]), abs(normal[2])
    x, y, z = point[0] / scale, point[1] / scale, point[2] / scale
    if nz >= nx and nz >= ny:
        u, v = x, y
    elif nx >= ny:
        u, v = y, z
    else:
        u, v = x, z
    blend, third, light = _pattern(int(row[0]), x, y, z, u, v, seed)
    wear = _noise(point[0] * GRAIN, point[1] * GRAIN, point[2] * GRAIN, N(11))
    light *= F(0.7) + F(0.6) * wear
    for c in range(3):
        colour = row[1 + c] * (F(1) - blend) + row[4 + c] * blend
        out[c] = (colour * (F(1) - third) + row[7 + c] * third) * light


@exact
def shade(points, normals, rays, kinds, towards, lit, table, ambient, out):
    """Colour n hits: solid texture, Lambert, sky light from above, and a little gloss; arrays are
    float32, `normals` towards the camera, `kinds` rows of the (m, 13) `table`; fills `out`."""
    for i in range(len(points)):
        row = table[kinds[i]]
        toward, mirror, facing = F(0), F(0), F(0)
        for c in range(3):
            toward += normals[i, c] * towards[i, c]
            facing += normals[i, c] * rays[i, c]
        if lit[i] and toward > 0:
            for c in range(3):
                mirror += (rays[i, c] - 2 * facing * normals[i, c]) * towards[i, c]
            mirror = row[12] * max(mirror, F(0)) ** 24
        else:
            toward = F(0)
        light = ambient * (F(0.8) + F(0.2) * normals[i, 2]) + SUN_SHARE * toward
        _albedo(points[i], normals[i], row, out[i])
        for c in range(3):
            out[i, c] = out[i, c] * light + mirror


@exact
def sky(rays, seed):
    """(n, 3) colours, a gradient with clouds, of rays that leave the scene: (n, 3) unit, z up."""
    out = np.empty_like(rays)
    for i in range(len(rays)):
        up = max(rays[i, 2], F(0.0))
        stretch = F(1) / (up + F(0.25))
        cloud = _fractal(rays[i, 0] * stretch * F(2), rays[i, 1] * stretch * F(2), F(0), seed)
        cloud = min(max((cloud - F(0.45)) * F(3.5), F(0)), F(1))
        low = (F(1) - up) ** 4
        for c in range(3):
            blue = ZENITH[c] + (HORIZON[c] - ZENITH[c]) * low
            out[i, c] = blue * (F(1) - cloud) + F(0.9) * cloud
    return out
