"""The selector without appearance, and without appearance and sharpness."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.evaluation import Evaluator
from fsel.features.columns import NAMES
from fsel.files import write_table
from fsel.metrics import METRIC_UNITS, METRICS
from fsel.problem import Method, Problem, checked_select
from fsel.reconstruct import reconstructor_of
from fsel.selector.policies import POLICIES
from fsel.selector.scorer import Network, Scorer
from fsel.split import Split
from fsel.training.imitation import Trajectory, train
from fsel.training.labelled import Scenes, training_data
from fsel.training.scorers import save_scorer

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Variant:
    """A selector without some features.

    Attributes:
        label: how tables print it (LaTeX).
        policy: key of `POLICIES`.
        hidden: features held at zero besides what the policy does not see.
        reads: descriptors that it needs.
    """

    label: str
    policy: str
    hidden: tuple[str, ...]
    reads: tuple[str, ...]

    def method(self, scorer: Scorer) -> Method:
        """The selection method with a trained scorer."""
        return POLICIES[self.policy].method(scorer)


GEOMETRY = "ours_geometry"
VARIANTS = {
    "ours": Variant(r"\textbf{Ours}", "ours", (), ("appearance", "sharpness")),
    "ours_no_appearance": Variant(
        r"\shortstack{w/o\\appear.}", "ours_no_appearance", (), ("sharpness",)
    ),
    GEOMETRY: Variant(
        r"\shortstack{w/o appear.\\\& sharp.}", "ours_no_appearance", ("sharpness",), ()
    ),
}


def hide(trajectories: Sequence[Trajectory], hidden: Sequence[str]) -> list[Trajectory]:
    """The trajectories with some features at zero."""
    shown = ~np.isin(NAMES, list(hidden))
    return [replace(t, features=t.features * shown.astype(np.float32)) for t in trajectories]


def blinded(weights: Mapping[str, np.ndarray], hidden: Sequence[str]) -> dict[str, np.ndarray]:
    """Weights that ignore some features: what a network trained with them at zero must do.

    Their columns of the first layer were multiplied by zero alone, and hold their initial values.
    """
    shown = ~np.isin(NAMES, list(hidden))
    first = weights["layer1.weight"] * shown.astype(np.float32)
    return {**weights, "layer1.weight": first}


def train_variant(
    scenes: Scenes,
    trajectories: str | Path,
    weights: str | Path,
    *,
    name: str,
    seed: int,
    epochs: int,
    learning_rate: float,
    config: str,
) -> None:
    """Behaviour cloning as of `selectors.clone`, some features at zero.

    Args:
        scenes: see `fsel.training.labelled.Scenes`.
        trajectories: what `fsel.stages.order` wrote.
        weights: receives the scorer.
        name: key of `VARIANTS`.
        seed, epochs, learning_rate: of the training.
        config: digest of the parameters.
    """
    variant = VARIANTS[name]
    table = pd.read_parquet(trajectories).query("role == 'train'")
    data = hide(training_data(table, scenes, POLICIES[variant.policy]), variant.hidden)
    arrays, log = train(data, [], seed=seed, epochs=epochs, learning_rate=learning_rate)
    made = f"behaviour cloning of {len(data)} searched subsets, {epochs} epochs"
    save_scorer(Network(blinded(arrays, variant.hidden)), name, made, seed, config, weights)
    logger.info("%s: %s\n%s", name, made, log.tail(1).to_string())


def evaluate_variant(
    folder: str | Path,
    splits: Sequence[str | Path],
    weights: Sequence[str | Path],
    outputs: Sequence[str | Path],
    *,
    name: str,
    budgets: Sequence[int],
    reconstruction: Mapping,
    config: str,
) -> None:
    """A variant's selections of every draw, budget and seed, measured on the targets.

    Args:
        folder: a canonical capture with its descriptors.
        splits: split.parquet, one a draw.
        weights: its scorers, one a training seed.
        outputs: one a draw: method, seed, k, target, metrics.
        name: key of `VARIANTS`.
        budgets: frames to pick.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    methods = [VARIANTS[name].method(Scorer.load(path)) for path in weights]
    reconstructor = None
    for path, output in zip(splits, outputs, strict=True):
        problem, targets = Problem.load(folder, path), Split.load(path).targets
        reconstructor = reconstructor or reconstructor_of(problem.capture, reconstruction)
        evaluate = Evaluator.on_frames(reconstructor, targets)
        tables = []
        for seed, method in enumerate(methods):
            picks = checked_select(method, problem, max(budgets), np.random.default_rng(0))
            for k in budgets:
                table = pd.DataFrame({"method": name, "seed": seed, "k": k, "target": targets})
                table[list(METRICS)] = evaluate.measure(picks[:k]).scores
                tables.append(table)
        write_table(pd.concat(tables), output, units=METRIC_UNITS, config=config)
