"""What selections look like: rendered targets of several methods, and their cameras."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.baselines import METHODS
from fsel.capture import Capture
from fsel.metrics import METRICS, score_views
from fsel.reconstruct import reconstructor_of
from fsel.report.captions import note
from fsel.report.numbers import write_csv
from fsel.report.plan import plan_positions
from fsel.report.views import Shown, draw
from fsel.selector.policies import POLICIES
from fsel.split import Split

LABELS = {name: method.label for name, method in {**METHODS, **POLICIES}.items()}
WARM = 4  # frames of a reconstruction that only compiles


def qualitative(
    folder: str | Path,
    split: str | Path,
    selections: str | Path,
    figures: Sequence[str | Path],
    numbers: str | Path,
    *,
    methods: Sequence[str],
    views: int,
    k: int,
    reconstruction: Mapping,
    facts: Mapping,
) -> None:
    """Held-out views rendered from each method's selection, its cameras from above below them.

    Args:
        folder: a canonical capture.
        split: split.parquet of the draw.
        selections: what `fsel.stages.select` wrote for it.
        figures: paths; their endings choose the format.
        numbers: receives method, k, role (`target` or `selected`), frame, x, y in world units and,
            of targets, the metrics; of each method, the seconds of its reconstruction and of
            rendering all targets.
        methods: columns, in order; the first training or random seed of each is shown.
        views: targets drawn, evenly spaced in capture order.
        k: frames; `all` takes its own number.
        reconstruction: the config's section.
        facts: see `captions.note`.
    """
    capture = Capture.load(folder)
    targets = Split.load(split).targets
    drawn = np.linspace(0, len(targets) - 1, min(views, len(targets))).round().astype(int)
    reconstructor_of(capture, reconstruction).fit(targets[:WARM]).render(capture.view(targets))
    picked, places = pd.read_parquet(selections).query("seed == 0"), plan_positions(capture)
    columns, tables = [], []
    for method in methods:
        frames = picks_of(picked, method, k)
        rendered, scores, seconds = render_cold(capture, frames, targets, reconstruction)
        cost = f"{len(frames)} frames, {seconds:.2f} s"
        title = f"{LABELS[method]}\n{cost}\n{scores[:, 0].mean():.2f} dB"
        columns.append(Shown(title, rendered[drawn], scores[drawn, 0], frames))
        tables.append(_table(method, frames, targets, scores, seconds, places))
    write_csv(pd.concat(tables), numbers)
    small = capture.resized(reconstruction["long_side"])
    truth = np.asarray(small.images[targets[drawn]])
    text = (
        f"{Path(folder).name}; heading: frames, seconds to reconstruct and render "
        f"{len(targets)} targets, their mean PSNR; {note(facts)}"
    )
    draw(truth, columns, places, targets, figures, text)


def picks_of(picked: pd.DataFrame, method: str, k: int) -> np.ndarray:
    """(K,) frames of a method at a budget; of one that takes every frame, all of them.

    Args:
        picked: method, k, order, frame of one seed.
        method, k: which.
    """
    part = picked[picked["method"] == method]
    part = part if method == "all" else part[part["k"] == k]
    return part.sort_values("order")["frame"].to_numpy(np.int64)


def render_cold(
    capture: Capture, frames: np.ndarray, targets: np.ndarray, reconstruction: Mapping
) -> tuple[np.ndarray, np.ndarray, float]:
    """Targets rendered from frames by a reconstructor that has cached nothing yet.

    Args:
        capture: the capture.
        frames: (K,) to reconstruct from.
        targets: (T,) to render.
        reconstruction: the config's section.

    Returns:
        (T, h, w, 3) float32 views, (T, 3) metrics as `METRICS`, and the seconds of fitting and
        rendering.
    """
    reconstructor = reconstructor_of(capture, reconstruction)
    views = reconstructor.capture.view(targets)
    started = time.perf_counter()
    rendered = reconstructor.fit(np.sort(frames)).render(views)
    seconds = time.perf_counter() - started
    truth = np.asarray(reconstructor.capture.images[targets])
    return rendered, score_views(rendered, truth), seconds


def _table(method, frames, targets, scores, seconds, places) -> pd.DataFrame:
    selected = pd.DataFrame({"role": "selected", "frame": frames})
    held_out = pd.DataFrame({"role": "target", "frame": targets})
    held_out[list(METRICS)] = scores
    table = pd.concat([held_out, selected], ignore_index=True)
    table[["x", "y"]] = places[table["frame"]]
    head = {"method": method, "k": len(frames), "seconds": seconds}
    columns = [*head, "role", "frame", "x", "y", *METRICS]
    return table.assign(**head)[columns]
