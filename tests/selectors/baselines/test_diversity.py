"""Selection by diversity: hand-worked cases, brute force, and published packages as oracles."""

import kmedoids
import numpy as np
import pytest
from scipy.cluster.vq import kmeans2
from scipy.spatial.transform import Rotation
from selection_problems import in_line, problem_of, random_capture, random_problem

from fsel.core.geometry import pairwise_angles, pairwise_distances
from fsel.features.appearance import KERNEL_JITTER
from fsel.selectors.baselines import METHODS
from fsel.selectors.baselines import kmedoids as kmedoids_method
from fsel.selectors.baselines.by_appearance import greedy_map
from fsel.selectors.baselines.by_pose import lloyd, snapped
from fsel.selectors.baselines.greedy import lazy_greedy, locate, most_central
from fsel.selectors.baselines.kmedoids import distances, fasterpam


def select(name, problem, k):
    return METHODS[name].select(problem, k, np.random.default_rng(0))


def observed(capture, described=None, **more):
    """A problem of all frames but the last two, which are targets."""
    n = len(capture) - 2
    if described is not None:
        described = np.vstack([described, np.ones((2, len(described[0])))]).astype(np.float32)
    return problem_of(capture, [0, 1], np.arange(2, n), [n, n + 1], described, **more)


def described_by(rows):
    return observed(random_capture(len(rows) + 2), rows)


def unit_rows(rng, n, width):
    rows = rng.normal(size=(n, width)) + 0.8
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


@pytest.mark.parametrize("seed", range(5))
def test_lazy_and_plain_greedy_pick_alike(seed):
    rng = np.random.default_rng(seed)
    value = rng.integers(0, 4, (20, 20)).astype(np.float32)  # many ties
    served, picked = np.zeros(20, np.float32), []
    for _ in range(20):
        gains = np.maximum(value - served, 0).sum(axis=1)
        gains[picked] = -1
        picked.append(int(np.argmax(gains)))
        served = np.maximum(served, value[picked[-1]])
    np.testing.assert_array_equal(locate(lambda rows: value[rows], np.full(20, np.inf), 20), picked)


def test_lazy_greedy_looks_again_only_where_it_could_matter():
    known = np.array([5.0, 4.0, 1.0, 0.5])
    computed = []

    def gains(rows):
        computed.extend(rows.tolist())
        return known[rows]

    assert lazy_greedy(known, gains, lambda row: None, 2).tolist() == [0, 1]
    assert computed == [0, 1]


def test_facility_location_by_hand():
    # three alike, two alike and one alone, orthogonal: gains 9, then 2, then 1, then nothing
    rows = np.eye(3)[[0, 0, 0, 1, 1, 2]]
    assert select("facility", described_by(rows), 4).tolist() == [0, 3, 5, 1]


@pytest.mark.parametrize("seed", range(4))
def test_dpp_takes_the_largest_determinant_at_every_step(seed):
    rows = unit_rows(np.random.default_rng(seed), 25, 30)
    kernel = rows @ rows.T + KERNEL_JITTER * np.eye(25)
    picks = greedy_map(rows, KERNEL_JITTER, 12)
    assert picks[0] == np.argmax(kernel.sum(axis=1))
    for step in range(1, 12):
        left = np.setdiff1d(np.arange(25), picks[:step])
        sets = [[*picks[:step], i] for i in left]
        logdet = [np.linalg.slogdet(kernel[np.ix_(s, s)])[1] for s in sets]
        assert picks[step] == left[np.argmax(logdet)]


def test_dpp_beyond_the_rank_goes_on_in_order():
    # the jitter leaves a second copy 2 parts in a million of its length, a third copy 1.5
    rows = np.repeat(np.eye(3), 3, axis=0)
    assert greedy_map(rows, KERNEL_JITTER, 9).tolist() == [0, 3, 6, 1, 4, 7, 2, 5, 8]


def slow_distances(problem):
    pool = problem.observed
    centers, axes = problem.capture.centers[pool], problem.capture.axes[pool]
    f = problem.descriptors[pool].astype(np.float64)
    parts = (pairwise_distances(centers, centers), pairwise_angles(axes, axes), 1 - f @ f.T)
    return sum(part / part.max() for part in parts) / 3


