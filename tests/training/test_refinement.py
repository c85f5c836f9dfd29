"""The linear embedding is exact, and the strategy climbs."""

import numpy as np
import pytest

from fsel.features.static import FEATURES
from fsel.selector.scorer import INPUTS, Scorer
from fsel.stages.refine import _better, start_of
from fsel.training.refinement import RefineSettings, linear_weights, refine


def test_embedded_linear_score_is_exact():
    rng = np.random.default_rng(0)
    coefficients = rng.normal(size=INPUTS)
    inputs = rng.normal(scale=3, size=(50, INPUTS)).astype(np.float32)
    scores = Scorer(linear_weights(coefficients), {}).scores(inputs)
    np.testing.assert_allclose(scores, inputs @ coefficients, atol=2e-5)


def test_wrong_number_of_coefficients_is_refused():
    with pytest.raises(ValueError, match="expected"):
        linear_weights(np.zeros(3))


def test_strategy_climbs_a_noisy_hill_and_leaves_frozen_inputs_alone():
    rng = np.random.default_rng(0)
    best = np.linspace(-1, 1, INPUTS)
    start = np.zeros(INPUTS)
    start[3] = 2.0
    free = np.arange(INPUTS) != 3

    def objective(policies, generation):
        shift = rng.normal()
        return np.array([shift - np.sum((p - best) ** 2) for p in policies])

    found, log = refine(objective, start, free, RefineSettings(generations=150), seed=0)
    assert found[3] == 2.0
    assert np.abs(found - best)[free].max() < 0.1
    assert len(log) == 150


def test_same_seed_same_answer():
    def objective(policies, generation):
        return np.array([-np.sum(p**2) for p in policies])

    settings = RefineSettings(generations=5)
    start, free = np.ones(INPUTS), np.ones(INPUTS, bool)
    first = refine(objective, start, free, settings, seed=4)[0]
    again = refine(objective, start, free, settings, seed=4)[0]
    np.testing.assert_array_equal(first, again)


class Valley:
    """A draw whose PSNR falls with the distance from its best coefficients."""

    def __init__(self, best):
        self.best = best

    def value(self, coefficients):
        return 20 - np.abs(coefficients - self.best).sum()


@pytest.mark.parametrize(
    ("bests", "kept"),
    [
        ((0.1, 0.1), "start"),
        ((0.9, 0.8), "found"),
        ((1.0, 0.1), "start"),  # 19 and -15.2 dB: better on the mean, by less than the doubt
        ((1.0,), "start"),  # a single draw says nothing of its own doubt
    ],
)
def test_what_was_found_must_hold_on_draws_kept_apart(bests, kept):
    vectors = {"start": np.zeros(19), "found": np.ones(19)}
    chosen = _better([Valley(best) for best in bests], vectors["start"], vectors["found"])
    np.testing.assert_array_equal(chosen, vectors[kept])


def test_only_what_the_line_search_found_useful_is_free():
    start, free = start_of()
    names = [*FEATURES, "coverage"]
    assert {names[i] for i in np.flatnonzero(free)} == {"d_min_s", "gamma_min_s", "phi_nov"}
    assert {names[i] for i in np.flatnonzero(start)} == {
        "d_min_s",
        "gamma_min_s",
        "phi_nov",
        "coverage",
    }
