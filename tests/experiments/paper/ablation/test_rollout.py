"""The inputs along picks, and selecting by any score."""

import numpy as np
import pytest
from selection_problems import random_problem

from fsel.experiments.paper.ablation.extras import EXTRAS, relations
from fsel.experiments.paper.ablation.trials import PartialRollout, view_inputs
from fsel.features.columns import FEATURES
from fsel.selectors.policies import POLICIES
from fsel.selectors.rollout import Rollout, follow, pick

PICKS = np.array([5, 0, 11, 7])


def started(shown=FEATURES, added=None, problem=None):
    problem = problem or random_problem(n=30)
    prepared = POLICIES["less_is_more"].prepare(problem)
    scene = relations(problem, prepared, budget=6)
    return PartialRollout(prepared, scene, shown, added), prepared, scene


def test_with_all_features_it_is_what_the_deployed_scorer_sees():
    rollout, prepared, _ = started()
    features, selectable = follow(rollout, PICKS)
    expected, left = follow(Rollout(prepared), PICKS)
    np.testing.assert_array_equal(features, expected)
    np.testing.assert_array_equal(selectable, left)


def test_columns_that_are_not_shown_are_zero_and_the_others_unchanged():
    shown = ["d_min_o", "rho_max_s", "sharpness"]
    full = follow(started()[0], PICKS)[0]
    part = follow(started(shown)[0], PICKS)[0]
    kept = np.isin(FEATURES, shown)
    np.testing.assert_array_equal(part[..., :18][..., kept], full[..., :18][..., kept])
    assert not part[..., :18][..., ~kept].any()
    assert not part[..., 18].any()


@pytest.mark.parametrize("name", EXTRAS)
def test_a_group_takes_its_columns_and_no_other(name):
    extra = EXTRAS[name]
    shown = [f for f in FEATURES if f not in ("tau_tri", "alpha_mean", "b_perp", "b_par", "c_vis")]
    plain = follow(started(shown)[0], PICKS)[0]
    rollout, _, scene = started(shown, extra)
    features, selectable = follow(rollout, PICKS)
    others = np.setdiff1d(np.arange(19), extra.inputs)
    np.testing.assert_array_equal(features[..., others], plain[..., others])
    for step in range(len(PICKS)):
        raw = extra.raw(scene, PICKS[:step].tolist())
        expected = extra.scale(raw, selectable[step])
        np.testing.assert_allclose(features[step][:, extra.inputs], expected, rtol=1e-6)


def test_a_score_sees_the_steps_so_far():
    seen = []

    def score(features, selectable, past):
        seen.append((features.copy(), selectable.copy(), past))
        return np.where(np.arange(features.shape[1]) == PICKS[len(past)], 1.0, 0.0)

    rows = pick(started()[0], score, len(PICKS))
    np.testing.assert_array_equal(rows, PICKS)
    expected, left = follow(started()[0], PICKS)
    for step, (features, selectable, past) in enumerate(seen):
        np.testing.assert_array_equal(features, expected[: step + 1])
        np.testing.assert_array_equal(selectable, left[: step + 1])
        np.testing.assert_array_equal(past, PICKS[:step])


def test_relations_to_views_are_z_scores_over_all_pairs():
    _, _, scene = started()
    values = view_inputs(scene)
    assert values.shape == (*scene.distance.shape, 3)
    np.testing.assert_allclose(values.mean(axis=(0, 1)), 0, atol=1e-6)
    np.testing.assert_allclose(values.std(axis=(0, 1)), 1, atol=1e-5)
    place = np.unravel_index(scene.likeness.argmax(), scene.likeness.shape)
    assert values[..., 2].max() == values[(*place, 2)]
