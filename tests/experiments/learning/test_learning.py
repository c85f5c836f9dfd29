"""Learning from labelled requests: inputs by hand, walks, costs, what is learned."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from selection_problems import problem_on, random_capture, random_problem

from fsel.experiments.learning import inputs as candidate
from fsel.experiments.learning import teaching
from fsel.experiments.learning.cases import EVERY, INPUT_CASES, LEARNERS
from fsel.experiments.learning.inputs import COLUMNS, GROUPS, State, inputs, shown
from fsel.experiments.learning.lessons import Lesson, by_rule, walked
from fsel.experiments.learning.network import Learned, load, save
from fsel.experiments.learning.pairs import Pairs
from fsel.experiments.learning.picking import mean_score
from fsel.experiments.learning.practice import evolve, policy_gradient
from fsel.geometry import pairwise_distances
from fsel.selector import pretrained
from fsel.selector.walk import Walk
from fsel.training.imitation import mean_cost

K = 6
SETTINGS = {"kept": 2, "epochs": 3, "learning_rate": 1e-2}


@pytest.fixture(scope="module")
def pairs():
    return Pairs.of(random_problem(30))


def state_after(pairs, rows, k=K):
    walk = Walk(pairs.prepared)
    for row in rows:
        walk.add(row)
    return State(np.array(walk.picked, np.int64), walk.selectable, walk.inputs(), k)


def lesson_on(pairs, seed=0, wanted=None):
    """Random subsets; or those whose rows' sum of a column is the largest are the best."""
    rng = np.random.default_rng(seed)
    n = len(pairs.prepared.pool)
    subsets = np.sort([rng.choice(n, K, replace=False) for _ in range(8)], axis=1)
    if wanted is not None:
        subsets[0] = np.sort(np.argsort(-wanted)[:K])
    psnr = np.sort(rng.uniform(20, 25, 8))[::-1]
    return Lesson((0, seed), pairs, K, subsets, psnr)


def test_pairs_by_hand(pairs):
    problem = random_problem(30)
    pool = problem.observed
    centers, axes = problem.capture.centers[pool], problem.capture.axes[pool]
    depth = 1.8 * np.sqrt(np.mean(np.sum((centers - centers.mean(axis=0)) ** 2, axis=1)))
    np.testing.assert_allclose(pairs.distance, pairwise_distances(centers, centers) / depth)
    i, j = 3, 11
    point = centers[i] + depth * axes[i]
    first, second = centers[i] - point, centers[j] - point
    cosine = first @ second / np.linalg.norm(first) / np.linalg.norm(second)
    assert pairs.parallax[i, j] == pytest.approx(np.arccos(cosine))
    ahead = (point - centers[j]) @ axes[j] / np.linalg.norm(point - centers[j])
    sees = np.arccos(ahead) <= problem.capture.views.half_fov[pool[j]]
    degrees = np.degrees(pairs.parallax[i, j])
    score = np.exp(-((degrees - 5) ** 2) / (2 * (1 if degrees <= 5 else 10) ** 2))
    assert pairs.support[i, j] == pytest.approx(score if sees else 0)
    np.testing.assert_allclose(np.diag(pairs.parallax), 0, atol=1e-7)


def test_sharpness_is_compared_with_the_frames_that_look_alike():
    problem = random_problem(30)
    pool, sharp = problem.observed, np.full(30, 100.0)
    sharp[pool[4]] = 400.0
    found = Pairs.of(replace(problem, sharpness=sharp)).sharper
    assert found[4] == pytest.approx(np.log(401 / 101))
    assert np.count_nonzero(found) == 1  # one of six does not move the others' median


def test_groups_by_hand(pairs):
    picks = [2, 17, 9]
    state = state_after(pairs, picks)
    near = candidate.nearest(pairs, state)
    np.testing.assert_array_equal(near[:, 0], pairs.distance[:, picks].min(axis=1))
    np.testing.assert_array_equal(near[:, 2], pairs.likeness[:, picks].max(axis=1))
    beside = candidate.partners(pairs, state)
    row = 5
    closest = picks[int(np.argmin(pairs.distance[row, picks]))]
    expected = [pairs.support[row, picks].max(), pairs.support[row, picks].sum()]
    expected += [pairs.parallax[row, closest], np.log(pairs.distance[row, closest] + 1e-3)]
    np.testing.assert_allclose(beside[row], expected)
    close = pairs.prepared.rows.closeness
    gained = close[row] / (1 + close[picks].sum(axis=0))
    share = np.mean([c > close[picks, t].max() for t, c in enumerate(close[row])])
    np.testing.assert_allclose(candidate.single(pairs, state)[row], [gained.max(), share])
    np.testing.assert_allclose(candidate.progress(pairs, state)[:, 0], 0.5)
    start = state_after(pairs, [])
    for group in (candidate.nearest, candidate.partners):
        assert not group(pairs, start).any()


