"""Rendering of splats: one by one, filling of holes against a plain twin, four lanes at once."""

import numba
import numpy as np
import pytest

from fsel.reconstruct import lanes
from fsel.reconstruct.splats import render

F = np.float32


def splat(x, y, z, opacity=1.0):
    return [x, y, z, opacity, z]


def rendered(splats, colors):
    splats = np.array(splats, F).T.copy()
    colors = np.column_stack([colors, np.ones(len(colors))]).astype(F)
    pose, k, size = np.eye(3, 4, dtype=F), np.array([10, 10, 8, 8], F), (16, 16)
    room = render.make_room(splats.shape[1], size)
    return render.render_view(splats, colors, pose, k, size, F(0.06), (F(0.5), F(10)), room)


def test_one_splat_on_a_pixel_centre_fills_that_pixel():
    total = rendered([splat(0.1, 0.1, 2.0, 0.25)], [[10, 20, 30]])
    # x = 10 * 0.1 / 2 + 8 = 8.5, the centre of pixel 8; the weight is the opacity
    assert np.argwhere(total[..., 3] > 1e-4).tolist() == [[8, 8]]
    np.testing.assert_allclose(total[8, 8], np.array([10, 20, 30, 1]) / 4, rtol=1e-4)


def test_the_front_surface_hides_the_back():
    total = rendered([splat(0.1, 0.1, 2.0), splat(0.4, 0.4, 8.0)], [[255, 0, 0], [0, 255, 0]])
    assert total[8, 8, 1] == 0


def test_projection_rounds_as_it_is_written():
    """Bit by bit: were sums reordered or fused, code compiled anew and code from a cache differ."""
    rng = np.random.default_rng(2)
    x, y, z = cloud = rng.uniform(0.5, 4, (3, 999)).astype(F)
    pose, k = rng.uniform(0.1, 1, (3, 4)).astype(F), np.array([40, 41, 32, 24], F)
    splats = np.concatenate([cloud, np.ones((2, 999), F)])
    where, cells, corners, _, _ = render.make_room(999, (64, 48))
    render._project(splats, pose, k, (64, 48), (F(0.1), F(10)), where, cells, corners)
    u, v, depth = (p[0] * x + p[1] * y + p[2] * z + p[3] for p in pose)
    closeness = F(1) / depth
    np.testing.assert_array_equal(where[2], closeness)
    np.testing.assert_array_equal(where[0], k[0] * u * closeness + k[2] + F(0.5))
    np.testing.assert_array_equal(where[1], k[1] * v * closeness + k[3] + F(0.5))


def test_a_cloud_is_accumulated_as_one_by_one():
    """Bilinear shares of every splat at the pixels where it is not hidden, added up in float64."""
    rng = np.random.default_rng(4)
    z = rng.choice([2.0, 3.0, 6.0], 400) * rng.uniform(0.95, 1.05, 400)
    cloud = np.array([*(rng.uniform(-1, 1, (2, 400)) * z), z, rng.uniform(0.2, 1, 400), z]).T
    colors = rng.uniform(0, 255, (400, 3))
    u, v = (10 * cloud[:, i] / z + 8.5 for i in range(2))  # of the image padded by one pixel
    mass, expected = np.zeros((18, render.BINS, 18), F), np.zeros((18, 18, 4))
    inside = (u >= 0) & (v >= 0) & (u < 17) & (v < 17)
    low, scale = F(0.1), F(render.BINS) / F(2 - 0.1)
    bins = render.BINS - 1 - ((1 / z - 0.1) * scale).astype(int)
    line, column = ((w + 0.5).clip(0, 17).astype(int) for w in (v, u))
    np.add.at(mass, (line, bins.clip(0), column), inside * cloud[:, 3])
    reach = np.zeros((18, 18), F)
    render._reach(mass, (low, scale), F(0.06), reach)
    for i in np.flatnonzero(inside):
        x, y = int(u[i]), int(v[i])
        for row, column in ((y, x), (y, x + 1), (y + 1, x), (y + 1, x + 1)):
            share = (1 - abs(u[i] - column)) * (1 - abs(v[i] - row)) * cloud[i, 3]
            if 1 / z[i] >= reach[row, column]:
                expected[row, column] += share * np.append(colors[i], 1)
    assert (expected[1:-1, 1:-1, 3] > 0).mean() > 0.5
    np.testing.assert_allclose(rendered(cloud, colors), expected[1:-1, 1:-1], rtol=1e-3, atol=1e-2)


