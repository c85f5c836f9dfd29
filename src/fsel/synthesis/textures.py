"""Solid procedural textures and shading, evaluated where rays hit."""

from __future__ import annotations

import numba
import numpy as np

F = np.float32
_jit = numba.njit(cache=True, fastmath=True, nogil=True)

PLAIN, NOISE, BRICK, PLANK, TILE, STRIPE, POSTER, BOOKS, LEAVES = range(9)
MATERIAL_WIDTH = 13  # kind, three colours, scale, seed, gloss
SUN_SHARE = F(0.5)
ZENITH = np.array([0.42, 0.6, 0.88], np.float32)
HORIZON = np.array([0.67, 0.8, 0.88], np.float32)


def material(kind: int, first, second, third, scale: float, seed: int, gloss: float = 0.0):
    """One row of the material table: colours are RGB in 0..1, scale in world units."""
    return np.array([kind, *first, *second, *third, scale, seed, gloss], np.float32)


@_jit
def _hash(x, y, z, seed):
    h = np.uint32(x) * np.uint32(374761393) + np.uint32(y) * np.uint32(668265263)
    h += np.uint32(z) * np.uint32(2147483647) + np.uint32(seed) * np.uint32(1274126177)
    h = (h ^ (h >> np.uint32(13))) * np.uint32(1274126177)
    h = h ^ (h >> np.uint32(16))
    return F(h & np.uint32(65535)) * F(1.0 / 65535.0)


@_jit
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


@_jit
def _fractal(x, y, z, seed):
    return (
        F(0.55) * _noise(x, y, z, seed)
        + F(0.3) * _noise(x * F(2.1), y * F(2.1), z * F(2.1), seed + 7)
        + F(0.15) * _noise(x * F(4.3), y * F(4.3), z * F(4.3), seed + 13)
    )


@_jit
def _pattern(kind, x, y, z, u, v, seed):
    """Blend weights of the first two colours, the third's share, and a brightness."""
    blend, third, light = F(0), F(0), F(1)
    if kind == PLAIN:
        light = F(0.94) + F(0.12) * _noise(x * F(0.6), y * F(0.6), z * F(0.6), seed)
    elif kind == NOISE:
        blend = min(max((_fractal(x, y, z, seed) - F(0.25)) * F(2), F(0)), F(1))
    elif kind == BRICK:
        row = int(np.floor(v * F(2)))
        along = u + F(0.5) * (row % 2)
        column = int(np.floor(along))
        mortar = v * F(2) - row < F(0.16) or along - column < F(0.08)
        blend = _hash(row, column, 3, seed)
        third = F(1) if mortar else F(0)
        light = F(0.85) + F(0.3) * _noise(x * F(5), y * F(5), z * F(5), seed)
    elif kind == PLANK:
        row = int(np.floor(v))
        grain = _noise(u * F(0.8), v * F(9), F(row * 5), seed)
        blend = (
            F(0.5) * _hash(row, int(np.floor(u / F(6) + row * F(0.37))), 1, seed) + F(0.5) * grain
        )
        third = F(1) if v - row < F(0.06) else F(0)
    elif kind == TILE:
        row, column = int(np.floor(v)), int(np.floor(u))
        blend = F((row + column) % 2) * F(0.7) + F(0.3) * _hash(row, column, 2, seed)
        third = F(1) if v - row < F(0.05) or u - column < F(0.05) else F(0)
    elif kind == STRIPE:
        blend = F(1) if (u + F(0.3) * _noise(u, v, F(0), seed)) % F(1) < F(0.5) else F(0)
        third = F(0.7) if (v % F(2.7)) < F(0.35) else F(0)
    elif kind == POSTER:
        row, column = int(np.floor(v)), int(np.floor(u))
        blend = _hash(row, column, 5, seed)
        du = u - column - F(0.3) - F(0.4) * _hash(row, column, 8, seed)
        dv = v - row - F(0.3) - F(0.4) * _hash(row, column, 9, seed)
        radius = F(0.15) + F(0.3) * _hash(row, column, 10, seed)
        third = F(1) if du * du + dv * dv < radius * radius else F(0)
        light = F(0.6) + F(0.6) * _hash(row, column, 11, seed)
    elif kind == BOOKS:
        column = int(np.floor(u * F(3)))
        blend = _hash(column, int(np.floor(v)), 4, seed)
        third = F(1) if _hash(column, int(np.floor(v)), 6, seed) < F(0.25) else F(0)
        edge = u * F(3) - column
        light = F(0.45) if edge < F(0.1) else F(0.7) + F(0.5) * _hash(column, 1, 12, seed)
    else:
        spots = _fractal(x * F(2), y * F(2), z * F(2), seed)
        blend = min(max((spots - F(0.3)) * F(2.5), F(0)), F(1))
        third = F(1) if _noise(x * F(3), y * F(3), z * F(3), seed + 3) > F(0.8) else F(0)
        light = F(0.55) + F(0.9) * _noise(x * F(1.2), y * F(1.2), z * F(1.2), seed + 5)
    return blend, third, light


