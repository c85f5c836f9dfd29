"""Figure of how the scorer learns to imitate: loss and agreement by epoch (paper, section 3.5)."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from fsel.core.files import File, Files, read_table
from fsel.evaluation.figures import COLORS, footnote, name_axes, new_figure, save
from fsel.evaluation.latex import note
from fsel.evaluation.summary import write_csv

MEASURES = {"loss": "loss (nats)", "agreement": "agreement with the search"}
SPLITS = {"train": "-", "validation": "--"}


def imitation(
    logs: Files, figures: Files, numbers: File, *, scenes: Mapping[str, str], facts: Mapping
) -> None:
    """Draw loss in nats and agreement on training and validation scenes, a line a seed, from the
    logs of `fsel.stages.train`; `scenes` maps scenes to roles."""
    parts = [read_table(path).assign(seed=seed) for seed, path in enumerate(logs)]
    table = pd.concat(parts)[["seed", "epoch", "split", *MEASURES]]
    write_csv(table, numbers)
    figure = new_figure((5.0, 2.3))
    for axis, (measure, label) in zip(figure.subplots(1, 2), MEASURES.items(), strict=True):
        for (split, seed), part in table.groupby(["split", "seed"], sort=False):
            name = split if seed == 0 else None
            style = {"color": COLORS[int(seed) % len(COLORS)], "linestyle": SPLITS[str(split)]}
            axis.plot(part["epoch"], part[measure], label=name, linewidth=1, **style)
        name_axes(axis, "epoch", label)
    axis.legend(fontsize=7)
    roles = list(scenes.values())
    counts = ", ".join(f"{roles.count(split)} {split}" for split in SPLITS)
    footnote(figure, f"Scenes: {counts}; one colour per seed. {note(facts)}")
    save(figure, figures)
