"""Quality, runtime and memory of the selector and its cheaper variants (paper, Table 5)."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from fsel.captures.images.previews import sharpness
from fsel.core.files import File, Files, read_table, write_table, write_text
from fsel.core.problem import Problem
from fsel.core.programs import FINISHED, Unfinished
from fsel.core.split import Split
from fsel.evaluation.latex import MISSING, bold_if, made_by, number, plain_table
from fsel.evaluation.measuring import Run, learned_runs, picks_at, rng_by_name
from fsel.evaluation.summary import ALL_FRAMES, differences, summarise, write_csv
from fsel.evaluation.sweep import sweep_cells
from fsel.experiments.scheme import Scenes, Trials, cells_of, every_draw
from fsel.experiments.studies.footprint import measure_alone
from fsel.features.appearance import descriptors
from fsel.metrics import Metrics
from fsel.selection.budget import losses, shipped

logger = logging.getLogger(__name__)

ALL = "all"
UNITS = {"fit_seconds": "s", "render_seconds": "s", "peak_bytes": "bytes"}
ENDED = ["device", "outcome"]
ENOUGH = 1.0  # seconds of measured runs after which a method is not run again
REPEATS = 5
VARIANTS = {
    "less_is_more": r"\textbf{Ours}",
    "less_is_more_no_appearance": r"\shortstack{w/o\\appear.}",
    "less_is_more_geometry": r"\shortstack{w/o appear.\\\& sharp.}",
}


def costs_alone(
    folder: File,
    subsets: Iterable[tuple[int, np.ndarray]],
    targets: np.ndarray,
    reconstruction: Mapping,
    metrics: Metrics = ("psnr",),
    **limits: Any,
) -> pd.DataFrame:
    """Measure subsets, k (`ALL_FRAMES` for all) and frames of each, in processes of their own;
    numbers are NaN where a reconstruction did not finish, and `outcome` says why."""
    rows = []
    for k, frames in subsets:
        try:
            cost = measure_alone(folder, frames, targets, reconstruction, metrics=metrics, **limits)
        except Unfinished as end:
            logger.warning("%s", end)
            cost = {"outcome": end.outcome}
        rows.append({"k": k, "device": "", "outcome": FINISHED, **cost})
        logger.info("%s", rows[-1])
    numbers = [*metrics, *UNITS]
    table = pd.DataFrame(rows, columns=["k", *numbers, *ENDED])
    return table.astype(dict.fromkeys(numbers, float))


def cost_means(costs: Files, metrics: Metrics = ()) -> pd.DataFrame:
    """Return means by k, NaN where a scene did not finish; the outcome says why."""
    table = pd.concat([read_table(path) for path in costs])
    table["seconds"] = table["fit_seconds"] + table["render_seconds"]
    table["peak_mb"] = table["peak_bytes"] / 1e6
    groups = table.groupby("k", sort=False)
    means = groups[[*metrics, "seconds", "peak_mb"]].agg(lambda values: values.mean(skipna=False))
    return means.assign(n=groups.size(), **{name: groups[name].max() for name in ENDED})


def measure_costs(
    folder: File,
    split: File,
    weights: Files,
    costs: File,
    times: File,
    *,
    budgets: Sequence[int],
    appearance: Mapping,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Measure what reconstruction from ours costs at every budget, and what selecting does.

    `weights` has one scorer of each variant; `costs` receives `costs_alone`, and `times` variant, k
    and seconds of one thread: descriptors of all observed frames, where the variant reads them, and
    the selection.
    """
    problem, targets = Problem.load(folder, split), Split.load(split).targets
    variants = {run.method.name: run for run in learned_runs(weights)}
    picks = picks_at(problem, variants[next(iter(VARIANTS))], budgets, rng_by_name(0))
    subsets = {made.k: made.frames for made in picks} | {ALL_FRAMES: problem.candidates}
    measured = costs_alone(folder, subsets.items(), targets, reconstruction)
    write_table(measured, costs, units=UNITS, config=config)
    described = descriptor_seconds(problem, appearance)
    rows = [
        (name, k, sum(selection_seconds(problem, run, k, described)))
        for name, run in variants.items()
        for k in budgets
    ]
    seconds = pd.DataFrame(rows, columns=["variant", "k", "seconds"])
    write_table(seconds, times, units={"seconds": "s"}, config=config)


def descriptor_seconds(problem: Problem, appearance: Mapping) -> dict[str, float]:
    """Time `appearance` and `sharpness` of all observed frames; `appearance` as in the config."""
    images = np.asarray(problem.capture.images[problem.observed])
    kind, weights = appearance["kind"], appearance["weights"]
    return {
        "appearance": timed(lambda: descriptors(images, kind, weights)),
        "sharpness": timed(lambda: sharpness(images)),
    }


def selection_seconds(
    problem: Problem, run: Run, k: int, described: Mapping[str, float]
) -> tuple[float, float]:
    """Return the seconds of the descriptors that a method reads, of those that were `described`,
    and of selecting k frames."""

    def select_once() -> None:
        list(picks_at(problem, run, [k], rng_by_name(0)))

    select_once()  # compiles
    return sum(described[name] for name in run.method.reads), timed(select_once)


def timed(run: Callable[[], object]) -> float:
    """Return the median seconds of up to `REPEATS` runs; of one alone where it takes a second."""
    taken: list[float] = []
    while len(taken) < REPEATS and sum(taken) < ENOUGH:
        started = time.perf_counter()
        run()
        taken.append(time.perf_counter() - started)
    return float(np.median(taken))


