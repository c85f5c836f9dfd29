"""Loss and agreement of the paper's scorer over the epochs of its training."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from fsel.report import curves
from fsel.report.captions import note
from fsel.report.numbers import write_csv
from fsel.utils.files import File, Files, read_table
from fsel.utils.wording import counted
from fsel.workflow import inputs
from fsel.workflow.tables import Table


def training_figure(logs: Files, figures: Files, numbers: File, *, facts: Mapping) -> None:
    """Loss and agreement with the labels over epochs.

    Args:
        logs: what `fsel.stages.train` logged, one a seed in order.
        numbers: receives seed, epoch, split, loss, agreement.
    """
    tables = [read_table(path).assign(seed=seed) for seed, path in enumerate(logs)]
    log = pd.concat(tables)[["seed", "epoch", "split", "loss", "agreement"]]
    write_csv(log, numbers)
    curves.training(log, figures, f"{counted(len(tables), 'seed')}. {note(facts)}")


TABLE = Table(
    training_figure,
    outputs={"figures": inputs.figure_files("training"), "numbers": "<figures>/training.csv"},
    inputs=lambda experiment: {
        "logs": inputs.scorer_files(experiment, "less_is_more")["logs"],
    },
    params=lambda experiment: {"facts": experiment.facts([experiment.trained])},
    category="Paper",
    title="Training",
    caption="Loss, and share of the steps that agree with the label, over the epochs of behaviour "
    "cloning.",
)
