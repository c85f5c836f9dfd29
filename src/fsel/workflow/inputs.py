"""Files and scenes that rules ask for: nouns that say what they return.

Paths begin with `<results>`, `<tables>`, `<figures>` or `<downloads>`, which Snakemake replaces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product
from typing import Any

from fsel.workflow.experiment import Experiment
from fsel.workflow.refusal import refuse
from fsel.workflow.settings import Scene

SCENE = "<results>/{dataset}/{scene}"
FILES = {
    "frames": "frames.parquet",
    "points": "points.parquet",
    "images": "images.npy",
    "masks": "masks.npy",
    "descriptors": "descriptors.parquet",
}
LABEL_PART = "<results>/labels/{scene}/part{part}.jsonl"
BARE = ("frames", "images")
CAPTURE = ("frames", "points", "images")
DESCRIBED = (*CAPTURE, "descriptors")

Paths = dict[str, Any]


def table_files(name: str) -> Paths:
    """A table in LaTeX and its numbers. `{reconstructor}` in its name is a folder."""
    return {"table": f"<tables>/{name}.tex", "numbers": f"<tables>/{name}.csv"}


def figure_files(name: str) -> list[str]:
    """A figure in both formats. `{reconstructor}` in its name is a folder."""
    return [f"<figures>/{name}.pdf", f"<figures>/{name}.png"]


def expanded(pattern: str, **values: Iterable[object]) -> list[str]:
    """A pattern with every combination of values in its braces; other braces stay as they are."""
    texts = []
    for combination in product(*(list(each) for each in values.values())):
        text = pattern
        for key, value in zip(values, combination, strict=True):
            text = text.replace(f"{{{key}}}", str(value))
        texts.append(text)
    return texts


def capture(kinds: Sequence[str] = CAPTURE, folder: str = SCENE, prefix: str = "") -> Paths:
    """Name -> file of a canonical capture.

    Args:
        kinds: keys of `FILES`.
        folder: of the capture.
        prefix: of the names, with an underscore at its end.
    """
    return {f"{prefix}{kind}": f"{folder}/{FILES[kind]}" for kind in kinds}


def captures(scenes: Iterable[str], kinds: Sequence[str] = CAPTURE, prefix: str = "") -> Paths:
    """Name -> files of several canonical captures, one a scene.

    Args:
        scenes: dataset/scene of each.
        kinds: keys of `FILES`.
        prefix: of the names, with an underscore at its end.
    """
    names = list(scenes)
    return {f"{prefix}{kind}": [f"<results>/{n}/{FILES[kind]}" for n in names] for kind in kinds}


def of_draws(experiment: Experiment, name: str, draws: Iterable[int] | None = None) -> list[str]:
    """A file of every draw of the scene in the wildcards, or of some draws."""
    chosen = range(experiment.config["draws"]) if draws is None else draws
    return [f"{SCENE}/draw{n}/{name}" for n in chosen]


def of_problems(problems: Iterable[str], name: str) -> list[str]:
    """A file of every problem, dataset/scene/draw; of every scene, dataset/scene."""
    return [f"<results>/{problem}/{name}" for problem in problems]


def of_scenes(scenes: Iterable[Scene], name: str, draws: Iterable[int] | None = None) -> list[str]:
    """A file of every scene, or of each of its draws."""
    parts = [""] if draws is None else [f"draw{n}/" for n in draws]
    return [f"<results>/{d}/{s}/{part}{name}" for d, s in scenes for part in parts]


def joined(scenes: Iterable[Scene]) -> list[str]:
    """List dataset/scene of every scene."""
    return [f"{dataset}/{scene}" for dataset, scene in scenes]


def with_labels(experiment: Experiment) -> list[str]:
    """The labelled scenes, at least one."""
    if not experiment.labelled:
        refuse(
            "no dataset has `train` scenes",
            "this is made of labels; name scenes to train on, docs/datasets.md",
        )
    return list(experiment.labelled)


def labelled(experiment: Experiment) -> list[str]:
    """List dataset/scene of every labelled scene."""
    return [f"{experiment.trained}/{scene}" for scene in with_labels(experiment)]


def label_files(experiment: Experiment, scenes: Iterable[str] | None = None) -> list[str]:
    """The searched subsets of every labelled scene and coverage, or of some scenes."""
    return expanded(
        "<results>/labels/{scene}/p{coverage}.parquet",
        scene=with_labels(experiment) if scenes is None else scenes,
        coverage=experiment.config["coverages"],
    )


def parts_before(experiment: Experiment) -> Paths:
    """The evaluations that earlier jobs made for the labels of the scene in the wildcards."""
    parts = experiment.config["label_jobs"] - 1
    return {"known": LABEL_PART.replace("{part}", str(parts - 1))} if parts else {}


def part_before(wildcards: Any) -> list[str]:
    """Evaluations that the part before the one in the wildcards made, if it is not the first."""
    part, scene = int(wildcards.part), wildcards.scene
    before = LABEL_PART.replace("{part}", str(part - 1)).replace("{scene}", scene)
    return [before] if part else []


def of_labelled(experiment: Experiment, name: str) -> list[str]:
    """`splits` or `features` of every labelled scene, at all coverages."""
    return [f"<results>/labels/{scene}/{name}.parquet" for scene in with_labels(experiment)]


def embedded(experiment: Experiment) -> Paths:
    """Return what an embedded capture is made from: family, seed, layout, frames and size."""
    entries = experiment.datasets.entries
    return {
        **experiment.config["embedded"],
        "layout": lambda wildcards: entries[wildcards.dataset]["layout"],
        "family": lambda wildcards: entries[wildcards.dataset]["embedded"]["family"],
        "seed": experiment.scene_seed,
    }


def protocol(experiment: Experiment) -> Paths:
    """Return the protocol of the dataset in the wildcards, if it has one."""
    of = experiment.datasets.protocol
    return {"protocol": lambda wildcards: of(wildcards.dataset, wildcards.scene)}


def unpacked(experiment: Experiment) -> Paths:
    """Return where the scene in the wildcards lies in its archive, its sha256 and its licence."""

    def known(key: str) -> Callable[[Any], Any]:
        return lambda wildcards: experiment.datasets.fetched(wildcards.dataset, wildcards.scene)[
            key
        ]

    return {key: known(key) for key in ("inside", "files", "licence")}


def ingested(experiment: Experiment, long_side: int) -> Paths:
    """Return how the capture in the wildcards is read, with images of some size."""
    datasets = experiment.datasets
    return {
        "reading": lambda wildcards: datasets.reading(wildcards.dataset, wildcards.scene),
        "long_side": long_side,
        "at_least": lambda wildcards: experiment.frames_needed(
            datasets.role_of(wildcards.dataset, wildcards.scene)
        ),
    }


def scorer_files(experiment: Experiment, policy: str) -> Paths:
    """Scorers of a policy that are trained here, one a seed, with a log beside each."""
    with_labels(experiment)
    folder = experiment.scorer_folder(policy)
    return {
        "weights": [f"{folder}/seed{seed}.safetensors" for seed in experiment.seeds],
        "logs": [f"{folder}/seed{seed}.parquet" for seed in experiment.seeds],
    }


def training(experiment: Experiment, policy: str) -> Paths:
    """Return how a policy is trained."""
    config = experiment.config["training"]
    settings = {key: config[key] for key in ("epochs", "learning_rate")}
    return {"policy": policy, "scenes": list(experiment.labelled), **settings}


def held_out_scenes(experiment: Experiment) -> list[Scene]:
    """Evaluation scenes of the labelled dataset, at least one."""
    trained = experiment.trained
    scenes = experiment.scenes(trained, "evaluation")
    if not scenes:
        refuse(
            f"{trained} has no evaluation scenes",
            "this experiment is made on evaluation scenes of training.dataset",
        )
    return [(trained, scene) for scene in scenes]


def held_out_problems(experiment: Experiment) -> list[str]:
    """Problems on which selections are compared with the search, at least one."""
    problems, config = experiment.searched_problems(), experiment.config
    if not problems:
        refuse(
            f"{experiment.trained} has no evaluation scenes, or oracle.draws is 0",
            "the comparison with the search is made on evaluation scenes of training.dataset",
        )
    if config["search"]["k"] not in config["budgets"]:
        refuse(
            f"search.k is {config['search']['k']}, which is not among budgets {config['budgets']}",
            "selections are compared with the search at its own budget",
        )
    return problems


def rooms(experiment: Experiment) -> list[Scene]:
    """The evaluation scenes filmed in several passes, at least one."""
    held_out: Mapping[str, Mapping[str, list[str]]] = experiment.config["crosscapture"]["held_out"]
    entries = experiment.datasets.entries

    def in_passes(dataset: str, scene: str) -> bool:
        if held_out:
            return scene in held_out.get(dataset, {})
        entry = entries[dataset]
        return bool(entry.get("passes", entry["layout"] == "seven_scenes"))

    scenes = [scene for scene in experiment.evaluation_scenes if in_passes(*scene)]
    named = {(d, s) for d in held_out for s in held_out[d] if d in entries}
    if unknown := sorted(joined(named - set(scenes))):
        refuse(
            f"crosscapture.held_out: {unknown} are no evaluation scenes",
            "it names datasets, their scenes, and passes of each",
        )
    if not scenes:
        refuse(
            "no dataset with evaluation scenes was filmed in several passes",
            "the cross-capture experiment needs layout seven_scenes, a dataset with `passes: "
            "true`, or crosscapture.held_out",
        )
    return scenes


def passes(experiment: Experiment, wildcards: Any) -> list[str]:
    """The passes of a room that are held out in turn; none for each of all."""
    named = experiment.config["crosscapture"]["held_out"].get(wildcards.dataset, {})
    found: list[str] = named.get(wildcards.scene, [])
    return found


def object_scenes(experiment: Experiment) -> list[Scene]:
    """The captures that are about an object, at least one."""
    scenes = experiment.with_role("object")
    if not scenes:
        refuse(
            "no dataset has `object` scenes",
            "the object-centric experiment needs captures with masks of an object",
        )
    return scenes


def first_scenes(experiment: Experiment) -> list[Scene]:
    """Every dataset's first evaluation scene."""
    return [(d, experiment.scenes(d, "evaluation")[0]) for d in experiment.labels()]
