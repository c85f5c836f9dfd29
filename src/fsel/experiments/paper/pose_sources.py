"""Two sources of poses for the same images, such as COLMAP's and a network's (paper, Table 4)."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from fsel.captures.read import read_folder
from fsel.core.capture import Capture
from fsel.core.files import File, Files, write_text
from fsel.core.split import evaluation_split
from fsel.evaluation.latex import difference, made_by, number, plain_table, tex
from fsel.evaluation.measuring import rng_by_draw
from fsel.evaluation.summary import differences, summarise, write_csv
from fsel.experiments.scheme import ExperimentCase, Scenes, Trials, cells_of
from fsel.metrics import Metrics, headings
from fsel.selection.frames import frames_of
from fsel.selectors.baselines import FURTHER, PAPER

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
    """Write two canonical captures, by the dataset's poses and by the other ones, of the frames
    that both sources place; ValueError where these are too few.

    `poses`, `model` and `reading` are keywords of `fsel.captures.read.read_folder`.
    """
    readings = (reading, {**reading, "poses": poses, "model": model})
    with TemporaryDirectory() as first, TemporaryDirectory() as second:
        given, other = (
            read_folder(source, long_side=long_side, store=Path(store), **how).capture
            for store, how in zip((first, second), readings, strict=True)
        )
        placed = set(other.names)
        shared = [name for name in given.names if name in placed]
        if len(shared) < at_least:
            raise ValueError(
                f"{source}: both sources place {len(shared)} of {len(given)} frames, {at_least} "
                "are needed (targets, as many proxies, and the largest budget). Hint: lower "
                "`targets` or `budgets` in the config"
            )
        for capture, folder in ((given, given_folder), (other, estimated_folder)):
            capture.subset(frames_of(capture, shared)).save(folder)
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
) -> Iterator[ExperimentCase]:
    """Yield every draw with both sources of poses, to select and to reconstruct by."""
    for draw in range(draws):
        for source, capture in ((GIVEN, given), (OTHER, other)):
            split = evaluation_split(capture, draw, split_seed, targets)
            key = {"draw": draw, "source": source}
            yield ExperimentCase(key, capture, split, budgets, rng_by_draw(seed, draw))


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
    """Write the table "Estimated poses": ours on both sources, printed by `names`, and the
    difference."""
    cells = cells_of(scenes, evaluations, metrics, facts, ["draw", "source"])
    # both sources stand for the methods to compare, each selector for a dataset
    cells = cells.assign(dataset=cells["method"], method=cells["source"])
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


TRIALS = Trials(trials, methods=[*PAPER, *FURTHER])
