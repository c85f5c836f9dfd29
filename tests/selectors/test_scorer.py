"""The scorers' arithmetic against plain loops, and what they refuse to load."""

import json
import math

import numpy as np
import pytest
from safetensors.numpy import save_file
from selection_problems import random_weights

from fsel.features.columns import INPUTS, NAMES
from fsel.selectors.scorer import SHAPES, WIDTH, Linear, Network, Scorer


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
    np.testing.assert_allclose(Network(weights).scores(inputs), want, rtol=1e-12)


def test_saved_and_loaded_is_the_same(tmp_path):
    scorer = Network(random_weights(3), {"seed": "3", "labels": "a test"})
    scorer.save(tmp_path / "seed3.safetensors")
    again = Scorer.load(tmp_path / "seed3.safetensors")
    assert again.provenance == scorer.provenance
    for name in SHAPES:
        np.testing.assert_array_equal(again.weights[name], scorer.weights[name])


def test_a_linear_rule_by_hand():
    rule = Linear({"phi_nov": 0.5, "d_min_s": -2, "target_gain": 10.0})
    inputs = np.zeros((2, INPUTS))
    inputs[0, [NAMES.index("phi_nov"), NAMES.index("d_min_s"), 0]] = 4, 0.5, 99
    inputs[1, NAMES.index("target_gain")] = 0.125
    np.testing.assert_array_equal(rule.scores(inputs), [1.0, 1.25])
    assert rule.scores(inputs.astype(np.float32)).dtype == np.float32


def test_a_saved_linear_rule_is_readable_and_the_same(tmp_path):
    rule = Linear({"d_min_s": 0.4, "target_gain": 150.0}, {"policy": "fsel", "config": "abc"})
    rule.save(tmp_path / "seed0.json")
    assert json.loads((tmp_path / "seed0.json").read_text()) == {
        "coefficients": {"d_min_s": 0.4, "target_gain": 150.0},
        "provenance": {"config": "abc", "policy": "fsel"},
    }
    assert Scorer.load(tmp_path / "seed0.json") == rule


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"coefficients": {"d_min": 1}, "provenance": {}}', "d_min"),
        ('{"coefficients": {}, "provenance": {}}', "no input"),
        ('{"coefficients": {"d_min_s": NaN}, "provenance": {}}', "d_min_s.*nan"),
        ('{"coefficients": {"d_min_s": "1"}, "provenance": {}}', "d_min_s.*'1'"),
        ('{"coefficients": {"d_min_s": true}, "provenance": {}}', "True"),
        ('{"coefficients": {"d_min_s": 1}}', "provenance"),
        ('["d_min_s"]', "rule.json"),
        ("{", "rule.json"),
    ],
)
def test_another_linear_rule_is_refused(text, said, tmp_path):
    (tmp_path / "rule.json").write_text(text)
    with pytest.raises(ValueError, match=said):
        Scorer.load(tmp_path / "rule.json")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"layer2.weight": np.zeros((WIDTH, 32), np.float32)}, r"\(64, 32\)"),
        ({"extra": np.zeros(1, np.float32)}, "extra"),
        ({"layer1.bias": np.full(WIDTH, np.nan, np.float32)}, "layer1.bias"),
    ],
)
def test_another_network_is_refused(change, said, tmp_path):
    save_file(random_weights(4) | change, tmp_path / "other.safetensors")
    with pytest.raises(ValueError, match=f"other.safetensors.*{said}"):
        Scorer.load(tmp_path / "other.safetensors")


@pytest.mark.parametrize("name", ["net.safetensors", "net.pt"])
def test_other_files_are_refused(name, tmp_path):
    (tmp_path / name).write_bytes(b"no tensors")
    with pytest.raises(ValueError, match=name):
        Scorer.load(tmp_path / name)
