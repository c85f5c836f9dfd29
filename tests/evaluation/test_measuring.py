"""One way to measure: runs, their picks, their worth."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from selection_problems import problem_on, random_capture, random_weights
from slow_selector import random_scorer

from fsel.core.names import name_seed
from fsel.core.problem import Method
from fsel.evaluation import measuring
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import Run, learned_runs, picks_at, rng_by_name, runs
from fsel.selectors.baselines import METHODS
from fsel.selectors.policies import POLICIES
from fsel.selectors.scorer import Linear, Network, Scorer
from fsel.stages.train import save_scorer

SUFFIX = {Linear: ".json", Network: ".safetensors"}


class Drawn:
    """A method that draws frames at random, and counts its calls."""

    def __init__(self, nested: bool) -> None:
        self.budgets: list[int] = []
        self.method = Method("drawn", "D", "candidates", nested, self.select, 2)

    def select(self, problem, k, rng):
        self.budgets.append(k)
        return rng.permutation(problem.candidates)[:k]


@pytest.fixture
def problem():
    return problem_on(random_capture(24))


def test_scorers_say_whose_they_are(tmp_path):
    paths, trained = {}, ["less_is_more_no_appearance", "less_is_more"]
    for name, seed in (("fsel", 0), (trained[1], 0), (trained[1], 1), (trained[0], 0)):
        scorer = random_scorer(POLICIES[name], seed)
        paths[name, seed] = tmp_path / f"{name}{seed}{SUFFIX[type(scorer)]}"
        save_scorer(scorer, name, "a test", seed, "c", paths[name, seed])
    made = [(run.method.name, run.seed) for run in learned_runs(paths.values())]
    assert made == [(trained[0], 0), (trained[1], 0), (trained[1], 1), ("fsel", 0)]
    save_scorer(scorer, "another", "a test", 0, "c", tmp_path / "x.safetensors")
    with pytest.raises(ValueError, match=r"x.*'another'"):
        runs([], [tmp_path / "x.safetensors"])


def test_each_scorer_picks_as_itself(tmp_path, problem):
    paths = [tmp_path / f"{seed}.safetensors" for seed in range(2)]
    for seed, path in enumerate(paths):
        save_scorer(Network(random_weights(seed)), "less_is_more", "a test", seed, "c", path)
    made = learned_runs(paths)
    for run in made:
        scorer = Scorer.load(paths[run.seed])
        method = POLICIES["less_is_more"].method(scorer)
        expected = method.select(problem, 5, np.random.default_rng(0))
        (picks,) = picks_at(problem, run, [5], rng_by_name(0))
        np.testing.assert_array_equal(picks.frames, expected)


@pytest.mark.parametrize(("nested", "sizes"), [(True, [6]), (False, [3, 6, 2])])
def test_a_nested_method_runs_once(problem, nested, sizes):
    drawn = Drawn(nested)
    made = list(picks_at(problem, Run(drawn.method, 1), [3, 6, 2], rng_by_name(7)))
    assert drawn.budgets == sizes
    assert [picks.k for picks in made] == [len(picks.frames) for picks in made] == [3, 6, 2]
    for picks in made:
        rng = np.random.default_rng(name_seed(7, "drawn", 1, 6 if nested else picks.k))
        expected = rng.permutation(problem.candidates)[: picks.k]
        np.testing.assert_array_equal(picks.frames, expected)


def test_chance_is_named_so_that_other_runs_change_nothing(problem):
    drawn = Drawn(nested=False).method
    alone = pd.DataFrame(measuring.select(problem, [Run(drawn, 1)], [4], rng_by_name(7)))
    both = runs([METHODS["random"], drawn])
    among = pd.DataFrame(measuring.select(problem, both, [3, 4], rng_by_name(7)))
    same = among[(among["method"] == "drawn") & (among["seed"] == 1) & (among["k"] == 4)]
    assert same["frame"].tolist() == alone["frame"].tolist()
    other = among[(among["method"] == "drawn") & (among["seed"] == 0) & (among["k"] == 4)]
    assert other["frame"].tolist() != alone["frame"].tolist()


def test_picks_are_written_down_in_order(problem):
    made = measuring.select(problem, runs([METHODS["nearest"]]), [2, 3], rng_by_name(0))
    table = pd.DataFrame(made)
    assert table["k"].tolist() == [2, 2, 3, 3, 3]
    assert table["order"].tolist() == [0, 1, 0, 1, 2]
    frames = table["frame"].tolist()
    assert frames[:2] == frames[2:4]
    assert table["name"].tolist() == [problem.capture.names[i] for i in frames]
    assert table["pool"].unique().tolist() == [METHODS["nearest"].pool]


class Flat:
    """Renders every view in one grey, which the subset decides; counts its fits."""

    def __init__(self, capture) -> None:
        self.capture, self.fitted = capture, []

    def fit(self, frames):
        self.fitted.append(frames.tolist())
        width, height = self.capture.size
        grey = np.float32(frames.sum() / 100)

        def render(views):
            return np.full((len(views), height, width, 3), grey, np.float32)

        count = len(frames)
        costs = {"seconds": 0.5, "peak_bytes": 100 * count, "device": "abacus"}
        return SimpleNamespace(primitives=count, bytes=8 * count, render=render, **costs)


def test_each_distinct_subset_is_reconstructed_once():
    capture = random_capture(20)
    images = np.full((20, 12, 16, 3), 51, np.uint8)  # a grey of 0.2
    flat = Flat(replace(capture, images=images))
    evaluator = Evaluator.on_frames(flat, np.array([4, 9]))
    rows = [("a", 0, 2, [11, 1]), ("b", 0, 2, [1, 11]), ("b", 1, 3, [1, 11, 18])]
    picks = pd.concat(
        pd.DataFrame({"method": m, "seed": s, "k": k, "frame": frames}) for m, s, k, frames in rows
    )
    table = pd.DataFrame(measuring.measure(evaluator, picks))
    assert flat.fitted == [[1, 11], [1, 11, 18]]
    assert table["method"].tolist() == list("aabbbb")
    assert table["target"].tolist() == [4, 9] * 3
    # grey 0.12 and 0.30 against 0.20: squared errors 0.0064 and 0.01
    expected = np.repeat([-10 * np.log10(0.0064)] * 2 + [20.0], 2)
    np.testing.assert_allclose(table["psnr"], expected, atol=1e-5)
    assert table["primitives"].tolist() == [2] * 4 + [3] * 2
    assert table["bytes"].tolist() == [16] * 4 + [24] * 2
    assert table["fit_seconds"].unique().tolist() == [0.5]
    assert table["peak_bytes"].tolist() == [200] * 4 + [300] * 2
    assert table["device"].unique().tolist() == ["abacus"]
    by_method = measuring.measure(evaluator, picks[picks["method"] == "a"], by=["method"])
    assert len(flat.fitted) == 2
    assert list(by_method)[:2] == ["method", "target"]