def test_inputs_are_the_rules_score_and_standardised_groups(pairs):
    state = state_after(pairs, [2, 17, 9])
    found = inputs(pairs, state)
    assert found.shape == (len(pairs.prepared.pool), 1 + len(COLUMNS))
    assert np.isfinite(found).all()
    score = pretrained.method("fsel").scorer.scores(state.shown.astype(float))[state.selectable]
    expected = (score - score.mean()) / score.std()
    np.testing.assert_allclose(found[state.selectable, 0], expected, rtol=1e-5, atol=1e-6)
    standard = found[state.selectable][:, 1:][:, candidate.STANDARD]
    np.testing.assert_allclose(standard.mean(axis=0), 0, atol=1e-5)
    assert (np.abs(standard.std(axis=0) - 1) < 1e-4).mean() > 0.8
    assert not found[[2, 17, 9]].any()
    assert shown(EVERY).all()
    assert not shown(()).any()
    assert shown(["sharper"]).sum() == 1


def test_candidate_inputs_follow_neither_frame_nor_unit():
    capture = random_capture(30)
    turned = capture.world_to_camera.copy()
    spin = random_capture(1, seed=5).world_to_camera[0, :, :3]
    turned[:, :, :3] = turned[:, :, :3] @ spin.T
    turned[:, :, 3] *= 3.0
    found = []
    for poses in (capture.world_to_camera, turned):
        pairs = Pairs.of(problem_on(replace(capture, world_to_camera=poses)))
        found.append(inputs(pairs, state_after(pairs, [2, 17, 9])))
    np.testing.assert_allclose(found[0], found[1], atol=2e-4)


@pytest.mark.parametrize("seed", range(3))
def test_a_network_on_the_rule_is_the_rule_before_it_learns(seed):
    problem = random_problem(40, seed)
    pairs = Pairs.of(problem)
    network = Learned(EVERY, on_rule=True)
    expected = pretrained.method("fsel").select(problem, 8, np.random.default_rng(0))
    for score in (by_rule, network.scores):
        picks = walked(pairs, 8, score).picks
        np.testing.assert_array_equal(pairs.prepared.pool[picks], expected)


def test_walks_stay_among_what_is_allowed(pairs):
    among = np.array([1, 4, 5, 20, 22, 23])
    steps = walked(pairs, K, by_rule, among)
    assert sorted(steps.picks.tolist()) == among.tolist()
    assert steps.selectable.sum(axis=1).tolist() == [30 - 4 - t for t in range(K)]
    for step, row in enumerate(steps.picks):
        left = [r for r in among if steps.selectable[step, r]]
        assert steps.features[step, row, 0] == steps.features[step, left, 0].max()


class Fixed(torch.nn.Module):
    """Scores that do not depend on inputs."""

    def __init__(self, scores):
        super().__init__()
        self.values = torch.tensor(scores)

    def forward(self, features):
        return self.values.expand(features.shape[:2])


def test_any_wanted_row_is_right():
    features = torch.zeros(2, 4, 3)
    selectable = torch.tensor([[True] * 4, [True, True, True, False]])
    wanted = torch.tensor([[True, False, False, True], [True, False, False, False]])
    scores = np.log([1.0, 2, 3, 4]).tolist()
    loss, agreement = teaching.any_of(Fixed(scores), features, selectable, wanted)
    # 5 of 10, then 1 of 6; the best-scored row is wanted in the first step alone
    assert loss.item() == pytest.approx(-(np.log(5 / 10) + np.log(1 / 6)) / 2)
    assert agreement.item() == 0.5


