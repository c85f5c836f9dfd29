"""Cost of a reconstructor: seconds to load, to fit a subset and to render a view, and memory."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fsel.core.capture import Capture
from fsel.reconstruct import reconstructor_of

FITS = 3  # after the first, of which the median is taken


@dataclass(frozen=True)
class Cost:
    """Seconds by the clock.

    Attributes:
        load: the first fit beyond later ones: a program's start, weights, compilation.
        fit: of a subset.
        render: of a view.
        peak_bytes: the most memory that a fit took, as its model states it.
        device: of that memory.
    """

    load: float
    fit: float
    render: float
    peak_bytes: int
    device: str

    @property
    def section(self) -> dict[str, float]:
        """The key `cost` of a reconstructor in the configuration, to two digits."""
        return {key: float(f"{getattr(self, key):.2g}") for key in ("load", "fit", "render")}


def measured_cost(capture: Capture, reconstruction: Mapping[str, Any], k: int, views: int) -> Cost:
    """The cost of a configured reconstructor on a capture.

    Args:
        capture: with k + views frames or more; the first are rendered, the others reconstructed
            from.
        reconstruction: the config's section: name, long_side, settings.
        k: frames of a subset.
        views: rendered from each.

    Raises:
        ValueError: for a capture with fewer frames.
        Unfinished: when a reconstruction does not finish.
    """
    if len(capture) < k + views + FITS:
        raise ValueError(f"{len(capture)} frames; {k} and {views} views need {k + views + FITS}")
    reconstructor = reconstructor_of(capture, reconstruction)
    seen = reconstructor.capture.view(np.arange(views))
    fits, renders, peaks = [], [], []
    for at in range(FITS + 1):
        started = time.perf_counter()
        model = reconstructor.fit(np.arange(views + at, views + at + k))
        fitted = time.perf_counter()
        model.render(seen)
        fits.append(fitted - started)
        renders.append((time.perf_counter() - fitted) / views)
        peaks.append(model.peak_bytes)
    fit, render = float(np.median(fits[1:])), float(np.median(renders[1:]))
    return Cost(max(fits[0] - fit, 0.0), fit, render, max(peaks), model.device)
