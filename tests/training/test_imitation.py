"""Behaviour cloning learns what it is shown, reproducibly."""

import numpy as np
import pandas as pd
import pytest
import torch

from fsel.selectors.policies import UNTRAINED
from fsel.selectors.scorer import INPUTS, Network
from fsel.training.imitation import SUM_SCALE, Trajectory, begin_as_sum, perceptron, train


def trajectories(count, seed):
    """The label is always the selectable row with the largest fifth input."""
    rng = np.random.default_rng(seed)
    items = []
    for _ in range(count):
        features = rng.normal(size=(6, 20, INPUTS)).astype(np.float32)
        selectable = np.ones((6, 20), bool)
        selectable[3:, :3] = False
        picks = np.where(selectable, features[:, :, 4], -np.inf).argmax(axis=1)
        items.append(Trajectory(features, selectable, picks, 1.0))
    return items


def fit(seed=0, **settings):
    options = {"epochs": 4, "learning_rate": 1e-3} | settings
    return train(trajectories(60, 0), trajectories(10, 1), seed=seed, **options)


def test_agreement_rises_on_unseen_items():
    _, log = fit()
    log = pd.DataFrame(log)
    held = log[log["split"] == "validation"].set_index("epoch")
    assert held.loc[0, "agreement"] < 0.3
    assert held.loc[4, "agreement"] > 0.7
    assert held.loc[4, "loss"] < held.loc[0, "loss"]


def test_weights_fill_the_papers_network():
    weights, _ = fit(epochs=1)
    assert sum(w.size for w in weights.values()) == 5505
    Network(weights)


def test_a_network_may_begin_as_the_untrained_sum():
    network = perceptron(64)
    begin_as_sum(network)
    with torch.no_grad():
        network[4].weight[0, 2:] = 0
    inputs = np.random.default_rng(0).normal(size=(50, INPUTS)).astype(np.float32)
    scores = network(torch.from_numpy(inputs)).detach().numpy()[:, 0]
    expected = SUM_SCALE * UNTRAINED.scorer.scores(inputs)
    assert np.ptp(scores - expected) < 1e-5  # but for the last bias
    _, log = fit(from_sum=True, epochs=1)
    assert log["loss"][0] != fit(epochs=1)[1]["loss"][0]


def test_zero_weight_trajectory_teaches_nothing():
    items = [Trajectory(t.features, t.selectable, t.picks, 0.0) for t in trajectories(3, 0)]
    _, log = train(items, [], seed=0, epochs=1, learning_rate=1e-3)
    before, after = log["loss"]
    assert after == pytest.approx(before, rel=1e-6)  # sums of float32
