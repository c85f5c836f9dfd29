"""Bad frames by name: what is wrong with each, by how much, and which are left out; as text too."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fsel.core.wording import counted

BLURRED, MISPLACED, EXPOSED = "blurred", "misplaced", "exposure"
DUPLICATE, UNREADABLE = "duplicate", "unreadable"
ALONE = "no other frame shows half of its content"

TABLE = "bad_frames.csv"
COLUMNS = ("name", "kind", "value", "threshold", "measure", "left_out", "alone")
NAMED = 5  # frames of a kind


class Finding(NamedTuple):
    """Fault of a frame."""

    frame: int
    kind: str  # one of the words above
    value: float  # how bad it is
    threshold: float  # the value of a good frame, at most; of a duplicate, at least
    measure: str  # what the value counts, in words that follow it

    @property
    def severity(self) -> float:
        """The value over its threshold."""
        return self.value / self.threshold if self.threshold > 0 else float("inf")

    def __str__(self) -> str:
        bound = "at least" if self.kind == DUPLICATE else "at most"
        return f"{self.kind}: {self.value:.3g} {self.measure}, {bound} {self.threshold:.3g}"


@dataclass(frozen=True)
class Health:
    """Health of a capture's N frames.

    Attributes:
        findings: in the order of the frames.
        sharpness: (N,) high frequencies over the contrast, NaN where unknown; None for all.
        left_out: (n,) int64 frames that are not to be picked, the least bad first.
        alone: (m,) int64 bad frames that stay: no others show half of what each shows.
        pictures: frame -> small JPEG file; none where `MOST_SHOWN` are exceeded.
    """

    findings: tuple[Finding, ...] = ()
    sharpness: np.ndarray | None = None
    left_out: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    alone: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    pictures: Mapping[int, bytes] = field(default_factory=dict)

    def of(self, frame: int) -> list[Finding]:
        """Return the findings on a frame."""
        return [finding for finding in self.findings if finding.frame == frame]

    def of_kind(self, kind: str) -> np.ndarray:
        """Return (n,) int64 frames that something is wrong with."""
        return np.unique([f.frame for f in self.findings if f.kind == kind]).astype(np.int64)

    def leaving_out(self, frames: np.ndarray, most: int) -> Health:
        """The same with the worst of the frames left out, of those given and at most so many."""
        kept = self.left_out[np.isin(self.left_out, frames)]
        return replace(self, left_out=kept[max(0, len(kept) - most) :])


def exceeding(
    kind: str, values: np.ndarray, threshold: float | np.ndarray, measure: str
) -> list[Finding]:
    """Return a finding for each frame whose value is above the threshold, none for NaN."""
    limits = np.broadcast_to(threshold, values.shape)
    rows = np.flatnonzero(values > limits)
    return [Finding(int(i), kind, float(values[i]), float(limits[i]), measure) for i in rows]


def left_out(
    findings: tuple[Finding, ...], count: int, shown: Callable[[int, np.ndarray], bool]
) -> tuple[np.ndarray, np.ndarray]:
    """Return (n,) int64 bad frames that are left out, the least bad first, and (m,) those that
    stay, since they alone show a part of the scene; misplaced and unreadable ones never do.
    `shown` says of a frame whether (N,) bool others show what it shows."""
    severity, useless = np.zeros(count), np.zeros(count, bool)
    for finding in findings:
        if finding.kind != DUPLICATE:
            severity[finding.frame] = max(severity[finding.frame], finding.severity)
            useless[finding.frame] |= finding.kind in (MISPLACED, UNREADABLE)
    staying = severity == 0
    bad = np.lexsort((severity, useless))[staying.sum() :]
    for frame in bad[~useless[bad]].tolist():
        staying[frame] = not shown(frame, staying)
    return bad[~staying[bad]], bad[staying[bad]]


def in_words(health: Health, names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield for each kind of bad frames how many there are, with the worst of them by name."""
    for kind in dict.fromkeys(finding.kind for finding in health.findings):
        worst = sorted((f for f in health.findings if f.kind == kind), key=lambda f: -f.severity)
        gone = np.isin([f.frame for f in worst], health.left_out).sum()
        few = ", ".join(f"{names[f.frame]} ({str(f).partition(': ')[2]})" for f in worst[:1])
        more = ", ".join([names[f.frame] for f in worst[1:NAMED]] + ["..."] * (len(worst) > NAMED))
        what = f", {gone} left out" if gone < len(worst) else " left out"
        what = "" if kind == DUPLICATE else what
        yield kind, f"{counted(len(worst), 'frame')}{what}: {few}{', ' if more else ''}{more}"
    if count := len(health.alone):
        few = ", ".join(names[frame] for frame in health.alone[:NAMED])
        yield "stay", f"{counted(count, 'bad frame')}, since {ALONE}: {few}"


def entries(health: Health, names: Sequence[str]) -> list[dict]:
    """Return one entry a finding. A bad frame that is not left out alone shows a part of the scene
    (`alone`), or is wanted, held out, or needed; duplicates may be picked."""
    gone, alone = set(health.left_out.tolist()), set(health.alone.tolist())
    return [
        {
            "name": names[finding.frame],
            "kind": finding.kind,
            "value": float(f"{finding.value:.4g}"),
            "threshold": float(f"{finding.threshold:.4g}"),
            "measure": finding.measure,
            "left_out": finding.kind != DUPLICATE and finding.frame in gone,
            "alone": finding.kind != DUPLICATE and finding.frame in alone,
        }
        for finding in health.findings
    ]


def write(health: Health, names: Sequence[str], path: Path) -> None:
    """Write the list of bad frames, one row a finding."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        table.writerows(entries(health, names))
