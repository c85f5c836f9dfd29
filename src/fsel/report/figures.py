"""Common parts of all figures."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LETTERS = 21  # of the footnote's size, an inch


def new_figure(size: tuple[float, float]) -> Figure:
    """An empty figure of a width and height in inches; no window belongs to it."""
    from matplotlib.figure import Figure  # here: jobs that draw nothing do without

    return Figure(figsize=size, layout="constrained")


def footnote(figure: Figure, text: str) -> None:
    """A small line under a figure, broken to its width: what made the numbers."""
    width = int(LETTERS * figure.get_figwidth())
    figure.supxlabel("\n".join(textwrap.wrap(text, width)), fontsize=6)


def save(figure: Figure, outputs: Sequence[str | Path]) -> None:
    """Write a figure to paths whose endings choose the format; equal figures give equal bytes."""
    for output in outputs:
        undated = {"CreationDate": None} if Path(output).suffix == ".pdf" else {"Software": None}
        figure.savefig(output, dpi=200, metadata=undated)
