"""Figure of how labels are made: the population of a search, and its labels (paper, Figure 2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table
from fsel.core.split import Split
from fsel.evaluation import curves
from fsel.evaluation.captions import note
from fsel.evaluation.numbers import write_csv
from fsel.evaluation.plan import plan_positions
from fsel.training.search import fittest_so_far


def pipeline_figure(
    folder: File,
    splits: File,
    labels: Files,
    trajectories: File,
    figures: Files,
    numbers: File,
    *,
    coverages: Sequence[int],
    scene: str,
    facts: Mapping,
) -> None:
    """The search's population over generations, and the fittest labels on the plan.

    Drawn are the labels of the narrowest, the middle and the widest coverage level.

    Args:
        folder: canonical capture of a labelled scene.
        splits: its splits at all coverage levels.
        labels: the searched subsets of each coverage level; the population of the widest is drawn.
        trajectories: of all scenes.
        numbers: receives panel, coverage and, of `population`, generation, psnr, fitness, best; of
            `plan`, order, frame, x, y in world units.
        coverages: the levels.
        scene: its name among the trajectories.
    """
    searched = dict(zip(coverages, labels, strict=True))
    levels = sorted(searched)
    widest, shown = levels[-1], {levels[0], levels[len(levels) // 2], levels[-1]}
    population = met_until(read_table(searched[widest]))
    parts = [population.assign(panel="population", coverage=widest)]
    ordered = read_table(trajectories).query("scene == @scene and rank == 0")
    ordered = ordered[ordered["coverage"].isin(shown)]
    capture, table = Capture.load(folder), read_table(splits)
    places, plans = plan_positions(capture), {}
    for coverage, picks in zip(ordered["coverage"], ordered["picks"], strict=True):
        split = Split.from_table(table[table["coverage"] == coverage])
        picks = np.array(picks)
        title = f"coverage {coverage} %"
        plans[title] = {"places": places, "targets": split.targets, "picks": picks}
        plan = pd.DataFrame({"order": range(len(picks)), "frame": picks})
        plan[["x", "y"]] = places[picks]
        parts.append(plan.assign(panel="plan", coverage=coverage))
    columns = ["panel", "coverage", "generation", "psnr", "fitness", "best"]
    write_csv(pd.concat(parts)[[*columns, "order", "frame", "x", "y"]], numbers)
    text = f"{scene}, population of {widest} %; open diamonds: targets. {note(facts)}"
    curves.search_and_labels(population, plans, figures, text)


def met_until(subsets: pd.DataFrame) -> pd.DataFrame:
    """Table of generation, psnr, fitness of each subset, and the fittest's PSNR until then."""
    table = subsets[["generation", "psnr", "fitness"]].reset_index(drop=True)
    fittest = fittest_so_far(table["fitness"].to_numpy())
    return table.assign(best=table["psnr"].to_numpy()[fittest])
