"""Both greedy loops pick what a loop over plain numbers picks, by networks and linear rules alike,
and training sees their inputs."""

from dataclasses import replace

import numpy as np
import pytest
from selection_problems import random_problem, random_weights
from slow_selector import POLICIES, random_scorer, slow_inputs, spelled

from fsel.features.columns import (
    APPEARANCE,
    INPUTS,
    NAMES,
    SHARPNESS,
    TARGET_GAIN,
    TARGET_GAIN_INPUT,
    positions,
)
from fsel.selectors import pretrained, reference_loop
from fsel.selectors.greedy import greedy, standardise
from fsel.selectors.policies import GEOMETRY
from fsel.selectors.policies import POLICIES as SHIPPED
from fsel.selectors.rollout import Rollout, follow, pick
from fsel.selectors.scorer import Linear, Network

LOOPS = {"compiled": greedy, "plain": reference_loop.greedy}
loops = pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS.keys())
policies = pytest.mark.parametrize("policy", POLICIES.values(), ids=POLICIES.keys())


def slow_greedy(problem, scorer, k, policy):
    picked, scores = [], []
    for _ in range(k):
        left, inputs = slow_inputs(problem, picked, policy)
        values = scorer.scores(inputs)
        scores.append(values.max())
        picked.append(int(left[np.argmax(values)]))
    return np.array(picked), np.array(scores)


def with_depths(problem, seed=0):
    depths = np.random.default_rng([3, seed]).uniform(0.5, 4, len(problem.targets))
    return replace(problem, target_depths=depths)


