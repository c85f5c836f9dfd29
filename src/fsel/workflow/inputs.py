"""Files and scenes that rules ask for: nouns that say what they return.

Paths begin with `<results>`, `<tables>`, `<figures>` or `<downloads>`, which Snakemake replaces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from fsel.workflow.datasets import kinds_of
from fsel.workflow.experiment import Experiment
from fsel.workflow.settings import Scene

SCENE = "<results>/{dataset}/{scene}"
FILES = {
    "frames": "frames.parquet",
    "points": "points.parquet",
    "images": "images.npy",
    "masks": "masks.npy",
    "descriptors": "descriptors.parquet",
}
LABELS = "<results>/labels/{scene}/p{coverage}.parquet"
CAPTURE = ("frames", "points", "images", "masks")
DESCRIBED = (*CAPTURE, "descriptors")
COSTED = ("less_is_more", "less_is_more_no_appearance", "less_is_more_geometry")

SHOWN = ("table", "numbers", "differences", "figures")  # outputs that the report shows

Paths = dict[str, Any]


def table_files(name: str) -> Paths:
    """Name the files of a table, LaTeX and numbers. `{reconstructor}` in its name is a folder."""
    return {"table": f"<tables>/{name}.tex", "numbers": f"<tables>/{name}.csv"}


def figure_files(name: str) -> list[str]:
    """List the files of a figure, in both formats. `{reconstructor}` in its name is a folder."""
    return [f"<figures>/{name}.pdf", f"<figures>/{name}.png"]


def capture(kinds: Sequence[str] = CAPTURE, folder: str = SCENE, prefix: str = "") -> Paths:
    """Map kinds, keys of `FILES` with a prefix, to the files of a canonical capture."""
    return {f"{prefix}{kind}": f"{folder}/{FILES[kind]}" for kind in kinds}


def captures(scenes: Iterable[str], kinds: Sequence[str] = CAPTURE) -> Paths:
    """Map kinds to the files of several canonical captures, one for each dataset/scene."""
    names = list(scenes)
    return {kind: [f"<results>/{n}/{FILES[kind]}" for n in names] for kind in kinds}


def chosen(files: Callable[[Any], Paths], *names: str) -> Paths:
    """Return the files of some names that a function of the wildcards decides, or refuses."""

    def of(name: str) -> Callable[[Any], Any]:
        return lambda wildcards: files(wildcards)[name]

    return {name: of(name) for name in names}


def of_draws(experiment: Experiment, name: str, draws: Iterable[int] | None = None) -> list[str]:
    """List a file of every draw of the scene in the wildcards, or of some draws."""
    chosen = range(experiment.config["draws"]) if draws is None else draws
    return [f"{SCENE}/draw{n}/{name}" for n in chosen]


def of_problems(problems: Iterable[str], name: str) -> list[str]:
    """List a file of every problem, dataset/scene/draw; of every scene, dataset/scene."""
    return [f"<results>/{problem}/{name}" for problem in problems]


def of_scenes(scenes: Iterable[Scene], name: str, draws: Iterable[int] | None = None) -> list[str]:
    """List a file of every scene, or of each of its draws."""
    parts = [""] if draws is None else [f"draw{n}/" for n in draws]
    return [f"<results>/{d}/{s}/{part}{name}" for d, s in scenes for part in parts]


def joined(scenes: Iterable[Scene]) -> list[str]:
    """List dataset/scene of every scene."""
    return [f"{dataset}/{scene}" for dataset, scene in scenes]


def labelled(experiment: Experiment) -> list[str]:
    """List dataset/scene of every labelled scene."""
    return [f"{experiment.trained}/{scene}" for scene in experiment.labelled]


def label_files(experiment: Experiment) -> list[str]:
    """List the searched subsets of every labelled scene at each of its coverage levels."""
    levels = experiment.coverages.items()
    return [LABELS.format(scene=scene, coverage=c) for scene, each in levels for c in each]


def of_labelled(experiment: Experiment, name: str) -> list[str]:
    """List `splits` or `features` of every labelled scene, at all coverages."""
    return [f"<results>/labels/{scene}/{name}.parquet" for scene in experiment.labelled]


def ingested(experiment: Experiment, long_side: int) -> Paths:
    """Return how the capture in the wildcards is read, with images of some size."""
    datasets = experiment.datasets
    return {
        "reading": datasets.reading,
        "long_side": long_side,
        "at_least": lambda wildcards: experiment.frames_needed(
            datasets.role_of(wildcards.dataset, wildcards.scene)
        ),
    }


def scorer_files(experiment: Experiment, policy: str, fold: str = "") -> Paths:
    """Name the scorers of a policy that are trained here, one for each seed, and their logs."""
    folder = experiment.scorer_folder(policy, fold)
    return {
        "weights": [f"{folder}seed{seed}.safetensors" for seed in experiment.seeds],
        "logs": [f"{folder}seed{seed}.parquet" for seed in experiment.seeds],
    }


def training(experiment: Experiment, policy: str) -> Paths:
    """Return how a policy is trained."""
    config = experiment.config["training"]
    settings = {key: config[key] for key in ("epochs", "learning_rate", "from_sum")}
    return {"policy": policy, "scenes": list(experiment.labelled), **settings}


def filmed_anew(experiment: Experiment, folder: str) -> Callable[[Any], str]:
    """Choose the scene with large images: embedded ones are rendered again into a folder."""

    def source(wildcards: Any) -> str:
        if kinds_of(experiment.datasets.entries[wildcards.dataset]) == ["embedded"]:
            return f"<results>/{wildcards.dataset}/{wildcards.scene}/{folder}"
        return experiment.datasets.raw_capture(wildcards)

    return source


def report_labels(title: str, output: str) -> Callable[[Any], dict[str, str]]:
    """Return what the report prints beside an output of `SHOWN`, which names a reconstructor."""

    def labels(wildcards: Any) -> dict[str, str]:
        folder = getattr(wildcards, "reconstructor", "").rstrip("/")
        text = title + ", differences" * (output == "differences") + (f", {folder}" * bool(folder))
        if output == "figures":
            return {"figure": text}
        return {"table": text, "form": "LaTeX" if output == "table" else "numbers"}

    return labels
