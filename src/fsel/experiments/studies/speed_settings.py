"""Cost of every setting of the reconstructor, and its worth."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict

import pandas as pd

from fsel.core.files import File, Files
from fsel.evaluation.numbers import write_csv
from fsel.experiments.studies.bench import (
    benches,
    halved,
    measure_cold,
    measure_model,
    measure_splats,
)
from fsel.reconstruct.splats import SplatSettings

logger = logging.getLogger(__name__)

PLANES = (8, 16, 32, 64, 96)
PARTNERS = (1, 2, 3, 4)
OPACITY = (0.0, 0.1, 0.25, 0.4, 0.6)
RESOLUTION = (0.5, 0.75, 1.0, 1.5, 2.0)  # of the configured longer side


def speed_settings(
    folders: Files,
    splits: Files,
    numbers: File,
    *,
    generated: Sequence[Mapping | None],
    k: int,
    reconstruction: Mapping,
) -> None:
    """Measure the reconstructor with one setting changed at a time.

    Args:
        numbers: receives setting, value, default, and means over the problems of what
            `bench.measure_cold` returns, `seconds` being fit and rendering together.
        generated: see `bench.benches`.
        k: frames reconstructed from.
    """
    rows = []
    for place in benches(folders, splits, generated, k, reconstruction):
        usual, model = measure_splats(place, reconstruction)
        for setting, value, default, changes in settings_of(reconstruction, place.capture.size):
            cost = usual if default else measure_cold(place, reconstruction, **changes)[0]
            rows.append({"setting": setting, "value": value, "default": default, **cost})
        rounded = {"setting": "precision", "value": "float16", "default": False}
        rows.append(rounded | usual | measure_model(place, halved(model)))
        logger.info("%r: %d settings", place.capture, len(rows))
    table = pd.DataFrame(rows)
    table["seconds"] = table.pop("fit_seconds") + table.pop("render_seconds")
    means = table.groupby(["setting", "value", "default"], sort=False).mean().reset_index()
    write_csv(means, numbers)


def settings_of(
    reconstruction: Mapping, size: tuple[int, int]
) -> Iterator[tuple[str, str, bool, dict]]:
    """(setting, printed value, whether it is the default, changes).

    Args:
        size: (width, height) of the stored images, which no variant enlarges.
    """
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