@_jit
def shade(points, normals, rays, kinds, lit, table, sun, ambient, out):
    """Colour of every hit: solid texture, Lambert, sky light from above, and a little gloss.

    Args:
        points: (n, 3) float32 hits in the scene's own frame (z up, metres).
        normals: (n, 3) float32 unit, towards the camera.
        rays: (n, 3) float32 unit directions of travel.
        kinds: (n,) int32 rows of `table`.
        lit: (n,) bool, whether the sun reaches the hit.
        table: (m, 13) float32 materials.
        sun: (3,) float32 unit direction towards the light.
        ambient: light without the sun, 0..1.
        out: (n, 3) float32 to fill, 0..1.
    """
    for i in range(len(points)):
        row = table[kinds[i]]
        kind, scale, seed, gloss = int(row[0]), row[10], int(row[11]), row[12]
        nx, ny, nz = abs(normals[i, 0]), abs(normals[i, 1]), abs(normals[i, 2])
        x, y, z = points[i, 0] / scale, points[i, 1] / scale, points[i, 2] / scale
        if nz >= nx and nz >= ny:
            u, v = x, y
        elif nx >= ny:
            u, v = y, z
        else:
            u, v = x, z
        blend, third, light = _pattern(kind, x, y, z, u, v, seed)
        toward = F(0)
        mirror = F(0)
        facing = F(0)
        for c in range(3):
            toward += normals[i, c] * sun[c]
            facing += normals[i, c] * rays[i, c]
        if lit[i] and toward > 0:
            for c in range(3):
                mirror += (rays[i, c] - 2 * facing * normals[i, c]) * sun[c]
            mirror = gloss * max(mirror, F(0)) ** 24
        else:
            toward = F(0)
        sky = ambient * (F(0.8) + F(0.2) * normals[i, 2])
        for c in range(3):
            colour = row[1 + c] * (F(1) - blend) + row[4 + c] * blend
            colour = (colour * (F(1) - third) + row[7 + c] * third) * light
            out[i, c] = colour * (sky + SUN_SHARE * toward) + mirror


@_jit
def sky(rays, seed, out):
    """A gradient with clouds for rays that leave the scene: (n, 3) unit directions, z up."""
    for i in range(len(rays)):
        up = max(rays[i, 2], F(0.0))
        stretch = F(1) / (up + F(0.25))
        cloud = _fractal(rays[i, 0] * stretch * F(2), rays[i, 1] * stretch * F(2), F(0), seed)
        cloud = min(max((cloud - F(0.45)) * F(3.5), F(0)), F(1))
        for c in range(3):
            blue = ZENITH[c] + (HORIZON[c] - ZENITH[c]) * (F(1) - up)
            out[i, c] = blue * (F(1) - cloud) + F(0.95) * cloud
