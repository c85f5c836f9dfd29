"""Views of one capture rendered from other captures of the place (paper, `fig:real_world`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from fsel.data.capture import Capture
from fsel.experiments.paper.pictures import draw_views, frames_named, resolved
from fsel.experiments.paper.qualitative import picks_of
from fsel.report.captions import note
from fsel.utils.files import read_table


def real_world(
    folder: str | Path,
    selected_from: str | Path,
    picks: str | Path,
    evaluation: str | Path,
    figures: Sequence[str | Path],
    numbers: str | Path,
    *,
    methods: Sequence[str],
    views: int,
    k: int,
    reconstruction: Mapping,
    facts: Mapping,
) -> None:
    """Targets of the first sequence, rendered from what methods picked among the others.

    Args:
        folder: a canonical capture of several sequences with images large enough.
        selected_from: frames.parquet of the capture that was selected from; names connect the two.
        picks: what `crosscapture.select_crosscapture` wrote.
        evaluation: what `crosscapture.evaluate_crosscapture` wrote.
        figures: paths; their endings choose the format.
        numbers: see `pictures.draw_views`.
        methods, views, k, reconstruction, facts: as in `qualitative.qualitative`; `all` is every
            frame of the other sequences.
    """
    capture = Capture.load(folder)
    every = read_table(evaluation).query("draw == 0")
    passes = set(every["held_out"])
    held_out = next(name for name in capture.sequences if name in passes)
    measured = every.query("held_out == @held_out")
    names = read_table(selected_from)["name"]
    targets = frames_named(capture, names[np.unique(measured["target"])].tolist())
    picked = read_table(picks).query("held_out == @held_out and draw == 0 and seed == 0")
    # of a sequence split, no held-out pass is selected from
    rest = set(capture.sequences) - passes or set(capture.sequences) - {held_out}
    others = np.flatnonzero(np.isin(capture.sequences, list(rest)))
    chosen = {
        method: others if method == "all" else frames_named(capture, picks_of(picked, method, k))
        for method in resolved(methods, measured, k)
    }
    draw_views(
        capture,
        chosen,
        targets,
        figures,
        numbers,
        views=views,
        reconstruction=reconstruction,
        note=f"Views of {held_out}, frames of {len(rest)} other captures of it. {note(facts)}",
    )