def test_a_good_subset_is_to_lead_by_its_gap():
    features, selectable = torch.zeros(1, 4, 3), torch.ones(1, 4, dtype=torch.bool)
    item = [features, selectable, torch.tensor([3]), features, selectable, torch.tensor([0])]
    scores = np.log([1.0, 2, 3, 4]).tolist()
    loss, leads = teaching.above(Fixed(scores), *item, torch.tensor(1.5))
    assert loss.item() == pytest.approx(np.log(1 + np.exp(1.5 - np.log(4))))
    assert leads.item() == 1
    *_, other = item[:3], item[3:]
    assert teaching.above(Fixed(scores), *other, *item[:3], torch.tensor(0.0))[1].item() == 0


def test_taught_steps_want_what_is_left_of_a_subset_in_any_order(pairs):
    lesson, rng = lesson_on(pairs), np.random.default_rng(0)
    items = [next(teaching.taught_steps(lesson, 1, rng)) for _ in range(2)]
    firsts = []
    for _, selectable, wanted in items:
        for step in range(K):
            left = [row for row in lesson.subsets[0] if selectable[step, row]]
            assert wanted[step].nonzero()[:, 0].tolist() == left
            assert len(left) == K - step
        firsts.append((wanted[0] & ~wanted[-1]).nonzero()[:, 0].tolist())
    assert firsts[0] != firsts[1]


def test_own_steps_want_the_good_subset_that_shares_most(pairs):
    own = walked(pairs, K, by_rule).picks
    far = np.setdiff1d(np.arange(len(pairs.prepared.pool)), own)
    subsets = np.sort([far[:K], [*own[:3], *far[:3]]], axis=1)
    lesson = Lesson((0, 0), pairs, K, subsets, np.array([25.0, 24.0]))
    _, selectable, wanted = teaching.own_steps(lesson, by_rule, kept=2)
    # before the first pick both share nothing, and the better one counts
    assert torch.equal(wanted[0].nonzero()[:, 0], torch.from_numpy(subsets[0]))
    for step in range(1, K):
        left = [row for row in subsets[1] if selectable[step, row]]
        assert wanted[step].nonzero()[:, 0].tolist() == left


def test_swaps_are_pairs_of_subsets_that_differ_in_one_frame(pairs):
    subsets = np.array([[0, 1, 2], [1, 2, 3], [2, 3, 4], [5, 6, 7]])
    lesson = Lesson((0, 0), pairs, 3, subsets, np.array([25.0, 24.5, 23.0, 20.0]))
    features, gaps = teaching.swapped(lesson, 9, np.random.default_rng(0))
    # the first two share rows 1 and 2, the second and third 2 and 3: two steps each
    assert sorted(gaps.tolist()) == [0.5, 0.5, 1.5, 1.5]
    steps = walked(pairs, 3, by_rule, np.array([1, 2]))
    assert len(steps.picks) == 2
    own = features[(gaps == 0.5).nonzero()[:, 0]].numpy()
    np.testing.assert_array_equal(own, steps.features[:, [0, 3]])
    none = Lesson((0, 0), pairs, 3, subsets[[0, 3]], np.array([25.0, 20.0]))
    assert len(teaching.swapped(none, 9, np.random.default_rng(0))[1]) == 0


def test_a_pair_counts_by_its_gap():
    features = torch.tensor([[[2.0], [1.0]], [[0.0], [3.0]]])
    loss, share = teaching.better(lambda x: x[..., 0], features, torch.tensor([3.0, 1.0]))
    expected = (3 * np.log(1 + np.exp(-1)) + np.log(1 + np.exp(3))) / 4
    assert loss.item() == pytest.approx(expected)
    assert share.item() == 0.75


@pytest.mark.parametrize("way", ["imitate", "dagger", "rank"])
def test_every_way_of_teaching_lowers_its_own_cost(pairs, way):
    lessons = [lesson_on(pairs, seed, pairs.sharper) for seed in range(3)]
    torch.manual_seed(0)
    network = Learned(EVERY, on_rule=False)
    if way == "rank":
        rng = np.random.default_rng([0, 1])
        items = [pair for one in lessons for pair in teaching.ranked_pairs(one, 2, rng)]
        cost = teaching.above
    else:
        items = teaching.all_taught(lessons, {"kept": 1}, 0)
        cost = teaching.any_of
    weighted = [(*item, 1.0) for item in items]
    before = mean_cost(network, weighted, cost)
    settings = SETTINGS | ({} if way == "rank" else {"kept": 1})
    getattr(teaching, way)(network, lessons, settings, 0)
    after = mean_cost(network, weighted, cost)
    assert after[0] < 0.8 * before[0]
    assert after[1] >= before[1]


