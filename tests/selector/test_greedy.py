"""The compiled greedy loop picks what a plain float64 loop picks, and training sees its inputs."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from selection_problems import capture_of, random_problem
from slow_selector import POLICIES, slow_inputs

from fsel.experiments.hard_cases.worlds import moved, random_weights
from fsel.features.static import FEATURES
from fsel.problem import checked_select
from fsel.selector import plain
from fsel.selector.greedy import (
    DYNAMIC,
    greedy,
    learned_method,
    prepare,
    run_greedy,
    standardise,
    trajectory_inputs,
)
from fsel.selector.scorer import INPUTS, Scorer
from fsel.training.refinement import linear_weights

LOOPS = {"compiled": greedy, "plain": plain.greedy}
loops = pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS.keys())
policies = pytest.mark.parametrize("policy", POLICIES.values(), ids=POLICIES.keys())


def slow_greedy(problem, weights, k, policy):
    scorer = Scorer(weights, {})
    picked, scores = [], []
    for _ in range(k):
        left, inputs = slow_inputs(problem, picked, **policy)
        values = scorer.scores(inputs)
        scores.append(values.max())
        picked.append(int(left[np.argmax(values)]))
    return np.array(picked), np.array(scores)


@loops
@policies
@pytest.mark.parametrize("seed", range(12))
def test_picks_against_the_slow_loop(loop, policy, seed):
    problem = random_problem(20 + 3 * seed, seed)
    weights = random_weights(seed, gain=(0.3, 1.0, 3.0)[seed % 3])
    prepared = prepare(problem, **policy)
    rows, scores = loop(prepared, weights, 8)
    want_rows, want_scores = slow_greedy(problem, weights, 8, policy)
    np.testing.assert_array_equal(rows, want_rows)
    np.testing.assert_allclose(scores, want_scores, rtol=1e-9, atol=1e-9)


@loops
@policies
def test_the_whole_pool_in_order(loop, policy):
    problem = random_problem(17, 5, targets=3)
    prepared = prepare(problem, **policy)
    n = len(prepared.pool)
    rows, _ = loop(prepared, random_weights(5), n)
    np.testing.assert_array_equal(np.sort(rows), np.arange(n))
    np.testing.assert_array_equal(rows, slow_greedy(problem, random_weights(5), n, policy)[0])


@policies
def test_training_sees_what_greedy_sees(policy):
    problem = random_problem(40, 2)
    prepared = prepare(problem, **policy)
    weights = random_weights(2)
    rows, scores = greedy(prepared, weights, 10)
    features, selectable = trajectory_inputs(prepared, rows)
    assert features.shape == (10, len(prepared.pool), INPUTS)
    assert features.dtype == np.float32
    for step, row in enumerate(rows):
        np.testing.assert_array_equal(np.flatnonzero(~selectable[step]), np.sort(rows[:step]))
        left, want = slow_inputs(problem, list(rows[:step]), **policy)
        np.testing.assert_allclose(features[step][left], want, atol=2e-6)
        seen = np.where(selectable[step], Scorer(weights, {}).scores(features[step]), -np.inf)
        assert np.argmax(seen) == row
        assert seen.max() == pytest.approx(scores[step], abs=1e-5)


def test_the_first_step_has_no_selection_conditioned_input():
    prepared = prepare(random_problem(30), **POLICIES["fsel"])
    features, _ = trajectory_inputs(prepared, np.array([4, 2]))
    np.testing.assert_array_equal(features[0][:, 13:17], 0)
    assert (features[1][:, 13:17].std(axis=0) > 0.5).all()


@policies
def test_the_nineteenth_input_is_zero_without_coverage(policy):
    features, _ = trajectory_inputs(prepare(random_problem(30), **policy), np.array([4, 2]))
    assert features[..., 18].any() == policy["coverage"]


@policies
def test_budgets_are_nested(policy):
    prepared = prepare(random_problem(40, 9), **policy)
    whole, _ = greedy(prepared, random_weights(9), 20)
    for k in (1, 7, 19):
        np.testing.assert_array_equal(greedy(prepared, random_weights(9), k)[0], whole[:k])


@loops
def test_a_constant_scorer_takes_the_lowest_rows(loop):
    weights = {name: np.zeros_like(array) for name, array in random_weights(0).items()}
    weights["layer3.bias"][0] = 3
    rows, scores = loop(prepare(random_problem(30), **POLICIES["ours"]), weights, 5)
    np.testing.assert_array_equal(rows, np.arange(5))
    np.testing.assert_array_equal(scores, 3)


@loops
def test_float32_screening_never_decides_between_near_ties(loop):
    problem = random_problem(60, 12)
    sharpness = np.where(np.isin(np.arange(60), problem.candidates[[3, 30, 41]]), 900.0, 10.0)
    sharpness[problem.candidates[41]] += 1e-9
    prepared = prepare(replace(problem, sharpness=sharpness), **POLICIES["ours"])
    only_sharpness = np.zeros(INPUTS)
    only_sharpness[FEATURES.index("sharpness")] = 1
    rows, _ = loop(prepared, linear_weights(only_sharpness), 3)
    np.testing.assert_array_equal(rows, [41, 3, 30])


def test_weights_read_from_a_file_pick_the_same(tmp_path):
    prepared = prepare(random_problem(40), **POLICIES["ours"])
    scorer = Scorer(random_weights(4), {})
    scorer.save(tmp_path / "s.safetensors")
    read = Scorer.load(tmp_path / "s.safetensors").weights
    again = greedy(prepared, read, 10)
    for got, want in zip(again, greedy(prepared, scorer.weights, 10), strict=True):
        np.testing.assert_array_equal(got, want)


@loops
@policies
def test_of_equal_frames_the_lowest_goes_first(loop, policy):
    problem = random_problem(60, 11)
    twin = np.arange(60)
    twin[30:] = np.arange(30)
    same = replace(
        problem,
        capture=replace(problem.capture, world_to_camera=problem.capture.world_to_camera[twin]),
        descriptors=problem.descriptors[twin],
        sharpness=problem.sharpness[twin],
    )
    prepared = prepare(same, **policy)
    for seed in range(20):
        row = loop(prepared, random_weights(seed), 1)[0][0]
        equal = np.flatnonzero(twin[prepared.pool] == twin[prepared.pool[row]])
        assert row == equal[0]


@loops
@policies
def test_cameras_in_one_place_are_no_trouble(loop, policy):
    problem = random_problem(24, 3)
    capture = capture_of(np.zeros((24, 3)), np.tile(np.eye(3), (24, 1, 1)))
    one = replace(problem, capture=capture, targets=capture.view(np.arange(4)))
    prepared = prepare(one, **policy)
    assert np.isfinite(prepared.static).all()
    rows, scores = loop(prepared, random_weights(3), len(prepared.pool))
    np.testing.assert_array_equal(np.sort(rows), np.arange(len(prepared.pool)))
    assert np.isfinite(scores).all()


@policies
def test_picks_do_not_depend_on_the_worlds_frame_or_scale(policy):
    for seed in range(5):
        problem = random_problem(40, seed)
        rng = np.random.default_rng(seed)
        rotation = Rotation.random(rng=rng).as_matrix()
        other = moved(problem, rotation, rng.normal(scale=50, size=3), 10.0 ** rng.uniform(-3, 3))
        first = greedy(prepare(problem, **policy), random_weights(seed), 15)[0]
        second = greedy(prepare(other, **policy), random_weights(seed), 15)[0]
        np.testing.assert_array_equal(first, second)


def test_the_generic_loop_agrees():
    prepared = prepare(random_problem(40, 6), **POLICIES["fsel"])
    weights = random_weights(6)

    def score(inputs):
        full = prepared.static.copy()
        full[:, DYNAMIC] += inputs
        return Scorer(weights, {}).scores(full)

    rows, scores = run_greedy(prepared, score, 12)
    fast_rows, fast_scores = greedy(prepared, weights, 12)
    np.testing.assert_array_equal(rows, fast_rows)
    np.testing.assert_allclose(scores, fast_scores, rtol=1e-12)


def test_z_scores_by_hand():
    columns = np.array([[1.0, 5, 1e9], [2, 5, 1e9 + 1e-3], [3, 5, 1e9]])
    got = standardise(columns)
    np.testing.assert_allclose(got[:, 0], [-np.sqrt(1.5), 0, np.sqrt(1.5)])
    np.testing.assert_array_equal(got[:, 1:], 0)


@loops
@pytest.mark.parametrize("k", [0, -1, 1000])
def test_an_impossible_budget_is_refused(loop, k):
    prepared = prepare(random_problem(30), **POLICIES["ours"])
    with pytest.raises(ValueError, match=f"got {k}"):
        loop(prepared, random_weights(0), k)


@policies
def test_a_learned_method_keeps_the_contract(policy):
    problem = random_problem(40)
    scorer = Scorer(random_weights(0), {})
    method = learned_method("ours", "Ours", scorer, **policy)
    rng = np.random.default_rng(0)
    for k in (1, 10, len(problem.pool(policy["pool"]))):
        picks = checked_select(method, problem, k, rng)
        np.testing.assert_array_equal(picks, checked_select(method, problem, k, rng))


@policies
@pytest.mark.parametrize("gain", [0.3, 1.0, 4.0])
def test_rows_that_are_not_looked_at_would_not_have_been_picked(policy, gain):
    problem = random_problem(1200, 21, targets=9)
    prepared, weights = prepare(problem, **policy), random_weights(7, gain)
    rows, scores = greedy(prepared, weights, 60)
    want_rows, want_scores = plain.greedy(prepared, weights, 60)
    np.testing.assert_array_equal(rows, want_rows)
    np.testing.assert_allclose(scores, want_scores, rtol=1e-9, atol=1e-9)
