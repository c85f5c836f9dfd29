"""How well two reconstructors rank the same subsets of requests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import spearmanr

from fsel.files import read_table, write_text
from fsel.report.captions import captures_of, printed
from fsel.report.latex import difference, plain_table
from fsel.report.numbers import write_csv
from fsel.report.statistics import of_places
from fsel.training.requests import RULE

ALL = ""  # the budget of a mean over all requests
METRICS = ("spearman", "lost", "lost_random", "gain", "gain_again")
ORDER = ["judge", "k", "metric", "mean", "ci_low", "ci_high", "p", "n", "requests"]


def judges_rank(
    judged: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[str],
    labeller: Mapping,
    judge: Mapping,
    facts: Mapping,
) -> None:
    """Agreement of the labels with a judge, and what it costs to trust them, by budget.

    Args:
        judged: what `judging.judge_requests` wrote, one a scene.
        table: receives LaTeX.
        numbers: receives judge, k (empty for all requests), metric (see `measures`), mean, ci_low,
            ci_high, p, n (scenes), requests.
        scenes: dataset/scene of each.
        labeller, judge: `reconstructor` and `long_side` to print.
        facts: see `captions.captures_of`.
    """
    tables = (read_table(path).assign(scene=s) for s, path in zip(scenes, judged, strict=True))
    rows = pd.concat(tables, ignore_index=True)
    found = measures(rows)
    result = over_scenes(found)
    write_csv(result.assign(judge=judge["reconstructor"])[ORDER], numbers)
    budgets = list(dict.fromkeys(result["k"]))
    head = ["Frames", "requests", "scenes", "Spearman", "labels' best", "at random"]
    head += ["by the label", "by the judge"]
    groups = [("", 3), ("lost (dB)", 2), (r"labels' best over \textbf{fsel} (dB)", 2)]
    text = caption(rows, labeller, judge, facts)
    cells = [_row(result[result["k"] == k].set_index("metric")) for k in budgets]
    made = plain_table(head, cells, caption=text, label="tab:judges_rank", groups=groups)
    write_text(made, table)


def measures(rows: pd.DataFrame) -> pd.DataFrame:
    """What is told of every request.

    Args:
        rows: scene, and the columns of `judging.judge_requests`.

    Returns:
        scene, request, k, and `METRICS`: spearman, NaN where one judge holds all subsets equal;
        lost and lost_random, the judge's PSNR of its best subset less that of the labels' best and
        the mean of all; gain and gain_again, the PSNR of the labels' best less that of the picks of
        `fsel`, by the label and by the judge, dB.
    """
    found = []
    for (scene, request, k), part in rows.groupby(["scene", "request", "k"]):
        label, again = part["psnr"].to_numpy(), part["psnr_again"].to_numpy()
        best, rule = label.argmax(), ((part["start"] == RULE) & part["begun"]).to_numpy().argmax()
        varied = np.ptp(label) > 0 and np.ptp(again) > 0
        correlation = spearmanr(label, again).statistic if varied else np.nan
        lost = again.max() - again[best], again.max() - again.mean()
        gains = label[best] - label[rule], again[best] - again[rule]
        found.append((scene, request, k, correlation, *lost, *gains))
    return pd.DataFrame(found, columns=["scene", "request", "k", *METRICS])


def over_scenes(found: pd.DataFrame) -> pd.DataFrame:
    """Means over a scene's requests, then over scenes, of every budget and of all.

    Args:
        found: see `measures`; a NaN counts for nothing.

    Returns:
        k, metric, mean, ci_low, ci_high, p, n (scenes), requests; n and requests count what is no
        NaN.
    """
    rows = []
    for k, part in [*found.groupby("k"), (ALL, found)]:
        means = part.groupby("scene")[list(METRICS)].mean()
        for metric in METRICS:
            interval = of_places(means[metric].dropna().to_numpy())
            rows.append((k, metric, *interval, part[metric].count()))
    return pd.DataFrame(rows, columns=ORDER[1:])


def caption(rows: pd.DataFrame, labeller: Mapping, judge: Mapping, facts: Mapping) -> str:
    """What was judged by what, in LaTeX; arguments as in `measures` and `judges_rank`."""
    each = rows.groupby(["scene", "request"]).size()
    return (
        r"\textbf{Two judges of the same subsets.} Requests of the first labelled scene of every "
        f"dataset were labelled by {printed(labeller)}; {_counted(each)} subsets of each, spread "
        f"over the ranks, are judged again by {printed(judge)} on the same targets. Spearman's "
        "correlation of both PSNR, within a request. Lost: PSNR of the judge's best subset of "
        "these less that of the labels' best, and of one drawn at random, under the judge. On the "
        r"right, PSNR of the labels' best less that of the picks of \textbf{fsel}, which the "
        "search begins with; the label's own is what the search has sought. Means over requests, "
        f"then scenes, with 95\\% intervals over scenes. Captures: {captures_of(facts)}."
    )


def _counted(each: pd.Series) -> str:
    """How many, or from how many to how many."""
    least, most = each.min(), each.max()
    return str(least) if least == most else f"{least} to {most}"


def _row(part: pd.DataFrame) -> list[str]:
    """Cells of one budget, whose metrics are the index."""
    own = part.loc["lost"]
    head = [str(own["k"]) or "all", str(own["requests"]), str(own["n"])]
    between = ["mean", "ci_low", "ci_high"]
    levels = [_level(*part.loc[name, between]) for name in METRICS[:3]]
    return head + levels + [difference(*part.loc[name, between]) for name in METRICS[3:]]


def _level(mean: float, low: float, high: float) -> str:
    """A number that is not compared with zero, with its interval where there is one."""
    text = "" if np.isnan(mean) else f"${mean:.2f}$"
    return text if np.isnan(low) else rf"{text} {{\tiny$[{low:.2f},{high:.2f}]$}}"
