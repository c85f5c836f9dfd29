"""Bad frames of a capture as a selection reports them: in words, as entries, as a table."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from fsel.captures.quality import Health
from fsel.captures.quality.findings import ALONE, DUPLICATE
from fsel.core.wording import counted

TABLE = "bad_frames.csv"
COLUMNS = ("name", "kind", "value", "threshold", "measure", "left_out", "alone")
NAMED = 5  # frames of a kind


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
