"""The numbers of a table as CSV."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from fsel.core.files import atomic
from fsel.evaluation.summary import ALL_FRAMES


def write_csv(table: pd.DataFrame, path: str | Path, form: str = "%.6f") -> None:
    """Write numbers in a form; the budget of a method that takes every frame is written `all`."""
    if "k" in table:
        table = table.assign(k=table["k"].astype(object).where(table["k"] != ALL_FRAMES, "all"))
    with atomic(path) as temporary:
        table.to_csv(temporary, index=False, float_format=form)


def read_csv(path: str | Path) -> pd.DataFrame:
    """Read what `write_csv` wrote, budgets as numbers again."""
    table = pd.read_csv(path, dtype={"k": str})
    if "k" in table:
        # a row that is about no budget has none
        table["k"] = pd.to_numeric(table["k"].replace("all", str(ALL_FRAMES)))
    return table
