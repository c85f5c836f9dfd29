"""Every scorer that the paper compared: sizes by hand, symmetry, what it may see, and learning."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
import yaml

from fsel.experiments.paper.ablation.architectures import MODULES, Steps
from fsel.training.imitation import imitation, mean_cost, passes

ROOT = Path(__file__).resolve().parents[4]
SCORERS = yaml.safe_load((ROOT / "config" / "scorers.yaml").read_text())
every = pytest.mark.parametrize("name", SCORERS)
ORDERED = {"ordered_attention", "bilstm", "convolution"}
WIDTH, INPUTS, LEFT = 64, 19, 13


def network(name, seed=0):
    torch.manual_seed(seed)
    return MODULES[SCORERS[name]["module"]](**SCORERS[name]["settings"])


def steps(count=6, rows=11, views=4, seed=0):
    """Random steps; as in a walk, rows keep their first thirteen inputs from step to step."""
    rng = np.random.default_rng(seed)
    features = rng.normal(size=(count, rows, INPUTS)).astype(np.float32)
    features[:, :, :LEFT] = features[0, :, :LEFT]
    features[..., -1] = 0
    picks = rng.permutation(rows)[:count]
    selectable = np.ones((count, rows), bool)
    for step, row in enumerate(picks):
        selectable[step + 1 :, row] = False
    views = rng.normal(size=(rows, views, 3)).astype(np.float32)
    return Steps(*map(torch.from_numpy, (features, selectable, picks, views)))


def scores(net, given):
    with torch.no_grad():
        return net(given).numpy()


def layer(inputs, outputs):
    return inputs * outputs + outputs


def perceptron(inputs, width=WIDTH):
    return layer(inputs, width) + layer(width, width) + width + 1


ATTENTION = 3 * layer(WIDTH, WIDTH) + layer(WIDTH, WIDTH)
ENCODER = ATTENTION + layer(WIDTH, 2 * WIDTH) + layer(2 * WIDTH, WIDTH) + 2 * 2 * WIDTH


def recurrent(gates, hidden, inputs=INPUTS):
    return gates * (inputs * hidden + hidden * hidden + 2 * hidden)


SIZES = {
    "wider": perceptron(INPUTS, 256),
    "less_is_more": 5505,
    "residual": layer(INPUTS, 64) + 4 * (2 * 64 + 2 * layer(64, 64)) + layer(64, 1),
    "pooled": layer(INPUTS, 64) + perceptron(3 * 64),
    "rescoring": layer(INPUTS, 64) + layer(64, 1) + perceptron(2 * 64 + 1),
    "cross_attention": layer(INPUTS, 64) + 64 + ATTENTION + perceptron(2 * 64),
    "self_attention": layer(INPUTS, 64) + ENCODER + layer(64, 1),
    "ordered_attention": layer(INPUTS, 64) + ENCODER + layer(64, 1),
    "self_attention_2": layer(INPUTS, 64) + 2 * ENCODER + layer(64, 1),
    "lstm_decoder": (
        layer(INPUTS, 64) + ENCODER + recurrent(4, 64, 64) + perceptron(INPUTS + 2 * 64)
    ),
    "bilstm": 2 * recurrent(4, 32) + layer(64, 1),
    "lstm": recurrent(4, 64) + perceptron(INPUTS + 64),
    "lstm_128": recurrent(4, 128) + perceptron(INPUTS + 128),
    "gru": recurrent(3, 64) + perceptron(INPUTS + 64),
    "rnn": recurrent(1, 64) + perceptron(INPUTS + 64),
    "convolution": layer(5 * INPUTS, 64) + 2 * layer(5 * 64, 64) + layer(64, 1),
    "view_attention": layer(5, 64) + layer(3, 64) + ATTENTION + perceptron(64 + 5),
}


@every
def test_parameters_by_hand_and_equal_seeds_equal_scores(name):
    assert sum(array.numel() for array in network(name).parameters()) == SIZES[name]
    given = steps()
    first, second, other = (scores(network(name, seed), given) for seed in (0, 0, 1))
    assert first.shape == (6, 11)
    assert np.isfinite(first).all()
    np.testing.assert_array_equal(first, second)
    assert np.abs(first - other).max() > 1e-3


@every
def test_the_order_of_candidates_matters_only_where_it_is_meant_to(name):
    given = steps()
    order = torch.from_numpy(np.random.default_rng(5).permutation(11))
    moved = given.features[:, order], given.selectable[:, order]
    shuffled = Steps(*moved, torch.argsort(order)[given.picks], given.views[order])
    net = network(name)
    expected, found = scores(net, given)[:, order], scores(net, shuffled)
    if name in ORDERED:
        assert np.abs(found - expected).max() > 1e-3
    else:
        np.testing.assert_allclose(found, expected, atol=1e-5)


@every
def test_the_last_step_of_a_prefix_is_that_step_of_the_whole(name):
    given, step = steps(), 4
    past = torch.cat([given.picks[:step], torch.zeros(1, dtype=torch.int64)])
    seen = given.features[: step + 1], given.selectable[: step + 1]
    part = Steps(*seen, past, given.views)
    net = network(name)
    np.testing.assert_allclose(scores(net, part)[-1], scores(net, given)[step], atol=1e-5)


READING_PICKS = {"cross_attention", "lstm_decoder", "lstm", "lstm_128", "gru", "rnn"}


@pytest.mark.parametrize("name", sorted(READING_PICKS))
def test_a_scorer_of_the_picks_reads_them(name):
    given = steps()
    picks = given.picks.clone()
    picks[0] = int(given.picks[-1])
    net = network(name)
    before, after = scores(net, given), scores(net, replace(given, picks=picks))
    np.testing.assert_allclose(after[0], before[0], atol=1e-6)
    assert np.abs(after[1:] - before[1:]).max(axis=1).min() > 1e-5


@pytest.mark.parametrize(
    "name", ["pooled", "rescoring", "self_attention", "self_attention_2", "ordered_attention"]
)
def test_what_was_picked_is_out_of_the_context(name):
    given = steps()
    features = given.features.clone()
    features[3, given.picks[0]] += 5.0
    net = network(name)
    before, after = scores(net, given), scores(net, replace(given, features=features))
    left = given.selectable[3].numpy()
    np.testing.assert_allclose(after[3][left], before[3][left], atol=1e-5)


def test_attention_over_views_reads_relations_and_not_their_summaries():
    given, net = steps(), network("view_attention")
    before = scores(net, given)
    features = given.features.clone()
    features[..., :LEFT] += 3.0
    np.testing.assert_array_equal(scores(net, replace(given, features=features)), before)
    views = given.views.clone()
    views[2, 1] += 3.0
    after = scores(net, replace(given, views=views))
    assert np.abs(after - before)[:, 2].min() > 1e-5
    np.testing.assert_allclose(np.delete(after, 2, axis=1), np.delete(before, 2, axis=1), atol=1e-6)
    order = given.views[:, torch.tensor([2, 0, 3, 1])]
    np.testing.assert_allclose(scores(net, replace(given, views=order)), before, atol=1e-5)


def toy(seed):
    """The label is the row left with the largest distance to the selected frames."""
    given = steps(count=5, rows=12, seed=seed)
    selectable = torch.ones_like(given.selectable)
    picks = given.features[..., LEFT].argmax(dim=1)
    return replace(given, picks=picks, selectable=selectable)


def cost(net, given):
    return imitation(net(given), given.selectable, given.picks)


@pytest.mark.parametrize("name", {SCORERS[name]["module"]: name for name in SCORERS}.values())
def test_it_learns_a_rule_from_a_few_examples(name):
    data = [(toy(seed), 1.0) for seed in range(20)]
    held = [(toy(seed), 1.0) for seed in range(40, 50)]
    net = network(name)
    before, _ = mean_cost(net, held, cost)
    for _ in passes(net, data, cost, seed=0, epochs=6, learning_rate=4e-3):
        pass
    after, agreement = mean_cost(net, held, cost)
    assert after < 0.6 * before
    assert agreement > 0.5