def test_ranking_swaps_learns_what_parts_subsets(pairs):
    rng, n = np.random.default_rng(0), len(pairs.prepared.pool)
    walks = [np.sort(rng.choice(n, K, replace=False))]
    for _ in range(60):
        swapped = walks[-1].copy()
        swapped[rng.integers(K)] = rng.choice(np.setdiff1d(np.arange(n), swapped))
        walks.append(np.sort(swapped))
    subsets = np.array(walks)
    worth = pairs.sharper[subsets].sum(axis=1)
    order = np.argsort(-worth)
    lesson = Lesson((0, 0), pairs, K, subsets[order], worth[order])
    torch.manual_seed(0)
    network = Learned(EVERY, on_rule=True)
    before = sharpest(lesson, walked(pairs, K, network.scores).picks)
    settings = {"swaps": 60, "swap_epochs": 80, "learning_rate": 1e-2}
    teaching.rank_swaps(network, [lesson], settings, 0)
    picks = walked(pairs, K, network.scores).picks
    assert sharpest(lesson, picks) > 0.8 * np.sort(pairs.sharper)[-K:].sum() > before


def sharpest(lesson, rows):
    """A judge that wants sharp frames."""
    return float(lesson.pairs.sharper[rows].sum())


def test_policy_gradient_raises_what_is_judged(pairs):
    lesson, network = lesson_on(pairs), Learned(EVERY, on_rule=True)
    before = sharpest(lesson, walked(pairs, K, network.scores).picks)
    settings = {"updates": 30, "walks": 4, "gradient_rate": 1e-2}
    torch.manual_seed(0)
    policy_gradient(network, [lesson], sharpest, settings, 0)
    assert sharpest(lesson, walked(pairs, K, network.scores).picks) > before + 1


def test_evolution_moves_the_last_layer_alone_to_what_is_judged_better(pairs):
    torch.manual_seed(0)
    network = Learned(EVERY, on_rule=False)
    lesson, first = lesson_on(pairs), network.body[0].weight.clone()
    before = sharpest(lesson, walked(pairs, K, network.scores).picks)
    settings = {"generations": 6, "population": 8, "batch": 1, "step": 0.3}
    evolve(network, [lesson], sharpest, settings, 0)
    assert sharpest(lesson, walked(pairs, K, network.scores).picks) > before
    assert torch.equal(network.body[0].weight, first)


def test_networks_come_back_from_their_file_as_they_were(tmp_path, pairs):
    torch.manual_seed(1)
    made = {"a": [Learned(["gain"], True), Learned(EVERY, False)], "b": [Learned(EVERY, True)]}
    for name in ("one", "two"):
        save(made, tmp_path / name)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()
    found, features = load(tmp_path / "one"), inputs(pairs, state_after(pairs, [3]))
    assert {name: len(seeds) for name, seeds in found.items()} == {"a": 2, "b": 1}
    for name, seeds in made.items():
        for own, other in zip(seeds, found[name], strict=True):
            np.testing.assert_array_equal(own.scores(features), other.scores(features))
    both = [network.scores(features) for network in found["a"]]
    np.testing.assert_array_equal(mean_score(found["a"], features), np.mean(both, axis=0))


def test_inputs_that_are_not_shown_are_not_read(pairs):
    torch.manual_seed(0)
    network, features = Learned(["sharper"], False), inputs(pairs, state_after(pairs, [3]))
    other = features.copy()
    other[:, 1:][:, ~shown(["sharper"])] += 1
    np.testing.assert_array_equal(network.scores(features), network.scores(other))


def test_cases_name_what_is_there():
    for name, learner in LEARNERS.items():
        before = list(LEARNERS)[: list(LEARNERS).index(name)]
        assert learner.start is None or learner.start in before
    for case in INPUT_CASES.values():
        assert set(case.groups) <= set(GROUPS)
        assert case.reference in ("", *INPUT_CASES)
