"""Inputs and params that the specs of several tables share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from fsel.workflow import inputs
from fsel.workflow.datasets import kinds_of
from fsel.workflow.experiment import Experiment

Scenes = Sequence[tuple[str, str]]
"""Dataset and scene of each."""
Values = dict[str, Any]


def sweep_evaluations(experiment: Experiment) -> Values:
    """The evaluations of the budget sweep, one a problem."""
    name = "{reconstructor}evaluation.parquet"
    return {"evaluations": inputs.of_problems(experiment.problems(), name)}


def sweep_settings(experiment: Experiment) -> Values:
    """The problems, datasets and budgets of the sweep, and what captions tell."""
    return {
        "problems": experiment.problems(),
        "datasets": experiment.labels(),
        "budgets": experiment.config["budgets"],
        "facts": experiment.facts_of,
    }


def facts_about(experiment: Experiment, names: Sequence[str]) -> Callable[[Any], Values]:
    """Facts of some datasets and the reconstructor in the wildcards."""
    return lambda wildcards: experiment.facts(names, wildcards.reconstructor)


def facts_of_trained(experiment: Experiment) -> Callable[[Any], Values]:
    """Facts of the labelled dataset and the reconstructor in the wildcards."""
    return facts_about(experiment, [experiment.trained])


def datasets_of(scenes: Sequence[tuple[str, str]]) -> list[str]:
    """The datasets of scenes, each once, in order."""
    return list(dict.fromkeys(dataset for dataset, _ in scenes))


def scene_seed(experiment: Experiment, *parts: object) -> Callable[[Any], int]:
    """The seed of the scene in the wildcards for one purpose."""
    return lambda wildcards: experiment.scene_seed(wildcards, *parts)


def of_draw(*names: str, draw: str = "draw{draw}", kinds: Sequence[str] = inputs.CAPTURE) -> Values:
    """A capture, and parquet files of one draw by their names."""
    files = {name: f"{inputs.SCENE}/{draw}/{name}.parquet" for name in names}
    return {**inputs.capture(kinds), **files}


def draws(experiment: Experiment) -> range:
    """The draws of targets."""
    return range(experiment.config["draws"])


def budgets(experiment: Experiment) -> Values:
    """The budgets of the sweep."""
    return {"budgets": experiment.config["budgets"]}


def evaluated_problems(experiment: Experiment) -> Values:
    """Described captures of all evaluation scenes, and the split of each one's first draw."""
    return {
        **inputs.captures(inputs.joined(experiment.evaluation_scenes), inputs.DESCRIBED),
        "splits": inputs.of_problems(experiment.problems(1), "split.parquet"),
    }


def benched(experiment: Experiment) -> Values:
    """Return what made each evaluation scene, and frames and reconstructor of a bench."""
    return {
        "generated": [experiment.generated(*scene) for scene in experiment.evaluation_scenes],
        "k": experiment.config["search"]["k"],
        "reconstruction": experiment.reconstruction,
    }


def filmed_anew(experiment: Experiment, folder: str) -> Callable[[Any], str]:
    """The scene in the wildcards with large images: embedded ones are filmed anew into a folder."""

    def source(wildcards: Any) -> str:
        dataset, scene = wildcards.dataset, wildcards.scene
        if kinds_of(experiment.datasets.entries[dataset]) == ["embedded"]:
            return f"<results>/{dataset}/{scene}/{folder}"
        return experiment.datasets.raw_capture(dataset, scene)

    return source
