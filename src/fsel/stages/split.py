"""Splits and features of selection problems, and how later stages read them back."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.capture import Capture
from fsel.features.static import STATIC, UNITS, static_features
from fsel.files import write_table
from fsel.problem import Problem
from fsel.split import Split, evaluation_split


def split_table(split: Split, names: Sequence[str]) -> pd.DataFrame:
    """One row a frame: frame, name, role, proxy_of (-1 unless a proxy), in_region."""
    role = np.full(len(names), "candidate", dtype=object)
    proxy_of = np.full(len(names), -1)
    role[split.targets], role[split.proxies] = "target", "proxy"
    proxy_of[split.proxies] = split.targets
    frames = np.arange(len(names))
    return pd.DataFrame(
        {
            "frame": frames,
            "name": names,
            "role": role,
            "proxy_of": proxy_of,
            "in_region": np.isin(frames, split.region),
        }
    )


def split_from(table: pd.DataFrame) -> Split:
    """What `split_table` wrote down."""
    table = table.sort_values("frame")
    frame, role = table["frame"].to_numpy(np.int64), table["role"]
    proxies = table[role == "proxy"].sort_values("proxy_of")["frame"].to_numpy(np.int64)
    return Split(
        targets=frame[role == "target"],
        proxies=proxies,
        candidates=frame[role == "candidate"],
        region=frame[table["in_region"]],
    )


def problem_of(capture: Capture, split: Split, described: pd.DataFrame) -> Problem:
    """The selection problem of a split; `described` is descriptors.parquet."""
    return Problem(
        capture=capture,
        candidates=split.candidates,
        proxies=split.proxies,
        targets=capture.view(split.targets),
        descriptors=np.stack(described["descriptor"].to_list()).astype(np.float32),
        sharpness=described["sharpness"].to_numpy(np.float64),
    )


def load_problem(folder: str | Path, split: str | Path) -> Problem:
    """The problem of a capture's folder and a split.parquet."""
    folder = Path(folder)
    return problem_of(
        Capture.load(folder),
        split_from(pd.read_parquet(split)),
        pd.read_parquet(folder / "descriptors.parquet"),
    )


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
        table = split_table(evaluation_split(capture, draw, seed, targets), capture.names)
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
        problem = load_problem(folder, path)
        names = problem.capture.names
        table = pd.DataFrame({"frame": problem.candidates})
        table["name"] = [names[frame] for frame in problem.candidates]
        table[list(STATIC)] = static_features(
            problem, problem.candidates, problem.capture.view(problem.proxies)
        )
        write_table(table, output, units=UNITS, config=config)
