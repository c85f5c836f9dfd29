"""The six further groups of features: values by hand, and beside one-number-at-a-time forms."""

from dataclasses import replace

import numpy as np
import pytest
from selection_problems import permuted, random_problem

from fsel.experiments.paper.ablation.extras import EXTRAS, Relations, over_step, relations
from fsel.selectors.policies import POLICIES


def by_hand(**changes):
    """Three frames on a line at 0, 3, 4; two proxies at 1 and 4, with likeness given."""
    scene = Relations(
        distance=np.array([[1.0, 4.0], [2.0, 1.0], [3.0, 0.0]]),
        angle=np.array([[0.1, 0.2], [0.4, 0.3], [0.0, 0.6]]),
        likeness=np.array([[0.9, 0.1], [0.5, 0.5], [0.2, 0.8]]),
        centers=np.array([[0.0, 0, 0], [3, 0, 0], [4, 0, 0]]) - [7 / 3, 0, 0],
        axes=np.array([[0.0, 0, 1], [0, 1, 0], [0, 0, -1]]),
        descriptors=np.array([[1.0, 0], [0.6, 0.8], [0, 1]]),
        frames=10,
        budget=2,
    )
    return replace(scene, **changes)


def raw(name, picked=(), **changes):
    return EXTRAS[name].raw(by_hand(**changes), list(picked))


def test_capture_context_is_the_same_for_all():
    np.testing.assert_allclose(raw("capture_context"), [[7 / 3, np.log(3), 0.2]] * 3)
    scaled = EXTRAS["capture_context"].scale(raw("capture_context"), np.ones(3, bool))
    np.testing.assert_array_equal(scaled, raw("capture_context"))


def test_ranks_run_from_minus_to_plus_a_half():
    # d_min 1, 1, 0 (a tie); d_mean 2.5, 1.5, 1.5 (a tie); gamma_mean 0.15, 0.35, 0.3
    expected = [[0.25, 0.5, -0.5], [0.25, -0.25, 0.5], [-0.5, -0.25, 0]]
    np.testing.assert_allclose(raw("rank_normalised"), expected)
    stretched = raw("rank_normalised", distance=by_hand().distance ** 3)[:, 0]
    np.testing.assert_allclose(stretched, [0.25, 0.25, -0.5])


def test_soft_aggregates_by_hand():
    found = raw("soft_aggregates")
    temperature = np.std([1, 4, 2, 1, 3, 0])
    for i, (a, b) in enumerate([(1, 4), (2, 1), (3, 0)]):
        share = np.exp(-a / temperature) / (np.exp(-a / temperature) + np.exp(-b / temperature))
        assert found[i, 0] == pytest.approx(share * a + (1 - share) * b)
    assert found[1, 2] == pytest.approx(0.5)
    low, mean = by_hand().distance.min(axis=1), by_hand().distance.mean(axis=1)
    assert ((low < found[:, 0]) & (found[:, 0] < mean)).all()
    high = by_hand().likeness.max(axis=1)
    assert (found[:, 2] <= high).all()


def test_set_aware_trio_by_hand():
    one = raw("set_aware", [0])
    # nearest so far 1 and 4: frame 1 is nearer to the second proxy alone, so is frame 2
    np.testing.assert_allclose(one[1:, 0], [0.5, 0.5])
    # Schur complements of the likenesses 0.6 and 0 with frame 0
    np.testing.assert_allclose(one[1:, 1], np.log([1 - 0.36, 1.0]), atol=1e-5)
    np.testing.assert_array_equal(one[:, 2], 0)
    two = raw("set_aware", [0, 2])
    np.testing.assert_allclose(two[1], [0, np.log(2e-6), 3], atol=0.5)


def test_z_scores_are_over_what_is_left():
    left = np.array([True, True, False, True])
    values = np.array([[1.0], [3.0], [99.0], [5.0]])
    scaled = over_step(values, left)
    np.testing.assert_allclose(scaled[:, 0], [-np.sqrt(1.5), 0, 0, np.sqrt(1.5)])


def slow_gain(kernel, picked, row):
    """log det of the kernel of the picks and a row, minus that of the picks."""
    kernel = kernel + 1e-6 * np.eye(len(kernel))
    both = [*picked, row]
    determinants = [np.linalg.slogdet(kernel[np.ix_(s, s)])[1] for s in (both, picked)]
    return determinants[0] - determinants[1]


def test_groups_on_a_capture_beside_plain_loops():
    problem = random_problem(n=24)
    prepared = POLICIES["less_is_more"].prepare(problem)
    scene = relations(problem, prepared, budget=6)
    centers, axes = problem.capture.centers, problem.capture.axes
    described = problem.descriptors.astype(np.float64)
    picked, pool = [3, 8, 1], prepared.pool
    worst, mean, trio = (
        EXTRAS[name].raw(scene, picked) for name in ("worst_case", "mean_redundancy", "set_aware")
    )
    for row, frame in enumerate(pool):
        gaps = [np.linalg.norm(centers[frame] - centers[o]) for o in problem.proxies]
        turns = [np.arccos(np.clip(axes[frame] @ axes[o], -1, 1)) for o in problem.proxies]
        alike = [described[frame] @ described[o] for o in problem.proxies]
        np.testing.assert_allclose(worst[row], [max(gaps), max(turns), min(alike)], atol=1e-7)
        if row in picked:
            continue
        chosen = [pool[p] for p in picked]
        apart = sorted(np.linalg.norm(centers[frame] - centers[p]) for p in chosen)
        turned = [np.arccos(np.clip(axes[frame] @ axes[p], -1, 1)) for p in chosen]
        same = [described[frame] @ described[p] for p in chosen]
        averages = [np.mean(apart), np.mean(turned), np.mean(same)]
        np.testing.assert_allclose(mean[row], averages, atol=1e-7)
        wins = [
            gap < min(np.linalg.norm(centers[p] - centers[o]) for p in chosen)
            for gap, o in zip(gaps, problem.proxies, strict=True)
        ]
        kernel = described[pool] @ described[pool].T
        expected = [np.mean(wins), slow_gain(kernel, picked, row), apart[1]]
        np.testing.assert_allclose(trio[row], expected, atol=1e-7)


def test_blank_and_repeated_descriptors_have_finite_gains():
    described = np.array([[1.0, 0], [1, 0], [0, 0]])
    found = raw("set_aware", [0, 1], descriptors=described)
    assert np.isfinite(found).all()


@pytest.mark.parametrize("name", EXTRAS)
def test_the_order_of_frames_does_not_matter(name):
    problem = random_problem(n=24)
    order = np.random.default_rng(3).permutation(24)
    place = np.argsort(order)
    prepared = POLICIES["less_is_more"].prepare(problem)
    other = permuted(problem, order)
    shuffled = POLICIES["less_is_more"].prepare(other)
    rows = np.searchsorted(shuffled.pool, place[prepared.pool])
    picked = [4, 9, 2]
    values = EXTRAS[name].raw(relations(problem, prepared, 6), picked)
    again = EXTRAS[name].raw(relations(other, shuffled, 6), rows[picked].tolist())
    np.testing.assert_allclose(again[rows], values, atol=1e-9)
