"""Speed of the camera, sharpness and exposure of the report's frames over time."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

import cv2
import numpy as np

from fsel.core.geometry import viewing_angles
from fsel.features.conditioned import look_depth
from fsel.pages.drawings import timeline
from fsel.selection.export.record import Outcome


def over_time(outcome: Outcome, frames: np.ndarray, pictures: Mapping[int, bytes]) -> list[str]:
    """Timeline of some frames, with picks, held-out and bad frames marked.

    Args:
        outcome: the selection.
        frames: (n,) that are shown.
        pictures: frame -> JPEG, which tell the exposure; may be empty.
    """
    rows = {"speed of the camera (degrees a frame)": speeds(outcome)[frames]}
    if outcome.sharpness is not None:
        rows["sharpness"] = np.asarray(outcome.sharpness)[frames]
    if pictures:
        light = brightness(pictures, len(outcome.capture))[frames]
        rows["exposure (mean grey level, %)"] = light
    targets = outcome.targets
    kinds = {"held": targets.frames, "pick": outcome.selection.indices, "bad": targets.bad}
    marks = {kind: np.flatnonzero(np.isin(frames, of)).tolist() for kind, of in kinds.items()}
    labels = "".join(
        f'<span style="top:{100 * at / len(rows):.1f}%">{escape(name)}: up to '
        f"{np.nanmax(values, initial=0):.3g}</span>"
        for at, (name, values) in enumerate(rows.items())
    )
    return [
        "<h2>Over time</h2>",
        f'<figure><div class="lanes">{timeline(rows, marks)}{labels}</div><figcaption>Frames in '
        "the order of their names; picks in orange, held-out frames in blue, bad ones in dashed "
        "red. Click to see a frame.</figcaption></figure>",
    ]


def speeds(outcome: Outcome) -> np.ndarray:
    """(N,) degrees by which the view moved since the frame before; NaN where a sequence begins.

    The turn of the optical axis, and the angle that the way of the centre makes at the depth of
    the scene.
    """
    capture = outcome.capture
    way = np.linalg.norm(np.diff(capture.centers, axis=0), axis=1)
    turn = viewing_angles(capture.axes[1:], capture.axes[:-1])
    moved = np.degrees(turn + np.arctan(way / look_depth(capture.centers)))
    label = np.array(capture.sequences)
    return np.concatenate([[np.nan], np.where(label[1:] == label[:-1], moved, np.nan)])


def brightness(pictures: Mapping[int, bytes], count: int) -> np.ndarray:
    """(N,) mean grey level of each picture in per cent, NaN without one."""
    out = np.full(count, np.nan)
    for frame, jpeg in pictures.items():
        reduced = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_REDUCED_GRAYSCALE_4)
        out[frame] = np.asarray(reduced).mean() / 2.55
    return out
