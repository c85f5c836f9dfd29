"""The splat reconstructor: agreement against a plain twin, and behaviour on a generated room."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from selection_problems import moved, problem_of
from textured_walls import textured_wall
from watched_images import Watched

from fsel.evaluation.evaluator import Evaluator
from fsel.reconstruct import RECONSTRUCTORS
from fsel.reconstruct.splats import Splats, fusion, reconstructor
from fsel.reconstruct.splats import planes as frames_module
from fsel.reconstruct.splats.planes import affinity, depth_range

F = np.float32


@pytest.mark.parametrize("points", [True, False])
def test_a_wrong_pose_of_a_frame_that_is_not_selected_costs_nothing(points):
    wall = textured_wall(frames=24)
    wall = wall if points else replace(wall, points=None)
    poses = wall.world_to_camera.copy()
    poses[20, :, 3] += 1000.0
    scores = [
        Evaluator.on_frames(Splats(capture), np.array([5, 9]))(np.array([4, 6, 8, 10]))[0]
        for capture in (wall, replace(wall, world_to_camera=poses))
    ]
    assert scores[0] > 12
    assert scores[1] > scores[0] - 0.1


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
    depth = Splats(textured_wall()).fit(np.arange(8)).positions[:, 2]
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
    monkeypatch.setattr(fusion, "VERDICT_BYTES", 3 * 6 * (48 * 36 + 1) * 12)

    def counted(*given):
        held.append(compare(*given))
        return held[-1]

    monkeypatch.setattr(fusion, "compare", counted)
    found = Splats(capture).fit(frames)
    np.testing.assert_array_equal(found.splats, expected.splats)
    np.testing.assert_array_equal(found.colors, expected.colors)
    assert [len(part.pixels) for part in held] == [3, 3, 1] * 3  # two rounds, and depths
    assert sum(part.nbytes for part in held[0][:3]) == fusion.VERDICT_BYTES


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
    turn = Rotation.random(rng=np.random.default_rng(1)).as_matrix()
    other = moved(problem_of(capture, [0], [1]), turn, np.array([3, -2, 9]), 7.0).capture
    frames = np.array([0, 2, 3, 5, 7])
    scores = [Evaluator.on_frames(Splats(c), np.array([1, 4]))(frames) for c in (capture, other)]
    np.testing.assert_allclose(scores[0], scores[1], rtol=0.02)


def test_two_frames_are_enough():
    capture = textured_wall()
    model = Splats(capture).fit(np.array([3, 4]))
    assert np.isfinite(model.render(capture.view(np.array([0])))).all()


@pytest.mark.parametrize("settings", [{"partners": 5}, {"planes": (1, 4)}, {"planes": (32, 129)}])
def test_bad_settings_are_refused(settings):
    with pytest.raises(ValueError, match="must be"):
        Splats(textured_wall(), **settings)


def test_depth_range_covers_the_wall_without_points():
    near, far = depth_range(replace(textured_wall(), points=None))[0]
    assert near < 4 < far


def test_exported_ply_reads_back(tmp_path):
    model = Splats(textured_wall()).fit(np.arange(4))
    model.export_ply(tmp_path / "wall.ply")
    cloud = trimesh.load(tmp_path / "wall.ply")
    np.testing.assert_allclose(cloud.vertices, model.positions, rtol=1e-6)
    assert model.bytes == model.primitives * 8 * 4
