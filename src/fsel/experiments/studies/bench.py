"""Cost of a setting of the reconstructor with nothing cached, and its worth against exact depth."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import PurePath
from typing import Any

import numpy as np
import pandas as pd

from fsel.core.capture import Capture, Views
from fsel.core.files import File, Files
from fsel.core.geometry import camera_centers, pixel_rays
from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.evaluation.summary import write_csv
from fsel.metrics import score_views
from fsel.reconstruct import RECONSTRUCTORS, Model
from fsel.reconstruct.splats import SplatModel, SplatSettings
from fsel.selectors.baselines.nearest import nearest
from fsel.synthetic.record import clear_shot
from fsel.synthetic.sensor import exact_depth

logger = logging.getLogger(__name__)

MISPLACED = 0.01  # of the cameras' spread, beyond which a capture is of another recording
PLANES = (8, 16, 32, 64, 96)
PARTNERS = (1, 2, 3, 4)
OPACITY = (0.0, 0.1, 0.25, 0.4, 0.6)
RESOLUTION = (0.5, 0.75, 1.0, 1.5, 2.0)  # of the configured longer side
REPEATS = 3  # the least of three times: other work on the machine only adds


@dataclass(frozen=True)
class BenchCase:
    """A capture, frames to reconstruct it from, and views to compare it at.

    Attributes:
        picks: (K,) int64 frames to reconstruct from.
        views: T held-out targets at the size of comparison.
        truth: (T, h, w, 3) uint8 their images.
        depth: (T, h, w) float64 their exact depth, 0 where none; None for real captures.
    """

    capture: Capture
    picks: np.ndarray
    views: Views
    truth: np.ndarray
    depth: np.ndarray | None


def benches(
    folders: Files,
    splits: Files,
    generated: Sequence[Mapping | None],
    k: int,
    reconstruction: Mapping,
) -> Iterator[BenchCase]:
    """Yield the frames nearest to each draw's proxies, compared at its targets, all compiled;
    `generated` are keywords of `true_depth`, None where depth is not known."""
    for folder, split, made in zip(folders, splits, generated, strict=True):
        posed, targets = Problem.load(folder, split), Split.load(split).targets
        small = posed.capture.resized(reconstruction["long_side"])
        bench = BenchCase(
            capture=posed.capture,
            picks=np.sort(nearest(posed, posed.observed, k)),
            views=small.view(targets),
            truth=np.asarray(small.images[targets]),
            depth=None if made is None else true_depth(small, targets, **made),
        )
        measure_cold(bench, reconstruction)  # compiles
        yield bench


def measure_cold(
    bench: BenchCase, reconstruction: Mapping, **changes: Any
) -> tuple[dict[str, float], Model]:
    """Reconstruct with nothing cached, with changed settings or `long_side`; return psnr in dB,
    depth_error, fit_seconds, render_seconds, primitives and bytes, and the model."""
    long_side = changes.pop("long_side", reconstruction["long_side"])
    settings = {**reconstruction["settings"], **changes}
    capture = bench.capture.resized(long_side)
    factory = RECONSTRUCTORS[reconstruction["name"]]
    models = [factory(capture, **settings).fit(bench.picks) for _ in range(REPEATS)]
    seconds = min(model.seconds for model in models)
    return {"fit_seconds": seconds, **measure_model(bench, models[0])}, models[0]


def measure_model(bench: BenchCase, model: Model) -> dict[str, float]:
    """Measure as `measure_cold` for a model, without the fit's seconds."""
    taken = []
    for _ in range(REPEATS):
        started = time.perf_counter()
        rendered = model.render(bench.views)
        taken.append(time.perf_counter() - started)
    return {
        "psnr": float(score_views(rendered, bench.truth)[:, 0].mean()),
        "depth_error": depth_error(model, bench),
        "render_seconds": min(taken),
        "primitives": model.primitives,
        "bytes": model.bytes,
    }


def depth_error(model: Model, bench: BenchCase) -> float:
    """Compute the median of |depth / exact depth - 1| without sky; NaN where either is unknown."""
    if bench.depth is None or not isinstance(model, SplatModel):
        return float("nan")
    seen = bench.depth > 0
    inverse = rendered_inverse_depth(model, bench.views)[seen]
    return float(np.median(np.abs(1 / (inverse * bench.depth[seen]) - 1)))


