"""The targets of every draw, their proxies and the candidates."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fsel.data.capture import Capture
from fsel.data.split import evaluation_split
from fsel.utils.files import write_table


def split(
    folder: str | Path, splits: Sequence[str | Path], *, targets: int, seed: int, config: str
) -> None:
    """Draw the targets of a capture.

    Args:
        folder: a canonical capture.
        splits: one a draw, see `fsel.data.split.Split.table`.
        targets: how many target views a draw.
        seed: of the scene.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    for draw, output in enumerate(splits):
        table = evaluation_split(capture, draw, seed, targets).table(capture.names)
        write_table(table, output, units={}, config=config)