def test_a_faint_floater_hides_nothing():
    crowd = [splat(0.4, 0.4, 8.0)] * 20
    total = rendered([splat(0.05, 0.05, 1.0, 0.3), *crowd], [[255, 0, 0]] + [[0, 255, 0]] * 20)
    assert total[8, 8, 1] > 0


def plain_fill(total, full):
    """Pull-push, one pixel at a time."""
    height, width = total.shape[:2]
    under = np.zeros((height, width, 3))
    if max(height, width) > 1:
        padded = np.pad(total, ((0, height % 2), (0, width % 2), (0, 0)))
        coarse = plain_fill(sum(padded[y::2, x::2] for y in (0, 1) for x in (0, 1)) / 4, full)
        for y, x in np.ndindex(height, width):
            v = np.clip((y - 0.5) / 2, 0, coarse.shape[0] - 1)
            u = np.clip((x - 0.5) / 2, 0, coarse.shape[1] - 1)
            for i, j in np.ndindex(coarse.shape[:2]):
                share = max(1 - abs(v - i), 0) * max(1 - abs(u - j), 0)
                under[y, x] += share * coarse[i, j]
    own = np.minimum(total[..., 3:] / full, 1)
    return (1 - own) * under + own * total[..., :3] / np.maximum(total[..., 3:], 1e-9)


@pytest.mark.parametrize("shape", [(8, 8), (7, 10), (5, 3), (1, 6), (9, 1), (1, 1)])
@pytest.mark.parametrize("hidden", [0.4, 1.0])
def test_filling_equals_plain_pull_push(shape, hidden, monkeypatch):
    rng = np.random.default_rng(3)
    total = rng.gamma(2, 3, (*shape, 4)).astype(F)
    total[rng.random(shape) < hidden] = 0
    monkeypatch.setattr(render, "typical_weight", lambda weights: F(12))
    views = np.stack([total, total[::-1]]).transpose(0, 3, 1, 2).copy()
    filled, _ = render.fill_holes(views)
    # a pixel is mixed below a quarter of the typical weight: below 3
    np.testing.assert_allclose(filled, plain_fill(total.astype(float), 3.0), rtol=2e-5, atol=2e-6)


def test_four_lanes_are_added_at_any_offset():
    total, values = np.arange(9, dtype=F), np.array([7, 1, 2, 3, 4, 9], F)

    @numba.njit
    def add(total, values):
        lanes.add_scaled(total, 3, F(0.5), values, 1)

    add(total, values)
    np.testing.assert_array_equal(total, [0, 1, 2, 3.5, 5, 6.5, 8, 7, 8])


@pytest.mark.parametrize("shape", [(7, 9), (8, 9), (1, 2), (1, 1)])
@pytest.mark.parametrize("decimals", [8, 1])
def test_typical_weight_is_the_median_of_what_was_met(shape, decimals):
    total = 0.1 + 50 * np.random.default_rng(0).random((*shape, 4)).astype(F) ** 4
    total = total.round(decimals)  # few decimals: many equal weights
    if shape[1] == 9:
        total[::3, ::2, 3] = 0
    weights = total[..., 3]
    assert render.typical_weight(weights) == np.median(weights[weights > 0])
    assert render.typical_weight(np.zeros(shape, F)) == 1
