"""Gain of swaps of picks, against the seconds they take (not in the paper)."""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from fsel.data.problem import Problem
from fsel.data.split import Split
from fsel.evaluation.evaluator import Evaluator
from fsel.experiments import specs
from fsel.reconstruct import reconstructor_of
from fsel.report import curves
from fsel.report.captions import captures_of
from fsel.report.numbers import write_csv
from fsel.report.statistics import of_places
from fsel.request.swaps import problem_swaps, scoring
from fsel.utils.files import File, Files, read_table, write_table
from fsel.workflow import inputs
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job, Table

logger = logging.getLogger(__name__)

METHOD = "fsel"
TRIED = (1, 25, 50, 100, 200, 300, 450, 600)  # subsets, when the picks so far are measured
METRIC = "psnr"
UNITS = {"seconds": "s of processor time", "estimate": "dB", METRIC: "dB"}


def evaluate_swaps(
    folder: File,
    split: File,
    selections: File,
    evaluation: File,
    *,
    reconstruction: Mapping,
    k: int,
    seed: int,
    config: str,
) -> None:
    """Swaps of the picks of `fsel`, measured on the targets as they go.

    Args:
        split, selections: split.parquet and what `select` wrote of one draw.
        evaluation: receives tried, seconds, estimate (of the gain, by the swaps), psnr (of the
            targets).
        reconstruction: the config's section, of the reconstructor that measures.
        seed: of the swaps.
    """
    problem = Problem.load(folder, split)
    picked = read_table(selections)
    picks = picked[(picked["method"] == METHOD) & (picked["seed"] == 0) & (picked["k"] == k)]
    start = picks.sort_values("order")["frame"].to_numpy(np.int64)
    measuring = reconstructor_of(problem.capture, reconstruction)
    evaluator = Evaluator.on_frames(measuring, Split.load(split).targets, metrics=(METRIC,))
    rows, spent, began = [], 0.0, time.process_time()
    rng = np.random.default_rng(seed)
    reconstructor = reconstructor_of(problem.capture, scoring("splats"))
    for best in problem_swaps(reconstructor, problem, start, rng):
        if best.tried not in TRIED:
            continue
        spent += time.process_time() - began
        rows.append((best.tried, spent, best.gain, float(evaluator(best.picks)[0])))
        logger.info("%d subsets, %.1f s: %.3f dB", best.tried, spent, rows[-1][-1])
        if best.tried == TRIED[-1]:
            break
        began = time.process_time()
    table = pd.DataFrame(rows, columns=["tried", "seconds", "estimate", METRIC])
    write_table(table, evaluation, units=UNITS, config=config)


def swaps(evaluations: Files, figures: Files, numbers: File, *, k: int, facts: Mapping) -> None:
    """Gain in PSNR on the targets against seconds, over scenes.

    Args:
        numbers: receives `gains`.
    """
    means = gains([read_table(path) for path in evaluations])
    write_csv(means, numbers)
    note = (
        f"picks of fsel, K = {k}, {len(evaluations)} scenes; band: 95% interval of the mean; "
        f"captures: {captures_of(facts)}"
    )
    curves.swaps(means, figures, note)


def gains(scenes: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Table of tried; seconds, estimate, gain: means over scenes; and ci_low, ci_high, least, n.

    The bounds and the least are of the gain.

    Args:
        scenes: what `evaluate_swaps` wrote; a scene whose swaps are exhausted keeps its last row.
    """
    whole = [scene.set_index("tried").reindex(TRIED).ffill() for scene in scenes]
    rows = []
    for tried in TRIED:
        here = pd.DataFrame([scene.loc[tried] for scene in whole])
        gain = np.array([scene[METRIC][tried] - scene[METRIC][TRIED[0]] for scene in whole])
        interval = of_places(gain)
        spent = here[["seconds", "estimate"]].mean()
        rows.append(
            (tried, *spent, interval.mean, interval.low, interval.high, gain.min(), interval.n)
        )
    columns = ["tried", "seconds", "estimate", "gain", "ci_low", "ci_high", "least", "n"]
    return pd.DataFrame(rows, columns=columns)


MEASURED = Job(
    evaluate_swaps,
    outputs={"evaluation": f"{inputs.SCENE}/{{reconstructor}}swaps.parquet"},
    message="Swapping picks of {wildcards.dataset}/{wildcards.scene}",
    inputs=lambda experiment: specs.of_draw(
        "split", "selections", draw="draw0", kinds=inputs.DESCRIBED
    ),
    params=lambda experiment: {
        "reconstruction": experiment.reconstruction_of,
        "k": experiment.config["search"]["k"],
        "seed": specs.scene_seed(experiment, "swaps"),
    },
    size=Size(4000, 30, "reconstruction"),
)

TABLE = Table(
    swaps,
    outputs={
        "figures": inputs.figure_files("{reconstructor}swaps"),
        "numbers": "<tables>/{reconstructor}swaps.csv",
    },
    inputs=lambda experiment: {
        "evaluations": inputs.of_scenes(
            experiment.evaluation_scenes, "{reconstructor}swaps.parquet"
        )
    },
    params=lambda experiment: {
        "k": experiment.config["search"]["k"],
        "facts": experiment.facts_of,
    },
    category="Speed",
    title="Gain of swaps against seconds",
    caption="Gain in PSNR on the targets, against the processor seconds of swaps that are judged "
    "by reconstructions.",
    jobs=[MEASURED],
)