def time_quality(
    evaluations: Files,
    variant: Files,
    costs: Files,
    times: Files,
    table: File,
    numbers: File,
    *,
    problems: Sequence[str],
    scenes: Scenes,
    budgets: Sequence[int],
    facts: Mapping,
) -> None:
    """Write PSNR, seconds and memory of ours and its variants at every budget and with all frames.

    `evaluations` are of the sweep's selections; `costs` and `times` are what `measure_costs` wrote.
    """
    swept = sweep_cells(problems, evaluations, facts=facts)
    swept["scene"] = swept["dataset"] + "/" + swept["scene"]
    swept["draw"] = swept["draw"].str.removeprefix("draw").astype(int)
    further = cells_of(scenes, variant, ["psnr"], facts)
    cells = pd.concat([swept, further], ignore_index=True)
    cells = cells[cells["method"].isin([*VARIANTS, ALL])]
    result = joined(cells, cost_means(costs), pd.concat(map(read_table, times)))
    write_csv(result, numbers)
    text = (
        r"\textbf{Quality, runtime and memory per scene}, scenes: "
        f"{result['n'].max():.0f}. Selection: seconds on one thread for the descriptors of "
        "all observed frames that a variant reads and for the selection. Reconstruction (processor "
        "seconds, nothing cached, rendering of all targets included) and its peak memory, measured "
        "in a process of its own on the first draw, are shared by all variants. Last row: the "
        "whole candidate pool. Against it: PSNR of ours, what real captures of other places let "
        "expect with the 90\\% interval (\\texttt{fsel info}), and the share of reconstruction's "
        "seconds. "
        "Bold PSNR: ahead of both other variants, each paired 95\\% interval excluding zero. "
        f"{made_by(facts)}"
    )
    labels = list(VARIANTS.values())
    head = ["$K$", *labels, *labels, "(s)", *labels, "(MB)", "(dB)", "expected", "time"]
    groups = [
        (r"PSNR$\uparrow$", 3),
        (r"Selection time (s)$\downarrow$", 3),
        (r"Recon.$\downarrow$", 1),
        (r"Selec. + recon. (s)$\downarrow$", 3),
        (r"Peak mem.$\downarrow$", 1),
        ("Against all frames", 3),
    ]
    rows = [_row(result, str(k), k) for k in budgets] + [_row(result, "All", ALL_FRAMES)]
    made = plain_table(head, rows, caption=text, label="tab:time_quality", groups=groups)
    write_text(made, table)


def joined(cells: pd.DataFrame, costs: pd.DataFrame, times: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each method and budget: quality, whether it `leads` with all intervals to
    the other variants excluding zero, selection and reconstruction seconds, and n scenes."""
    result = summarise(cells, ["psnr"])
    result = result.rename(columns={"mean": "psnr"}).drop(columns=["dataset", "metric"])
    gaps = differences(cells, list(VARIANTS), ["psnr"])
    gaps = gaps[gaps["reference"].isin(VARIANTS)].assign(sure=gaps["ci_low"] > 0)
    leads = gaps.groupby(["method", "k"])["sure"].all()
    selecting = times.groupby(["variant", "k"])["seconds"].mean()
    keys = list(zip(result["method"], result["k"], strict=True))
    result["leads"] = [bool(leads.get(key, False)) for key in keys]
    result["selection_s"] = [selecting.get(key, 0.0) for key in keys]
    result["reconstruction_s"] = result["k"].map(costs["seconds"])
    every = result[result["k"] == ALL_FRAMES].iloc[0]
    result["against_all"] = result["psnr"] - every["psnr"]
    result["time_share"] = result["reconstruction_s"] / every["reconstruction_s"]
    return result.assign(peak_mb=result["k"].map(costs["peak_mb"]))


def _row(result: pd.DataFrame, title: str, k: int) -> list[str]:
    part = result[result["k"] == k].set_index("method")
    shared = part.iloc[0]
    fit, peak = _printed(shared["reconstruction_s"], 3), _printed(shared["peak_mb"], 0)
    if k == ALL_FRAMES:
        blank = [MISSING] * (len(VARIANTS) - 1)
        quality = [number(shared["psnr"], "psnr"), *blank]
        return [title, *quality, MISSING, *blank, fit, fit, *blank, peak, *[MISSING] * 3]
    variants = [part.loc[name] for name in VARIANTS]
    quality = [bold_if(v["leads"], number(v["psnr"], "psnr")) for v in variants]
    selecting = np.array([v["selection_s"] for v in variants])
    totals = selecting + shared["reconstruction_s"]
    seconds = [[_printed(value, 3) for value in values] for values in (selecting, totals)]
    low, median, high, _ = -losses(shipped(), np.array([k]))[:, 0]
    expected = f"{median:+.1f} ({high:+.1f} to {low:+.1f})"
    against = [f"{variants[0]['against_all']:+.2f}", expected, _printed(shared["time_share"], 2)]
    return [title, *quality, *seconds[0], fit, *seconds[1], peak, *against]


def _printed(value: float, digits: int) -> str:
    """Print a cost; a dash where a reconstruction did not finish."""
    return MISSING if np.isnan(value) else f"{value:.{digits}f}"


TRIALS = Trials(every_draw)
