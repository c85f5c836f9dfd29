"""Figure of how labels are made: the population of a search, and its labels (paper, Figure 2)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table
from fsel.core.split import Split
from fsel.evaluation.figures import (
    COLORS,
    TEXT,
    draw_cameras,
    footnote,
    name_axes,
    new_figure,
    plan_positions,
    save,
)
from fsel.evaluation.latex import note
from fsel.evaluation.summary import write_csv
from fsel.training.search import fittest_so_far

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def pipeline_figure(
    folders: Files,
    splits: Files,
    labels: Files,
    trajectories: File,
    figures: Files,
    numbers: File,
    *,
    scenes: Mapping[int, str],
    facts: Mapping,
) -> None:
    """Draw the search's population over generations, and the fittest labels from above.

    `folders`, `splits` and `labels` are of one panel each, `scenes` maps its coverage level,
    ascending, to its scene among the trajectories; `numbers` has x and y in world units.
    """
    *_, widest = scenes
    population = met_until(read_table(labels[-1]))
    parts = [population.assign(panel="population", coverage=widest)]
    fittest = read_table(trajectories).query("rank == 0").set_index(["scene", "coverage"])
    plans = {}
    for (coverage, scene), folder, path in zip(scenes.items(), folders, splits, strict=True):
        table, places = read_table(path), plan_positions(Capture.load(folder))
        split = Split.from_table(table[table["coverage"] == coverage])
        picks = np.array(fittest.loc[(scene, coverage), "picks"])
        plans[f"coverage {coverage} %"] = places, split.targets, picks
        plan = pd.DataFrame({"order": range(len(picks)), "frame": picks})
        plan[["x", "y"]] = places[picks]
        parts.append(plan.assign(panel="plan", coverage=coverage))
    columns = ["panel", "coverage", "generation", "psnr", "fitness", "best"]
    write_csv(pd.concat(parts)[[*columns, "order", "frame", "x", "y"]], numbers)
    named = ", ".join(dict.fromkeys(scenes.values()))
    figure = _drawn(population, plans)
    footnote(figure, f"{named}; population of {widest} %; open diamonds: targets. {note(facts)}")
    save(figure, figures)


def met_until(subsets: pd.DataFrame) -> pd.DataFrame:
    """Return generation, psnr, fitness of each subset, and the fittest's PSNR until then."""
    table = subsets[["generation", "psnr", "fitness"]].reset_index(drop=True)
    fittest = fittest_so_far(table["fitness"].to_numpy())
    return table.assign(best=table["psnr"].to_numpy()[fittest])


def _drawn(
    population: pd.DataFrame, plans: Mapping[str, tuple[np.ndarray, np.ndarray, np.ndarray]]
) -> Figure:
    """Draw the population and, by title, (N, 2) cameras, (H,) targets and (K,) frames in order."""
    from matplotlib.ticker import MaxNLocator  # here: jobs that draw nothing do without

    figure = new_figure((TEXT, 2.1))
    first, *others = figure.subplots(1, 1 + len(plans), width_ratios=[1.3, *[1.0] * len(plans)])
    first.plot(population["generation"], population["psnr"], ".", color="0.6", markersize=3)
    best = population.groupby("generation")["best"].last()
    first.step(best.index, best, where="post", color=COLORS[0], label="fittest so far")
    name_axes(first, "generation that met it", "PSNR on the proxies (dB)")
    first.xaxis.set_major_locator(MaxNLocator(integer=True))
    first.legend(fontsize=7)
    for axis, (title, (places, targets, picks)) in zip(others, plans.items(), strict=True):
        draw_cameras(axis, places, targets)
        x, y = places[picks].T
        axis.plot(x, y, "-", color="0.5", linewidth=0.4, zorder=2)
        steps = np.arange(1, len(picks) + 1)
        shown = axis.scatter(x, y, c=steps, cmap="viridis", s=18, zorder=4)
        axis.set_title(title, fontsize=8)
    bar = figure.colorbar(shown, ax=others, shrink=0.8, ticks=MaxNLocator(integer=True))
    bar.set_label("step of the label", fontsize=7)
    bar.ax.tick_params(labelsize=6)
    return figure
