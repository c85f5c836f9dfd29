"""Study of modelling only what a scene needs: what it removes, and what it costs."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, write_text
from fsel.evaluation.latex import MISSING, plain_table
from fsel.evaluation.summary import write_csv
from fsel.experiments.studies.bench import (
    BenchCase,
    benches,
    measure_cold,
    measure_model,
    measure_splats,
)
from fsel.experiments.studies.selection_time import descriptor_seconds, timed
from fsel.features.appearance import descriptors
from fsel.reconstruct.splats import SplatSettings

logger = logging.getLogger(__name__)

SAVINGS = {
    "planes": "planes from one pixel of disparity",
    "opacity": "splats only where opaque",
    "views": "splats only where a requested view sees them",
    "view": "the same, one view being requested",
    "descriptors": "descriptors only for methods that read them",
}
COSTS = ("primitives", "bytes", "seconds", "psnr")


def economy(
    folders: Files,
    splits: Files,
    table: File,
    numbers: File,
    *,
    generated: Sequence[Mapping | None],
    k: int,
    reconstruction: Mapping,
    appearance: Mapping,
) -> None:
    """Switch off each saving in turn and tabulate means over the problems with and without it."""
    rows = []
    for place in benches(folders, splits, generated, k, reconstruction):
        rows += _of_reconstruction(place, reconstruction)
        rows.append(_of_descriptors(place.capture, appearance))
        logger.info("%r: %d savings", place.capture, len(SAVINGS))
    means = pd.DataFrame(rows).groupby("saving", sort=False).mean().reset_index()
    write_csv(means, numbers)
    write_text(_table(means, k), table)


def _of_reconstruction(place: BenchCase, reconstruction: Mapping) -> list[dict]:
    """Planes, opacity and views; the default has the first two."""
    most = asdict(SplatSettings(**reconstruction["settings"]))["planes"][1]
    usual, model = measure_splats(place, reconstruction)
    every, _ = measure_cold(place, reconstruction, planes=(most, most))
    clear, _ = measure_cold(place, reconstruction, opacity=0.0)
    rows = [_row("planes", usual, every), _row("opacity", usual, clear)]
    single = replace(place, views=place.views.subset(slice(1)), truth=place.truth[:1], depth=None)
    for saving, few in (("views", place), ("view", single)):
        fitted = {"fit_seconds": usual["fit_seconds"]}
        culled = {"fit_seconds": usual["fit_seconds"] + timed(partial(model.seen_by, few.views))}
        whole, part = measure_model(few, model), measure_model(few, model.seen_by(few.views))
        rows.append(_row(saving, culled | part, fitted | whole))
    return rows


def _of_descriptors(capture: Capture, appearance: Mapping) -> dict:
    """A method that reads sharpness alone does without the appearance of every frame."""
    images = np.asarray(capture.images)
    seconds = descriptor_seconds(images, appearance)
    described = descriptors(images, appearance["kind"], appearance["weights"])
    few = {"bytes": 8 * len(images), "seconds": seconds["sharpness"]}
    both = {"bytes": few["bytes"] + described.nbytes, "seconds": sum(seconds.values())}
    return _row("descriptors", few, both)


def _row(saving: str, with_it: Mapping, without: Mapping) -> dict:
    row = {"saving": saving}
    for side, cost in (("with", with_it), ("without", without)):
        if "fit_seconds" in cost:
            cost = {**cost, "seconds": cost["fit_seconds"] + cost["render_seconds"]}
        row |= {f"{side}_{name}": cost.get(name, np.nan) for name in COSTS}
    return row


def _table(means: pd.DataFrame, k: int) -> str:
    rows = []
    for row in means.to_dict("records"):
        cells = [SAVINGS[row["saving"]]]
        for name, unit in (("primitives", 1), ("bytes", 1e-3), ("seconds", 1e3)):
            with_it, without = row[f"with_{name}"], row[f"without_{name}"]
            known = np.isfinite(with_it)
            cells.append(f"{unit * without:,.0f} / {unit * with_it:,.0f}" if known else MISSING)
        cost = row["without_psnr"] - row["with_psnr"]
        # what a method does not read cannot change what it picks
        cells.append(f"{round(cost, 2) + 0.0:+.2f}" if np.isfinite(cost) else "none")
        rows.append(cells)
    return plain_table(
        ["Saving", "splats", "kB", "ms", "PSNR lost (dB)"],
        rows,
        caption=r"\textbf{Modelling only what a scene needs.} Each saving switched off / on, the "
        rf"others as by default; negative: the saving gains. {k} frames, nothing cached, one "
        "thread, means over scenes. Descriptors: of a whole capture, for a method that reads "
        "sharpness alone.",
        label="tab:economy",
    )