def rendered_inverse_depth(model: SplatModel, views: Views) -> np.ndarray:
    """Render (T, h, w) inverse depth: every splat is painted with its own."""
    shown = model.painted(views, lambda z: np.clip(model.near / np.maximum(z, model.near), 0, 1))
    inverse = (shown / (model.near * model.frame.unit)).astype(np.float64)
    return np.maximum(inverse, np.finfo(np.float32).tiny)


def true_depth(
    capture: Capture, frames: np.ndarray, *, family: str, seed: int, recorded: int
) -> np.ndarray:
    """Cast the exact depth of (T,) frames anew: the capture's layout may not keep it.

    Returns (T, h, w) distances along the optical axis in the capture's units, 0 for sky; ValueError
    for a capture of another recording.
    """
    shot, caster, _ = clear_shot(family, seed, recorded)
    rows = {name: i for i, name in enumerate(shot.names)}
    stems = [str(PurePath(name).with_suffix("")) for name in capture.names]
    unknown = [name for name in stems if name not in rows]
    if unknown:
        raise ValueError(
            f"{capture.source}: frame {unknown[0]!r} is none of the {family} recording's, which "
            f"are like {shot.names[0]!r}. Hint: was the capture generated with another config?"
        )
    poses = shot.poses(np.zeros(recorded))[[rows[name] for name in stems]]
    unit = _unit_of(capture, camera_centers(poses))
    width, height = capture.size
    depth = np.empty((len(frames), height, width))
    for t, frame in enumerate(frames):
        rays = pixel_rays(capture.intrinsics[frame], width, height).reshape(-1, 3)
        depth[t] = exact_depth(caster, poses[[frame]], rays).reshape(height, width)
    return unit * depth


def _unit_of(capture: Capture, centers: np.ndarray) -> float:
    """World units a metre: structure from motion has its own, which the cameras' spread tells."""
    given, true = (
        np.linalg.norm(points - points.mean(axis=0), axis=1)
        for points in (capture.centers, centers)
    )
    unit = np.linalg.norm(given) / np.linalg.norm(true)
    off = np.abs(given - unit * true).max() / given.max()
    if off > MISPLACED:
        raise ValueError(
            f"{capture.source}: cameras are {off:.0%} of their spread from where the recording "
            "has them. Hint: the capture was generated by another version; generate it again"
        )
    return float(unit)


def speed_settings(
    folders: Files,
    splits: Files,
    numbers: File,
    *,
    generated: Sequence[Mapping | None],
    k: int,
    reconstruction: Mapping,
) -> None:
    """Measure the reconstructor with one setting changed at a time, means over the problems."""
    rows = []
    for place in benches(folders, splits, generated, k, reconstruction):
        usual, model = measure_cold(place, reconstruction)
        if not isinstance(model, SplatModel):
            raise TypeError(
                f"reconstructor {reconstruction['name']!r}: this study changes settings of "
                "`splats`. Hint: name `splats` first in `reconstruction`"
            )
        for setting, value, default, changes in settings_of(reconstruction, place.capture.size):
            cost = usual if default else measure_cold(place, reconstruction, **changes)[0]
            rows.append({"setting": setting, "value": value, "default": default, **cost})
        rounded = {"setting": "precision", "value": "float16", "default": False}
        halved = replace(model, splats=model.splats.astype(np.float16).astype(np.float32))
        rows.append(rounded | usual | measure_model(place, halved))
        logger.info("%r: %d settings", place.capture, len(rows))
    table = pd.DataFrame(rows)
    table["seconds"] = table.pop("fit_seconds") + table.pop("render_seconds")
    means = table.groupby(["setting", "value", "default"], sort=False).mean().reset_index()
    write_csv(means, numbers)


def settings_of(
    reconstruction: Mapping, size: tuple[int, int]
) -> Iterator[tuple[str, str, bool, dict]]:
    """(setting, printed value, whether it is the default, changes); no side is above the size's."""
    usual = asdict(SplatSettings(**reconstruction["settings"]))
    least, most = usual["planes"]
    for count in PLANES:
        yield "planes", str(count), False, {"planes": (count, count)}
    yield "planes", f"{least}-{most}", True, {}
    for setting, values in (("partners", PARTNERS), ("opacity", OPACITY)):
        for value in sorted({*values, usual[setting]}):
            yield setting, f"{value:g}", value == usual[setting], {setting: value}
    for share in RESOLUTION:
        side = round(share * reconstruction["long_side"])
        if side <= max(size):
            yield "resolution", str(side), share == 1, {"long_side": side}
    yield "precision", "float32", True, {}
