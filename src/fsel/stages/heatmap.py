"""Gain of a method over the strongest baseline, by dataset and budget (paper, Figure 4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from fsel.core.files import File, Files
from fsel.evaluation.figures import TEXT, footnote, new_figure, save
from fsel.evaluation.latex import note
from fsel.evaluation.statistics import ahead_of_all, holm
from fsel.evaluation.summary import read_csv, write_csv
from fsel.evaluation.sweep import BASELINES, with_all_label
from fsel.selectors.baselines import PAPER
from fsel.selectors.policies import POLICIES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize

METRIC = "psnr"
ERROR = 0.05
COLUMNS = 2  # panels side by side
GAINS = "YlGnBu"  # the darker, the better, also in grey
WHITE = 0.55  # of the scale: writing on what is darker is white
PANELS = ("fsel", "less_is_more")
EXTERNAL = [name for name in PAPER if name != "untrained"]  # that is the paper's own control
RIVALS = {"paper": EXTERNAL, "all": list(BASELINES)}
WORDS = {"paper": f"the paper's {len(EXTERNAL)}", "all": f"all {len(BASELINES)}"}


def heatmap(
    numbers: File,
    differences: File,
    figures: Files,
    cells: File,
    *,
    datasets: Mapping[str, str],
    budgets: Sequence[int],
    facts: Mapping,
) -> None:
    """Draw the gain of fsel and `less_is_more` over the strongest baseline.

    Args:
        numbers, differences: what `fsel.stages.ksweep` wrote.
        cells: receives its numbers: method, rivals (`paper` or `all` baselines), and the columns of
            `gains`.
        facts: see `fsel.evaluation.latex.note`.
    """
    means, gaps = read_csv(numbers), read_csv(differences)
    panels, rows = {}, []
    labels = with_all_label(datasets)
    for method, (rivals, baselines) in product(PANELS, RIVALS.items()):
        title = f"{POLICIES[method].label}, over the strongest of {WORDS[rivals]}"
        panel = gains(
            means, gaps, method=method, baselines=baselines, datasets=list(labels), budgets=budgets
        )
        panels[title] = panel
        rows.append(panel.assign(method=method, rivals=rivals))
    write_csv(pd.concat(rows), cells)
    draw(panels, labels, figures, facts)


def gains(
    summary: pd.DataFrame,
    differences: pd.DataFrame,
    *,
    method: str,
    baselines: Sequence[str],
    datasets: Sequence[str],
    budgets: Sequence[int],
) -> pd.DataFrame:
    """Compute a method's PSNR gain over the baseline with the highest mean in each cell.

    The baseline is chosen on the scenes that it is compared on, which favours it. The mark needs no
    choice: the method is ahead of every baseline, by Holm's correction over all cells.

    Args:
        summary, differences: see `fsel.evaluation.summary.summarise` and `differences`.

    Returns:
        dataset, k, reference (the strongest), gain in dB, n (places), p (of being ahead of every
        baseline, corrected for the number of cells), significant (p below 0.05).
    """
    here = summary[(summary["metric"] == METRIC) & summary["method"].isin(baselines)]
    strongest = here.loc[here.groupby(["dataset", "k"])["mean"].idxmax()]
    strongest = strongest.set_index(["dataset", "k"])["method"]
    paired = differences[(differences["metric"] == METRIC) & (differences["method"] == method)]
    paired = paired[paired["reference"].isin(baselines)]
    paired = paired.set_index(["dataset", "k", "reference"]).sort_index()
    rows = []
    for dataset, k in product(datasets, budgets):
        rivals, best = paired.loc[(dataset, k)], strongest[dataset, k]
        p = ahead_of_all(rivals["mean"].to_numpy(), rivals["p"].to_numpy())
        rows.append((dataset, k, best, rivals["mean"][best], int(rivals["n"][best]), p))
    table = pd.DataFrame(rows, columns=["dataset", "k", "reference", "gain", "n", "p"])
    table["p"] = holm(table["p"].to_numpy())
    return table.assign(significant=table["p"] < ERROR)


def draw(
    panels: Mapping[str, pd.DataFrame],
    labels: Mapping[str, str],
    outputs: Files,
    facts: Mapping,
) -> None:
    """Draw one panel a method, on one colour scale from the least gain, or zero, to the greatest.

    Args:
        panels: title -> what `gains` returned; all over the same datasets and budgets.
        facts: see `fsel.evaluation.latex.note`; it stands under the panels.
    """
    from matplotlib.colors import Normalize

    gained = pd.concat([panel["gain"] for panel in panels.values()])
    scale = Normalize(min(gained.min(), 0.0), max(gained.max(), 0.1))
    lines = -(-len(panels) // COLUMNS)
    size = (TEXT, 0.5 + lines * (0.6 + 0.3 * len(labels)))
    figure = new_figure(size)
    axes = figure.subplots(lines, COLUMNS, squeeze=False, sharey=True).ravel()
    for axis, (title, panel) in zip(axes, panels.items(), strict=True):
        image = _panel(axis, panel, labels, scale)
        axis.set_title(title, fontsize=8)
    bar = figure.colorbar(image, ax=list(axes), shrink=0.9)
    bar.set_label("PSNR gain (dB)", fontsize=8)
    bar.ax.axhline(0, color="black", linewidth=0.8)
    bar.ax.tick_params(labelsize=7)
    footnote(
        figure,
        "number: over the baseline with the highest mean of the cell; n: scenes; bold and *: ahead "
        f"of every baseline (paired t-tests on scene means, 5%, Holm over a panel's cells). "
        f"{note(facts)}",
    )
    save(figure, outputs)


def _panel(axis: Axes, panel: pd.DataFrame, labels: Mapping[str, str], scale: Normalize):
    grid = panel.pivot(index="dataset", columns="k", values="gain").loc[list(labels)]
    image = axis.imshow(grid, cmap=GAINS, norm=scale, aspect="auto")
    marked = panel.set_index(["dataset", "k"])["significant"]
    for (y, dataset), (x, k) in product(enumerate(labels), enumerate(grid.columns)):
        value, sure = grid.loc[dataset, k], marked[dataset, k]
        text = f"{value:+.2f}{'*' if sure else ''}"
        color = "white" if scale(value) > WHITE else "black"
        weight = "bold" if sure else "normal"
        axis.text(x, y, text, ha="center", va="center", size=7, weight=weight, color=color)
    axis.set_xticks(np.arange(len(grid.columns)), [f"K={k}" for k in grid.columns], fontsize=7)
    counts = panel.groupby("dataset")["n"].first()
    names = [f"{label} (n={counts[name]})" for name, label in labels.items()]
    axis.set_yticks(np.arange(len(labels)), names, fontsize=8)
    axis.tick_params(length=0)
    return image
