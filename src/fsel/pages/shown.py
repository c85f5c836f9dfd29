"""Frames of a page about a selection, and what is said of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fsel.captures.quality.findings import ALONE
from fsel.core.subsets import evenly
from fsel.selection.export.record import Outcome

SHOWN = 3000  # frames of a page at most, beside the picks: 50,000 would take 12 MB
SIDE, LARGE, LEAST = 240, 300, 48  # pixels of a picture where so many are shown; with more, fewer


class Commands(NamedTuple):
    """Command lines that make the selection anew.

    Attributes:
        asked: as it was asked for, without lists of frames.
        keeping: the same for the number of picks, without what does not go with kept frames.
        viewing: what shows the selection in three dimensions.
    """

    asked: str
    keeping: str
    viewing: str


@dataclass(frozen=True)
class Shown:
    """Content of a page about a selection.

    Attributes:
        outcome: the selection.
        picked, left: see `fsel.selection.export.record`.
        pictures: frame -> JPEG; none where no image was opened.
        commands: that a person's wishes are added to.
        notes: further sentences about the capture.
    """

    outcome: Outcome
    picked: Sequence[dict]
    left: Sequence[dict]
    pictures: Mapping[int, bytes]
    commands: Commands
    notes: Sequence[str] = ()


class Card(NamedTuple):
    """A frame as the page says it: its number, name, kind (`pick`, `held`, `left`, or `bad` where
    it is left out as a bad frame), order among the picks, text, and what is wrong with it."""

    frame: int
    name: str
    kind: str
    order: int
    text: str
    faults: str


def frames_shown(outcome: Outcome) -> np.ndarray:
    """(n,) numbers of the frames that a page shows: all, or evenly spread ones and the picks."""
    some = evenly(len(outcome.capture), SHOWN)
    return np.union1d(some, outcome.selection.indices)


def picture_side(count: int) -> int:
    """Longer side of each picture in pixels: so many take no more room than 300 of 240 pixels."""
    return max(LEAST, round(SIDE * min(1.0, np.sqrt(LARGE / count))))


def cards_of(shown: Shown) -> list[Card]:
    """A card of every frame that is shown, in the order of the capture."""
    outcome = shown.outcome
    picked = {entry["index"]: entry for entry in shown.picked}
    left = {entry["name"]: entry["reason"] for entry in shown.left}
    held, bad = set(outcome.targets.frames.tolist()), set(outcome.targets.bad.tolist())
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
        elif frame in held:
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
        said = [f"brings the picks {entry['adds']:.1%} closer to the views"]
    else:
        said = [f"sees {entry['sees_new']:.1%} of the scene that no earlier pick sees well"]
    if entry["sharpness_rank"] is not None:
        said.append(f"rank {entry['sharpness_rank']} in sharpness")
    return ", ".join(said)
