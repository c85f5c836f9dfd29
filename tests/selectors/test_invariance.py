"""Picks follow neither the world's frame and unit, nor the order of frames, nor the threads."""

import os
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from own_python import printed
from scipy.spatial.transform import Rotation
from selection_problems import (
    capture_of,
    moved,
    permuted,
    problem_on,
    random_capture,
    random_problem,
    random_weights,
    with_points_ahead,
)

from fsel.selection.problem import with_target_depths
from fsel.selectors import pretrained, reference_loop
from fsel.selectors.baselines import METHODS
from fsel.selectors.greedy import greedy
from fsel.selectors.policies import POLICIES
from fsel.selectors.scorer import Network

K = 12
SCORERS = {
    "less_is_more": lambda: Network(random_weights(3)),
    "less_is_more_no_appearance": lambda: Network(random_weights(4)),
    "fsel": lambda: pretrained.method().scorer,
    (WITH_DEPTHS := "fsel, with the depths of the targets"): lambda: pretrained.method().scorer,
}
LOOPS = {"compiled": greedy, "plain": reference_loop.greedy}
policies = pytest.mark.parametrize("policy", SCORERS)
loops = pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS.keys())
seeds = st.integers(0, 2**32 - 1)
# compiling is slow, and a time limit would fail on a busy machine
unhurried = settings(max_examples=15, deadline=None, derandomize=True)


def problem_for(policy, seed):
    problem = random_problem(40, seed)
    return with_points_ahead(problem, seed) if policy == WITH_DEPTHS else problem


def prepared_for(policy, problem):
    if policy == WITH_DEPTHS:
        policy, problem = "fsel", with_target_depths(problem)
        assert problem.target_depths is not None
    return POLICIES[policy].prepare(problem)


def picked(loop, policy, problem):
    prepared = prepared_for(policy, problem)
    return prepared.pool[loop(prepared, SCORERS[policy](), K)[0]]


@loops
@policies
@unhurried
@given(seed=seeds, power=st.floats(-6, 6), shift=st.floats(0, 1e4))
def test_neither_the_frame_nor_the_unit_of_the_world(loop, policy, seed, power, shift):
    rng = np.random.default_rng(seed)
    problem, scale = problem_for(policy, seed), 10.0**power
    rotation = Rotation.random(rng=rng).as_matrix()
    # rounding grows with the distance from the origin: far, in units of the scene, but not endless
    other = moved(problem, rotation, rng.normal(size=3) * shift * scale, scale)
    want = picked(loop, policy, problem)
    np.testing.assert_array_equal(picked(loop, policy, other), want)


@loops
@policies
@unhurried
@given(seed=seeds)
def test_nor_the_order_of_frames(loop, policy, seed):
    problem = problem_for(policy, seed)
    order = np.random.default_rng(seed).permutation(40)
    other = picked(loop, policy, permuted(problem, order))
    np.testing.assert_array_equal(order[other], picked(loop, policy, problem))


def test_nor_millimetres_far_from_the_origin():
    utm = np.array([5e5, 1e7, 120.0])
    for policy in SCORERS:
        problem = problem_for(policy, 0)
        other = picked(greedy, policy, moved(problem, np.eye(3), utm, 1e-3))
        np.testing.assert_array_equal(other, picked(greedy, policy, problem))


ODD, BACK = np.arange(40)[:, None] % 2, np.diag([-1.0, 1, -1])
HARD = {
    "at one point": lambda centers, turns: (0 * centers + centers[0], turns),
    "on a line": lambda centers, turns: (np.arange(40.0)[:, None] * [1, 2, -0.5], turns),
    "in two clusters": lambda centers, turns: (centers + ODD * [1e6, 0, 0], turns),
    "with parallel axes": lambda centers, turns: (centers, 0 * turns + turns[0]),
    "with opposite axes": lambda centers, turns: (
        centers,
        np.where(ODD[..., None], BACK @ turns[0], turns[0]),
    ),
}


@policies
@pytest.mark.parametrize("case", HARD.values(), ids=HARD.keys())
def test_hard_cameras_have_the_picks_of_the_plain_loop(policy, case):
    """Of rounding alone there would be other picks: where cameras or axes coincide."""
    plain = random_capture(40)
    problem = problem_on(capture_of(*case(plain.centers, plain.world_to_camera[:, :, :3])))
    if policy == WITH_DEPTHS:
        problem = with_points_ahead(problem)
    prepared = prepared_for(policy, problem)
    (rows, scores), (want, wanted) = (
        loop(prepared, SCORERS[policy](), K) for loop in LOOPS.values()
    )
    np.testing.assert_array_equal(rows, want)
    np.testing.assert_allclose(scores, wanted, rtol=1e-9, atol=1e-9)


PROGRAM = """
import numpy as np
from fsel.selectors.baselines import METHODS
from fsel.selectors.policies import POLICIES
from fsel.core.problem import checked_select
from fsel.selectors.greedy import greedy
from coloured_wall import wall
from selection_problems import problem_on, random_problem, random_weights
from fsel.selectors import pretrained
from fsel.selectors.scorer import Network

problem = random_problem(1200)
for name, policy in POLICIES.items():
    scorer = pretrained.method().scorer if name == "fsel" else Network(random_weights(3))
    print(*greedy(policy.prepare(problem), scorer, 40)[0])
problem = problem_on(wall(frames=40))
for method in METHODS.values():
    print(*checked_select(method, problem, 12, np.random.default_rng(0)))
"""


def test_nor_the_number_of_threads():
    told = set()
    for threads in ("1", "3"):
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
        variables = dict.fromkeys(names, threads) | {"PYTHONPATH": os.pathsep.join(sys.path)}
        told.add(printed(PROGRAM, **variables))
        assert len(min(told).splitlines()) == len(POLICIES) + len(METHODS)
    assert len(told) == 1
