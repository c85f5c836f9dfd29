"""Means over scenes with paired bootstrap intervals."""

from __future__ import annotations

import functools
import zlib
from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from fsel.metrics import REGISTERED

ALL_FRAMES = 0  # the budget of a method that takes every frame; tables write it as "all"
LEVELS = (2.5, 97.5)  # percentiles of a 95% interval
SUMMARY = ("dataset", "method", "k", "metric", "mean", "ci_low", "ci_high", "n")


def draw_means(evaluation: pd.DataFrame, metrics: Sequence[str]) -> pd.DataFrame:
    """One row a method and budget of a draw: means over targets within a seed, then over seeds.

    Args:
        evaluation: rows of one draw's evaluation: method, seed, k, target, metrics.
        metrics: columns to average.

    Returns:
        method, k and the metrics. The method `all` has the budget `ALL_FRAMES`.
    """
    table = evaluation.assign(k=evaluation["k"].where(evaluation["method"] != "all", ALL_FRAMES))
    by_seed = table.groupby(["method", "k", "seed"])[list(metrics)].mean()
    return by_seed.groupby(["method", "k"]).mean().reset_index()


def bootstrap_weights(scenes: np.ndarray, resamples: int, rng: np.random.Generator) -> np.ndarray:
    """Weights of rows in resamples of scenes, and of the draws within every scene met.

    All methods and budgets share one set of weights, which makes their differences paired.

    Args:
        scenes: (R,) scene of each row; every scene must have equally many rows, its draws.
        resamples: how many.
        rng: the only source of chance.

    Returns:
        (resamples, R) float64, each row of sum one.

    Raises:
        ValueError: when scenes have unequal numbers of draws.
    """
    names, counts = np.unique(scenes, return_counts=True)
    if len(set(counts.tolist())) != 1:
        found = dict(zip(names.tolist(), counts.tolist(), strict=True))
        raise ValueError(f"a mean over unequal sets: draws by scene are {found}")
    rows = np.stack([np.flatnonzero(scenes == name) for name in names])
    count, draws = rows.shape
    scene = rng.integers(count, size=(resamples, count))
    draw = rng.integers(draws, size=(resamples, count, draws))
    met = rows[scene[:, :, None], draw].reshape(resamples, -1)
    weights = np.zeros((resamples, len(scenes)))
    np.add.at(weights, (np.arange(resamples)[:, None], met), 1 / (count * draws))
    return weights


def summarise(
    cells: pd.DataFrame, metrics: Sequence[str], *, resamples: int, seed: int
) -> pd.DataFrame:
    """Mean over scenes of every dataset, method, budget and metric, with a 95% interval.

    Args:
        cells: dataset, scene, draw, method, k, metrics; one row a combination.
        metrics: columns to summarise.
        resamples: of the bootstrap.
        seed: of the bootstrap.

    Returns:
        Columns as `SUMMARY`; n counts scenes. Datasets and methods keep the order of `cells`.

    Raises:
        ValueError: when a method was not measured in all of a dataset's scenes.
    """
    rows = []
    for dataset, part in cells.groupby("dataset", sort=False):
        wide = _wide(part, metrics)
        for block in _blocks(wide, dataset):
            low, high, count = _interval(block, resamples, seed, dataset)
            for i, (metric, method, k) in enumerate(block.columns):
                mean = block.iloc[:, i].mean()
                rows.append((dataset, method, k, metric, mean, low[i], high[i], count))
    return _sorted(pd.DataFrame(rows, columns=list(SUMMARY)), cells, ["dataset", "method"])


def differences(
    cells: pd.DataFrame,
    methods: Sequence[str],
    metrics: Sequence[str],
    *,
    resamples: int,
    seed: int,
) -> pd.DataFrame:
    """Paired differences, method minus reference, at equal budgets, with 95% intervals.

    A reference that takes every frame is compared at each of the method's budgets.

    Args:
        cells: as in `summarise`.
        methods: to compare with every other method.
        metrics: columns to compare.
        resamples, seed: of the bootstrap.

    Returns:
        dataset, method, reference, k, metric, mean, ci_low, ci_high, n.
    """
    columns = ["dataset", "method", "reference", *SUMMARY[2:]]
    rows = []
    for dataset, part in cells.groupby("dataset", sort=False):
        wide = _wide(part, metrics)
        for metric, method, k in wide.columns:
            if method not in methods or k == ALL_FRAMES:
                continue
            for reference in part["method"].unique():
                budget = k if (metric, reference, k) in wide.columns else ALL_FRAMES
                if reference == method or (metric, reference, budget) not in wide.columns:
                    continue
                gap = wide[metric, method, k] - wide[metric, reference, budget]
                gap = gap.dropna().to_frame()
                low, high, n = _interval(gap, resamples, seed, dataset)
                value = gap.iloc[:, 0].mean()
                rows.append((dataset, method, reference, k, metric, value, low[0], high[0], n))
    table = pd.DataFrame(rows, columns=columns)
    return _sorted(table, cells, ["dataset", "method", "reference"])


