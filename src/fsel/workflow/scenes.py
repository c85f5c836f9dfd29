"""The scenes that tables are made of; a configuration without them is refused."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from fsel.workflow.datasets import folder_of, kinds_of, roots_of
from fsel.workflow.experiment import Choice, Experiment
from fsel.workflow.inputs import joined, of_scenes
from fsel.workflow.requirements import check_poses
from fsel.workflow.schema import Refusal
from fsel.workflow.settings import Scene

Scenes = list[Scene]


def _some(scenes: Scenes, none: str, hint: str) -> Scenes:
    """Return scenes; refuse a configuration in which there are none."""
    if not scenes:
        raise Refusal(none, hint)
    return scenes


def of_table(experiment: Experiment, chosen: Callable[[Experiment], Scenes]) -> dict[str, Any]:
    """Return params of a table: its `scenes`, and the `facts` for its caption."""

    def facts(wildcards: Any) -> dict[str, Any]:
        return experiment.facts(datasets_of(chosen(experiment)), wildcards.reconstructor)

    return {"scenes": lambda wildcards: chosen(experiment), "facts": facts}


def files(experiment: Experiment, chosen: Callable[[Experiment], Scenes], name: str) -> Choice:
    """Return an input function: a file of each scene of a table."""
    return lambda wildcards: of_scenes(chosen(experiment), name)


def problems(scenes: Scenes, draws: Iterable[int]) -> list[str]:
    """List dataset/scene/draw of some draws of scenes."""
    numbers = list(draws)
    return [f"{dataset}/{scene}/draw{n}" for dataset, scene in scenes for n in numbers]


def datasets_of(scenes: Scenes) -> list[str]:
    """List the datasets of scenes, each once, in order."""
    return list(dict.fromkeys(dataset for dataset, _ in scenes))


def with_labels(experiment: Experiment) -> list[str]:
    """List the labelled scenes, at least one."""
    if not experiment.labelled:
        raise Refusal(
            "no dataset has `train` scenes",
            "this is made of labels; name scenes to train on, docs/datasets.md",
        )
    return list(experiment.labelled)


def from_labels(experiment: Experiment, files: Any) -> Any:
    """Return files that are made from labels; refuse a configuration without labels."""
    with_labels(experiment)
    return files


def held_out(experiment: Experiment) -> Scenes:
    """List the evaluation scenes of the labelled dataset, at least one."""
    trained = experiment.trained
    return _some(
        [(trained, scene) for scene in experiment.scenes(trained, "evaluation")],
        f"{trained} has no evaluation scenes",
        "this experiment is made on evaluation scenes of training.dataset",
    )


def searched(experiment: Experiment) -> Scenes:
    """List the evaluation scenes on which selections are compared with the search."""
    everywhere = experiment.config["oracle"]["everywhere"]
    return experiment.evaluation_scenes if everywhere else held_out(experiment)


def held_out_problems(
    experiment: Experiment, chosen: Callable[[Experiment], Scenes] = held_out
) -> list[str]:
    """List the problems of some scenes that are searched, at least one."""
    config = experiment.config
    if not experiment.searched_problems():
        raise Refusal(
            f"{experiment.trained} has no evaluation scenes, or oracle.draws is 0",
            "the comparison with the search is made on evaluation scenes of training.dataset",
        )
    if config["search"]["k"] not in config["budgets"]:
        raise Refusal(
            f"search.k is {config['search']['k']}, which is not among budgets {config['budgets']}",
            "selections are compared with the search at its own budget",
        )
    return problems(chosen(experiment), range(config["oracle"]["draws"]))


def rooms(experiment: Experiment) -> Scenes:
    """List the evaluation scenes filmed in several passes, at least one."""
    passes: Mapping[str, Mapping[str, list[str]]] = experiment.config["crosscapture"]["held_out"]
    entries = experiment.datasets.entries

    def in_passes(dataset: str, scene: str) -> bool:
        if passes:
            return scene in passes.get(dataset, {})
        entry = entries[dataset]
        return bool(entry.get("passes", entry["layout"] == "seven_scenes"))

    scenes = [scene for scene in experiment.evaluation_scenes if in_passes(*scene)]
    named = {(d, s) for d in passes for s in passes[d] if d in entries}
    if unknown := sorted(joined(named - set(scenes))):
        raise Refusal(
            f"crosscapture.held_out: {unknown} are no evaluation scenes",
            "it names datasets, their scenes, and passes of each",
        )
    return _some(
        scenes,
        "no dataset with evaluation scenes was filmed in several passes",
        "the cross-capture experiment needs layout seven_scenes, a dataset with `passes: true`, or "
        "crosscapture.held_out",
    )


def passes(experiment: Experiment, wildcards: Any) -> list[str]:
    """List the passes of a room that are held out in turn; none for each of all."""
    named = experiment.config["crosscapture"]["held_out"].get(wildcards.dataset, {})
    found: list[str] = named.get(wildcards.scene, [])
    return found


def of_objects(experiment: Experiment) -> Scenes:
    """List the captures of an object, at least one."""
    return _some(
        experiment.with_role("object"),
        "no dataset has `object` scenes",
        "the object-centric experiment needs captures with masks of an object",
    )


def tried(experiment: Experiment, table: str) -> Scenes:
    """List the scenes on which `feature_sweep` or `scorer_arch` compares rows, at least one."""
    named = experiment.config["trials"]["scenes"][table]
    if not named:
        return _some(
            experiment.with_role("validation"),
            "no dataset has validation scenes",
            "features and scorers are compared on them unless trials.scenes says otherwise",
        )
    there = {d: role for d, role in named.items() if d in experiment.datasets.entries}
    return _some(
        [(d, s) for d, role in there.items() for s in experiment.scenes(d, role)],
        f"trials.scenes.{table} is {named}, of which no scene is there",
        "leave it out for the validation scenes of all datasets",
    )


def posed_twice(experiment: Experiment) -> Scenes:
    """List the evaluation scenes with a second source of poses, at least one."""
    config = experiment.config["pose_sources"]
    named, model = config["dataset"], config["model"]
    entry = experiment.datasets.entries.get(named, {})
    if named is None or named in experiment.datasets.missing:
        raise Refusal(
            f"pose_sources.dataset is {named}" + (", which is not there" if named else ""),
            "name a dataset on disk, and in `poses` what estimates them, or in `model` the folder "
            "of a COLMAP model inside each scene",
        )
    scenes = experiment.scenes(named, "evaluation")
    if config["poses"] != "file":
        if "embedded" in kinds_of(entry):
            raise Refusal(
                f"pose_sources.dataset is {named!r}, whose images are generated and small",
                "name a dataset with a `root` or `fetch`: poses are found in its images",
            )
        check_poses("pose_sources.poses", config["poses"])
        return [(named, scene) for scene in scenes]
    if not roots_of(entry):
        raise Refusal(
            f"pose_sources.dataset is {named!r}, no dataset with a `root`",
            "a second source of poses is a folder inside each scene; or name it in `poses`",
        )
    if missing := [s for s in scenes if not (folder_of(entry, s) / model).is_dir()]:
        raise Refusal(
            f"pose_sources.model is {model!r}, no folder in {len(missing)} of {len(scenes)} scenes "
            f"of {named}: {missing[:3]}",
            "export the second source's poses as a COLMAP model there, or name it in `poses`",
        )
    return [(named, scene) for scene in scenes]
