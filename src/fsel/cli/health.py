"""Bad frames in commands: they are looked for, left out of the targets' pool, told and listed."""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fsel.captures.lazy import LazyCapture
from fsel.captures.quality import Health
from fsel.captures.quality.examination import examined
from fsel.captures.quality.findings import ALONE, DUPLICATE
from fsel.cli.console import Console
from fsel.core.wording import counted
from fsel.selection import api
from fsel.selection.budget import Auto
from fsel.selection.export.record import bad_frames
from fsel.selection.targets import Targets

BAD = "bad_frames.csv"
COLUMNS = ("name", "kind", "value", "threshold", "measure", "left_out", "alone")
NAMED = 5  # frames of a kind


def without_bad(
    args: argparse.Namespace,
    console: Console,
    opened: LazyCapture,
    targets: Targets,
    k: int | Auto | None,
    *,
    images: bool = True,
) -> tuple[Targets, Health | None]:
    """Targets whose pool is without bad frames, and what was found; None with `--keep-bad`.

    Args:
        args: the command line.
        console: prints what was found.
        opened: the capture.
        targets: of the command line.
        k: how many frames are picked; so many remain at least.
        images: whether they are looked at.
    """
    if args.keep_bad:
        return targets, None
    bar = console.bar("health")
    found = examined(opened, bar, images=images, matching=args.check_poses)
    targets, health = api.without_bad(targets, found, opened.capture, k)
    say(console, health, opened.capture.names)
    return targets, health


def say(console: Console, health: Health, names: Sequence[str]) -> None:
    """Say how many frames are bad in which way, with the worst of them by name."""
    kinds = dict.fromkeys(finding.kind for finding in health.findings)
    for kind in kinds:
        worst = sorted((f for f in health.findings if f.kind == kind), key=lambda f: -f.severity)
        gone = np.isin([f.frame for f in worst], health.left_out).sum()
        few = ", ".join(f"{names[f.frame]} ({f})" for f in worst[:1])
        more = ", ".join(names[f.frame] for f in worst[1:NAMED])
        dots = ", ..." if len(worst) > NAMED else ""
        what = "" if kind == DUPLICATE else f", {gone} left out"
        text = f"{counted(len(worst), 'frame')}{what}: {few}{', ' if more else ''}{more}{dots}"
        console.say(kind, text)
    if count := len(health.alone):
        few = ", ".join(names[frame] for frame in health.alone[:NAMED])
        console.say("stay", f"{counted(count, 'bad frame')}, since {ALONE}: {few}")


def write(health: Health, names: Sequence[str], path: Path) -> None:
    """Write the list of bad frames, one row a finding."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        table.writerows(bad_frames(health, names))
