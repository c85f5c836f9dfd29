"""FisherRF and COVER: blending, information and coverage by hand and against slow twins."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from selection_problems import moved, permuted, problem_on, random_problem
from watched_images import Watched

from fsel.core.capture import Capture
from fsel.core.points import SparsePoints
from fsel.core.problem import checked_select
from fsel.evaluation.methods import METHODS
from fsel.selectors.baselines.by_reconstruction import (
    BINS,
    Coverage,
    Inconsistency,
    Information,
    fibonacci_sphere,
)
from fsel.selectors.baselines.splat_views import START, Blends, blend, fitted, greedily
from fsel.synthetic import record

K = np.array([[4.0, 4, 4, 3]], np.float32)  # principal point in the middle of 8x6 pixels
FRONT = np.eye(3, 4, dtype=np.float32)[None]


def splats_of(*rows):
    """x, y, z, opacity of each."""
    return np.array(rows, np.float32).T.copy()


def random_scene(seed, n=80, views=5):
    rng = np.random.default_rng(seed)
    xyz = rng.uniform(-1.5, 1.5, (n, 3))
    splats = np.vstack([xyz.T, rng.uniform(0.2, 1, n)]).astype(np.float32, order="C")
    rotation = Rotation.random(views, rng=rng).as_matrix()
    shift = np.tile([0.0, 0, 2.5], (views, 1)) + rng.normal(scale=0.3, size=(views, 3))
    poses = np.concatenate([rotation, shift[..., None]], axis=2).astype(np.float32)
    return splats, poses, np.tile(K, (views, 1))


def plain_blend(splats, pose, k, width, height):
    """Weights and squares of every splat, pixel by pixel, and the covered pixels.

    Depths count to ten binary places after the first; equal ones go by the order of the splats.
    """
    n = splats.shape[1]
    camera = pose[:, :3] @ splats[:3] + pose[:, 3:]
    clear = np.ones((height, width))
    weight, square = np.zeros((2, n))
    mantissa, exponent = np.frexp(camera[2])
    for i in np.argsort(np.floor(mantissa * 2**11) * 2.0**exponent, kind="stable"):
        x, y, z = camera[:, i]
        u, v = k[0] * x / z + k[2], k[1] * y / z + k[3]
        if z <= 0 or not (0 <= u < width and 0 <= v < height):
            continue
        for row in range(height):
            for column in range(width):
                share = max(0, 1 - abs(u - column - 0.5)) * max(0, 1 - abs(v - row - 0.5))
                part = splats[3, i] * share * clear[row, column]
                clear[row, column] -= part
                weight[i] += part
                square[i] += part**2
    return weight, square, (clear < 1).sum()


def blends_of(splats, poses, intrinsics, size=(8, 6)):
    return Blends(splats, poses, intrinsics, size, *blend(splats, poses, intrinsics, *size))


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_a_near_splat_hides_a_far_one(order):
    # both on the centre of one pixel: 0.8 of the light, then 0.5 of the 0.2 that is left
    rows = np.array([[0.125, 0.125, 1, 0.8], [0.25, 0.25, 2, 0.5]])[list(order)]
    _, index, weight, square, covered = blend(splats_of(*rows), FRONT, K, 8, 6)
    np.testing.assert_array_equal([order[i] for i in index], [0, 1])
    np.testing.assert_allclose(weight, [0.8, 0.1], rtol=1e-6)
    np.testing.assert_allclose(square, [0.64, 0.01], rtol=1e-6)
    assert covered.tolist() == [1]


def test_a_splat_between_pixels_is_shared_by_four():
    _, _, weight, square, covered = blend(splats_of([0, 0, 1, 0.8]), FRONT, K, 8, 6)
    np.testing.assert_allclose(weight, [0.8])
    np.testing.assert_allclose(square, [4 * 0.2**2], rtol=1e-6)
    assert covered.tolist() == [4]


def test_what_a_view_does_not_hold_is_left_out():
    behind, aside = [0, 0, -1, 1], [1.1, 0, 1, 1]
    for splats in (splats_of(behind, aside), np.empty((4, 0), np.float32)):
        start, index, _, _, covered = blend(splats, FRONT, K, 8, 6)
        assert start.tolist() == [0, 0]
        assert len(index) == 0
        assert covered.tolist() == [0]


@pytest.mark.parametrize("seed", range(4))
def test_blending_against_a_plain_loop(seed):
    splats, poses, intrinsics = random_scene(seed)
    blends = blends_of(splats, poses, intrinsics)
    for view in range(len(poses)):
        expected = plain_blend(splats.astype(float), poses[view].astype(float), K[0], 8, 6)
        part = slice(*blends.start[view : view + 2])
        weight, square = np.zeros((2, splats.shape[1]))
        weight[blends.index[part]] = blends.weight[part]
        square[blends.index[part]] = blends.square[part]
        np.testing.assert_allclose(weight, expected[0], atol=0.0101)  # faint ones are dropped
        kept = weight > 0
        np.testing.assert_allclose(weight[kept], expected[0][kept], atol=1e-4)
        np.testing.assert_allclose(square[kept], expected[1][kept], atol=1e-4)
        assert blends.covered[view] == expected[2]


def by_hand(views):
    """Blends of two splats from (splat, weight, square) entries, one list a view."""
    index, *sums = np.array([entry for view in views for entry in view], np.float32).T.copy()
    size, counts = len(views), np.array([len(view) for view in views])
    filled = np.append(0, np.cumsum(counts)), index.astype(np.int32), *sums, counts
    splats = splats_of([0, 0, 1, 1], [0.5, 0, 1, 1])
    return Blends(splats, np.tile(FRONT, (size, 1, 1)), np.tile(K, (size, 1)), (8, 6), *filled)


def test_information_by_hand():
    blends = by_hand([[(0, 1, 1)], [(0, 1, 0.5), (1, 1, 0.5)], [(1, 2, 2)]])
    criterion = Information(blends, damping=0.5)
    np.testing.assert_allclose(criterion.scores(), [2, 2, 4])
    criterion.add(0)  # splat 0 is now known to 1.5
    np.testing.assert_allclose(criterion.scores(), [1 / 1.5, 0.5 / 1.5 + 1, 4])
    criterion.add(2)
    np.testing.assert_allclose(criterion.scores(), [1 / 1.5, 0.5 / 1.5 + 0.5 / 2.5, 2 / 2.5])


def plain_coverage(blends, rows):
    """Coverage scores from counts of all views added, splat by splat."""
    directions = fibonacci_sphere(BINS).astype(float)
    splats = blends.splats[:3].T.astype(float)
    centers = [-pose[:, :3].T @ pose[:, 3] for pose in blends.poses.astype(float)]

    def along(k, view):
        ray = splats[k] - centers[view]
        return ray / np.linalg.norm(ray)

    def holds(k, view):
        x, y, z = blends.poses[view][:, :3] @ splats[k] + blends.poses[view][:, 3]
        u, v = 4 * x / z + 4, 4 * y / z + 3
        return z > 0 and 0 <= u < 8 and 0 <= v < 6

    scores = []
    for view in range(len(blends.poses)):
        total = 0.0
        for e in range(*blends.start[view : view + 2]):
            k = blends.index[e]
            bins = {int(np.argmax(directions @ along(k, row))) for row in rows if holds(k, row)}
            known = [(1 + along(k, view) @ directions[g]) / 2 for g in bins]
            total += blends.weight[e] * max(known, default=0)
        scores.append(-total / blends.covered[view])
    return scores


@pytest.mark.parametrize("seed", range(4))
def test_coverage_against_a_plain_loop(seed):
    blends = blends_of(*random_scene(seed))
    criterion, rows = Coverage(blends), []
    for row in (0, 3, 0, 2):
        criterion.add(row)
        rows.append(row)
        np.testing.assert_allclose(criterion.scores(), plain_coverage(blends, rows), atol=1e-5)


def test_the_unseen_comes_first_and_the_empty_last():
    blends = by_hand([[(0, 1, 1)], [(1, 1, 1)], [], [(0, 0.5, 0.5)]])
    criterion = Coverage(blends)
    np.testing.assert_array_equal(np.argsort(criterion.scores(), kind="stable"), [2, 0, 1, 3])
    # every splat lies in its image: both are covered up to the width of a direction
    criterion.add(0)
    scores = criterion.scores()
    assert scores[2] < scores[0] < scores[3] < 0
    assert scores[0] == pytest.approx(-1, abs=0.02)


@pytest.fixture(scope="module")
def filmed():
    """A generated scene with sparse points, 48x36 pixels."""
    made = record("mipnerf360", 3, frames=40, width=48, height=36)
    capture = Capture(
        made.names,
        made.world_to_camera,
        np.tile(made.camera.params, (len(made.names), 1)),
        made.images,
        made.sequences,
        SparsePoints(made.xyz, made.rgb, made.track_point, made.track_frame),
    )
    return problem_on(capture, targets=6)


every = pytest.mark.parametrize("name", ["fisher_rf", "cover", "warp_rf"])


def select(name, problem, k):
    return checked_select(METHODS[name], problem, k, np.random.default_rng(0))


@every
def test_only_images_of_picks_are_read(filmed, name):
    watched = Watched(filmed.capture.images)
    problem = replace(filmed, capture=replace(filmed.capture, images=watched))
    picks = select(name, problem, 12)
    assert watched.asked == set(picks[: 10 if name == "cover" else 8])  # fits from 4, ..., 8 (10)
    begun = replace(problem, fixed_picks=picks[[5, 2]])
    assert select(name, begun, 3)[:2].tolist() == picks[[5, 2]].tolist()
    assert select(name, replace(problem, fixed_picks=picks[5:6]), 3)[0] == picks[5]


@every
def test_a_filmed_scene_is_picked_to_the_last_frame_by_prefixes(filmed, name):
    whole = select(name, filmed, len(filmed.observed))
    for k in (1, 5, 13):
        np.testing.assert_array_equal(select(name, filmed, k), whole[:k])


@every
@pytest.mark.parametrize("points", [True, False])
def test_picks_of_a_filmed_scene_follow_neither_the_world_nor_the_order(filmed, name, points):
    if not points:
        filmed = replace(filmed, capture=replace(filmed.capture, points=None))
    picks = select(name, filmed, 14)
    turn = Rotation.random(rng=np.random.default_rng(1)).as_matrix()
    other = moved(filmed, turn, np.array([3.0, -8, 1]), 37.0)
    np.testing.assert_array_equal(picks, select(name, other, 14))
    order = np.random.default_rng(2).permutation(len(filmed.capture))
    np.testing.assert_array_equal(picks, order[select(name, permuted(filmed, order), 14)])


class Lowest:
    """A criterion by which the lowest free frame is worth most."""

    def __init__(self, blends):
        self.blends, self.rows = blends, []

    def scores(self):
        return -np.arange(float(len(self.blends.covered)))

    def add(self, row):
        self.rows.append(row)


def kept(made, criterion=lambda *seen: Lowest(fitted(*seen))):
    """The maker of a criterion, which adds each one that it makes to a list."""

    def make(*seen):
        made.append(criterion(*seen))
        return made[-1]

    return make


@pytest.mark.parametrize(
    ("growth", "counts"), [(1.0, [8, 16, 20]), (0.25, [5, 6, 7, 8, 10, 12, 15, 18, 20])]
)
def test_fits_are_made_anew_whenever_the_picks_have_grown(growth, counts):
    problem, made = random_problem(40), []
    picks = greedily(problem, 20, kept(made), growth)
    rows = np.searchsorted(problem.observed, picks).tolist()
    assert [one.rows for one in made] == [rows[:count] for count in counts]
    free = [row for row in range(len(problem.observed)) if row not in rows[:START]]
    assert rows[START:] == free[: 20 - START]


def test_splats_lie_where_the_views_look(filmed):
    """Fitted splats and the views that they are blended into share one frame."""
    made = []
    greedily(filmed, START + 1, kept(made))
    blends = made[0].blends
    assert blends.covered[made[0].rows[:START]].min() > 0.6 * np.prod(blends.size)
    begun = replace(filmed, fixed_picks=filmed.observed[:2])
    greedily(begun, 4, kept(made))
    assert [one.rows for one in made[1:]] == [[0, 1, 2], [0, 1, 2, 3]]  # a fit after every pick


def test_sparse_points_tell_of_views_where_no_pick_looks(filmed):
    pool, capture = filmed.observed, filmed.capture
    near = np.argsort(np.linalg.norm(capture.centers[pool] - capture.centers[pool[0]], axis=1))[:2]
    alone, beside = (fitted(capture, pool, near, sparse=sparse) for sparse in (False, True))
    shown = np.unique(capture.points.track_point[np.isin(capture.points.track_frame, pool)])
    added = beside.splats[:, alone.splats.shape[1] :]
    np.testing.assert_allclose(added[:3].T, capture.points.xyz[shown], rtol=1e-5, atol=1e-6)
    assert set(added[3].tolist()) == {np.float32(0.1)}
    unseen = np.setdiff1d(shown, capture.points.seen_from(pool[near], len(capture)).track_point)
    count = [
        np.isin(unseen, capture.points.seen_from(pool[[row]], len(capture)).track_point).sum()
        for row in range(len(pool))
    ]
    shows = []
    for blends in (alone, beside):
        criterion = Information(blends)
        for row in near:
            criterion.add(row)
        shows.append(count[np.argmax(criterion.scores())])
    assert shows[1] > shows[0]


def test_a_view_is_explained_by_its_own_rendering(filmed):
    made = []
    greedily(filmed, START + 1, kept(made, Inconsistency))
    one, row = made[0], 7
    before = one.scores()
    assert before[row] > 1
    one.add(row)
    assert one.scores()[row] < 1e-3  # its depth leads back to its own pixels
    assert (one.scores() < before).mean() > 0.5
