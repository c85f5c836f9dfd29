"""Targets from one pass of a room, frames from its other passes (paper, Table 1)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from fsel.core.capture import Capture
from fsel.core.files import File, Files, write_text
from fsel.core.geometry import pose_distance
from fsel.core.names import name_seed
from fsel.core.split import Split
from fsel.evaluation.latex import made_by, plain_table
from fsel.evaluation.measuring import RngFactory
from fsel.evaluation.summary import write_csv
from fsel.evaluation.sweep import LABELS, LEARNED
from fsel.experiments.scheme import ExperimentCase, Scenes, Trials, cells_of, led_rows, with_leads
from fsel.metrics import Metrics, headings

BASELINES = ("random", "uniform", "fvs", "nerf_director", "dpp", "kmedoids", "cover")
SHOWN = {name: LABELS[name] for name in (*BASELINES, *LEARNED)}
ROOMS = "crosscapture"  # one set of measurements whatever the dataset: each room counts once


def cross_split(
    capture: Capture,
    held_out: str,
    *,
    others: Sequence[str] = (),
    targets: int | None = None,
    rng: np.random.Generator | None = None,
) -> Split:
    """Draw targets from the half of a held-out pass that is nearest to the other passes, proxies
    and candidates from those.

    Each target takes one distinct proxy, minimising the summed distance. No frame of `others` is
    selected; `targets` None takes all of the half. ValueError for a pass with too few frames.
    """
    of = np.array(capture.sequences)
    away = np.flatnonzero(of == held_out)
    rest = np.flatnonzero(~np.isin(of, [held_out, *others]))
    half = max(1, len(away) // 2)
    count = half if targets is None else targets
    if len(rest) <= count or half < count:
        raise ValueError(
            f"{capture.source}: {len(rest)} frames outside {held_out!r} and {half} in the half of "
            f"it that targets come from, for {count} targets. Hint: a cross-capture scene needs "
            "two or more passes"
        )
    centers, axes = capture.centers, capture.axes
    cost = pose_distance(centers[away], axes[away], centers[rest], axes[rest])
    near = np.argsort(cost.min(axis=1), kind="stable")[:half]
    chosen = np.sort(near if rng is None else rng.choice(near, count, replace=False))
    _, match = linear_sum_assignment(cost[chosen])
    proxies = rest[match]
    candidates = np.setdiff1d(rest, proxies)
    return Split(away[chosen], proxies, candidates, candidates)


def thinned(sequences: Sequence[str], every: int) -> np.ndarray:
    """Sample each pass uniformly, its first frame included: (n,) int64 in capture order."""
    of = np.array(sequences)
    return np.sort(np.concatenate([np.flatnonzero(of == s)[::every] for s in dict.fromkeys(of)]))


def trials(
    whole: Capture,
    *,
    held_out: Sequence[str],
    every: int,
    targets: int | None,
    draws: int,
    budgets: Sequence[int],
    seed: int,
) -> Iterator[ExperimentCase]:
    """Yield the trials of a room: every held-out pass, and every draw of targets where drawn.

    Of none of the `held_out` passes may frames be selected; without any, each pass is held out in
    turn. `targets` None takes all of the nearer half, in one draw.
    """
    kept = thinned(whole.sequences, every)
    capture = whole.subset(kept)
    present = list(dict.fromkeys(capture.sequences))
    if unknown := [name for name in held_out if name not in present]:
        raise ValueError(
            f"{capture.source}: crosscapture.held_out has {unknown}; its passes are {present}"
        )
    for name in held_out or present:
        for draw in range(1 if targets is None else draws):
            rng = None
            if targets is not None:
                rng = np.random.default_rng([seed, 3, name_seed(name), draw])
            split = cross_split(capture, name, others=held_out, targets=targets, rng=rng)
            key, rng_of = {"held_out": name, "draw": draw}, _rng_of_pass(seed, name, draw)
            yield ExperimentCase(key, capture, split, budgets, rng_of, frames=kept)


def _rng_of_pass(seed: int, held_out: str, draw: int) -> RngFactory:
    key = name_seed(held_out)
    return lambda run, k: np.random.default_rng([seed, run.seed, key, k, draw])


def crosscapture(
    evaluations: Files,
    table: File,
    numbers: File,
    *,
    scenes: Scenes,
    budgets: Sequence[int],
    metrics: Metrics,
    facts: Mapping,
) -> None:
    """Write the table "Cross-capture novel view synthesis"; passes of a room are one place to the
    intervals."""
    cells = cells_of(scenes, evaluations, metrics, facts, ["held_out", "draw"])
    cells = cells.assign(dataset=ROOMS, scene=cells["scene"] + "/" + cells["held_out"])
    means = with_leads(cells, list(SHOWN), metrics)
    write_csv(means.drop(columns="dataset"), numbers)
    text = (
        r"\textbf{Cross-capture novel view synthesis.} Targets come from the half of one held-out "
        "pass of a room that is nearest to its other passes; candidates and proxies come from "
        f"those. {cells['scene'].nunique()} pairs of room and held-out pass, averaged within each "
        f"of {means['n'].max()} rooms, then over rooms. Bold: ahead of every other row, each "
        f"paired 95\\% interval over rooms excluding zero. {made_by(facts)}"
    )
    head = ["Method", *headings(metrics) * len(budgets)]
    rows = led_rows(means, SHOWN, [(ROOMS, k) for k in budgets], metrics)
    groups = [(f"$K{{=}}{k}$", len(metrics)) for k in budgets]
    made = plain_table(head, rows, caption=text, label="tab:crossvideowopt", groups=groups)
    write_text(made, table)


TRIALS = Trials(trials, methods=BASELINES)
