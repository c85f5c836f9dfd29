"""Time that every method takes to select."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation, Slerp

from fsel.captures.images.previews import sharpness
from fsel.core.capture import Capture
from fsel.core.files import File, Files, write_text
from fsel.core.geometry import poses_at
from fsel.core.problem import Problem
from fsel.core.split import evaluation_split
from fsel.evaluation.latex import plain_table, tex
from fsel.evaluation.measuring import Run, learned_runs, picks_at, rng_by_name
from fsel.evaluation.summary import write_csv
from fsel.evaluation.sweep import BASELINES, LABELS
from fsel.features.appearance import descriptors
from fsel.selectors.baselines import METHODS

logger = logging.getLogger(__name__)

ENOUGH = 1.0  # seconds of measured runs after which a method is not run again
REPEATS = 5


class _Repeated:
    """Images of frames that are shown more than once, without copies."""

    dtype, ndim = np.dtype(np.uint8), 4

    def __init__(self, images: np.ndarray, index: np.ndarray) -> None:
        self._images, self._index = images, index
        self.shape = (len(index), *images.shape[1:])

    def __len__(self) -> int:
        return len(self._index)

    def __getitem__(self, frames) -> np.ndarray:
        return np.asarray(self._images[self._index[frames]])


def refilmed(capture: Capture, frames: int) -> tuple[Capture, np.ndarray]:
    """Resample the path of a capture of one pass; return (frames,) the old frame of each too.

    Poses are interpolated between frames; each new frame has the image and the tracks of the
    nearest old one.
    """
    when = np.linspace(0, len(capture) - 1, frames)
    nearest, before = np.round(when).astype(np.int64), np.floor(when).astype(np.int64)
    after = np.minimum(before + 1, len(capture) - 1)
    share = (when - before)[:, None]
    centers = (1 - share) * capture.centers[before] + share * capture.centers[after]
    turns = Rotation.from_matrix(capture.world_to_camera[:, :, :3])
    rotations = Slerp(np.arange(len(capture)), turns)(when).as_matrix()
    points = capture.points
    if points is not None:
        tracks = pd.DataFrame({"old": points.track_frame, "track_point": points.track_point})
        seen = pd.DataFrame({"old": nearest, "track_frame": range(frames)}).merge(tracks, on="old")
        columns = ("track_point", "track_frame")
        points = replace(points, **{name: seen[name].to_numpy() for name in columns})
    dense = replace(
        capture,
        names=tuple(f"{i:06d}" for i in range(frames)),
        world_to_camera=poses_at(centers, rotations),
        intrinsics=capture.intrinsics[nearest],
        images=cast(np.ndarray, _Repeated(capture.images, nearest)),
        sequences=tuple(capture.sequences[i] for i in nearest),
        points=points,
        masks=None,
    )
    return dense, nearest


def problem_of_size(
    capture: Capture, described: np.ndarray, sharp: np.ndarray, pool: int, targets: int
) -> Problem:
    """Make a problem with `pool` observed frames on a resampled capture, and so many targets.

    `described` are (N, D) descriptors of the capture's frames, `sharp` (N,) their sharpness.
    """
    dense, old = refilmed(capture, pool + targets)
    split = evaluation_split(dense, 0, 0, targets=targets)
    return Problem(
        capture=dense,
        candidates=split.candidates,
        proxies=split.proxies,
        targets=dense.view(split.targets),
        descriptors=described[old],
        sharpness=sharp[old],
    )


def timed(run: Callable[[], object], repeats: int = REPEATS) -> float:
    """Return the median seconds of up to `repeats` runs; of one alone where it takes a second."""
    taken: list[float] = []
    while len(taken) < repeats and sum(taken) < ENOUGH:
        started = time.perf_counter()
        run()
        taken.append(time.perf_counter() - started)
    return float(np.median(taken))


def selection_time(
    folder: File,
    weights: Files,
    table: File,
    numbers: File,
    *,
    pools: Sequence[int],
    k: int,
    targets: int,
    appearance: Mapping,
) -> None:
    """Time every method over pools of several sizes, descriptors apart.

    Args:
        folder: a canonical capture, refilmed at other frame rates to make the pools.
        weights: scorers of the learned methods; the first of each is timed.
        table, numbers: receive LaTeX, and method, k, pool, descriptors, selection in seconds.
    """
    capture = Capture.load(folder)
    images = np.asarray(capture.images)
    described = descriptors(images, appearance["kind"], appearance["weights"])
    sharp = sharpness(images)
    a_frame = descriptor_seconds(images, appearance)
    problems = [problem_of_size(capture, described, sharp, pool, targets) for pool in sorted(pools)]
    learned = [run for run in learned_runs(weights) if run.seed == 0]
    contenders = [*(Run(METHODS[name], 0) for name in BASELINES), *learned]  # not `all`
    rows = []
    for pool, problem in zip(sorted(pools), problems, strict=True):
        for run in contenders:
            select_once(problems[0], run, k)  # compiles
            seconds = timed(partial(select_once, problem, run, k))
            share = pool / len(capture)
            before = share * sum(a_frame[name] for name in run.method.reads)
            rows.append((run.method.name, k, pool, before, seconds))
            logger.info("%s of %d: %.4f + %.4f s", run.method.name, pool, before, seconds)
    result = pd.DataFrame(rows, columns=["method", "k", "pool", "descriptors", "selection"])
    write_csv(result, numbers)
    write_text(_time_table(result, targets, appearance["kind"]), table)


def descriptor_seconds(images: np.ndarray, appearance: Mapping) -> dict[str, float]:
    """Seconds that the descriptors of (N, h, w, 3) images take: `appearance` and `sharpness`."""
    kind, weights = appearance["kind"], appearance["weights"]
    return {
        "appearance": timed(lambda: descriptors(images, kind, weights)),
        "sharpness": timed(lambda: sharpness(images)),
    }


def select_once(problem: Problem, run: Run, k: int) -> np.ndarray:
    """Select k frames anew: (k,) int64."""
    (picks,) = picks_at(problem, run, [k], rng_by_name(0))
    return picks.frames


def _time_table(result: pd.DataFrame, targets: int, kind: str) -> str:
    pools, k = result["pool"].unique().tolist(), result["k"].iloc[0]
    cells = result.set_index(["method", "pool"])[["descriptors", "selection"]]
    rows = [
        [LABELS[method], *(_milliseconds(*cells.loc[(method, pool)]) for pool in pools)]
        for method in result["method"].unique()
    ]
    return plain_table(
        ["Selection", *(f"{pool:,} frames" for pool in pools)],
        rows,
        caption=rf"\textbf{{Selection time}} in milliseconds on one thread, $K={k}$, {targets} "
        f"targets: where a method reads them, descriptors of the whole pool ({tex(kind)}, "
        "sharpness) plus the selection itself. FisherRF and COVER count the reconstructions that "
        "they make. Pools are one evaluation capture, its path refilmed at other frame rates.",
        label="tab:selection_time",
    )


def _milliseconds(*seconds: float) -> str:
    """The parts that are not zero, two significant digits each."""
    parts = [1e3 * value for value in seconds if value > 0]
    return " + ".join(f"{part:,.{max(0, 1 - int(np.floor(np.log10(part))))}f}" for part in parts)
