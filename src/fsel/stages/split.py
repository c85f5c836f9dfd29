"""Splits and features of selection problems, and how later stages read them back."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from fsel.capture import Capture
from fsel.features.static import STATIC, UNITS, static_features
from fsel.files import write_table
from fsel.problem import Problem
from fsel.split import evaluation_split


def split(
    folder: str | Path, outputs: Sequence[str | Path], *, targets: int, seed: int, config: str
) -> None:
    """Draw the targets of a capture; output d is the split of draw d.

    Args:
        folder: a canonical capture.
        outputs: one path a draw.
        targets: how many target views a draw.
        seed: of the scene.
        config: digest of the parameters.
    """
    capture = Capture.load(folder)
    for draw, output in enumerate(outputs):
        table = evaluation_split(capture, draw, seed, targets).table(capture.names)
        write_table(table, output, units={}, config=config)


def features(
    folder: str | Path,
    splits: Sequence[str | Path],
    outputs: Sequence[str | Path],
    *,
    config: str,
) -> None:
    """Raw features of every candidate of each draw against its proxies (paper, section 3.2)."""
    for path, output in zip(splits, outputs, strict=True):
        problem = Problem.load(folder, path)
        names = problem.capture.names
        table = pd.DataFrame({"frame": problem.candidates})
        table["name"] = [names[frame] for frame in problem.candidates]
        table[list(STATIC)] = static_features(
            problem, problem.candidates, problem.capture.view(problem.proxies)
        )
        write_table(table, output, units=UNITS, config=config)