def leaders(gaps: pd.DataFrame) -> set[tuple[str, int, str]]:
    """method, k, metric that are better than every other method, all intervals excluding zero.

    Args:
        gaps: see `differences`.
    """
    found = set()
    for key, part in gaps.groupby(["method", "k", "metric"]):
        rises = REGISTERED[key[2]].higher_is_better
        if ((part["ci_low"] > 0) if rises else (part["ci_high"] < 0)).all():
            found.add(key)
    return found


def seed_spread(runs: pd.DataFrame, metric: str) -> pd.DataFrame:
    """How far a dataset's mean moves with the training seed.

    Args:
        runs: dataset, scene, draw, seed, k and the metric, means over targets.
        metric: column to average within a seed over draws, then scenes.

    Returns:
        dataset, k, std (of a sample; NaN for one seed), seeds, n (scenes). Datasets keep their
        order.
    """
    keys = ["dataset", "k", "seed"]
    scenes = runs.groupby([*keys, "scene"], sort=False)[metric].mean()
    means = scenes.groupby(keys, sort=False).agg(["mean", "size"]).reset_index()
    cells = means.groupby(["dataset", "k"], sort=False)
    return cells.agg(std=("mean", "std"), seeds=("seed", "size"), n=("size", "first")).reset_index()


def _wide(part: pd.DataFrame, metrics: Sequence[str]) -> pd.DataFrame:
    """Rows: scene and draw. Columns: metric, method, k."""
    return part.pivot(index=["scene", "draw"], columns=["method", "k"], values=list(metrics))


def _blocks(wide: pd.DataFrame, dataset: str) -> Iterator[pd.DataFrame]:
    """Columns that were measured in the same scenes and draws, together."""
    scenes = wide.index.get_level_values("scene").nunique()
    present = wide.notna()
    for pattern in sorted({tuple(present[column]) for column in wide}, reverse=True):
        columns = [column for column in wide if tuple(present[column]) == pattern]
        block = wide.loc[list(pattern), columns]
        found = block.index.get_level_values("scene").nunique()
        if found != scenes:
            raise ValueError(
                f"{dataset}: a mean over unequal sets: {columns[0]} was measured in {found} of "
                f"{scenes} scenes"
            )
        yield block


def _interval(
    block: pd.DataFrame, resamples: int, seed: int, dataset: str
) -> tuple[np.ndarray, np.ndarray, int]:
    """Interval bounds of every column's mean, and the number of scenes.

    One draw of one scene says nothing about its own spread: its bounds are NaN.
    """
    scenes = block.index.get_level_values("scene").to_numpy()
    if len(scenes) == 1:
        unknown = np.full(block.shape[1], np.nan)
        return unknown, unknown, 1
    means = _shared_weights(tuple(scenes), resamples, seed, dataset) @ block.to_numpy()
    low, high = np.percentile(means, LEVELS, axis=0)
    return low, high, len(np.unique(scenes))


@functools.lru_cache(maxsize=32)
def _shared_weights(scenes: tuple[str, ...], resamples: int, seed: int, dataset: str) -> np.ndarray:
    """The weights of a dataset's resamples: the same for every method, budget and difference."""
    rng = np.random.default_rng([seed, zlib.crc32(dataset.encode())])
    return bootstrap_weights(np.array(scenes), resamples, rng)


def _sorted(table: pd.DataFrame, cells: pd.DataFrame, names: Sequence[str]) -> pd.DataFrame:
    """Rows by the order in which datasets and methods first come in `cells`, then by budget."""
    ranks = {
        column: {value: i for i, value in enumerate(cells[column].unique())}
        for column in ("dataset", "method")
    }
    ranks["reference"] = ranks["method"]
    keys = [table[name].map(ranks[name]).rename(name) for name in names] + [table["k"]]
    order = pd.concat(keys, axis=1).sort_values([*names, "k"], kind="stable").index
    return table.loc[order].reset_index(drop=True)
