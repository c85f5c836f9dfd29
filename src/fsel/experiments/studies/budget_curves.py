"""Fit what `fsel.request.budget` predicts, to reconstructions of training scenes."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import coverage_split
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import PICK_UNITS, chance, measure, runs, select
from fsel.experiments import specs
from fsel.reconstruct import reconstructor_of
from fsel.request.budget import enough, predicted, shifts, view_shift
from fsel.utils.files import atomic, read_table, write_table, write_text
from fsel.workflow import inputs
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job

logger = logging.getLogger(__name__)

COUNTS = (4, 6, 8, 10, 13, 16, 20, 25, 30, 40, 50, 60)  # frames reconstructed from
REPEATS = 3  # requests of each coverage
THRESHOLDS = (0.005, 0.01, 0.02, 0.03, 0.05, 0.1)  # dB a frame, compared on training scenes
SHIFTS = ["first", "second", "third"]
CURVE = ["scene", "coverage", "repeat"]
UNITS = {"coverage": "%", "psnr": "dB"} | dict.fromkeys(SHIFTS, "fields of view")


def select_curves(
    folder: str | Path,
    weights: str | Path,
    picks: str | Path,
    *,
    coverages: Sequence[int],
    seed: int,
    config: str,
) -> None:
    """Select by `fsel` for requests of several sizes on one scene.

    Args:
        folder: a canonical capture with its descriptors.
        weights: the scorer.
        picks: receives coverage, repeat and the columns of `fsel.evaluation.measuring.select`,
            of the largest number of frames in `COUNTS` that the scene has.
        coverages: per cent of the capture that requests are drawn from.
        seed: of the scene.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    described = read_table(Path(folder) / "descriptors.parquet")
    contenders = runs([], [weights])
    tables = []
    for coverage in coverages:
        for repeat in range(REPEATS):
            split = coverage_split(capture, coverage, seed + repeat)
            problem = Problem.of(capture, split, described)
            k = max(k for k in COUNTS if k <= len(problem.observed))
            chosen = select(problem, contenders, [k], chance(seed))
            tables.append(chosen.assign(coverage=coverage, repeat=repeat))
    write_table(pd.concat(tables), picks, units=PICK_UNITS, config=config)


