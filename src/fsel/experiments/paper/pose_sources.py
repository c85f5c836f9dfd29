"""Two sources of poses for the same images, such as COLMAP's and a network's (paper, Table 4)."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from fsel.experiments.paper.pose_trials import BOTH, EXACT
from fsel.ingest.read import read_folder
from fsel.metrics import Metrics, headings
from fsel.report.captions import made_by
from fsel.report.latex import difference, number, plain_table, tex
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, draw_means, summarise
from fsel.report.sweep import of_scenes
from fsel.utils.files import read_table, write_text

logger = logging.getLogger(__name__)

SHOWN = "less_is_more"
GIVEN, OTHER = "given", "other"


def pair_poses(
    source: str | Path,
    given_folder: str | Path,
    estimated_folder: str | Path,
    *,
    model: str,
    long_side: int,
    at_least: int,
    reading: Mapping,
) -> None:
    """Two canonical captures of the frames that both sources place.

    Args:
        source: folder as the dataset distributes it.
        given_folder, estimated_folder: receive the captures: the dataset's own poses, the model's.
        model: folder of a COLMAP model inside the source.
        long_side: of the images stored, pixels.
        at_least: frames that the experiment needs.
        reading: further keywords of `fsel.ingest.read.read_folder`.

    Raises:
        ValueError: when both place too few frames.
    """
    readings = (reading, {**reading, "poses": "file", "model": model})
    with TemporaryDirectory() as first, TemporaryDirectory() as second:
        given, other = (
            read_folder(source, long_side=long_side, store=Path(store), **how).capture
            for store, how in zip((first, second), readings, strict=True)
        )
        rows = [{name: at for at, name in enumerate(capture.names)} for capture in (given, other)]
        shared = [name for name in given.names if name in rows[1]]
        if len(shared) < at_least:
            raise ValueError(
                f"{source}: {len(shared)} of {len(given)} frames are in {model} too, {at_least} "
                "are needed (targets, as many proxies, and the largest budget). Hint: lower "
                "`targets` or `budgets` in the config"
            )
        for capture, at, folder in zip(
            (given, other), rows, (given_folder, estimated_folder), strict=True
        ):
            capture.subset([at[name] for name in shared]).save(folder)
    logger.info("%s: %d frames placed by both", source, len(shared))


def pose_sources(
    evaluations: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[tuple[str, str]],
    names: Sequence[str],
    budgets: Sequence[int],
    metrics: Metrics,
    facts: Mapping,
) -> None:
    """The table "Robustness to estimated poses": ours on both sources, and their difference.

    Args:
        evaluations: what `pose_trials.evaluate_estimated` wrote, one a scene.
        table: receives LaTeX.
        numbers: receives method, source (the second less the first: `difference`), k, metric, mean,
            ci_low, ci_high, n of every selector.
        scenes: dataset and scene of each file.
        names: of both sources, as the table prints them.
        budgets: rows.
        metrics: of a cell, in order; names, or name -> settings.
        facts: see `captions.made_by`.
    """
    measured = [_cells(item, metrics) for item in of_scenes(scenes, evaluations)]
    cells = pd.concat(measured, ignore_index=True)
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


def _cells(item: Mapping, metrics: Metrics) -> pd.DataFrame:
    """dataset (the selector), method (the source of poses), scene, draw, k, metrics."""
    table = read_table(item["path"])
    tables = []
    for (draw, change), part in table[table["scope"] == BOTH].groupby(["draw", "change"]):
        means = draw_means(part, metrics)
        means = means.assign(dataset=means["method"], method=GIVEN if change == EXACT else OTHER)
        tables.append(means.assign(scene=f"{item['dataset']}/{item['scene']}", draw=draw))
    return pd.concat(tables)
