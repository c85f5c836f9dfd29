"""The cells of the budget sweep, and the labels of its rows."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from fsel.captures.layouts import dl3dv
from fsel.core.files import read_table
from fsel.evaluation.summary import ALL_DATASETS, ALL_FRAMES, draw_means
from fsel.selectors.baselines import FURTHER, METHODS, PAPER
from fsel.selectors.policies import POLICIES

BASELINES = {name: method.label for name, method in {**PAPER, **FURTHER}.items()}
LEARNED = {name: rf"\textbf{{{policy.label}}}" for name, policy in POLICIES.items()}
LABELS = {**BASELINES, **LEARNED}
PLAIN = {**BASELINES, **{name: policy.label for name, policy in POLICIES.items()}}
"""Labels for figures: no command of LaTeX."""
REFERENCES = {
    dl3dv.LISTED: dl3dv.LISTED_LABEL,
    "search": r"\textit{Genetic search}",
    "random_search": r"\textit{Random search}",
    "all": METHODS["all"].label,
}


def with_all_label(datasets: Mapping[str, str]) -> dict[str, str]:
    """Return the labels of the datasets, and of all together where there are several."""
    together = {ALL_DATASETS: "All datasets"} if len(datasets) > 1 else {}
    return {**datasets, **together}


def named(problems: Iterable[str], paths: Iterable[str | Path]) -> list[dict[str, str | Path]]:
    """Map each file of a problem to its dataset, scene, draw and path.

    Args:
        problems: `dataset/scene/draw0` of each file.
        paths: of the files.
    """
    keys = ("dataset", "scene", "draw")
    return [
        dict(zip(keys, problem.split("/"), strict=True), path=path)
        for problem, path in zip(problems, paths, strict=True)
    ]


def place_of(scene: str, facts: Mapping) -> str:
    """Return the place that a scene is a capture of: itself, unless it shares one with another.

    Args:
        scene: `dataset/scene`.
        facts: `places`, dataset/scene -> place; it may lack.
    """
    return facts.get("places", {}).get(scene, scene)


def of_scenes(
    scenes: Iterable[tuple[str, str]], paths: Iterable[str | Path]
) -> list[dict[str, Any]]:
    """Map each file of a scene to its dataset, scene and path.

    Args:
        scenes: dataset and scene of each file.
        paths: of the files.
    """
    pairs = zip(scenes, paths, strict=True)
    return [{"dataset": d, "scene": scene, "path": path} for (d, scene), path in pairs]


def sweep_cells(
    evaluations: Sequence[Mapping],
    metrics: Collection[str] = ("psnr",),
    *,
    facts: Mapping,
    by_seed: bool = False,
) -> pd.DataFrame:
    """Return the table of dataset, scene, place, draw, method, k, metrics.

    The values are means over targets and seeds of each file.

    Args:
        evaluations: one mapping a file, see `named`.
        metrics: their columns to read.
        facts: `places`, dataset/scene -> place, of scenes that share a place with another; it may
            be left out.
        by_seed: one row a seed, with the column seed.
    """
    order = {name: i for i, name in enumerate([*LABELS, *REFERENCES])}
    tables = []
    for item in evaluations:
        table = draw_means(read_table(item["path"]), metrics, by_seed=by_seed)
        where = {key: item[key] for key in ("dataset", "scene", "draw")}
        name = f"{item['dataset']}/{item['scene']}"
        tables.append(table.assign(**where, place=place_of(name, facts)))
    cells = pd.concat(tables)
    cells["rank"] = cells["method"].map(order)
    datasets = {name: i for i, name in enumerate(cells["dataset"].unique())}
    cells["block"] = cells["dataset"].map(datasets)
    cells = cells.sort_values(["block", "rank", "k", "scene", "draw"], kind="stable")
    return cells.drop(columns=["block", "rank"]).reset_index(drop=True)


def row_groups(cells: pd.DataFrame, budgets: Sequence[int]) -> list[dict[str, str]]:
    """Return method -> label of the rows between two rules, for methods with a number to print."""
    shown = set(cells["method"][cells["k"].isin([*budgets, ALL_FRAMES])])
    labels = LABELS | REFERENCES
    groups = (PAPER, FURTHER, LEARNED, REFERENCES)
    rows = [{name: labels[name] for name in group if name in shown} for group in groups]
    return [group for group in rows if group]
