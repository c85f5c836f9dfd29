"""Content of a page about a selection: its frames, what is said of each, and the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fsel.captures.images.previews import MOST_SHOWN
from fsel.captures.quality.findings import ALONE
from fsel.core.geometry import plane_basis, upwards
from fsel.core.points import SparsePoints
from fsel.core.subsets import evenly
from fsel.selection.outcome import Outcome

MOST_POINTS = 4000
TICK = 0.08  # length of a viewing direction, as a share of the view
CORE = 95  # per cent of the points that the view is scaled to, where they lie close enough
WIDEST = 1.5  # times the cameras' own reach: farther points would make one dot of the cameras


class Commands(NamedTuple):
    """Command lines that a report offers."""

    editing: str  # the selection's, without the number of picks and lists of frames
    picks: str  # the list of picks that it begins with
    viewing: str  # what shows the selection in three dimensions


@dataclass(frozen=True)
class ReportContent:
    """Content of a page about a selection."""

    outcome: Outcome
    picked: Sequence[dict]  # see `fsel.selection.export.record`, also `left`
    left: Sequence[dict]
    pictures: Mapping[int, bytes]  # frame -> JPEG; none where no image was opened
    commands: Commands
    notes: Sequence[str]  # warnings about the capture
    times: Mapping[str, float]  # seconds of frames of a video, by name


class Card(NamedTuple):
    """A frame as the page says it; its kind is `pick`, `held`, `left` or `bad`."""

    frame: int
    name: str
    kind: str
    order: int
    text: str
    faults: str


def frames_shown(outcome: Outcome) -> np.ndarray:
    """Return (n,) frames that a page shows: all, or evenly spread ones and the picks."""
    some = evenly(len(outcome.capture), MOST_SHOWN)
    return np.union1d(some, outcome.selection.indices)


def cards_of(shown: ReportContent) -> list[Card]:
    """Return a card of every frame that is shown, in the order of the capture."""
    outcome = shown.outcome
    picked = {entry["index"]: entry for entry in shown.picked}
    left = {entry["name"]: entry["reason"] for entry in shown.left}
    held_out, bad = set(outcome.targets.frames.tolist()), set(outcome.targets.bad.tolist())
    wrong: dict[int, list[str]] = {}
    for finding in outcome.health.findings if outcome.health else ():
        wrong.setdefault(finding.frame, []).append(str(finding))
    for frame in outcome.health.alone.tolist() if outcome.health else ():
        wrong[frame].append(ALONE)
    cards = []
    for frame in frames_shown(outcome).tolist():
        name = outcome.capture.names[frame]
        kind, order, faults = "left", 0, "; ".join(wrong.get(frame, ()))
        if frame in picked:
            kind, order = "pick", picked[frame]["order"]
            text = f"Pick {order}: {adds(picked[frame])}."
        elif frame in held_out:
            kind, text = "held", "Held out as a target: never picked."
        elif frame in bad:
            kind, text = "bad", "Left out as a bad frame."
        else:
            text = f"Left out: {left[name]}."
        cards.append(Card(frame, name, kind, order, text, faults))
    return cards


def adds(entry: dict) -> str:
    """Say what a pick adds."""
    if entry["sees_new"] is None:
        said = [f"brings the views {entry['adds']:.1%} of an image closer"]
    else:
        said = [f"shows {entry['sees_new']:.1%} of the scene that earlier picks do not see well"]
    if entry["sharpness_rank"] is not None:
        said.append(f"rank {entry['sharpness_rank']} in sharpness")
    return ", ".join(said)


def scene_data(outcome: Outcome, frames: np.ndarray, points: SparsePoints | None) -> dict:
    """Return places of `frames`, targets and `points` around the origin, z upwards, extent 1."""
    capture, targets = outcome.capture, outcome.targets
    up = upwards(capture.world_to_camera)
    side, ahead = plane_basis(up)
    basis = np.stack([side, ahead, up], axis=1)
    drawn = np.zeros(0, np.int64) if len(targets.frames) else np.flatnonzero(~targets.far)
    views = targets.views.subset(drawn)
    centers, others = capture.centers @ basis, views.centers @ basis
    cloud = np.empty((0, 3)) if points is None else points.xyz @ basis
    extent, middle = _extent(np.concatenate([centers, others]), cloud)

    def placed(places: np.ndarray, axes: np.ndarray) -> list:
        put = (places - middle) / extent
        return np.stack([put, put + TICK * (axes @ basis)], axis=1).round(4).tolist()

    some = evenly(len(cloud), MOST_POINTS)
    colours = np.empty((0, 3)) if points is None else points.rgb[some]
    put = np.hstack([((cloud[some] - middle) / extent).round(4), colours]).tolist()
    return {
        "frames": placed(centers[frames], capture.axes[frames]),
        "targets": placed(others, views.axes),
        "points": put,
    }


def _extent(cameras: np.ndarray, cloud: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the extent and middle of the view: all cameras, and near points around them."""
    middle = (cameras.min(axis=0) + cameras.max(axis=0)) / 2
    reach = float(np.linalg.norm(cameras - middle, axis=1).max())
    far = np.linalg.norm(cloud - middle, axis=1)
    core = float(np.percentile(far, CORE)) if len(far) else 0.0
    around = min(core, WIDEST * reach) if reach else core
    return max(reach, around) or 1.0, middle
