"""What selections look like: rendered targets of several methods, and their cameras."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from fsel.data.capture import Capture
from fsel.experiments.paper.pictures import draw_views, frames_named, resolved
from fsel.report.captions import note
from fsel.utils.files import read_table


def qualitative(
    folder: str | Path,
    split: str | Path,
    selections: str | Path,
    evaluations: Sequence[str | Path],
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
        folder: a canonical capture of the scene with images large enough; frames are found in it by
            their names.
        split: split.parquet of the draw.
        selections: what `fsel.stages.select` wrote for it.
        evaluations: of the scene's draws, from which `strongest` is found.
        figures: paths; their endings choose the format.
        numbers: see `pictures.draw_views`.
        methods: columns, in order; the first training or random seed of each is shown. `strongest`
            is the paper's baseline with the highest PSNR at k that is not among them.
        views: targets drawn.
        k: frames; `all` takes its own number.
        reconstruction: the config's section.
        facts: see `captions.note`.
    """
    capture = Capture.load(folder)
    roles = read_table(split)
    targets = frames_named(capture, roles[roles["role"] == "target"]["name"].tolist())
    evaluation = pd.concat([read_table(path) for path in evaluations])
    picked = read_table(selections).query("seed == 0")
    chosen = {
        method: frames_named(capture, picks_of(picked, method, k))
        for method in resolved(methods, evaluation, k)
    }
    draw_views(
        capture,
        chosen,
        targets,
        figures,
        numbers,
        views=views,
        reconstruction=reconstruction,
        note=note(facts),
    )


def picks_of(picked: pd.DataFrame, method: str, k: int) -> list[str]:
    """Names of a method's frames at a budget; of one that takes every frame, all of them.

    Args:
        picked: method, k, order, name of one seed.
        method, k: which.
    """
    part = picked[picked["method"] == method]
    part = part if method == "all" else part[part["k"] == k]
    return part.sort_values("order")["name"].tolist()
