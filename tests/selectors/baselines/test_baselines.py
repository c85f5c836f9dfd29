"""One contract for every method, and each method by hand or against a slow twin."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from selection_problems import (
    capture_of,
    in_line,
    moved,
    permuted,
    problem_of,
    random_problem,
    with_points,
)
from slow_selector import POLICIES, random_scorer, slow_inputs

import fsel
from fsel.core.problem import checked_select
from fsel.features.static import SIGNS
from fsel.selectors.baselines import METHODS, PRACTICE

EVERY = dict(METHODS) | dict(PRACTICE)
EVERY |= {
    name: replace(policy.method(random_scorer(policy, 1)), name=name)
    for name, policy in POLICIES.items()
}
every_method = pytest.mark.parametrize("method", EVERY.values(), ids=EVERY.keys())
with_and_without_points = pytest.mark.parametrize("points", [True, False])
BY_ORDER = (
    *("uniform", "sharpest", "all"),  # follow the order of frames by definition
    *("best_n", "alicevision", "thumbnail"),
    *("fisher_rf", "cover", "warp_rf"),  # ties, as noise gives no splats; see test_splat_views.py
)


def select(method, problem, k, seed=0):
    return checked_select(method, problem, k, np.random.default_rng(seed))


def test_the_registry_names_its_methods():
    paper = ["random", "uniform", "fvs", "nerf_director", "mvsnet", "dpp", "kmedoids"]
    paper += ["fisher_rf", "cover", "untrained"]
    beyond = ["nearest", "sharpest", "long_lrm", "indoor_traj", "facility", "mvsnet_location"]
    assert list(METHODS) == [*paper, *beyond, "all"]
    assert set(PRACTICE) <= set(fsel.METHODS) - set(METHODS)
    assert all(method.name == name for name, method in EVERY.items())


def test_every_method_is_defined_in_the_documentation():
    text = (Path(__file__).parents[3] / "docs" / "methods.md").read_text()
    every = [*METHODS.values(), *PRACTICE.values()]
    missing = [m.label for m in every if f"**{m.label.replace('$', '')}" not in text]
    assert missing == []


@with_and_without_points
@every_method
def test_any_budget_up_to_the_pool(method, points):
    problem = with_points(random_problem(40)) if points else random_problem(40)
    size = len(problem.pool(method.pool))
    for k in (1, 2, 13, size - 1, size):
        assert len(select(method, problem, k)) == k


@every_method
@pytest.mark.parametrize("beyond", [0, 1])
def test_a_budget_outside_the_pool_is_refused(method, beyond):
    problem = random_problem(30)
    k = len(problem.pool(method.pool)) + 1 if beyond else 0
    with pytest.raises(ValueError, match=f"{method.name}: .* got {k}"):
        select(method, problem, k)


@every_method
def test_a_method_of_one_seed_ignores_it_and_of_several_does_not(method):
    problem = random_problem(60)
    picks = {tuple(select(method, problem, 9, seed)) for seed in range(8)}
    assert (len(picks) == 1) == (method.seeds == 1)


@every_method
def test_nested_budgets_are_prefixes(method):
    problem = random_problem(40)
    whole = select(method, problem, 20)
    if method.nested:
        for k in (1, 6, 19):
            np.testing.assert_array_equal(select(method, problem, k), whole[:k])


@with_and_without_points
@every_method
def test_picks_do_not_depend_on_the_worlds_frame_or_scale(method, points):
    for seed in range(2):
        problem = random_problem(40, seed)
        problem = with_points(problem, seed=seed) if points else problem
        rng = np.random.default_rng(seed)
        rotation = Rotation.random(rng=rng).as_matrix()
        other = moved(problem, rotation, rng.normal(scale=20, size=3), 10.0 ** rng.uniform(-3, 3))
        np.testing.assert_array_equal(select(method, problem, 12), select(method, other, 12))


class FrameChance:
    """Chance that follows frames rather than places in an array."""

    def __init__(self, key):
        self.key = key

    def choice(self, pool):
        return pool[np.argmin(self.key[pool])]

    def permutation(self, pool):
        return pool[np.argsort(self.key[pool])]


@pytest.mark.parametrize("method", [m for name, m in EVERY.items() if name not in BY_ORDER])
def test_picks_do_not_depend_on_the_order_of_frames(method):
    for seed in range(4):
        problem = with_points(random_problem(40, seed), seed=seed)
        rng = np.random.default_rng(seed)
        order, key = rng.permutation(40), rng.random(40)
        # few picks: two frames left that resemble each other alone are a tie
        picks = checked_select(method, problem, 5, FrameChance(key))
        other = order[checked_select(method, permuted(problem, order), 5, FrameChance(key[order]))]
        if method.nested:
            np.testing.assert_array_equal(picks, other)
        else:
            assert set(picks) == set(other)


@every_method
def test_a_method_reads_the_descriptors_that_it_declares_and_no_others(method):
    changed = {"appearance": 0, "sharpness": 0, "images": 0}
    for seed in range(4):
        problem = with_points(random_problem(40, seed), seed=seed)
        picks = select(method, problem, 12)
        back = np.arange(40)[::-1]
        others = {
            "appearance": replace(problem, descriptors=problem.descriptors[back]),
            "sharpness": replace(problem, sharpness=problem.sharpness[back]),
        }
        if method.name in PRACTICE:
            images = replace(problem.capture, images=problem.capture.images[back])
            others["images"] = replace(problem, capture=images)
        for name, other in others.items():
            changed[name] += not np.array_equal(select(method, other, 12), picks)
    assert tuple(name for name in changed if changed[name]) == method.reads


@every_method
def test_a_method_looks_at_tracks_only_if_it_says_so(method):
    changed = False
    for seed in range(4):
        problem = random_problem(40, seed)
        seen = with_points(problem, seed=seed)
        changed |= not np.array_equal(select(method, seen, 12), select(method, problem, 12))
    if method.name not in BY_ORDER[-3:]:  # noise gives no splats, which points would start
        assert changed == method.tracks
    else:
        assert method.tracks


def degenerate(problem):
    """name -> the problem with nothing to tell some or all of its frames apart."""
    n = len(problem.capture)
    here = capture_of(np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1)))
    twins = np.arange(n) // 2 * 2
    double = replace(
        problem.capture,
        world_to_camera=problem.capture.world_to_camera[twins],
        images=problem.capture.images[twins],
    )
    alike = np.tile(problem.descriptors[:1], (n, 1))
    white = replace(problem.capture, images=np.full_like(problem.capture.images, 255))
    return {
        "one pose": replace(problem, capture=here, targets=here.view(np.arange(4))),
        "every frame twice": replace(
            problem,
            capture=double,
            descriptors=problem.descriptors[twins],
            sharpness=problem.sharpness[twins],
        ),
        "one image": replace(problem, capture=white, descriptors=alike, sharpness=np.ones(n)),
        "blank images": replace(
            problem, capture=white, descriptors=0 * problem.descriptors, sharpness=np.zeros(n)
        ),
    }


@with_and_without_points
@pytest.mark.parametrize("case", degenerate(random_problem(24)))
@every_method
def test_frames_that_nothing_tells_apart_are_no_trouble(method, case, points):
    problem = with_points(random_problem(24)) if points else random_problem(24)
    bad = degenerate(problem)[case]
    for k in (1, 8, len(bad.pool(method.pool))):
        assert len(select(method, bad, k)) == k


def test_random_draws_evenly_over_observed_frames():
    problem = random_problem(20)
    draws = [select(METHODS["random"], problem, 4, seed) for seed in range(2000)]
    counts = np.bincount(np.concatenate(draws), minlength=20)[problem.observed]
    assert abs(counts / 2000 - 4 / len(problem.observed)).max() < 0.05


def test_uniform_and_nearest_by_hand():
    problem = random_problem(24, targets=4)  # 20 observed frames
    got = select(METHODS["uniform"], problem, 5)
    np.testing.assert_array_equal(got, problem.observed[[0, 5, 10, 14, 19]])
    problem = problem_of(in_line([0, 10, 1, 11, 3, 14, 20, 21]), [2, 3], [4, 5, 6, 7])
    assert select(METHODS["nearest"], problem, 5).tolist() == [2, 3, 4, 5, 6]


def test_fvs_takes_the_farthest_frame_each_time():
    problem = random_problem(40, seed=8)
    picks = select(METHODS["fvs"], problem, 15)
    centers = problem.capture.centers
    for step in range(1, 15):
        left = np.setdiff1d(problem.observed, picks[:step])
        gap = [min(np.linalg.norm(centers[i] - centers[j]) for j in picks[:step]) for i in left]
        assert picks[step] == left[np.argmax(gap)]


@pytest.mark.parametrize("seed", range(4))
def test_the_untrained_sum_against_a_slow_loop(seed):
    problem = random_problem(40, seed)
    picked = []
    for _ in range(8):
        left, inputs = slow_inputs(problem, picked, POLICIES["less_is_more"])
        picked.append(int(left[np.argmax(inputs[:, :18] @ list(SIGNS.values()))]))
    got = select(METHODS["untrained"], problem, 8)
    np.testing.assert_array_equal(got, problem.candidates[picked])


def test_all_frames_are_the_candidates_and_of_a_long_capture_some_evenly():
    problem = random_problem(30)
    np.testing.assert_array_equal(problem.sequence, problem.candidates)
    problem = random_problem(2105, targets=5)
    frames, pool = problem.sequence, problem.candidates
    assert len(frames) == 1000
    assert (frames[0], frames[-1]) == (pool[0], pool[-1])
    assert set(np.diff(np.searchsorted(pool, frames))) <= {2, 3}
    np.testing.assert_array_equal(select(METHODS["all"], problem, 1000), frames)
    np.testing.assert_array_equal(select(METHODS["all"], problem, 1500), pool[:1500])
