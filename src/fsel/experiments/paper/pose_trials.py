"""Trials on poses that are not exact: from two sources, or disturbed on purpose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fsel.core.capture import Capture
from fsel.core.split import Split, evaluation_split
from fsel.evaluation.measuring import draw_chance
from fsel.experiments import specs
from fsel.experiments.paper.pose_errors import perturbed
from fsel.experiments.scheme import Trial, Trials
from fsel.experiments.specs import Values
from fsel.metrics import METRICS
from fsel.selectors.baselines import FURTHER, PAPER
from fsel.workflow.experiment import Experiment

SELECTORS = {**PAPER, **FURTHER}
EXACT, ESTIMATED = "none", "estimated"  # what was done to the poses
SELECTOR, BOTH = "selector", "both"  # who works with the poses that result
FOLDERS = ("given", "estimated")


def of_two_sources(
    given: Capture,
    other: Capture,
    *,
    draws: int,
    budgets: Sequence[int],
    targets: int,
    seed: int,
    split_seed: int,
) -> Iterator[Trial]:
    """Yield every draw with both sources of poses: `change` is `none` or `estimated`.

    What is picked on the second is reconstructed with the first ones (`scope`: `selector`) and with
    the second ones (`both`).

    Args:
        given, other: captures of the same frames.
        draws: of targets, which chance alone decides, whatever the poses.
        targets: held-out views of a draw.
        split_seed: of the scene's draws of targets.
    """
    for draw in range(draws):
        for change, seen in ((EXACT, given), (ESTIMATED, other)):
            split = evaluation_split(seen, draw, split_seed, targets)
            key = {"draw": draw, "change": change}
            yield _trial(key, given, seen, split, budgets, seed)


def with_noise(
    capture: Capture,
    *,
    levels: Mapping[str, Sequence[float]],
    noises: int,
    budgets: Sequence[int],
    targets: int,
    seed: int,
    split_seed: int,
) -> Iterator[Trial]:
    """Yield the first draw with ever more noise, in rotations and in centres.

    Sparse points stay where they are. `change` is `none` or a key of `levels`, `noise` its seed.

    Args:
        levels: `degrees` and `percent` -> levels, see
            `fsel.experiments.paper.pose_errors.perturbed`.
        noises: seeds of the noise.
        budgets, targets, seed, split_seed: as in `of_two_sources`.
    """
    cases = [(EXACT, 0.0, 0)]
    cases += [(c, float(at), n) for c in levels for at in levels[c] for n in range(noises)]
    for change, level, noise in cases:
        seen = disturbed(capture, change, level, noise, seed)
        split = evaluation_split(seen, 0, split_seed, targets)
        key = {"draw": 0, "change": change, "level": level, "noise": noise}
        yield _trial(key, capture, seen, split, budgets, seed)


def _trial(
    key: Values, exact: Capture, seen: Capture, split: Split, budgets: Sequence[int], seed: int
) -> Trial:
    scopes = {BOTH: exact} if key["change"] == EXACT else {SELECTOR: exact, BOTH: seen}
    return Trial(key, seen, split, budgets, draw_chance(seed, key["draw"]), scopes=scopes)


def disturbed(capture: Capture, change: str, level: float, noise: int, seed: int) -> Capture:
    """The capture with noise in its poses; with none where `change` is `none`."""
    if change == EXACT:
        return capture
    amounts = {"degrees": 0.0, "percent": 0.0, change: level}
    rng = np.random.default_rng([seed, noise])
    return replace(capture, world_to_camera=perturbed(capture.world_to_camera, **amounts, rng=rng))


def budgets_tried(experiment: Experiment) -> list[int]:
    """The budgets up to 30: of a capture of few frames, larger ones would take nearly all."""
    most = experiment.budget_near(30)
    return [k for k in experiment.config["budgets"] if k <= most]


def _draws(experiment: Experiment, purpose: str) -> Values:
    return {
        "targets": experiment.config["targets"],
        "split_seed": specs.scene_seed(experiment, "split"),
        "seed": specs.scene_seed(experiment, purpose),
    }


ESTIMATES = Trials(
    f"{__name__}:ESTIMATES",
    "estimated",
    of_two_sources,
    settings=lambda experiment: {
        **_draws(experiment, "poses"),
        "draws": experiment.config["draws"],
        "budgets": budgets_tried(experiment),
    },
    methods=list(SELECTORS),
    captures=[f"poses/{name}/" for name in FOLDERS],
    folder="poses/",
    metrics=lambda experiment: METRICS,
)

SOURCES = Trials(
    f"{__name__}:SOURCES",
    "paired",
    of_two_sources,
    settings=lambda experiment: {
        **_draws(experiment, "sources"),
        "draws": experiment.config["draws"],
        "budgets": experiment.config["budgets"],
    },
    methods=list(SELECTORS),
    captures=[f"sources/{name}/" for name in FOLDERS],
    folder="sources/",
)

NOISE = Trials(
    f"{__name__}:NOISE",
    "noise",
    with_noise,
    settings=lambda experiment: {
        **_draws(experiment, "poses"),
        "levels": {k: experiment.config["inexact_poses"][k] for k in ("degrees", "percent")},
        "noises": experiment.config["inexact_poses"]["noises"],
        "budgets": [experiment.budget_near(30)],
    },
    methods=list(SELECTORS),
    folder="poses/",
    metrics=lambda experiment: METRICS,
)