@pytest.mark.parametrize(
    ("name", "depths"),
    [*((name, False) for name in POLICIES), *((n, True) for n, p in POLICIES.items() if p.points)],
)
@pytest.mark.parametrize("seed", range(3))
def test_picks_against_the_slow_loop(name, depths, seed):
    policy, problem = POLICIES[name], random_problem(20 + 6 * seed, seed)
    problem = with_depths(problem, seed) if depths else problem
    scorer = random_scorer(policy, seed, gain=(0.3, 1.0, 3.0)[seed % 3])
    prepared = policy.prepare(problem)
    k = 8 if seed else len(prepared.pool)
    want_rows, want_scores = slow_greedy(problem, scorer, k, policy)
    for loop in LOOPS.values():
        rows, scores = loop(prepared, scorer, k)
        np.testing.assert_array_equal(rows, want_rows)
        np.testing.assert_allclose(scores, want_scores, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("size", [40, 1200])
def test_the_shipped_rule_picks_what_the_network_that_spells_it_picks(size):
    problem, rule = random_problem(size, 4, targets=9), pretrained.method().scorer
    network = spelled(rule.coefficients)
    rows, scores = greedy(SHIPPED["fsel"].prepare(problem), rule, 30)
    # the network is shown every input, the rule only those that it reads
    want_rows, want_scores = greedy(POLICIES["every"].prepare(problem), network, 30)
    np.testing.assert_array_equal(rows, want_rows)
    np.testing.assert_allclose(scores, want_scores, rtol=1e-6)


@policies
def test_training_sees_what_greedy_sees(policy):
    problem = with_depths(random_problem(40, 2)) if policy.points else random_problem(40, 2)
    prepared, scorer = policy.prepare(problem), random_scorer(policy, 2)
    rows, scores = greedy(prepared, scorer, 10)
    features, selectable = follow(Rollout(prepared), rows)
    assert features.shape == (10, len(prepared.pool), INPUTS)
    assert features.dtype == np.float32
    read = np.isin(NAMES, policy.inputs)
    assert features[..., TARGET_GAIN_INPUT].any() == (TARGET_GAIN in policy.inputs)
    for step, row in enumerate(rows):
        np.testing.assert_array_equal(np.flatnonzero(~selectable[step]), np.sort(rows[:step]))
        left, want = slow_inputs(problem, list(rows[:step]), policy)
        np.testing.assert_allclose(features[step][left][:, read], want[:, read], atol=2e-6)
        seen = np.where(selectable[step], scorer.scores(features[step]), -np.inf)
        assert np.argmax(seen) == row
        assert seen.max() == pytest.approx(scores[step], abs=1e-5)


@policies
def test_picking_by_any_score_is_the_same_loop(policy):
    prepared, scorer = policy.prepare(random_problem(40, 6)), random_scorer(policy, 6)
    rows = pick(Rollout(prepared), lambda features, left, past: scorer.scores(features[-1]), 12)
    np.testing.assert_array_equal(rows, greedy(prepared, scorer, 12)[0])


@loops
def test_a_constant_scorer_takes_the_lowest_rows(loop):
    weights = {name: np.zeros_like(array) for name, array in random_weights(0).items()}
    weights["layer3.bias"][0] = 3
    rows, scores = loop(POLICIES["less_is_more"].prepare(random_problem(30)), Network(weights), 5)
    np.testing.assert_array_equal(rows, np.arange(5))
    np.testing.assert_array_equal(scores, 3)
    rows, scores = loop(POLICIES["sum"].prepare(random_problem(30)), Linear({"c_vis": 0.0}), 5)
    np.testing.assert_array_equal(rows, np.arange(5))
    np.testing.assert_array_equal(scores, 0)


@loops
@pytest.mark.parametrize("make", [spelled, Linear])
def test_rounding_never_decides_between_near_ties(loop, make):
    problem = random_problem(60, 12)
    sharpness = np.where(np.isin(np.arange(60), problem.candidates[[3, 30, 41]]), 900.0, 10.0)
    sharpness[problem.candidates[41]] += 1e-9
    prepared = POLICIES["less_is_more"].prepare(replace(problem, sharpness=sharpness))
    rows, _ = loop(prepared, make({"sharpness": 1.0}), 3)
    np.testing.assert_array_equal(rows, [41, 3, 30])


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
    prepared = policy.prepare(same)
    for seed in range(20):
        row = loop(prepared, random_scorer(policy, seed), 1)[0][0]
        equal = np.flatnonzero(twin[prepared.pool] == twin[prepared.pool[row]])
        assert row == equal[0]


def test_z_scores_by_hand():
    columns = np.array([[1.0, 5, 1e9], [2, 5, 1e9 + 1e-3], [3, 5, 1e9]])
    got = standardise(columns)
    np.testing.assert_allclose(got[:, 0], [-np.sqrt(1.5), 0, np.sqrt(1.5)])
    np.testing.assert_array_equal(got[:, 1:], 0)


@loops
@pytest.mark.parametrize("k", [0, -1, 1000])
def test_an_impossible_budget_is_refused(loop, k):
    prepared = POLICIES["less_is_more"].prepare(random_problem(30))
    with pytest.raises(ValueError, match=f"got {k}"):
        loop(prepared, Network(random_weights(0)), k)


def test_a_policy_takes_scorers_of_its_kind_and_inputs_only():
    for name, scorer, said in (
        ("fsel", Network(random_weights(0)), "Network"),
        ("less_is_more", pretrained.method().scorer, "Linear"),
        ("fsel", Linear({"d_min_s": 1.0, "sharpness": 1.0}), "sharpness"),
    ):
        with pytest.raises(ValueError, match=said):
            SHIPPED[name].method(scorer)


@policies
@pytest.mark.parametrize("gain", [0.3, 1.0, 4.0])
def test_rows_whose_exact_score_is_not_computed_would_not_have_been_picked(policy, gain):
    prepared = policy.prepare(random_problem(1200, 21, targets=9))
    scorer = random_scorer(policy, 7, gain)
    (rows, scores), (want_rows, want) = (loop(prepared, scorer, 30) for loop in LOOPS.values())
    np.testing.assert_array_equal(rows, want_rows)
    np.testing.assert_allclose(scores, want, rtol=1e-9, atol=1e-9)


def test_views_that_stand_for_a_capture_count_less_after_seven_picks():
    """With the gain alone, picks are the same; the gain at step j is 7 / j of what it was."""
    problem = random_problem(60, 5, targets=9)
    rule = Linear({"target_gain": 1.0})
    told, whole = (
        SHIPPED["fsel"].prepare(replace(problem, targets_unknown=flag)) for flag in (False, True)
    )
    for prepared in (told, whole):
        prepared.static[:] = 0
    rows, scores = reference_loop.greedy(told, rule, 40)
    less_rows, less = reference_loop.greedy(whole, rule, 40)
    np.testing.assert_array_equal(less_rows, rows)
    np.testing.assert_allclose(less, scores * np.minimum(1, 7 / np.maximum(np.arange(40), 1)))
    fast_rows, fast = greedy(whole, rule, 40)
    np.testing.assert_array_equal(fast_rows, rows)
    np.testing.assert_allclose(fast, less, rtol=1e-9)


def test_given_rows_come_first_and_the_rest_is_chosen_beside_them():
    problem = random_problem(60, 5, targets=9)
    first = problem.pool("observed")[[40, 7]]
    method = pretrained.method()
    picks = method.ranked(replace(problem, fixed_picks=first), 9)[0]
    assert picks[:2].tolist() == first.tolist()
    assert len(set(picks.tolist())) == 9
    free = method.ranked(problem, 9)[0]
    again = method.ranked(replace(problem, fixed_picks=free[:4]), 9)[0]
    np.testing.assert_array_equal(again, free)


def test_inputs_that_a_policy_does_not_read_are_zero_and_the_others_as_they_are():
    problem = random_problem(40)
    full, few = (p.prepare(problem).static for p in (SHIPPED["less_is_more"], GEOMETRY))
    gone = positions((*APPEARANCE, SHARPNESS))
    assert full[:, gone[:-2]].any(axis=0).all()
    assert full[:, gone[-1]].any()
    assert not few[:, gone].any()
    kept = np.setdiff1d(np.arange(len(NAMES)), gone)
    np.testing.assert_array_equal(few[:, kept], full[:, kept])
