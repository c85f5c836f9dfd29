"""Who sees what, NeRF-Director and the MVSNet scores: by hand, and against slow twins."""

from dataclasses import replace

import numpy as np
import pytest
from selection_problems import capture_of, in_line, problem_of, random_problem, with_points

from fsel.core.points import SparsePoints
from fsel.selectors.baselines import METHODS
from fsel.selectors.baselines.covisibility import (
    PREDICTED,
    most_shared,
    score_rows,
    score_sums,
    scores_with,
    shared_points,
    tracks,
)


def select(name, problem, k):
    return METHODS[name].select(problem, k, np.random.default_rng(0))


def on_a_line(positions, xyz, seen_by, proxies=()):
    """Cameras on the x axis looking along z, the last two targets, and points that some see."""
    n = len(positions)
    point = np.repeat(np.arange(len(xyz)), [len(frames) for frames in seen_by])
    frame = np.concatenate([np.array(frames, np.int64) for frames in seen_by])
    points = SparsePoints(np.array(xyz, float), np.zeros((len(xyz), 3), np.uint8), point, frame)
    capture = replace(in_line(positions), points=points)
    return problem_of(capture, proxies, np.setdiff1d(np.arange(n - 2), proxies), [n - 2, n - 1])


def slow_shared(problem, i, j):
    points = problem.capture.points
    sees = [set(points.track_point[points.track_frame == frame]) for frame in (i, j)]
    return sees[0] & sees[1]


def slow_score(problem, i, j):
    """MVSNet's score of two frames from sets and arc cosines."""
    points, centers = problem.capture.points, problem.capture.centers
    total = 0.0
    for p in slow_shared(problem, i, j):
        a, b = (centers[frame] - points.xyz[p] for frame in (i, j))
        cosine = a @ b / np.linalg.norm(a) / np.linalg.norm(b)
        angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
        total += np.exp(-((angle - 5) ** 2) / (2 * (1 if angle <= 5 else 10) ** 2))
    return total


def observed_as(problem, rows):
    """The same problem with some of the observations of its points, in the order given."""
    points = problem.capture.points.observed(rows)
    return replace(problem, capture=replace(problem.capture, points=points))


@pytest.fixture
def problem():
    """A third of its observations are listed twice."""
    problem = with_points(random_problem(30, seed=2), seed=2)
    rows = np.arange(len(problem.capture.points.track_point))
    return observed_as(problem, np.concatenate([rows, rows[::3]]))


