"""The scorer's arithmetic by hand, and what it refuses to load."""

import math

import numpy as np
import pytest
from safetensors.numpy import save_file

from fsel.experiments.hard_cases.worlds import random_weights
from fsel.selector.scorer import INPUTS, PARAMETERS, SHAPES, WIDTH, Scorer, change_bounds


def test_it_has_the_papers_number_of_parameters():
    assert PARAMETERS == 5505
    assert sum(array.size for array in random_weights(0).values()) == 5505


def test_scores_against_plain_loops():
    weights = random_weights(1, gain=2.0)
    inputs = np.random.default_rng(2).normal(size=(3, INPUTS))

    def layer(name, values):
        return [
            float(weights[f"{name}.bias"][j])
            + sum(float(weights[f"{name}.weight"][j, c]) * values[c] for c in range(len(values)))
            for j in range(len(weights[f"{name}.bias"]))
        ]

    def gelu(values):
        return [0.5 * z * (1 + math.erf(z / math.sqrt(2))) for z in values]

    want = [layer("layer3", gelu(layer("layer2", gelu(layer("layer1", x)))))[0] for x in inputs]
    np.testing.assert_allclose(Scorer(weights, {}).scores(inputs), want, rtol=1e-12)


def test_one_unit_by_hand():
    weights = {name: np.zeros(shape, np.float32) for name, shape in SHAPES.items()}
    weights["layer1.weight"][3, 7] = 1
    weights["layer2.weight"][5, 3] = 1
    weights["layer3.weight"][0, 5] = 2
    weights["layer3.bias"][0] = 0.5
    x = np.zeros((1, INPUTS))
    x[0, 7] = 1
    first = 0.841344746068543  # Phi(1)
    second = first * 0.5 * (1 + math.erf(first / math.sqrt(2)))
    assert Scorer(weights, {}).scores(x)[0] == pytest.approx(2 * second + 0.5, rel=1e-12)


def test_saved_and_loaded_is_the_same(tmp_path):
    scorer = Scorer(random_weights(3), {"seed": "3", "labels": "a test"})
    scorer.save(tmp_path / "seed3.safetensors")
    again = Scorer.load(tmp_path / "seed3.safetensors")
    assert again.provenance == scorer.provenance
    for name in SHAPES:
        np.testing.assert_array_equal(again.weights[name], scorer.weights[name])


def test_another_network_is_refused(tmp_path):
    weights = random_weights(4) | {"layer2.weight": np.zeros((WIDTH, 32), np.float32)}
    save_file(weights, tmp_path / "other.safetensors")
    with pytest.raises(ValueError, match=r"\(64, 32\).*\(64, 64\)"):
        Scorer.load(tmp_path / "other.safetensors")


def test_missing_and_extra_arrays_are_refused():
    weights = random_weights(5)
    with pytest.raises(ValueError, match="extra"):
        Scorer(weights | {"extra": np.zeros(1, np.float32)}, {})
    del weights["layer3.bias"]
    with pytest.raises(ValueError, match=r"layer3\.bias"):
        Scorer(weights, {})


def test_values_that_are_not_finite_are_refused():
    weights = random_weights(6)
    weights["layer1.bias"][0] = np.nan
    with pytest.raises(ValueError, match=r"layer1\.bias"):
        Scorer(weights, {})


@pytest.mark.parametrize("gain", [0.3, 1.0, 5.0])
def test_a_change_of_inputs_changes_a_score_by_no_more_than_its_bound(gain):
    weights, rng = random_weights(6, gain), np.random.default_rng(0)
    scorer, columns = Scorer(weights, {}), np.array([13, 14, 15, 16, 18])
    first, second, third = (weights[f"layer{i}.weight"].astype(np.float64) for i in (1, 2, 3))
    bounds = change_bounds(first[:, columns], second, third[0])
    x = rng.normal(scale=2, size=(4000, 19))
    d = rng.normal(size=(4000, 5)) * 10 ** rng.uniform(-3, 1, (4000, 1))
    y = x.copy()
    y[:, columns] += d
    change = scorer.scores(y) - scorer.scores(x)
    parts = [np.linalg.norm(d @ part.T, axis=1) for part in (bounds[1:6], bounds[6:])]
    most = d @ bounds[0] + sum(parts)
    assert (change <= most + 1e-12).all()
    # far from vacuous: norms alone, GELU's slope being at most 1.129, bound it by more
    whole = np.linalg.norm(third) * np.linalg.norm(second, 2)
    whole = 1.129**2 * whole * np.linalg.norm(d @ first[:, columns].T, axis=1)
    assert np.median(most / whole) < 0.8
