"""Matching costs, their aggregation and the winning planes, against plain twins."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from textured_walls import textured_wall

from fsel.reconstruct.splats import Splats, stereo

F, S = np.float32, np.int16


def plain_pair_cost(capture, i, j, inverse, truncation, enlarged):
    """Project every pixel at every plane, one at a time."""
    height, width = capture.images.shape[1:3]
    out = np.empty((height, width, len(inverse)))
    k = capture.intrinsics[i]
    for y in range(height):
        for x in range(width):
            ray = np.array([(x + 0.5 - k[2]) / k[0], (y + 0.5 - k[3]) / k[1], 1.0])
            for d, q in enumerate(inverse):
                pose = capture.world_to_camera[i]
                world = pose[:, :3].T @ (ray / q - pose[:, 3])
                other = capture.world_to_camera[j]
                p = other[:, :3] @ world + other[:, 3]
                u, v = 2 * (capture.intrinsics[j][:2] * p[:2] / p[2] + capture.intrinsics[j][2:])
                inside = p[2] > 0 and 0 <= u < 2 * width and 0 <= v < 2 * height
                cost = 150.0
                if inside:
                    gap = np.abs(enlarged[int(v), int(u)] - capture.images[i, y, x].astype(float))
                    cost = min(gap.mean() / truncation, 1) * 255
                out[y, x, d] = cost
    return out


def test_pair_cost_equals_plain_projection():
    capture = textured_wall(size=(16, 12))
    turn = Rotation.from_rotvec([0.03, -0.05, 0.07]).as_matrix()
    capture.world_to_camera[3] = turn @ capture.world_to_camera[3]
    bound = Splats(capture)
    inverse = np.linspace(0.1, 0.5, 8).astype(F)
    pose, other = capture.world_to_camera[[1, 3]]
    rotation = other[:, :3] @ pose[:, :3].T
    fast = stereo.pair_cost(
        bound.frames[1].image,
        bound.frames[3].enlarged,
        bound.frames[1].rays,
        rotation.astype(F),
        (other[:, 3] - rotation @ pose[:, 3]).astype(F),
        bound.ks[3],
        inverse,
        F(40),
    )
    enlarged = cv2.resize(capture.images[3].astype(F), None, fx=2, fy=2)
    slow = plain_pair_cost(capture, 1, 3, inverse, 40, enlarged)
    # a coordinate on a pixel's edge may round either way in float32
    assert (np.abs(fast - slow) <= 1).mean() > 0.97


def test_box_filter_is_the_mean_of_nine():
    cost = np.random.default_rng(0).integers(0, 256, (6, 7, 3), dtype=np.uint8)
    padded = np.pad(cost.astype(int), ((1, 1), (1, 1), (0, 0)), mode="edge")
    windows = [padded[y : y + 6, x : x + 7] for y in range(3) for x in range(3)]
    np.testing.assert_array_equal(stereo.box_filter(cost), sum(windows) // 9)


@pytest.mark.parametrize(("count", "expected"), [(1, 80), (2, 35), (3, 30), (4, 15)])
def test_merge_takes_the_better_half(count, expected):
    values = [40, 10, 20, 5]
    costs = [np.full((1, 1, 2), v, np.uint8) for v in values]
    assert stereo.merge_costs(costs, count)[0, 0, 0] == expected


def plain_path(costs, small, jumps):
    """One path of semi-global matching over (n, D) costs; (n - 1,) penalties between steps."""
    values = [costs[0]]
    for cost, jump in zip(costs[1:], jumps, strict=True):
        last, best = values[-1], values[-1].min()
        padded = np.pad(last, 1, constant_values=np.inf)
        steps = [last, padded[:-2] + small, padded[2:] + small, np.full(len(last), best + jump)]
        values.append(cost + np.min(steps, axis=0) - best)
    return np.array(values)


def both_ways(costs, grey, small, large):
    jumps = np.rint(np.maximum(small + 1, large / (1 + 0.1 * np.abs(np.diff(grey)))))
    back = plain_path(costs[::-1], small, jumps[::-1])[::-1]
    return plain_path(costs, small, jumps) + back


@pytest.mark.parametrize("shape", [(4, 6, 5), (6, 3, 2), (1, 5, 33)])
def test_aggregation_equals_the_recurrence(shape):
    rng = np.random.default_rng(0)
    cost, grey = rng.integers(0, 50, shape).astype(float), rng.integers(0, 256, shape[:2])
    expected = np.zeros(shape)
    for line in range(shape[0]):
        expected[line] += both_ways(cost[line], grey[line], 7, 90)
    for line in range(shape[1]):
        expected[:, line] += both_ways(cost[:, line], grey[:, line], 7, 90)
    total = stereo.aggregate(cost.astype(S), grey.astype(F), S(7), F(90))
    np.testing.assert_array_equal(total, expected)


def test_aggregation_of_the_largest_costs_stays_within_its_integers():
    cost = np.random.default_rng(0).choice([0, 510], (5, 6, 32)).astype(S)
    largest = 7600  # up to which four paths stay within int16
    total = stereo.aggregate(cost, np.zeros((5, 6), F), S(largest - 1), F(largest))
    bound = 4 * (510 + largest)
    assert bound <= np.iinfo(S).max
    assert total.min() >= 0
    assert total.max() <= bound


@pytest.mark.parametrize("planes", [2, 3, 33])
def test_winner_equals_the_plain_least(planes):
    rng = np.random.default_rng(planes)
    total = rng.integers(0, 40, (5, 7, planes)).astype(np.int16)  # many ties, and ends that win
    cost = rng.integers(0, 511, total.shape).astype(np.int16)
    inverse = np.linspace(0.5, 2, planes).astype(np.float32)
    depth, sure = stereo.winner(total, cost, inverse)
    for pixel in np.ndindex(total.shape[:2]):
        sums, costs = total[pixel].astype(float), cost[pixel].astype(float)
        best, shift = int(np.argmin(sums)), 0.0
        if 0 < best < planes - 1:
            left, low, right = sums[best - 1 : best + 2]
            curve = left + right - 2 * low
            shift = 0.5 * (left - right) / curve if curve else 0.0
        assert depth[pixel] == pytest.approx(inverse[best] + shift * (inverse[1] - inverse[0]))
        apart = (costs.mean() - costs[best]) / (costs.mean() + 8)
        assert sure[pixel] == pytest.approx(max(0.0, apart), abs=1e-6)


def test_the_costs_of_the_most_planes_are_summed_whole():
    cost = np.full((1, 1, stereo.MOST_PLANES), 510, S)
    cost[0, 0, 7] = 0
    _, sure = stereo.winner(cost, cost, np.arange(stereo.MOST_PLANES, dtype=np.float32))
    mean = 510 * (1 - 1 / stereo.MOST_PLANES)
    np.testing.assert_allclose(sure, mean / (mean + 8), rtol=1e-6)
