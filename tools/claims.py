"""Set the paper's claims beside a run's numbers: `python tools/claims.py`.

    python tools/claims.py [--results results] [--output docs/results/claims.md]

Numbers come from the evaluations and tables of a run of `snakemake paper`. A claim whose files are
not there is left out. Intervals are Student's t over scenes, 95 %.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import binom

from fsel.core.files import read_table, write_text
from fsel.evaluation.statistics import of_places
from fsel.evaluation.summary import ALL_FRAMES, draw_means, read_csv
from fsel.selectors.baselines import PAPER

OURS = "less_is_more"
OVER_ALL = {30: "+1.33 dB", 40: "+1.68 dB"}  # frames, by K
CHANCE = 0.025  # that an interval lies above zero where nothing is gained
EVALUATIONS, ORACLE = "draw*/evaluation.parquet", "draw*/oracle.parquet"  # of a scene
NINE = [name for name in PAPER if name != "untrained"] + ["mvsnet_location"]
WHY = {
    "cells": "little is left at K = 40 and 50: given K = 40 on DL3DV, the search itself gains "
    "0.19 dB over k-medoids ([measured](../notebook/2026-11-many-scenes.md))",
    "all": "`splats` matches each frame with its best partners and votes, so more frames do it no "
    "harm: it lacks what makes a feed-forward network worse with more of them",
    "search": "the scorer imitates picks; the search saw reconstructions of the scene itself",
}


class Row(NamedTuple):
    """A claim: the paper's number, ours, scenes or cells, and whether it holds."""

    claim: str
    paper: str
    ours: str
    n: str
    verdict: str
    why: str = ""


def scene_means(results: Path, files: str = EVALUATIONS, beside: str = "") -> pd.DataFrame:
    """Return PSNR by (dataset, scene) and (method, k): targets, seeds and draws averaged, of draws
    with a file `beside`."""
    paths = sorted(results.glob(f"*/*/{files}"))
    paths = [path for path in paths if (path.parent / beside).exists()]
    if not paths:
        raise FileNotFoundError(f"{results}: no {files}; run `snakemake --cores 2 paper` first")
    parts = []
    for path in paths:
        dataset, scene = path.relative_to(results).parts[:2]
        table = read_table(path)
        if "method" not in table:  # of the selector and all frames alone
            table = table.assign(method=np.where(table["k"] == ALL_FRAMES, "all", OURS), seed=0)
        means = draw_means(table, ["psnr"])
        parts.append(means.assign(dataset=dataset, scene=scene))
    return pd.concat(parts).pivot_table("psnr", ["dataset", "scene"], ["method", "k"])


def judged(gap: pd.Series) -> tuple[str, str, str]:
    """Print a mean difference and its interval, the number of scenes, and whether it is above 0."""
    found = of_places(gap.dropna().to_numpy())
    return _said(found.mean, found.low, found.high, f"{found.n} scenes")


def _said(mean: float, low: float, high: float, n: str) -> tuple[str, str, str]:
    verdict = "holds" if low > 0 else "not here" if high < 0 else "level"
    return f"{mean:+.2f} dB ({low:+.2f} to {high:+.2f})", n, verdict


def sweep(cells: pd.DataFrame) -> Iterator[Row]:
    """Compare the selector with the baselines, the untrained sum and all frames."""
    budgets = sorted(cells[OURS].columns)
    means = cells.groupby("dataset").mean()
    for rivals, claim, paper in (
        (NINE, "ahead of the strongest of nine baselines, cells of dataset and K", "30 of 30"),
        (["untrained"], "ahead of the untrained sum of the same features, cells", "29 of 30"),
    ):
        rivals = [name for name in rivals if name in cells]
        ahead = [
            means[OURS, k] > means[[(name, k) for name in rivals]].max(axis=1) for k in budgets
        ]
        count, total = int(np.sum(ahead)), int(np.size(ahead))
        verdict = _most(count, total)
        why = WHY["cells"] if rivals[0] == NINE[0] and verdict != "holds" else ""
        yield Row(claim, paper, f"{count} of {total}", f"{total} cells", verdict, why)
    for k in budgets:
        best = means[[(name, k) for name in NINE if name in cells]].idxmax(axis=1)
        rival = pd.Series({i: cells.loc[i, best[i[0]]] for i in cells.index})
        yield Row(
            f"over the strongest baseline of each dataset, K = {k}",
            "ahead",
            *judged(cells[OURS, k] - rival),
        )
    mean = np.mean([cells[OURS, k] - cells["untrained", k] for k in budgets], axis=0)
    yield Row("over the untrained sum", "+0.48 dB", *judged(pd.Series(mean)))
    for k, paper in OVER_ALL.items():
        gap = cells.loc[["dl3dv"], (OURS, k)] - cells.loc[["dl3dv"], ("all", ALL_FRAMES)]
        row = Row(f"over all frames on DL3DV, K = {k}", paper, *judged(gap))
        yield row if row.verdict == "holds" else row._replace(why=WHY["all"])
    lost = cells["less_is_more_no_appearance", 30] - cells[OURS, 30]
    small = "holds" if of_places(lost.to_numpy()).low > -0.1 else "not here"
    yield Row("without appearance, K = 30", "-0.03 dB", *judged(lost)[:2], small)


def _most(count: int, total: int) -> str:
    return "holds" if count >= 0.95 * total else "not here"


