"""A small scene through the stages: described, labelled, selected and evaluated."""

import pytest
from described_scene import write_scene
from small_sweep import RECONSTRUCTION, SEARCH

from fsel.evaluation.evaluator import Evaluator
from fsel.metrics import METRICS
from fsel.stages.evaluate import evaluate
from fsel.stages.features import features
from fsel.stages.label import label
from fsel.stages.order import order
from fsel.stages.select import select
from fsel.stages.split import split, split_labelled


@pytest.fixture
def kill(monkeypatch):
    """Interrupt one evaluation, the given one; returns a list with an entry for each."""

    def at(evaluation: int) -> list[int]:
        calls, scores = [], Evaluator.scores

        def counted(self, subset):
            calls.append(1)
            if len(calls) == evaluation:
                raise KeyboardInterrupt
            return scores(self, subset)

        monkeypatch.setattr(Evaluator, "scores", counted)
        return calls

    return at


@pytest.fixture(scope="session")
def scene(tmp_path_factory):
    """A small canonical capture with descriptors."""
    return write_scene(tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="session")
def labelled(scene, tmp_path_factory):
    """One coverage level of one scene, searched and ordered."""
    folder = tmp_path_factory.mktemp("labelled")
    splits, labels = folder / "splits.parquet", folder / "p25.parquet"
    described = folder / "features.parquet"
    split_labelled(scene, splits, seed=5, coverages=[25], config="c")
    features(scene, [splits], [described], config="c")
    settings = {"seed": 5, "search": SEARCH, "reconstruction": RECONSTRUCTION, "inputs": []}
    settings["fitness"] = METRICS
    label(scene, splits, labels, coverage=25, config="c", **settings)
    trajectories = folder / "trajectories.parquet"
    files = [scene], [splits], [described], [labels], trajectories
    order(*files, scenes={"s": "train"}, coverages={"s": [25]}, kept=2, config="c")
    return folder


@pytest.fixture(scope="session")
def swept(scene, tmp_path_factory):
    """Two draws of one scene, selected and evaluated by every method without weights."""
    folder = tmp_path_factory.mktemp("swept")
    draws = [folder / f"draw{d}" for d in range(2)]
    splits, described, picks, outputs = (
        [draw / f"{name}.parquet" for draw in draws]
        for name in ("split", "features", "selections", "evaluation")
    )
    split(scene, splits, targets=4, seed=1, config="c")
    features(scene, splits, described, config="c")
    select(scene, splits, described, [], picks, budgets=[3, 5], seeds=[2, 2], config="c")
    settings = {"reconstruction": RECONSTRUCTION, "metrics": METRICS}
    evaluate(scene, splits, picks, outputs, **settings, config="c")
    return draws
