"""The selectors beside the search that they imitate (paper, Appendix D.3)."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.data.capture import Capture
from fsel.data.split import Split
from fsel.evaluation.evaluator import Evaluator
from fsel.metrics import METRIC_UNITS, METRICS
from fsel.reconstruct import reconstructor_of
from fsel.report.captions import made_by
from fsel.report.latex import MISSING, difference, number, plain_table
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, summarise
from fsel.report.sweep import named, sweep_cells
from fsel.utils.files import read_table, write_table, write_text

logger = logging.getLogger(__name__)

SEARCH = "search"
AVERAGES = {"random_search": "average_random", SEARCH: "average_search"}
ROWS = {
    "average_random": "Average subset of random search",
    "average_search": "Average subset of the genetic search",
    "random_search": "Random search, fittest on the proxies",
    SEARCH: "Genetic search, fittest on the proxies",
    "less_is_more": r"\textbf{Ours}",
    "fsel": r"\textbf{fsel}",
}


def evaluate_searched(
    folder: str | Path,
    split: str | Path,
    subsets: str | Path,
    evaluation: str | Path,
    *,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Every subset that the searches met, scored on the held-out targets.

    Args:
        folder: a canonical capture.
        split: split.parquet of the draw.
        subsets: what `fsel.stages.search_oracle` wrote.
        evaluation: receives method, generation and metrics, rows as in `subsets`.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    table = read_table(subsets)
    targets = Split.load(split).targets
    evaluate = Evaluator.on_frames(reconstructor_of(Capture.load(folder), reconstruction), targets)
    measured = table[["method", "generation"]].copy()
    measured[list(METRICS)] = [evaluate(np.array(subset)) for subset in table["subset"]]
    write_table(measured, evaluation, units=METRIC_UNITS, config=config)
    logger.info("%d subsets\n%s", len(table), measured.groupby("method")["psnr"].describe())


def ga_vs_learned(
    evaluations: Sequence[str | Path],
    oracles: Sequence[str | Path],
    searched: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    problems: Sequence[str],
    k: int,
    facts: Mapping,
) -> None:
    """Average subset, random search, search and selectors, all scored on the targets.

    Args:
        evaluations, oracles: what `fsel.stages.evaluate` and `search_oracle` wrote, one a problem.
        searched: what `evaluate_searched` wrote, one a problem.
        table, numbers: receive LaTeX, and the columns of `compare_with_search`.
        problems: `dataset/scene/draw0` of each.
        k: budget of the search.
        facts: see `captions.made_by`.
    """
    cells = sweep_cells(named([*problems, *problems], [*evaluations, *oracles]), facts=facts)
    averages = pd.concat([_averages(item, k) for item in named(problems, searched)])
    result = compare_with_search(pd.concat([averages, cells[cells["k"] == k]]))
    write_csv(result, numbers)
    tried = pd.concat([read_table(path) for path in searched])
    tried = len(tried[tried["method"] == SEARCH]) / len(searched)
    text = (
        rf"\textbf{{Comparison with the genetic search}}, $K{{=}}{k}$, held-out scenes: "
        f"${result['n'].iloc[0]}$. The searches each reconstruct {tried:.0f} subsets a scene and "
        "keep the fittest on the proxies; the selectors reconstruct none. All PSNRs are on the "
        "held-out targets. In brackets: paired 95\\% intervals over scenes and draws; bold where "
        "they exclude zero. Ahead: scenes in which a row's PSNR exceeds the genetic search's. "
        f"{made_by(facts)}"
    )
    head = ["Selection", r"PSNR$\uparrow$ (dB)", "minus search (dB)", "ahead"]
    write_text(plain_table(head, _rows(result), caption=text, label="tab:ga_vs_learned"), table)


def compare_with_search(cells: pd.DataFrame) -> pd.DataFrame:
    """Means of every row of the table, and their paired differences to the search's.

    Args:
        cells: scene, draw, method, k, psnr of one dataset at one budget; the draws that the search
            was run on are compared, the others left out.

    Returns:
        method, k, mean, ci_low, ci_high, difference, difference_low, difference_high (NaN for the
        search itself), ahead (scenes), n (scenes); in the order of `ROWS`.
    """
    cells = cells[cells["method"].isin(ROWS)]
    common = cells[cells["method"] == SEARCH][["dataset", "scene", "draw"]]
    cells = cells.merge(common, on=["dataset", "scene", "draw"])
    means = summarise(cells, ["psnr"])
    others = [name for name in ROWS if name != SEARCH]
    gaps = differences(cells, others, ["psnr"])
    gaps = gaps[gaps["reference"] == SEARCH].set_index("method")
    bounds = {"mean": "difference", "ci_low": "difference_low", "ci_high": "difference_high"}
    result = means.set_index("method").join(gaps.rename(columns=bounds)[list(bounds.values())])
    scenes = cells.groupby(["method", "scene"])["psnr"].mean().unstack("scene")
    result["ahead"] = (scenes > scenes.loc[SEARCH]).sum(axis=1)
    order = ["k", "mean", "ci_low", "ci_high", *bounds.values(), "ahead", "n"]
    return result.loc[list(ROWS), order].rename_axis("method").reset_index()


def _averages(item: Mapping, k: int) -> pd.DataFrame:
    """One row a search: the mean over all its subsets."""
    means = read_table(item["path"]).groupby("method")[list(METRICS)].mean().reset_index()
    head = {"dataset": item["dataset"], "scene": item["scene"], "draw": item["draw"], "k": k}
    return means.assign(**head, method=means["method"].map(AVERAGES))


def _rows(result: pd.DataFrame) -> list[list[str]]:
    rows = []
    for name, row in result.set_index("method").iterrows():
        cells = [MISSING, MISSING]
        if name != SEARCH:
            gap = difference(row["difference"], row["difference_low"], row["difference_high"])
            cells = [gap, f"{row['ahead']:.0f} of {row['n']:.0f}"]
        rows.append([ROWS[name], number(row["mean"], "psnr"), *cells])
    return rows
