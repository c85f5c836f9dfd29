"""DL3DV as Long-LRM's authors evaluate on it: listed input frames, every eighth frame held out.

Ziwen et al. 2025, arXiv 2410.12781. Their list, `dl3dv_fold_8_kmeans_input_idx.json`, holds for
each scene the input frames that k-means chose, by their places in its transforms.json.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

from fsel.core.problem import Method, Problem

EVERY = 8
NAME, LABEL = "listed", "Long-LRM's list"


@dataclass(frozen=True)
class Protocol:
    """Frames of one scene, by their numbers in a capture.

    Attributes:
        targets: (T,) int64, ascending.
        inputs: number of frames -> (k,) int64 distinct frames, ascending.
    """

    targets: np.ndarray
    inputs: dict[int, np.ndarray]

    @property
    def method(self) -> Method:
        """The listed frames as a method, for the numbers of frames that are listed."""

        def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
            return self.inputs[k]

        return Method(NAME, LABEL, "observed", nested=False, select=select)


def read_protocol(
    file: str | Path, scene: str, folder: str | Path, names: Sequence[str]
) -> Protocol:
    """The protocol of one scene.

    Args:
        file: the list.
        scene: its name there.
        folder: the scene as it is distributed.
        names: of the capture's frames.

    Raises:
        ValueError: for a file that is no such list or lacks the scene, places that the scene does
            not have, targets among the inputs, or frames that the capture lacks.
    """
    from fsel.captures.layouts import dl3dv

    file, folder = Path(file), Path(folder)
    try:
        entries = {entry["scene_name"]: entry for entry in json.loads(file.read_text())}
    except (ValueError, TypeError, KeyError) as error:
        raise ValueError(f"{file}: no list of scenes with their scene_name ({error!r})") from error
    if scene not in entries:
        raise ValueError(f"{file}: no scene {scene} among its {len(entries)}")
    order = [PurePosixPath(name).stem for name in dl3dv.frame_order(folder)]
    rows = {PurePosixPath(name).stem: row for row, name in enumerate(names)}
    targets = _rows(range(0, len(order), EVERY), order, rows, f"{folder}: held-out frames")
    inputs = {}
    for key, places in entries[scene].items():
        if key.startswith(f"fold_{EVERY}_kmeans_") and key.endswith("_input"):
            found = _rows(places, order, rows, f"{file}: {scene}, {key}")
            if both := np.intersect1d(found, targets).tolist():
                raise ValueError(f"{file}: {scene}, {key}: frames {both} are held out")
            inputs[len(found)] = found
    return Protocol(targets, inputs)


def _rows(
    places: Sequence[int], order: Sequence[str], rows: dict[str, int], where: str
) -> np.ndarray:
    """(n,) int64 ascending rows of the capture at some places of transforms.json."""
    if wrong := [place for place in places if not 0 <= place < len(order)]:
        raise ValueError(f"{where}: places {wrong}; allowed: 0 to {len(order) - 1}")
    if missing := [order[place] for place in places if order[place] not in rows]:
        raise ValueError(f"{where}: {missing} are not among the capture's {len(rows)} frames")
    return np.unique([rows[order[place]] for place in places]).astype(np.int64)
