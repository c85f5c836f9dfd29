"""Simple selections: by hand, against slow twins, and what must not change them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from selection_problems import capture_of, in_line, moved, problem_of, random_problem, with_points

from fsel.core.limits import THREADS
from fsel.core.points import SparsePoints
from fsel.selection.candidates import EVEN, candidates, medoids, serving, stretches, uniform
from fsel.selection.covisible import FOLD, SECOND, covisible
from fsel.selection.scene_depth import scene_distances


def test_middles_of_equal_stretches():
    assert stretches(10, 2).tolist() == [2, 7]
    assert stretches(9, 3).tolist() == [1, 4, 7]
    assert stretches(5, 5).tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize(
    ("seconds", "left_out", "k", "expected"),
    [
        ([0, 1, 2, 3, 13, 14, 15, 16], [], 6, [0, 2, 3, 4, 5, 7]),  # a pause counts as 4 s
        ([0, 1, 2, 3, 4, 5, 6], [3], 3, [0, 2, 6]),
        ([0, 0.5, 1, 1.5, 2, 3, 4], [], 3, [0, 4, 6]),  # faster from 2 s on
        ([0, 1, 2, 0, 1, 2, np.nan], [], 3, [0, 3, 6]),  # two videos, and a photo
    ],
)
def test_frames_of_videos_are_even_in_time(seconds, left_out, k, expected):
    pool = np.setdiff1d(np.arange(len(seconds)), left_out)
    problem = SimpleNamespace(sequence=pool, seconds=np.array(seconds, float))
    assert pool[uniform(problem, k)].tolist() == expected
    problem.seconds = None
    assert uniform(problem, len(pool)).tolist() == list(range(len(pool)))


def test_a_distance_is_what_centres_and_sight_move_in_depths():
    turn = Rotation.from_euler("y", 60, degrees=True).as_matrix()
    places = np.array([[0, 0, 0], [3.0, 0, 0], [0, 0, 0]])
    capture = capture_of(places, [np.eye(3), np.eye(3), turn])
    xyz = np.array([[0.0, 0, 2], [3, 0, 2], turn.T @ [0, 0, 2]])
    seen = SparsePoints(xyz, np.zeros((3, 3), np.uint8), np.arange(3), np.arange(3))
    found = scene_distances(replace(capture, points=seen), np.arange(3))
    assert found[0, 1] == pytest.approx((3 + 3) / 2)
    assert found[0, 2] == pytest.approx((0 + 2) / 2)  # a chord of 60 degrees
    np.testing.assert_allclose(found, found.T)


@pytest.mark.parametrize("power", [1, 3])
def test_no_single_swap_makes_medoids_better(power):
    places = np.random.default_rng(power).normal(size=(25, 2))
    distance = np.linalg.norm(places[:, None] - places, axis=2)
    rows = medoids(distance, 5, power)

    def cost(chosen):
        return (distance[:, chosen].min(axis=1) ** power).sum()

    assert cost(rows) < cost(np.round(np.linspace(0, 24, 5)).astype(int))
    for place in range(5):
        for other in np.setdiff1d(np.arange(25), rows):
            swapped = rows.copy()
            swapped[place] = other
            assert cost(swapped) >= cost(rows) * (1 - 1e-5)


def slow_worth(problem, picks, served):
    """The mean of what picks see of every served frame's points, from sets and arc cosines."""
    points, centers = problem.capture.points, problem.capture.centers
    worth = {}
    for point, frame in {*zip(points.track_point, points.track_frame, strict=True)}:
        angles = []
        for pick in picks:
            if pick in points.track_frame[points.track_point == point]:
                a, b = (centers[f] - points.xyz[point] for f in (frame, pick))
                cosine = a @ b / np.linalg.norm(a) / np.linalg.norm(b)
                angles.append(np.exp(-np.arccos(np.clip(cosine, -1, 1)) / FOLD))
        first, second = ([*sorted(angles, reverse=True), 0, 0])[:2]
        worth.setdefault(frame, []).append((1 - SECOND) * first + SECOND * second)
    return sum(np.mean(values) for frame, values in worth.items() if served[frame])


@pytest.mark.parametrize("held", [(), (2, 5, 9)])
def test_no_single_exchange_makes_covisible_picks_better(held):
    problem = with_points(random_problem(14), count=25)
    pool = problem.observed
    targets = np.isin(np.arange(len(pool)), held)
    rows = covisible(problem, pool, 4, targets if len(held) else None)
    served = targets if len(held) else ~targets
    inside = replace(problem, capture=problem.capture.subset(pool))
    best = slow_worth(inside, rows, served)
    assert best > 0
    assert not np.isin(rows, held).any()
    for place in range(4):
        for other in np.setdiff1d(np.arange(len(pool)), np.union1d(rows, held)):
            swapped = rows.copy()
            swapped[place] = other
            assert slow_worth(inside, swapped, served) <= best * (1 + 1e-5)


def test_covisible_picks_are_the_same_on_any_number_of_threads(monkeypatch):
    problem = with_points(random_problem(100), count=50)
    found = []
    for count in ("1", "3"):
        monkeypatch.setenv(THREADS, count)
        found.append(covisible(problem, problem.observed, 8).tolist())
    assert found[0] == found[1]


def test_two_groups_that_share_no_point_get_a_pick_each():
    xyz, point = np.array([[0.0, 0, 400], [50, 0, 400]]), np.array([0, 0, 0, 0, 1, 1])
    seen = SparsePoints(xyz, np.zeros((2, 3), np.uint8), point, np.arange(6))
    capture = replace(in_line([0, 1, 2, 3, 49, 51]), points=seen)
    problem = problem_of(capture, [0, 1], np.arange(6))
    picks = covisible(problem, np.arange(6), 2)
    assert (picks < 4).tolist() == [True, False]


def every_candidate(problem):
    """Of a whole capture and of three targets, which none may hold; the rule picks the last six."""
    held, pool = problem.observed[[1, 8, 15]], np.delete(problem.observed, [1, 8, 15])
    told = replace(problem, candidates=pool, proxies=pool[:3], targets=problem.capture.view(held))
    found = serving(told, pool[-6:], held)
    for frames in found.values():
        assert len(np.unique(frames)) == 6
        assert np.isin(frames, pool).all()
    assert found["half_nearest"][:3].tolist() == found["nearest"][:3].tolist()
    left = np.setdiff1d(pool[-6:], found["nearest"][:3])
    assert found["half_nearest"][3:].tolist() == left[:3].tolist()
    return candidates(problem, 6) | {f"told {name}": frames for name, frames in found.items()}


def test_a_turned_scaled_and_shifted_world_changes_no_candidate():
    problem = with_points(random_problem(30))
    turn = Rotation.random(rng=np.random.default_rng(3)).as_matrix()
    other = moved(problem, turn, np.array([5.0, -3, 2]), 7.0)
    before, after = every_candidate(problem), every_candidate(other)
    assert list(before) == list(after)
    assert next(iter(before)) == EVEN
    for name, frames in before.items():
        assert len(np.unique(frames)) == 6
        assert np.isin(frames, problem.observed).all()
        np.testing.assert_array_equal(frames, after[name], err_msg=name)


def test_cameras_in_one_place_have_candidates():
    problem = problem_of(in_line(np.zeros(12)), [0, 1], np.arange(12))
    for name, frames in candidates(problem, 4).items():
        assert len(np.unique(frames)) == 4, name
