"""Loss and agreement of the paper's scorer over the epochs of its training."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from fsel.report import curves
from fsel.report.captions import note
from fsel.report.numbers import write_csv
from fsel.utils.files import read_table


def training_figure(
    logs: Sequence[str | Path],
    figures: Sequence[str | Path],
    numbers: str | Path,
    *,
    facts: Mapping,
) -> None:
    """Loss and agreement with the labels over epochs.

    Args:
        logs: what `fsel.stages.train` logged, one a seed in order.
        figures: paths; their endings choose the format.
        numbers: receives seed, epoch, split, loss, agreement.
        facts: see `captions.note`.
    """
    tables = [read_table(path).assign(seed=seed) for seed, path in enumerate(logs)]
    log = pd.concat(tables)[["seed", "epoch", "split", "loss", "agreement"]]
    write_csv(log, numbers)
    curves.training(log, figures, f"{len(tables)} seeds. {note(facts)}")
