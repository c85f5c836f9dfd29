"""Figures of views: of each dataset, of the full sequence, and of one capture from others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table
from fsel.evaluation.latex import note
from fsel.experiments.paper.pictures import VIEWED, draw_views
from fsel.selection.frames import frames_of


def qualitative(
    folder: File,
    split: File,
    selections: File,
    evaluations: Files,
    figures: Files,
    numbers: File,
    *,
    facts: Mapping,
    views: int,
    k: int,
    reconstruction: Mapping,
    methods: Sequence[str] = VIEWED,
) -> None:
    """Draw held-out views rendered from each method's first seed, and its cameras from above;
    `folder` has images large enough, the other arguments are of `pictures.draw_views`."""
    capture, roles = Capture.load(folder), read_table(split)
    targets = frames_of(capture, roles[roles["role"] == "target"]["name"].tolist())
    evaluation = pd.concat([read_table(path) for path in evaluations])
    picked = read_table(selections).query("seed == 0")
    shown: dict[str, Any] = {"k": k, "views": views, "methods": methods}
    shown |= {"reconstruction": reconstruction, "note": note(facts)}
    draw_views(capture, picked, evaluation, targets, figures, numbers, **shown)


def real_world(
    folder: File,
    selected_from: File,
    picks: File,
    evaluation: File,
    figures: Files,
    numbers: File,
    *,
    facts: Mapping,
    views: int,
    k: int,
    reconstruction: Mapping,
    methods: Sequence[str] = VIEWED,
) -> None:
    """Draw targets of the first sequence, rendered from what methods picked among the others.

    Names connect `folder`, whose images are large enough, with `selected_from`, the frames.parquet
    of the capture selected from; `picks` and `evaluation` are of `crosscapture.TRIALS`.
    """
    capture = Capture.load(folder)
    every = read_table(evaluation).query("draw == 0")
    passes = set(every["held_out"])
    held_out = next(name for name in capture.sequences if name in passes)
    measured = every.query("held_out == @held_out")
    names = read_table(selected_from)["name"]
    targets = frames_of(capture, names[np.unique(measured["target"])].tolist())
    # of a sequence split, no held-out pass is selected from
    rest = set(capture.sequences) - passes or set(capture.sequences) - {held_out}
    others = [n for n, of in zip(capture.names, capture.sequences, strict=True) if of in rest]
    picked = read_table(picks).query("held_out == @held_out and draw == 0 and seed == 0")
    all_others = pd.DataFrame({"method": "all", "name": others, "order": range(len(others))})
    picked = pd.concat([picked, all_others])
    text = f"Views of {held_out}, frames of {len(rest)} other captures of it. {note(facts)}"
    shown: dict[str, Any] = {"k": k, "views": views, "methods": methods}
    shown |= {"reconstruction": reconstruction, "note": text}
    draw_views(capture, picked, measured, targets, figures, numbers, **shown)
