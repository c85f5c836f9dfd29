"""The cells of the budget sweep, and the labels of its rows."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import pandas as pd

from fsel.core.files import Files, read_table
from fsel.evaluation.summary import ALL_DATASETS, ALL_FRAMES, draw_means
from fsel.selectors.baselines import FURTHER, METHODS, PAPER, PRACTICE
from fsel.selectors.policies import POLICIES

BASELINES = {name: method.label for name, method in {**PAPER, **FURTHER}.items()}
LEARNED = {name: rf"\textbf{{{policy.label}}}" for name, policy in POLICIES.items()}
LABELS = {**BASELINES, **{name: method.label for name, method in PRACTICE.items()}, **LEARNED}
PLAIN = {**BASELINES, **{name: policy.label for name, policy in POLICIES.items()}}  # of figures
REFERENCES = {
    "search": r"\textit{Genetic search}",
    "random_search": r"\textit{Random search}",
    "all": METHODS["all"].label,
}


def with_all_label(datasets: Mapping[str, str]) -> dict[str, str]:
    """Return the labels of the datasets, and of all together where there are several."""
    together = {ALL_DATASETS: "All datasets"} if len(datasets) > 1 else {}
    return {**datasets, **together}


def place_of(scene: str, facts: Mapping) -> str:
    """Return the place of `dataset/scene`: itself, unless `places` of the facts names another."""
    return facts.get("places", {}).get(scene, scene)


def sweep_cells(
    problems: Sequence[str],
    evaluations: Files,
    metrics: Collection[str] = ("psnr",),
    *,
    facts: Mapping,
    by_seed: bool = False,
) -> pd.DataFrame:
    """Return dataset, scene, place, draw, method, k, metrics: means over targets and seeds, or one
    row a seed; `problems` are `dataset/scene/draw0` of each file."""
    tables = []
    for problem, path in zip(problems, evaluations, strict=True):
        dataset, scene, draw = problem.split("/")
        where = {"dataset": dataset, "scene": scene, "draw": draw}
        where["place"] = place_of(f"{dataset}/{scene}", facts)
        table = draw_means(read_table(path), metrics, by_seed=by_seed)
        tables.append(table.assign(**where))
    cells = pd.concat(tables)
    order = {name: i for i, name in enumerate([*LABELS, *REFERENCES])}
    cells["rank"] = cells["method"].map(order)
    cells["block"] = pd.factorize(cells["dataset"])[0]
    cells = cells.sort_values(["block", "rank", "k", "scene", "draw"], kind="stable")
    return cells.drop(columns=["block", "rank"]).reset_index(drop=True)


def row_groups(cells: pd.DataFrame, budgets: Sequence[int]) -> list[dict[str, str]]:
    """Return method -> label of the rows between two rules, for methods with a number to print."""
    shown = set(cells["method"][cells["k"].isin([*budgets, ALL_FRAMES])])
    labels = LABELS | REFERENCES
    groups = (PAPER, {**FURTHER, **PRACTICE}, LEARNED, REFERENCES)
    rows = [{name: labels[name] for name in group if name in shown} for group in groups]
    return [group for group in rows if group]