def test_shared_points_and_scores_against_sets(problem):
    pool = problem.observed
    arrays = tracks(problem, pool).arrays
    shared = np.array([[len(slow_shared(problem, i, j)) for j in pool] for i in pool])
    scores = np.array([[slow_score(problem, i, j) * (i != j) for j in pool] for i in pool])
    counts, row = np.empty(len(pool), np.int64), np.empty(len(pool))
    for i in range(len(pool)):
        shared_points(i, arrays, counts)
        np.testing.assert_array_equal(counts, shared[i])
        scores_with(i, arrays, row)
        np.testing.assert_allclose(row, scores[i], rtol=1e-9, atol=1e-12)
    rows = np.arange(len(scores))[::-1].copy()
    np.testing.assert_allclose(score_rows(rows, arrays), scores[rows], rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(score_sums(arrays), scores.sum(axis=1), rtol=1e-9)
    assert most_shared(arrays) == (shared - np.diag(np.diag(shared))).max()


@pytest.mark.parametrize(
    ("degrees", "score"), [(5, 1.0), (4, np.exp(-0.5)), (15, np.exp(-0.5)), (25, np.exp(-2))]
)
def test_the_score_of_one_point_by_hand(degrees, score):
    half = np.tan(np.radians(degrees / 2))
    problem = on_a_line([-half, half, 8, 9], [[0, 0, 1]], [[0, 1]])
    row = np.empty(2)
    scores_with(0, tracks(problem, problem.observed).arrays, row)
    np.testing.assert_allclose(row, [0, score], rtol=1e-9)


def test_mvsnet_sums_over_proxies(problem):
    pool = problem.observed
    total = [sum(slow_score(problem, o, j) for o in problem.proxies if o != j) for j in pool]
    expected = pool[np.argsort(-np.array(total), kind="stable")[:9]]
    np.testing.assert_array_equal(select("mvsnet", problem, 9), expected)


def test_mvsnet_facility_location_against_a_plain_loop(problem):
    pool = problem.observed
    scores = np.array([[slow_score(problem, i, j) * (i != j) for j in pool] for i in pool])
    picked = []
    for _ in range(8):
        values = [scores[[*picked, j]].max(axis=0).sum() for j in range(len(pool))]
        picked.append(int(np.argmax(np.where(np.isin(np.arange(len(pool)), picked), -1, values))))
    np.testing.assert_array_equal(select("mvsnet_location", problem, 8), pool[picked])


def test_nerf_director_by_hand():
    # centred at 2, radius 4: d = gap + 8 (1 - n / 2); frames 0 and 1 share two points, 1 and 2 one
    seen = [[0, 1], [0, 1], [1, 2]]
    problem = on_a_line([-2, 1, 2, 3, 6, 0, 0], [[0, 0, 1]] * 3, seen)
    # from 2: 12, 5, -, 9, 12 -> the lower of 0 and 4, then 4: min(12, 16), 3: min(9, 13), 1: 3
    assert select("nerf_director", problem, 5).tolist() == [2, 0, 4, 3, 1]


def test_nerf_director_against_a_plain_loop(problem):
    pool, centers = problem.observed, problem.capture.centers
    radius = max(np.linalg.norm(centers[i] - centers[pool].mean(axis=0)) for i in pool)
    most = max(len(slow_shared(problem, i, j)) for i in pool for j in pool if i != j)

    def distance(i, j):
        unshared = 1 - len(slow_shared(problem, i, j)) / most
        return np.linalg.norm(centers[i] - centers[j]) + 2 * radius * unshared

    picks = select("nerf_director", problem, 9)
    for step in range(1, 9):
        left = np.setdiff1d(pool, picks[:step])
        assert picks[step] == max(left, key=lambda i: min(distance(i, j) for j in picks[:step]))


def test_observations_by_targets_are_not_used(problem):
    kept = np.isin(problem.capture.points.track_frame, problem.observed)
    blind = observed_as(problem, kept)
    for name in ("nerf_director", "mvsnet", "mvsnet_location"):
        np.testing.assert_array_equal(select(name, problem, 9), select(name, blind, 9))


def test_missing_points_are_predicted_by_viewing_cones():
    # two facing pairs back to back: each camera sees its own pair's points and no other's
    turn = np.diag([-1.0, 1, -1])
    centers = np.array([[0, 0, 0.0], [0.1, 0, 0], [0, 0, 9], [0.1, 0, 9], [0, 0, 0], [0, 0, 0]])
    rotations = np.stack([np.eye(3), np.eye(3), turn, turn, np.eye(3), np.eye(3)])
    problem = problem_of(capture_of(centers, rotations), [3], [0, 1, 2], [4, 5])
    counts = np.empty(4, np.int64)
    shared_points(0, tracks(problem, problem.observed).arrays, counts)
    # every ray passes the middle between the pairs, where all four look
    np.testing.assert_array_equal(counts, [4, 4, 4, 4])
    away = problem_of(capture_of(centers, rotations[[2, 2, 0, 0, 0, 0]]), [3], [0, 1, 2], [4, 5])
    shared_points(0, tracks(away, problem.observed).arrays, counts)
    # back to back, the closest point of a ray is its own camera: nobody sees across
    assert counts[2] == counts[3] == 0


def test_predicted_points_are_bounded():
    problem = random_problem(PREDICTED + 40)
    assert len(tracks(problem, problem.observed).point_start) == PREDICTED + 1
