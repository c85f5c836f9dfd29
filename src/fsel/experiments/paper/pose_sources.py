"""Two sources of poses for the same images, such as COLMAP's and a network's (paper, Table 4)."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

from fsel.captures.colmap.estimator import source_of
from fsel.captures.read import read_folder
from fsel.core.capture import Capture
from fsel.core.files import File, Files, write_text
from fsel.core.split import evaluation_split
from fsel.evaluation.captions import made_by
from fsel.evaluation.latex import difference, number, plain_table, tex
from fsel.evaluation.measuring import draw_chance
from fsel.evaluation.numbers import write_csv
from fsel.evaluation.summary import differences, summarise
from fsel.experiments import scheme, specs
from fsel.experiments.cells import cells_of
from fsel.experiments.specs import Scenes, Values
from fsel.metrics import Metrics, headings
from fsel.selectors.baselines import FURTHER, PAPER
from fsel.stages.describe import describe
from fsel.workflow import inputs
from fsel.workflow.datasets import kinds_of
from fsel.workflow.experiment import Experiment
from fsel.workflow.refusal import refuse
from fsel.workflow.requirements import check_poses
from fsel.workflow.resources import Size
from fsel.workflow.settings import Scene
from fsel.workflow.tables import Job

logger = logging.getLogger(__name__)

SHOWN = "less_is_more"
GIVEN, OTHER = "given", "other"


def pair_poses(
    source: File,
    given_folder: File,
    estimated_folder: File,
    *,
    poses: str | Mapping,
    model: str,
    long_side: int,
    at_least: int,
    reading: Mapping,
) -> None:
    """Two canonical captures of the frames that both sources place.

    Args:
        given_folder, estimated_folder: receive the captures: the dataset's poses, the other ones.
        poses: the other source, as `fsel.captures.read.read_folder` takes it.
        model: folder of a COLMAP model inside the source, for `poses="file"`.
        long_side: of the images stored, pixels.
        at_least: frames that the experiment needs.
        reading: further keywords of `fsel.captures.read.read_folder`.

    Raises:
        ValueError: when both place too few frames.
    """
    readings = (reading, {**reading, "poses": poses, "model": model})
    with TemporaryDirectory() as first, TemporaryDirectory() as second:
        given, other = (
            read_folder(source, long_side=long_side, store=Path(store), **how).capture
            for store, how in zip((first, second), readings, strict=True)
        )
        rows = [{name: at for at, name in enumerate(capture.names)} for capture in (given, other)]
        shared = [name for name in given.names if name in rows[1]]
        if len(shared) < at_least:
            raise ValueError(
                f"{source}: both sources place {len(shared)} of {len(given)} frames, {at_least} "
                "are needed (targets, as many proxies, and the largest budget). Hint: lower "
                "`targets` or `budgets` in the config"
            )
        for capture, at, folder in zip(
            (given, other), rows, (given_folder, estimated_folder), strict=True
        ):
            capture.subset(np.array([at[name] for name in shared])).save(folder)
    logger.info("%s: %d frames placed by both", source, len(shared))


def trials(
    given: Capture,
    other: Capture,
    *,
    draws: int,
    budgets: Sequence[int],
    targets: int,
    seed: int,
    split_seed: int,
) -> Iterator[scheme.Trial]:
    """Yield every draw with both sources of poses, to select and to reconstruct by.

    Args:
        given, other: captures of the same frames.
        draws: of targets, the same for both: chance alone decides them.
        targets: held-out views of a draw.
        split_seed: of the scene's draws of targets.
    """
    for draw in range(draws):
        for source, capture in ((GIVEN, given), (OTHER, other)):
            split = evaluation_split(capture, draw, split_seed, targets)
            key = {"draw": draw, "source": source}
            yield scheme.Trial(key, capture, split, budgets, draw_chance(seed, draw))


def pose_sources(
    evaluations: Files,
    table: File,
    numbers: File,
    *,
    scenes: Scenes,
    names: Sequence[str],
    budgets: Sequence[int],
    metrics: Metrics,
    facts: Mapping,
) -> None:
    """The table "Robustness to estimated poses": ours on both sources, and their difference.

    Args:
        numbers: receives method, source (the second less the first: `difference`), k, metric, mean,
            ci_low, ci_high, n of every selector.
        names: of both sources, as the table prints them.
    """
    cells = _cells(scenes, evaluations, metrics, facts)
    means = summarise(cells, metrics).rename(columns={"dataset": "method", "method": "source"})
    gaps = differences(cells, [OTHER], metrics).rename(columns={"dataset": "of"})
    gaps = gaps.assign(method=gaps["of"], source="difference")[means.columns]
    write_csv(pd.concat([means, gaps]), numbers)
    values = means[means["method"] == SHOWN].set_index(["source", "k", "metric"])["mean"]
    less = gaps[gaps["method"] == SHOWN].set_index(["k", "metric"])
    rows = []
    for k in budgets:
        cell = ["/".join(number(values[s, k, m], m) for m in metrics) for s in (GIVEN, OTHER)]
        change = less.loc[(k, "psnr"), ["mean", "ci_low", "ci_high"]]
        rows.append([str(k), *cell, difference(*change)])
    text = (
        r"\textbf{Robustness to estimated poses.} The learned selector and the reconstruction with "
        f"the poses of {tex(names[0])} and with those of {tex(names[1])}, on the frames that both "
        f"place; {'/'.join(headings(metrics))}, and the paired difference in PSNR (dB) with its "
        f"95\\% interval over scenes; bold where it excludes zero. Scenes: {means['n'].max()}. "
        f"{made_by(facts)}"
    )
    head = ["$K$", *map(tex, names), "difference"]
    write_text(plain_table(head, rows, caption=text, label="tab:vggtposes"), table)


def _cells(scenes: Scenes, evaluations: Files, metrics: Metrics, facts: Mapping) -> pd.DataFrame:
    """Table of dataset (the selector), method (the source of poses), scene, draw, k, metrics."""
    cells = cells_of(scenes, evaluations, metrics, facts, ["draw", "source"])
    return cells.assign(dataset=cells["method"], method=cells["source"])


def posed_twice(experiment: Experiment) -> list[Scene]:
    """Evaluation scenes with a second source of poses, at least one."""
    config = experiment.config["pose_sources"]
    named, model = config["dataset"], config["model"]
    entry = experiment.datasets.entries.get(named, {})
    if named is None or named in experiment.datasets.missing:
        refuse(
            f"pose_sources.dataset is {named}" + (", which is not there" if named else ""),
            "name a dataset on disk, and in `poses` what estimates them, or in `model` the folder "
            "of a COLMAP model inside each scene",
        )
    scenes = experiment.scenes(named, "evaluation")
    if config["poses"] != "file":
        if "embedded" in kinds_of(entry):
            refuse(
                f"pose_sources.dataset is {named!r}, whose images are generated and small",
                "name a dataset with a `root` or `fetch`: poses are found in its images",
            )
        check_poses("pose_sources.poses", config["poses"])
        return [(named, scene) for scene in scenes]
    if entry.get("root") is None:
        refuse(
            f"pose_sources.dataset is {named!r}, no dataset with a `root`",
            "a second source of poses is a folder inside each scene; or name it in `poses`",
        )
    if missing := [s for s in scenes if not Path(entry["root"], s, model).is_dir()]:
        refuse(
            f"pose_sources.model is {model!r}, no folder in {len(missing)} of {len(scenes)} scenes "
            f"of {named}: {missing[:3]}",
            "export the second source's poses as a COLMAP model there, or name it in `poses`",
        )
    return [(named, scene) for scene in scenes]


def _names(experiment: Experiment) -> list[str]:
    """The two sources as the table prints them."""
    (dataset,) = specs.datasets_of(posed_twice(experiment))
    (label,) = experiment.labels([dataset]).values()
    entry, other = experiment.datasets.entries[dataset], experiment.config["pose_sources"]
    first = source_of(entry["poses"], entry.get("model", ""))
    return [f"{label}, {first}", other["label"] or source_of(other["poses"], other["model"])]


def _source(experiment: Experiment) -> Values:
    raw = experiment.datasets.raw_capture
    return {"source": lambda wildcards: raw(wildcards.dataset, wildcards.scene)}


FOLDER = f"{inputs.SCENE}/sources"

PAIRED = Job(
    pair_poses,
    outputs=inputs.capture(folder=f"{FOLDER}/given", prefix="given_")
    | inputs.capture(folder=f"{FOLDER}/estimated", prefix="estimated_"),
    message="Reading two sources of poses of {wildcards.dataset}/{wildcards.scene}",
    inputs=_source,
    params=lambda experiment: {
        **inputs.ingested(experiment, experiment.config["long_side"]),
        **{key: experiment.config["pose_sources"][key] for key in ("poses", "model")},
        "at_least": experiment.frames_needed("evaluation"),
    },
    size=Size(4000, 240),
)

DESCRIBED = Job(
    describe,
    name="describe_paired",
    outputs={"descriptors": f"{FOLDER}/given/descriptors.parquet"},
    message="Describing {wildcards.dataset}/{wildcards.scene}, both sources of poses",
    inputs=lambda experiment: inputs.capture(inputs.BARE, f"{FOLDER}/given"),
    params=lambda experiment: experiment.config["appearance"],
    size=Size(2000, 30, "capture"),
)

TRIALS = scheme.Trials(
    f"{__name__}:TRIALS",
    "paired",
    trials,
    settings=lambda experiment: {
        **{key: experiment.config[key] for key in ("draws", "budgets", "targets")},
        "split_seed": specs.scene_seed(experiment, "split"),
        "seed": specs.scene_seed(experiment, "sources"),
    },
    methods=[*PAPER, *FURTHER],
    captures=["sources/given/", "sources/estimated/"],
    folder="sources/",
)

TABLE = scheme.table_of(
    pose_sources,
    TRIALS,
    scenes=posed_twice,
    params=lambda experiment: {
        **specs.budgets(experiment),
        "names": _names(experiment),
        "metrics": experiment.metrics,
    },
    category="Paper",
    title="Two sources of poses",
    caption="The learned selector with two sources of poses for the same images, such as COLMAP's "
    "and a network's; both the selector and the reconstruction have them. Every other selector is "
    "in the csv.",
    jobs=[PAIRED, DESCRIBED],
)