def search(cells: pd.DataFrame, oracle: pd.DataFrame) -> Iterator[Row]:
    """Compare the search with random search, and the selector with the search."""
    k = int(oracle.columns.get_level_values("k")[0])
    found, by_chance = oracle["search", k], oracle["random_search", k]
    yield Row("search over random search of equal cost", "+0.62 dB", *judged(found - by_chance))
    gap = cells[OURS, k].loc[found.index] - found
    row = Row("selector over its search", "-0.02 dB", *judged(gap))
    yield row if row.verdict == "holds" else row._replace(why=WHY["search"])


def others(results: Path) -> Iterator[Row]:
    """Read the claims of single tables; those that were not made are left out."""
    tables = results / "tables"
    if (tables / "objectcentric.csv").exists():
        for dataset, paper in (("scannet", "+0.50 dB"), ("co3d", "+0.82 dB")):
            cells = scene_means(results, "objects.parquet").loc[[dataset]]
            yield from _rows(cells, f"one object, {dataset}", paper)
    if (tables / "crosscapture.csv").exists():
        yield from _rows(scene_means(results, "crosscapture.parquet"), "across captures")
    if (path := tables / "transfer.csv").exists():
        for name in read_csv(path)["reconstructor"].unique():
            cells = scene_means(results, f"draw*/{name}/transfer.parquet")
            yield from _rows(cells, f"the same picks under `{name}`")
    if (path := tables / "reconchoice.csv").exists():
        names = read_csv(path)["reconstructor"].unique()
        for name in names[names != "splats"]:  # which the sweep tells of
            cells = scene_means(results, f"draw*/{name}/reconchoice.parquet")
            for k, paper in OVER_ALL.items():
                gap = judged(cells[OURS, k] - cells["all", ALL_FRAMES])
                yield Row(f"over all frames under `{name}`, K = {k}", paper, *gap)
    if (path := tables / "seedvar.csv").exists():
        table = read_csv(path)
        count = int((table["std"] < table["margin"].abs()).sum())
        text = f"{count} of {len(table)}"
        yield Row(
            "deviation over seeds below the margin, cells",
            "30 of 30",
            *(text, f"{len(table)} cells", _most(count, len(table))),
        )
    for name, what in (("scorer_arch", "scorer"), ("feature_sweep", "set of features")):
        if (path := tables / f"{name}.csv").exists():
            table = read_csv(path)
            better, total = int((table["difference_low"] > 0).sum()), len(table) - 1
            verdict = "not here" if better > binom.ppf(0.95, total, CHANCE) else "holds"
            text = f"{better} of {total} better beyond the interval; {CHANCE * total:.1f} by chance"
            scenes = f"{int(table['n'].max())} scenes"
            yield Row(f"no other {what} is better", "none", text, scenes, verdict)


def real(cells: pd.DataFrame) -> Iterator[Row]:
    """Compare the selector on captures from disk, and say what it is worth on the worst."""
    for over, rivals in (("strongest baseline", NINE), ("untrained sum", ["untrained"])):
        for k, best, gap in _over_best(cells, rivals):
            ours, _, verdict = judged(gap)
            n = f"{len(gap)} captures, worst {gap.min():+.2f} dB"
            claim = f"over the {over} on real captures, K = {k}"
            yield Row(claim, "ahead", ours, n, verdict, f"over `{best}`")


def _rows(cells: pd.DataFrame, claim: str, paper: str = "ahead") -> Iterator[Row]:
    """Compare the selector with the strongest baseline, on the mean, for each K."""
    for k, _, gap in _over_best(cells, NINE):
        yield Row(f"{claim}, K = {k}", paper, *judged(gap))


def _over_best(cells: pd.DataFrame, names: list[str]) -> Iterator[tuple[int, str, pd.Series]]:
    """Yield for each K the baseline that is the strongest on the mean, and the lead over it."""
    for k in sorted(cells[OURS].columns):
        rivals = cells[[(name, k) for name in names if (name, k) in cells]]
        best = rivals.mean().idxmax()
        yield k, best[0], cells[OURS, k] - rivals[best]


def page(results: Path) -> str:
    """Return the page."""
    cells, path = scene_means(results), results / "tables" / "captures" / "ksweep_differences.csv"
    captures = read_csv(path) if path.exists() else pd.DataFrame({"dataset": []})
    cells = cells[~cells.index.isin(captures["dataset"], level="dataset")]
    rows = list(sweep(cells))
    if any(results.glob(f"*/*/{ORACLE}")):
        beside = Path(ORACLE).name
        rows += search(*(scene_means(results, files, beside) for files in (EVALUATIONS, ORACLE)))
    rows += others(results)
    if any((results / "real").glob(f"*/*/{EVALUATIONS}")):
        rows += real(scene_means(results / "real"))
    table = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    lines = [
        "# The paper's claims, and what holds here",
        "`snakemake --cores 2 paper`, then `python tools/claims.py`. PSNR of `less_is_more` on "
        "generated captures (in the last rows on real ones, learned from others of them, by "
        "`config/real.yaml`), reconstructed by `splats` unless another is named; the baselines "
        "pick from P and O, the selector from P, as in the paper; of the MVSNet score the top K "
        "and the facility location both count. Means with 95 % intervals of paired differences "
        "over scenes; *level*: the interval includes zero.",
        f"| claim | paper | here | n | | why |\n|---|---|---|---|---|---|\n{table}",
    ]
    return "\n\n".join(lines) + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--results", type=Path, default=Path("results"))
    parser.add_argument("--output", type=Path, default=Path("docs/results/claims.md"))
    options = parser.parse_args()
    write_text(page(options.results), options.output)
