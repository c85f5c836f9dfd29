"""The splat reconstructor: kernels against plain twins, and behaviour on a generated room."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from watched_images import Watched

from fsel.data.capture import Capture
from fsel.data.points import SparsePoints
from fsel.evaluation.evaluator import Evaluator
from fsel.reconstruct import RECONSTRUCTORS
from fsel.reconstruct.splats import Splats, consistency, fusion, reconstructor, stereo
from fsel.reconstruct.splats import frames as frames_module
from fsel.reconstruct.splats.planes import affinity, depth_range

F, S = np.float32, np.int16


def textured_wall(frames=8, size=(48, 36), depth=4.0, step=0.25, seed=0):
    """Cameras in a row before a textured wall at a known depth."""
    rng = np.random.default_rng(seed)
    texture = np.kron(rng.random((60, 80, 3)), np.ones((4, 4, 1)))
    width, height = size
    focal = 40.0
    images = np.empty((frames, height, width, 3), np.uint8)
    poses = np.tile(np.eye(3, 4), (frames, 1, 1))
    for i in range(frames):
        center = (i - frames / 2) * step
        poses[i, 0, 3] = -center
        x = (np.arange(width) + 0.5 - width / 2) / focal * depth + center
        y = (np.arange(height) + 0.5 - height / 2) / focal * depth
        u = np.clip((x * 24 + 160).astype(int), 0, 319)
        v = np.clip((y * 24 + 120).astype(int), 0, 239)
        images[i] = texture[v[:, None], u[None]] * 255
    return Capture(
        names=tuple(f"{i}" for i in range(frames)),
        world_to_camera=poses,
        intrinsics=np.tile([focal, focal, width / 2, height / 2], (frames, 1)),
        images=images,
        sequences=("a",) * frames,
        points=SparsePoints(
            np.array([[0.0, 0.0, depth * 0.6], [0.0, 0.0, depth]]).repeat(10, axis=0),
            np.zeros((20, 3), np.uint8),
            np.tile(np.arange(20), frames),
            np.repeat(np.arange(frames), 20),
        ),
    )


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
    assert stereo.merge_costs(*costs, count)[0, 0, 0] == expected


def plain_path(costs, small, jumps):
    """One path of semi-global matching over (n, D) costs, straight from the recurrence.

    The (n - 1,) jumps are penalties between a step and the one before it.
    """
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
    largest = stereo.LARGEST_PENALTY
    total = stereo.aggregate(cost, np.zeros((5, 6), F), S(largest - 1), F(largest))
    bound = 4 * (510 + largest)
    assert bound <= np.iinfo(S).max
    assert total.min() >= 0
    assert total.max() <= bound


@pytest.mark.parametrize("penalties", [(48, 8000.0), (510, 510.0), (-1, 510.0)])
def test_penalties_that_could_overflow_or_contradict_are_refused(penalties):
    with pytest.raises(ValueError, match="penalties must be"):
        Splats(textured_wall(), small_penalty=penalties[0], large_penalty=penalties[1])


def test_textureless_pixels_take_their_neighbours_plane():
    cost = np.full((1, 9, 5), 100, S)
    cost[0, [0, 8], 3] = 0
    total = stereo.aggregate(cost, np.zeros((1, 9), F), S(10), F(80))
    assert (total[0].argmin(axis=1) == 3).all()


def test_winner_finds_the_parabola_and_knows_a_flat_pixel():
    cost = np.array([[[18, 8, 2, 1, 6], [14, 14, 14, 14, 14]]], S)
    inverse = np.linspace(0.1, 0.5, 5).astype(F)
    depth, sure = stereo.winner(cost, cost, inverse)
    # minimum 1 at plane 3, neighbours 2 and 6: offset 0.5 * (2 - 6) / (2 + 6 - 2)
    assert depth[0, 0] == pytest.approx(0.4 - 0.1 / 3, rel=1e-5)
    assert sure[0, 0] > 0.2
    assert sure[0, 1] == 0


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


def test_agreement_and_violation_by_hand():
    inverse = np.full((2, 1, 1), 0.5, F)
    inverse[1] = 0.25
    rays = np.zeros((2, 2, 1, 1), F)
    asked = np.array([[1], [0]])
    turn = np.tile(np.eye(3, dtype=F), (2, 1, 1, 1))
    ks = np.tile(np.array([1, 1, 0.5, 0.5], F), (2, 1))
    verdicts = fusion.compare(
        0, inverse, rays, asked, turn, np.zeros((2, 1, 3), F), ks, np.full(2, 0.1, F)
    )
    # none agree; the first floats before what the other sees; the second, hidden, is no evidence
    assert verdicts.bounds[:, 0].tolist() == [[0, 1], [0, 2]]
    assert verdicts.pixels[0, 0, 1] == verdicts.others[0, 0, 1] == 0
    opacity = fusion.vote(0, np.ones((2, 1, 1), F), asked, verdicts, F(1))
    assert opacity[0, 0, 0] == pytest.approx(0.2 / (0.35 + 0.2 + 1))


def plain_support(maps, i, p, neighbours, poses, ks, tolerance):
    """(agreeing, violated, carried) neighbours of one pixel, by whole points in float64."""
    inverse, rays = maps
    height, width = inverse.shape[1:]
    y, x = p
    point = np.array([*rays[i, :, y, x], 1]) / inverse[i, y, x]
    world = poses[i, :, :3].T @ (point - poses[i, :, 3])
    agreeing, violated, carried = [], [], []
    for j in neighbours[i]:
        there = poses[j, :, :3] @ world + poses[j, :, 3]
        u, v = ks[j, :2] * there[:2] / there[2] + ks[j, 2:]
        if there[2] <= 0 or not (0 <= u < width and 0 <= v < height):
            continue
        theirs = inverse[j, int(v), int(u)]
        gap = 1 / there[2] - theirs
        if gap > tolerance:
            violated.append((j, int(v), int(u)))
        elif gap > -tolerance:
            agreeing.append((j, int(v), int(u)))
            # the inverse depth whose first-order image in the neighbour is the neighbour's own
            z = there[2] * inverse[i, y, x]
            carried.append(inverse[i, y, x] - gap * z**2)
    return agreeing, violated, carried


def test_agreement_equals_plain_projection():
    rng = np.random.default_rng(5)
    capture = textured_wall()
    frames, neighbours = np.array([1, 3, 4]), np.array([[1, 2], [0, 2], [1, 0]])
    bound = Splats(capture)
    width, height = capture.size
    inverse = rng.uniform(0.15, 0.4, (3, height, width)).astype(F)
    poses, ks = capture.world_to_camera[frames], bound.ks[frames]
    rays = np.stack([bound.frames[i].rays for i in frames])
    sure = rng.random(inverse.shape).astype(F)
    rotation, translation = reconstructor._relative(poses, neighbours)
    given = (rotation, translation, ks, np.full(3, 0.02, F))
    verdicts = fusion.compare(0, inverse, rays, neighbours, *given)
    opacity = fusion.vote(0, sure, neighbours, verdicts, F(0.7))
    fused = fusion.fuse(0, inverse, sure, neighbours, verdicts)
    for i, y, x in rng.integers([3, height, width], size=(200, 3)):
        yes, no, back = plain_support((inverse, rays), i, (y, x), neighbours, poses, ks, 0.02)
        support = 0.2 * sure[i, y, x] + sum(sure[q] for q in yes)
        against = 0.7 * sum(sure[q] for q in no)
        assert opacity[i, y, x] == pytest.approx(support / (0.35 + support + against), rel=1e-4)
        weights = [sure[i, y, x] + 1e-3, *(sure[q] for q in yes)]
        mean = np.average([inverse[i, y, x], *back], weights=weights)
        assert fused[i, y, x] == pytest.approx(mean, rel=1e-4)


def test_depth_of_a_wall_is_found():
    capture = textured_wall()
    bound = Splats(capture)
    model = bound.fit(np.arange(8))
    depth = model.positions[:, 2]
    assert abs(np.median(depth) / 4 - 1) < 0.03


def test_held_out_view_is_rendered_well_and_the_same_each_time():
    capture = textured_wall()
    frames = np.array([0, 2, 3, 5, 7])
    evaluate = Evaluator.on_frames(RECONSTRUCTORS["splats"](capture), np.array([4]))
    first = evaluate(frames)
    assert first[0] > 17
    again = Evaluator.on_frames(evaluate.reconstructor, np.array([4]))
    np.testing.assert_array_equal(first, again(frames[::-1]))
    fresh = Evaluator.on_frames(RECONSTRUCTORS["splats"](capture), np.array([4]))
    np.testing.assert_array_equal(first, fresh(frames))


def test_full_caches_forget_and_change_nothing(monkeypatch):
    capture = textured_wall()
    subsets = [np.array(s) for s in ([0, 2, 3, 5], [0, 1, 3, 6], [0, 2, 3, 5])]
    bound = Splats(capture)
    expected = [bound.fit(s).splats for s in subsets]
    monkeypatch.setattr(reconstructor, "PAIR_BYTES", 16 * bound.inverse.shape[1] * 48 * 36)
    monkeypatch.setattr(reconstructor, "MAP_BYTES", 3 * 8 * 48 * 36)
    monkeypatch.setattr(frames_module, "FRAME_BYTES", 2 * 56 * 48 * 36)
    small = Splats(capture)
    for subset, splats in zip(subsets, expected, strict=True):
        np.testing.assert_array_equal(small.fit(subset).splats, splats)
    assert (len(small._pairs), len(small._maps), len(small.frames._known)) == (16, 3, 2)
    large, kept = np.arange(6), list(small._pairs)
    np.testing.assert_array_equal(small.fit(large).splats, bound.fit(large).splats)
    assert list(small._pairs) == kept  # its 24 pairs would have pushed out all


def test_maps_are_compared_in_blocks_without_changing_a_bit(monkeypatch):
    capture, frames = textured_wall(), np.array([0, 1, 2, 4, 5, 6, 7])
    expected, held, compare = Splats(capture).fit(frames), [], fusion.compare
    monkeypatch.setattr(consistency, "VERDICT_BYTES", 3 * 6 * (48 * 36 + 1) * 12)

    def counted(*given):
        held.append(compare(*given))
        return held[-1]

    monkeypatch.setattr(fusion, "compare", counted)
    found = Splats(capture).fit(frames)
    np.testing.assert_array_equal(found.splats, expected.splats)
    np.testing.assert_array_equal(found.colors, expected.colors)
    assert [len(part.pixels) for part in held] == [3, 3, 1] * 3  # two rounds, and depths
    assert sum(part.nbytes for part in held[0][:3]) == consistency.VERDICT_BYTES


def test_only_the_frames_of_subsets_are_opened():
    capture = textured_wall()
    opened = Watched(capture.images)
    bound = Splats(replace(capture, images=opened))
    assert opened.asked == set()
    bound.fit(np.array([0, 2, 5]))
    assert opened.asked == {0, 2, 5}


def test_partners_of_a_subset_are_those_of_the_whole_capture():
    """Row by row the same numbers, so that no choice of a partner depends on who else is there."""
    views = textured_wall().views
    whole = affinity(views.centers, views.axes, 4.0)
    assert (np.diag(whole) == -np.inf).all()
    rows = np.array([6, 1, 4])
    part = affinity(views.centers[rows], views.axes[rows], 4.0)
    np.testing.assert_array_equal(part, whole[np.ix_(rows, rows)])


def test_depth_ranges_against_a_plain_loop():
    capture, rng = textured_wall(), np.random.default_rng(0)
    xyz = rng.uniform([-1, -1, 2], [1, 1, 6], (20, 3))
    kept = rng.random(len(capture.points.track_frame)) < 0.6  # about twelve points a frame
    track = replace(
        capture.points,
        xyz=xyz,
        track_point=capture.points.track_point[kept],
        track_frame=capture.points.track_frame[kept],
    )
    seen = [xyz[track.track_point[track.track_frame == i], 2] for i in range(len(capture))]
    assert {len(z) >= 10 for z in seen} == {True, False}
    every = np.concatenate(seen)
    few = np.percentile(every, 99.5)  # of a frame that sees too few points
    far = np.array([np.percentile(z, 99) if len(z) >= 10 else few for z in seen])
    found = depth_range(replace(capture, points=track))
    np.testing.assert_allclose(found[:, 1], 2.5 * np.maximum(far, np.median(far)))


def test_reconstruction_does_not_depend_on_the_worlds_frame():
    capture = textured_wall()
    turn, shift, scale = Rotation.random(rng=np.random.default_rng(1)).as_matrix(), [3, -2, 9], 7.0
    rotation = capture.world_to_camera[:, :, :3] @ turn.T
    translation = scale * capture.world_to_camera[:, :, 3] - rotation @ shift
    moved = Capture(
        capture.names,
        np.concatenate([rotation, translation[:, :, None]], axis=2),
        capture.intrinsics,
        capture.images,
        capture.sequences,
        replace(capture.points, xyz=scale * capture.points.xyz @ turn.T + shift),
    )
    frames = np.array([0, 2, 3, 5, 7])
    scores = [Evaluator.on_frames(Splats(c), np.array([1, 4]))(frames) for c in (capture, moved)]
    np.testing.assert_allclose(scores[0], scores[1], rtol=0.02)


def test_two_frames_are_enough_and_one_is_refused():
    capture = textured_wall()
    bound = Splats(capture)
    assert np.isfinite(bound.fit(np.array([3, 4])).render(capture.view(np.array([0])))).all()
    with pytest.raises(ValueError, match="two or more distinct"):
        bound.fit(np.array([3]))
    with pytest.raises(ValueError, match="two or more distinct"):
        bound.fit(np.array([3, 3]))


def test_cameras_in_one_place_give_finite_images():
    capture = textured_wall(step=0.0)
    model = Splats(capture).fit(np.arange(4))
    assert np.isfinite(model.render(capture.view(np.array([5])))).all()


@pytest.mark.parametrize("settings", [{"partners": 5}, {"planes": (1, 4)}, {"planes": (32, 129)}])
def test_bad_settings_are_refused(settings):
    with pytest.raises(ValueError, match="must be"):
        Splats(textured_wall(), **settings)


def test_unknown_setting_is_refused():
    with pytest.raises(ValueError, match="colour"):
        Splats(textured_wall(), colour=1)


def test_depth_range_covers_the_wall_without_points():
    near, far = depth_range(replace(textured_wall(), points=None))[0]
    assert near < 4 < far


def test_exported_ply_reads_back(tmp_path):
    model = Splats(textured_wall()).fit(np.arange(4))
    model.export_ply(tmp_path / "wall.ply")
    cloud = trimesh.load(tmp_path / "wall.ply")
    np.testing.assert_allclose(cloud.vertices, model.positions, rtol=1e-6)
    header = (tmp_path / "wall.ply").read_bytes().split(b"end_header")[0].decode()
    for field in ("f_dc_0", "opacity", "scale_2", "rot_3"):
        assert f"property float {field}" in header
    assert model.bytes == model.primitives * 8 * 4
