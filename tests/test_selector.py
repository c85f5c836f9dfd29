"""The compiled greedy loop picks what a plain float64 loop picks, and training sees its inputs."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from selection_problems import capture_of, random_problem

from fsel import greedy_plain
from fsel.features import FEATURES, STATIC, static_features
from fsel.problem import checked_select
from fsel.refine import linear_weights
from fsel.scorer import INPUTS, Scorer
from fsel.selector import (
    DYNAMIC,
    greedy,
    learned_method,
    prepare,
    run_greedy,
    standardise,
    trajectory_inputs,
)
from fsel.stability.worlds import moved, random_weights

POLICIES = {
    "ours": {
        "pool": "candidates", "reference": "proxies", "appearance": True, "coverage": False,
    },
    "no_appearance": {
        "pool": "candidates", "reference": "proxies", "appearance": False, "coverage": False,
    },
    "fsel": {"pool": "observed", "reference": "targets", "appearance": True, "coverage": True},
}  # fmt: skip
LOOPS = {"compiled": greedy, "plain": greedy_plain.greedy}
loops = pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS.keys())
policies = pytest.mark.parametrize("policy", POLICIES.values(), ids=POLICIES.keys())


def views_of(problem, reference):
    proxies = problem.capture.view(problem.proxies)
    return problem.targets if reference == "targets" else proxies


def z_scores(values):
    if values.std() <= 1e-9 * np.abs(values).max():
        return np.zeros(len(values))
    return (values - values.mean()) / values.std()


def angle(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)


def slow_inputs(problem, picked, *, pool, reference, appearance, coverage):
    """(rows left, 19) the scorer's inputs after some picks, one number at a time."""
    frames = problem.pool(pool)
    views = views_of(problem, reference)
    static = static_features(problem, frames, views, appearance)
    columns = dict(zip(STATIC, static.T, strict=True))
    left = [row for row in range(len(frames)) if row not in picked]
    inputs = np.zeros((len(left), INPUTS))
    for position, name in enumerate(FEATURES):
        if name in columns:
            inputs[:, position] = z_scores(columns[name])[left]
    if picked:
        relations = slow_relations(problem, frames, views, left, picked, coverage)
        for name, values in relations.items():
            if appearance or name != "rho_max_s":
                inputs[:, FEATURES.index(name)] = z_scores(np.array(values))
    if coverage:
        inputs[:, 18] = slow_coverage(problem, frames, views, left, picked)
    return np.array(left), inputs


def slow_company(distances):
    """(rows left,) from (rows left, picks): to the fourth nearest of fewer than ten picks, the
    farthest of fewer than four; else as if all inverse squares came from one; to 1.5 means."""
    values = []
    for row in distances:
        if len(row) < 10:
            values.append(sorted(row)[: min(4, len(row))][-1])
        else:
            values.append(0.0 if min(row) == 0 else sum(d**-2 for d in row) ** -0.5)
    return np.minimum(values, 1.5 * np.mean(values))


def slow_relations(problem, frames, views, left, picked, coverage):
    capture = problem.capture
    centroid = capture.centers[problem.candidates].mean(axis=0)
    points = [
        c + max(0.0, (centroid - c) @ a) * a for c, a in zip(views.centers, views.axes, strict=True)
    ]
    common = np.mean(points, axis=0)

    def over(measure, best):
        return [best(measure(frames[i], frames[j]) for j in picked) for i in left]

    centers, axes, described = capture.centers, capture.axes, problem.descriptors.astype(float)
    if coverage:
        bearings = centers - common
        bearings /= np.linalg.norm(bearings, axis=1, keepdims=True)
        compared = {"d_min_s": centers, "gamma_min_s": axes, "phi_nov": bearings}
        company = {}
        for name, place in compared.items():
            at, picks = place[frames[left]], place[frames[picked]]
            company[name] = slow_company([[np.linalg.norm(p - j) for j in picks] for p in at])
        return company | {"rho_max_s": over(lambda i, j: described[i] @ described[j], max)}
    return {
        "d_min_s": over(lambda i, j: np.linalg.norm(centers[i] - centers[j]), min),
        "gamma_min_s": over(lambda i, j: angle(axes[i], axes[j]), min),
        "rho_max_s": over(lambda i, j: described[i] @ described[j], max),
        "phi_nov": over(lambda i, j: angle(centers[i] - common, centers[j] - common), min),
    }


def slow_coverage(problem, frames, views, left, picked):
    """What each row would add to the mean over views of log(1 + summed closeness), to first order,
    in proportion less within 0.2 of a pick's look; less its remoteness."""
    centers, axes = problem.capture.centers[frames], problem.capture.axes[frames]
    depth = 1.8 * np.sqrt(np.mean(np.linalg.norm(centers - centers.mean(axis=0), axis=1) ** 2))
    closeness, far = np.zeros((2, len(frames), len(views)))
    for t, (c, a) in enumerate(zip(views.centers, views.axes, strict=True)):
        shift = np.linalg.norm(centers - c, axis=1)
        ahead = np.linalg.norm(centers + depth * axes - c - depth * a, axis=1)
        distance = shift + 2 * ahead
        far[:, t] = distance
        for i in range(len(frames)):
            rank = np.sum(distance < distance[i])
            closeness[i, t] = 0.7**rank if rank < 64 else 0
    covered = closeness[list(picked)].sum(axis=0)
    remote = [min(far[i]) / depth / 75 for i in left]
    looked = centers + depth * axes

    def apart(i, j):
        ahead = np.linalg.norm(looked[i] - looked[j])
        return (np.linalg.norm(centers[i] - centers[j]) + 2 * ahead) / depth

    novel = [min([1, *(apart(i, j) / 0.2 for j in picked)]) for i in left]
    gain = [(closeness[i] / (1 + covered)).mean() for i in left]
    return np.array(gain) * novel - remote


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
    want_rows, want_scores = greedy_plain.greedy(prepared, weights, 60)
    np.testing.assert_array_equal(rows, want_rows)
    np.testing.assert_allclose(scores, want_scores, rtol=1e-9, atol=1e-9)
