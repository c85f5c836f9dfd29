"""Gain of swaps of picks, against the seconds they take (not in the paper)."""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from fsel.core.files import File, Files, read_table, write_table
from fsel.core.problem import Problem
from fsel.evaluation import curves
from fsel.evaluation.captions import captures_of
from fsel.evaluation.numbers import write_csv
from fsel.evaluation.statistics import of_places
from fsel.experiments import scheme, specs
from fsel.reconstruct import reconstructor_of
from fsel.selection.swaps import problem_swaps, scoring
from fsel.workflow import inputs
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job, Table

logger = logging.getLogger(__name__)

METHOD = "fsel"
TRIED = (1, 25, 50, 100, 200, 300, 450, 600)  # subsets, when the picks so far are measured
METRIC = "psnr"
BOUNDS = {"mean": "gain", "low": "ci_low", "high": "ci_high"}
BY = ["tried", "seconds", "estimate"]
UNITS = {"seconds": "s of processor time", "estimate": "dB"}


def swap(
    folder: File, split: File, selections: File, picks: File, *, k: int, seed: int, config: str
) -> None:
    """Swap picks of `fsel`, and write down those after some numbers of subsets.

    Args:
        split, selections: split.parquet and what `select` wrote of the first draw.
        picks: receives draw, tried, seconds, estimate (of the gain, by the swaps) and frame.
        seed: of the swaps.
    """
    problem, picked = Problem.load(folder, split), read_table(selections)
    own = picked[(picked["method"] == METHOD) & (picked["seed"] == 0) & (picked["k"] == k)]
    start = own.sort_values("order")["frame"].to_numpy(np.int64)
    rng, rows = np.random.default_rng(seed), []
    reconstructor = reconstructor_of(problem.capture, scoring("splats"))
    began = time.process_time()
    for best in problem_swaps(reconstructor, problem, start, rng):
        if best.tried in TRIED:
            rows.append((0, best.tried, time.process_time() - began, best.gain, best.picks))
            logger.info("%d subsets, %.1f s: %.3f dB estimated", *rows[-1][1:4])
        if best.tried == TRIED[-1]:
            break
    table = pd.DataFrame(rows, columns=["draw", *BY, "frame"]).explode("frame")
    write_table(table.astype({"frame": int}), picks, units=UNITS, config=config)


def swaps(evaluations: Files, figures: Files, numbers: File, *, k: int, facts: Mapping) -> None:
    """Gain in PSNR on the targets against seconds, over scenes.

    Args:
        numbers: receives `gains`.
    """
    means = gains([read_table(path).groupby(BY)[METRIC].mean() for path in evaluations])
    write_csv(means, numbers)
    note = (
        f"picks of fsel, K = {k}, {len(evaluations)} scenes; band: 95% interval of the mean; "
        f"captures: {captures_of(facts)}"
    )
    curves.swaps(means, figures, note)


def gains(scenes: Sequence[pd.Series]) -> pd.DataFrame:
    """Table of tried; seconds, estimate, gain: means over scenes; and ci_low, ci_high, least, n.

    The bounds and the least are of the gain.

    Args:
        scenes: PSNR by `BY`; a scene whose swaps are exhausted keeps its last row.
    """
    tables = [scene.reset_index().set_index("tried").reindex(TRIED).ffill() for scene in scenes]
    gain = np.array([table[METRIC] - table[METRIC].iloc[0] for table in tables]).T
    means = pd.concat(tables).groupby(level="tried")[["seconds", "estimate"]].mean()
    intervals = pd.DataFrame(map(of_places, gain), index=means.index).rename(columns=BOUNDS)
    means = means.join(intervals).assign(least=gain.min(axis=1)).reset_index()
    return means[[*BY, *BOUNDS.values(), "least", "n"]]


SWAPPED = Job(
    swap,
    outputs={"picks": f"{inputs.SCENE}/swapped.parquet"},
    message="Swapping picks of {wildcards.dataset}/{wildcards.scene}",
    inputs=lambda experiment: specs.of_draw(
        "split", "selections", draw="draw0", kinds=inputs.DESCRIBED
    ),
    params=lambda experiment: {
        "k": experiment.config["search"]["k"],
        "seed": specs.scene_seed(experiment, "swaps"),
    },
    size=Size(4000, 30),
)

TRIALS = scheme.Trials(
    f"{__name__}:TRIALS",
    "swaps",
    scheme.every_draw,
    picks=lambda experiment: [SWAPPED.written(experiment)["picks"]],
    by=BY,
    draws=lambda experiment: [0],
    metrics=lambda experiment: (METRIC,),
)

TABLE = Table(
    swaps,
    outputs={
        "figures": inputs.figure_files("{reconstructor}swaps"),
        "numbers": "<tables>/{reconstructor}swaps.csv",
    },
    inputs=lambda experiment: {"evaluations": TRIALS.measured(experiment.evaluation_scenes)},
    params=lambda experiment: {
        "k": experiment.config["search"]["k"],
        "facts": experiment.facts_of,
    },
    category="Speed",
    title="Gain of swaps against seconds",
    caption="Gain in PSNR on the targets, against the processor seconds of swaps that are judged "
    "by reconstructions.",
    jobs=[SWAPPED, *TRIALS.jobs],
)