def test_kmedoids_distance_against_numpy():
    problem = random_problem(30)
    pool = problem.observed
    capture = problem.capture
    got = distances(capture.centers[pool], capture.axes[pool], problem.descriptors[pool])
    rows = np.arange(len(pool))
    np.testing.assert_allclose(got(rows), slow_distances(problem), atol=1e-6)
    np.testing.assert_array_equal(got(rows[[7, 3]]), got(rows)[[7, 3]])


@pytest.mark.parametrize("seed", range(6))
def test_kmedoids_cannot_be_bettered_by_one_swap(seed):
    problem = random_problem(40, seed)
    distance, k = slow_distances(problem), 7
    picks = np.searchsorted(problem.observed, select("kmedoids", problem, k))
    loss = distance[picks].min(axis=0).sum()
    for m in range(k):
        for candidate in np.setdiff1d(np.arange(len(distance)), picks):
            swapped = [*np.delete(picks, m), candidate]
            assert distance[swapped].min(axis=0).sum() >= loss - 1e-5
    oracle = kmedoids.fasterpam(distance, picks.astype(np.uint64))
    assert oracle.n_swap == 0
    assert oracle.loss == pytest.approx(loss)


@pytest.mark.parametrize("block", [1, 7, 64])
def test_kmedoids_in_blocks_picks_as_from_the_whole_matrix(monkeypatch, block):
    problem = random_problem(60, seed=block)
    picks = select("kmedoids", problem, 9)
    monkeypatch.setattr(kmedoids_method, "DENSE", 0)
    monkeypatch.setattr(kmedoids_method, "BLOCK", block)
    np.testing.assert_array_equal(select("kmedoids", problem, 9), picks)
    distance = slow_distances(problem).astype(np.float32)
    start = np.arange(0, 36, 4)
    swapped = fasterpam(distance.__getitem__, len(distance), start)
    assert set(swapped) != set(start)
    assert kmedoids.fasterpam(distance, swapped.astype(np.uint64)).n_swap == 0


@pytest.mark.parametrize("seed", range(4))
def test_build_against_a_published_package(seed):
    distance = slow_distances(random_problem(40, seed)).astype(np.float32)
    got = locate(lambda rows: 1 - distance[rows], np.full(len(distance), np.inf), 6)
    oracle = kmedoids.pam_build(distance, 6)
    assert set(got) == set(oracle.medoids.astype(int))


def test_lloyd_against_scipy():
    rng = np.random.default_rng(4)
    points = rng.normal(size=(60, 6))
    start = points[:7]
    expected, _ = kmeans2(points, start, iter=300, minit="matrix")
    np.testing.assert_allclose(lloyd(points, start, 300), expected)


def test_long_lrm_by_hand():
    # two groups of cameras on a line, means at 1 and 10.5: the nearest frames are 1 and the tie 3
    assert set(select("long_lrm", observed(in_line([0, 1, 2, 10, 11, 3, 3])), 2)) == {1, 3}


def test_a_frame_serves_one_mean_only():
    points = np.array([[0.0], [1], [5]])
    np.testing.assert_array_equal(snapped(points, np.array([[0.1], [0.2], [0.3]])), [0, 1, 2])


def test_indoor_traj_against_a_plain_loop():
    problem = random_problem(40, seed=5)
    pool, capture = problem.observed, problem.capture
    centers, f = capture.centers, problem.descriptors.astype(np.float64)
    offset = centers[pool] - centers[pool].mean(axis=0)
    sigma = 0.5 * np.sqrt(np.mean(np.sum(offset**2, axis=1)))
    turns = Rotation.from_matrix(capture.world_to_camera[:, :, :3])

    def alike(i, j):
        near = np.exp(-(np.linalg.norm(centers[i] - centers[j]) ** 2) / (2 * sigma**2))
        angle = (turns[i] * turns[j].inv()).magnitude()
        return 0.7 * near + 0.2 * (np.cos(angle) + 1) / 2 + 0.1 * f[i] @ f[j]

    picks = select("indoor_traj", problem, 12)
    assert picks[0] == pool[most_central(centers[pool])]
    for step in range(1, 12):
        left = np.setdiff1d(pool, picks[:step])
        assert picks[step] == min(left, key=lambda i: max(alike(i, j) for j in picks[:step]))


def test_sharpest_by_hand():
    problem = observed(random_capture(9), sharpness=[1, 5, 2, 4, 4, 0, 9, 99, 99])
    # windows 0-2, 3-4, 5-6; the tie in the middle goes to the lower frame
    assert select("sharpest", problem, 3).tolist() == [1, 3, 6]
