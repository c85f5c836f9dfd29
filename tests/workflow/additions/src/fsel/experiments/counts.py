"""How many frames the captures have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from fsel.files import write_text
from fsel.report.latex import plain_table
from fsel.report.numbers import write_csv


def counts(
    frames: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[str],
    datasets: Mapping[str, str],
) -> None:
    """One row a capture.

    Args:
        frames: frames.parquet of each.
        table, numbers: receive LaTeX, and dataset, scene, frames.
        scenes: (dataset, scene) of each.
        datasets: name -> printed label.
    """
    found = pd.DataFrame(scenes, columns=["dataset", "scene"])
    found["frames"] = [len(pd.read_parquet(path)) for path in frames]
    write_csv(found, numbers)
    rows = [[datasets[d], scene, str(n)] for d, scene, n in found.itertuples(index=False)]
    head = ["Dataset", "Scene", "Frames"]
    write_text(plain_table(head, rows, caption="Frames.", label="tab:counts"), table)
