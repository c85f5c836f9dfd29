"""Means over scenes, paired differences, and their csv files."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.core.files import atomic
from fsel.core.programs import FINISHED
from fsel.evaluation.statistics import Interval, of_places_and_seeds
from fsel.metrics import REGISTERED

ALL_FRAMES = 0  # the budget of a method that takes every frame; tables write it as "all"
ALL_DATASETS = "all"
SUMMARY = ("dataset", "method", "k", "metric", "mean", "ci_low", "ci_high", "n")
DIFFERENCES = ("dataset", "method", "reference", "k", "metric", "mean", "ci_low", "ci_high", "p")

OUTCOME = "outcome"  # of reconstructions that did not finish, see fsel.core.programs

Column = tuple[str, str, int]  # metric, method, budget


def draw_means(
    evaluation: pd.DataFrame, metrics: Collection[str], *, by_seed: bool = False
) -> pd.DataFrame:
    """Average one draw's evaluation over targets within a seed, then over seeds unless `by_seed`:
    one row a method and budget, `ALL_FRAMES` of the method `all`; NaN, and a column outcome, where
    a reconstruction did not finish."""
    table = evaluation.assign(k=evaluation["k"].where(evaluation["method"] != "all", ALL_FRAMES))
    means = table.groupby(["method", "k", "seed"])[list(metrics)].mean()
    keys = ["method", "k", "seed"] if by_seed else ["method", "k"]
    if not by_seed:
        means = means.groupby(keys).mean()
    if OUTCOME in table and table[OUTCOME].any():
        means[OUTCOME] = table.groupby(keys)[OUTCOME].max()
        means.loc[means[OUTCOME] != FINISHED, list(metrics)] = np.nan
    return means.reset_index()


def with_all_datasets(cells: pd.DataFrame) -> pd.DataFrame:
    """Append, as one more dataset, the cells of methods and budgets that every dataset has."""
    datasets = cells["dataset"].nunique()
    if datasets == 1:
        return cells
    counts = cells.groupby(["method", "k"])["dataset"].transform("nunique")
    shared = cells[counts == datasets]
    scenes = shared["dataset"] + "/" + shared["scene"]
    return pd.concat([cells, shared.assign(dataset=ALL_DATASETS, scene=scenes)], ignore_index=True)


class _Part:
    """The cells of one dataset, as arrays with a row a scene and draw.

    Args:
        cells: scene, draw, method, k, metrics; seed where single seeds count; place where scenes
            share one.
        trained: methods whose seeds are of training, the same in all scenes.
    """

    def __init__(
        self, cells: pd.DataFrame, metrics: Collection[str], trained: Sequence[str]
    ) -> None:
        keys = ["scene", "draw"]
        means = cells.groupby([*keys, "method", "k"], sort=False)[list(metrics)].mean()
        wide = means.reset_index().pivot(index=keys, columns=["method", "k"], values=list(metrics))
        self.dataset = cells["dataset"].iloc[0]
        self.scenes = wide.index.get_level_values("scene").to_numpy()
        places = dict(zip(cells["scene"], cells.get("place", cells["scene"]), strict=True))
        self.places = np.array([places[scene] for scene in self.scenes])
        self.columns: list[Column] = list(wide.columns)
        self._values = dict(zip(self.columns, wide.to_numpy().T, strict=True))
        self._seeds: dict[Column, np.ndarray] = {}
        self._weights: dict[bytes, np.ndarray] = {}  # by the rows that a column has
        self.ended: dict[tuple[str, int], str] = {}  # method, budget -> why it did not finish
        if OUTCOME in cells:
            rows = cells[cells[OUTCOME].fillna(FINISHED) != FINISHED]
            self.ended = {(row.method, row.k): row.outcome for row in rows.itertuples()}
        for method in trained if "seed" in cells else ():
            own = cells[cells["method"] == method]
            parted = own.pivot(index=keys, columns=["k", "seed"], values=list(metrics))
            parted = parted.reindex(wide.index)
            for metric, k in {column[:2] for column in parted.columns}:
                self._seeds[metric, method, k] = parted[metric][k].to_numpy()

    def interval(self, column: Column, less: Column | None = None) -> Interval:
        """Compute the interval of a column's mean over places, or of its difference to another;
        NaN, of no places, where a reconstruction did not finish."""
        if self.ended.keys() & {key[1:] for key in (column, less) if key is not None}:
            return Interval(np.nan, np.nan, np.nan, np.nan, 0)
        values = self._seeds.get(column, self._values[column][:, None])
        if less is not None:
            values = values - self._values[less][:, None]
        known = np.isfinite(values).all(axis=1)
        if (key := known.tobytes()) not in self._weights:
            self._weights[key] = self._of_places(column, known)
        return of_places_and_seeds(self._weights[key] @ values[known])

    def _of_places(self, column: Column, known: np.ndarray) -> np.ndarray:
        """Return (n, rows) weights of means over draws, then over the scenes of a place."""
        names, counts = np.unique(self.scenes[known], return_counts=True)
        every = len(np.unique(self.scenes))
        if len(names) < every:
            raise ValueError(
                f"{self.dataset}: a mean over unequal sets: {column} was measured in {len(names)} "
                f"of {every} scenes"
            )
        if len(set(counts.tolist())) > 1:
            draws = dict(zip(names.tolist(), counts.tolist(), strict=True))
            raise ValueError(f"a mean over unequal sets: draws by scene are {draws}")
        places = self.places[known]
        belongs = (np.unique(places)[:, None] == places).astype(float)
        return belongs / belongs.sum(axis=1, keepdims=True)


def summarise(
    cells: pd.DataFrame, metrics: Collection[str], *, trained: Sequence[str] = ()
) -> pd.DataFrame:
    """Average over places by dataset, method, budget and metric, with a 95 % interval.

    Args:
        cells: dataset, scene, draw, method, k, metrics; one row a combination, or one a seed with
            the column seed. The column place names what scenes share, where they share a place.
        trained: methods whose seeds are of training, the same in all scenes; their chance enters
            the interval.

    Returns:
        Columns as `SUMMARY`; n counts places. Datasets and methods keep the order of `cells`. Where
        reconstructions did not finish there is no mean, and one column more, outcome.

    Raises:
        ValueError: when a method was not measured in all of a dataset's scenes.
    """
    rows = []
    for dataset, part in cells.groupby("dataset", sort=False):
        own = _Part(part, metrics, trained)
        for metric, method, k in own.columns:
            mean, low, high, _, n = own.interval((metric, method, k))
            ended = own.ended.get((method, k), FINISHED)
            rows.append((dataset, method, k, metric, mean, low, high, n, ended))
    table = pd.DataFrame(rows, columns=[*SUMMARY, OUTCOME])
    if not table[OUTCOME].any():
        table = table.drop(columns=OUTCOME)
    return _sorted(table, cells, ["dataset", "method"])


def differences(
    cells: pd.DataFrame,
    methods: Sequence[str],
    metrics: Collection[str],
    *,
    trained: Sequence[str] = (),
) -> pd.DataFrame:
    """Compute paired differences, method minus reference, at equal budgets, with 95 % intervals.

    A reference that takes every frame is compared at each of the method's budgets.

    Args:
        cells, metrics, trained: as in `summarise`.
        methods: to compare with every other method.

    Returns:
        Columns as `DIFFERENCES`, and n; p is two-sided, of the difference being zero.
    """
    rows = []
    for dataset, part in cells.groupby("dataset", sort=False):
        measured = _Part(part, metrics, trained)
        for metric, method, k in measured.columns:
            if method not in methods or k == ALL_FRAMES:
                continue
            for reference in part["method"].unique():
                own = (metric, reference, k)
                other = own if own in measured.columns else (metric, reference, ALL_FRAMES)
                if reference == method or other not in measured.columns:
                    continue
                gap = measured.interval((metric, method, k), other)
                rows.append((dataset, method, reference, k, metric, *gap))
    table = pd.DataFrame(rows, columns=[*DIFFERENCES, "n"])
    return _sorted(table, cells, ["dataset", "method", "reference"])


def leaders(gaps: pd.DataFrame) -> set[tuple[str, int, str]]:
    """Find the method, k, metric that beat every other, all intervals of `differences` agreeing."""
    leads = set()
    for key, part in gaps.groupby(["method", "k", "metric"]):
        rises = REGISTERED[key[2]].higher_is_better
        if ((part["ci_low"] > 0) if rises else (part["ci_high"] < 0)).all():
            leads.add(key)
    return leads


def seed_spread(runs: pd.DataFrame, metric: str) -> pd.DataFrame:
    """Measure how far a dataset's mean moves with the training seed: dataset, k, std (of a sample;
    NaN for one seed), seeds, n (scenes)."""
    keys = ["dataset", "k", "seed"]
    scenes = runs.groupby([*keys, "scene"], sort=False)[metric].mean()
    means = scenes.groupby(keys, sort=False).agg(["mean", "size"]).reset_index()
    cells = means.groupby(["dataset", "k"], sort=False)
    return cells.agg(std=("mean", "std"), seeds=("seed", "size"), n=("size", "first")).reset_index()


def _sorted(table: pd.DataFrame, cells: pd.DataFrame, names: Sequence[str]) -> pd.DataFrame:
    """Sort rows by the first place of datasets and methods in `cells`, then by budget."""
    ranks = {
        column: {value: i for i, value in enumerate(cells[column].unique())}
        for column in ("dataset", "method")
    }
    ranks["reference"] = ranks["method"]
    keys = [table[name].map(ranks[name]).rename(name) for name in names] + [table["k"]]
    order = pd.concat(keys, axis=1).sort_values([*names, "k"], kind="stable").index
    return table.loc[order].reset_index(drop=True)


def write_csv(table: pd.DataFrame, path: str | Path, form: str = "%.6f") -> None:
    """Write numbers in a form; the budget of a method that takes every frame is written `all`."""
    if "k" in table:
        table = table.assign(k=table["k"].astype(object).where(table["k"] != ALL_FRAMES, "all"))
    with atomic(path) as temporary:
        table.to_csv(temporary, index=False, float_format=form)


def read_csv(path: str | Path) -> pd.DataFrame:
    """Read what `write_csv` wrote, budgets as numbers again."""
    table = pd.read_csv(path, dtype={"k": str})
    if "k" in table:
        # a row that is about no budget has none
        table["k"] = pd.to_numeric(table["k"].replace("all", str(ALL_FRAMES)))
    return table