def evaluate_curves(
    folder: str | Path,
    picks: str | Path,
    curves: str | Path,
    *,
    seed: int,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Measure what those requests reach with ever more frames.

    Args:
        folder: a canonical capture.
        picks: what `select_curves` wrote.
        curves: receives coverage, repeat, k, psnr (NaN where nothing was reconstructed) and the
            mean shifts of `fsel.request.budget.shifts`.
        seed: of the scene.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    reconstructor = reconstructor_of(capture, reconstruction)
    tables = []
    for (coverage, repeat), part in read_table(picks).groupby(CURVE[1:], sort=False):
        targets = coverage_split(capture, coverage, seed + repeat).targets
        frames = part["frame"].to_numpy(np.int64)
        evaluator = Evaluator.on_frames(reconstructor, targets)
        psnr = measure(evaluator, _beginnings(frames), ["k"]).groupby("k")["psnr"].mean()
        means = shifts(view_shift(capture, frames, capture.view(targets)))
        table = pd.DataFrame(means, columns=SHIFTS)
        table = table.assign(coverage=coverage, repeat=repeat, k=table.index)
        tables.append(table.assign(psnr=table["k"].map(psnr)))
        logger.info("%d %%, request %d: %s", coverage, repeat, psnr.to_dict())
    write_table(pd.concat(tables), curves, units=UNITS, config=config)


def _beginnings(frames: np.ndarray) -> pd.DataFrame:
    """The first of some picks, for each of `COUNTS` that there are: k, frame."""
    counts = [k for k in COUNTS if k <= len(frames)]
    return pd.concat([pd.DataFrame({"k": k, "frame": frames[:k]}) for k in counts])


def fit_worth(curves: pd.DataFrame) -> np.ndarray:
    """(3,) dB that a field of view is worth, by non-negative least squares.

    Every curve has an offset of its own: what a scene reaches at best is not predicted. All
    datasets weigh the same.

    Args:
        curves: dataset, scene, coverage, repeat, k, psnr and mean shifts.
    """
    from scipy.optimize import nnls  # here: every job imports this module

    known = curves[curves["psnr"].notna()]
    columns = [*SHIFTS, "psnr"]
    offset = known.groupby(["dataset", *CURVE])[columns].transform("mean")
    weight = np.sqrt(1 / known.groupby("dataset")["psnr"].transform("size").to_numpy())
    centred = (known[columns] - offset).to_numpy() * weight[:, None]
    return nnls(-centred[:, :-1], centred[:, -1])[0]


def compare_thresholds(curves: pd.DataFrame, thresholds: Sequence[float]) -> pd.DataFrame:
    """Budgets found under each threshold beside one number of frames for all requests.

    A dataset's requests are served by what was fitted to the others, where there are others.

    Args:
        curves: as in `fit_worth`.
        thresholds: dB a frame.

    Returns:
        threshold, frames (mean), deviation (of the frames), psnr, fixed (PSNR of that mean number
        of frames for every request) and lead (psnr - fixed); PSNR between `COUNTS` is interpolated,
        and all datasets weigh the same.
    """
    sizes = curves.groupby("dataset")["k"].size()
    budgets, weight, levels = [], [], []
    last = int(curves.loc[curves["psnr"].notna()].groupby(["dataset", *CURVE])["k"].max().min())
    frames = np.arange(last + 1)
    for (dataset, *_), curve in curves.groupby(["dataset", *CURVE]):
        others = curves[curves["dataset"] != dataset]
        worth = fit_worth(others if len(others) else curves)
        curve = curve.sort_values("k").iloc[: last + 1]
        known = curve[curve["psnr"].notna()]
        quality = predicted(curve[SHIFTS].to_numpy(), worth)
        budgets.append([enough(quality, threshold) for threshold in thresholds])
        levels.append(np.interp(frames, known["k"], known["psnr"]))
        weight.append(1 / sizes[dataset])
    return _beside_fixed(np.array(budgets), np.array(levels), np.array(weight), thresholds)


def _beside_fixed(
    budgets: np.ndarray, levels: np.ndarray, weight: np.ndarray, thresholds: Sequence[float]
) -> pd.DataFrame:
    """The table of `compare_thresholds`.

    Args:
        budgets: (R, L) frames of each request under each threshold.
        levels: (R, n) PSNR of each request after 0, 1, ... frames.
        weight: (R,) of the requests.
        thresholds: L of them.
    """
    weight = weight / weight.sum()
    everywhere = weight @ levels
    rows = []
    for threshold, frames in zip(thresholds, budgets.T, strict=True):
        mean = float(weight @ frames)
        psnr = float(weight @ levels[np.arange(len(levels)), frames])
        fixed = float(np.interp(mean, np.arange(len(everywhere)), everywhere))
        rows.append(
            {
                "threshold": threshold,
                "frames": mean,
                "deviation": float(np.sqrt(weight @ (frames - mean) ** 2)),
                "psnr": psnr,
                "fixed": fixed,
                "lead": psnr - fixed,
            }
        )
    return pd.DataFrame(rows)


def fit_budget(
    curves: Sequence[str | Path],
    record: str | Path,
    comparison: str | Path,
    *,
    scenes: Sequence[tuple[str, str]],
    config: str,
) -> None:
    """Fit the prediction to all training scenes, and compare thresholds.

    Args:
        curves: what `evaluate_curves` wrote, one a scene.
        record: receives `worth` and where it comes from, as JSON.
        comparison: receives the columns of `compare_thresholds`.
        scenes: dataset and scene of each.
        config: digest of the parameters.
    """
    table = pd.concat(
        read_table(path).assign(dataset=dataset, scene=scene)
        for (dataset, scene), path in zip(scenes, curves, strict=True)
    )
    worth = fit_worth(table)
    count = len(table.drop_duplicates(["dataset", *CURVE]))
    made = f"least squares on {count} curves of PSNR against K of {len(curves)} scenes"
    content = {
        "worth": worth.round(4).tolist(),
        "unit": "dB a field of view, of the closest, second and third frame",
        "provenance": {"made by": made, "config": config},
        "remade by": "make weights",
    }
    write_text(json.dumps(content, indent=2) + "\n", record)
    compared = compare_thresholds(table, THRESHOLDS)
    with atomic(comparison) as temporary:
        compared.to_csv(temporary, index=False, float_format="%.4f")
    logger.info("%s: %s\n%s", made, worth, compared.to_string())


RECORD = "<results>/selector/budget.json"

PICKED = Job(
    select_curves,
    outputs={"picks": f"{inputs.SCENE}/curves_picks.parquet"},
    message="Selecting ever more frames of {wildcards.dataset}/{wildcards.scene}",
    inputs=lambda experiment: {
        **inputs.capture(inputs.DESCRIBED),
        "weights": experiment.fsel[0],
    },
    params=lambda experiment: {
        "coverages": experiment.config["coverages"],
        "seed": specs.scene_seed(experiment, "budget"),
    },
    size=Size(2000, 10, "capture"),
)

EVALUATED = Job(
    evaluate_curves,
    outputs={"curves": f"{inputs.SCENE}/curves.parquet"},
    message="Reconstructing {wildcards.dataset}/{wildcards.scene} from ever more frames",
    inputs=lambda experiment: specs.picks_of("curves_picks.parquet"),
    params=lambda experiment: {
        "seed": specs.scene_seed(experiment, "budget"),
        "reconstruction": experiment.reconstruction,
    },
    size=Size(4000, 30, "reconstruction"),
)

FITTED = Job(
    fit_budget,
    outputs={"record": RECORD, "comparison": "<results>/selector/budget.csv"},
    message="Fitting what further frames bring",
    inputs=lambda experiment: {
        "curves": inputs.of_problems(
            experiment.practised or inputs.with_labels(experiment), "curves.parquet"
        )
    },
    params=lambda experiment: {"scenes": [name.split("/") for name in experiment.practised]},
)

JOBS = (PICKED, EVALUATED, FITTED)
