"""What all figures share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure


def save(figure: Figure, outputs: Sequence[str | Path]) -> None:
    """Write a figure to paths whose endings choose the format; equal figures give equal bytes."""
    for output in outputs:
        undated = {"CreationDate": None} if Path(output).suffix == ".pdf" else {"Software": None}
        figure.savefig(output, dpi=200, metadata=undated)
