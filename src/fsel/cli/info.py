"""`fsel info`: describe a capture, its bad frames, and how many frames to keep."""

from __future__ import annotations

import argparse
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path

import numpy as np

from fsel.captures.layouts import bare
from fsel.captures.lazy import LazyCapture
from fsel.captures.quality import findings
from fsel.captures.quality.examination import examined
from fsel.cli import open_capture
from fsel.cli.console import Console
from fsel.cli.open_capture import reasons
from fsel.core.capture import Capture
from fsel.core.geometry import lengths
from fsel.core.names import natural
from fsel.core.wording import counted
from fsel.selection.budget import LEAST, Auto, find
from fsel.selection.export.record import reason
from fsel.selection.focus import scene_bounds
from fsel.selection.paths import attention
from fsel.selection.request import LEAST_FRAMES
from fsel.selection.scene_depth import viewing_distance


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    opened = open_capture.opened(args, console)
    health = examined(opened, console.bar("health"))
    with console.clock("points"):
        capture = opened.with_points()
    result = described(opened, capture, health)
    frames = result["frames"]
    console.say(
        "capture", f"{counted(frames, 'frame')}, {opened.layout}, passes: {result['passes']}"
    )
    console.say("cameras", ", ".join(result["cameras"]))
    if opened.left_out:
        console.say("left out", reasons(opened.left_out))
    if result["unregistered"]:
        few = ", ".join(result["unregistered"][:5])
        console.say("no pose", f"{counted(len(result['unregistered']), 'more image')}: {few}")
    console.say("points", str(result["points"]) if result["points"] else "none")
    console.say(
        "poses",
        f"extent {result['extent']:.4g}, step {result['step']:.4g}, viewing distance "
        f"{result['distance']:.4g} (medians, world units)",
    )
    low, high = (" ".join(f"{x:.4g}" for x in end) for end in result["bounds"])
    what = "98 % of the points" if result["points"] else "their viewing points"
    console.say("bounds", f"{low} to {high} (of cameras and {what}; see --box)")
    if result["looked_at"]:
        place = " ".join(f"{x:.4g}" for x in result["looked_at"])
        console.say("looked at", f"{place} (the point closest to all optical axes)")
    console.say("agree", str(opened.agreement))
    for line in findings.in_words(health, capture.names):
        console.say(*line)
    if not health.findings:
        console.say("bad", "no frames")
    console.text(f"{table}\n" if (table := result["how_many"]) else "")
    console.say("keep", f"{result['enough']} (fsel select -k auto)")
    known = {"agreement": str(opened.agreement), "how_many": table and asdict(table)}
    console.give(result | known)


def described(opened: LazyCapture, capture: Capture, health: findings.Health) -> dict:
    """Return the report that the command prints, of a capture, the same with its points."""
    centers, points = capture.centers, capture.points
    distance = viewing_distance(capture.views, points)
    cameras = dict.fromkeys(f"{c.model} {c.width}x{c.height}" for c in opened.raw.cameras)
    looked_at = None  # where the cameras look at no common point
    with suppress(ValueError):
        looked_at = attention(centers, capture.axes).tolist()
    return {
        "layout": opened.layout,
        "frames": len(capture),
        "passes": len(set(capture.sequences)),
        "cameras": list(cameras),
        "dropped": opened.raw.dropped,
        "unregistered": _unregistered(opened),
        "points": 0 if points is None else len(points.xyz),
        "extent": float(2 * lengths(centers - centers.mean(axis=0)).max()),
        "step": float(np.median(lengths(np.diff(centers, axis=0)))) if len(capture) > 1 else 0.0,
        "distance": float(np.median(distance)),
        "bounds": scene_bounds(capture).tolist(),
        "looked_at": looked_at,
        "bad": findings.entries(health, capture.names),
        **_enough(capture, health),
    }


def _enough(capture: Capture, health: findings.Health) -> dict:
    """Return how many frames `fsel select -k auto` keeps, in words, and what others lose."""
    count = len(capture)
    if count < LEAST_FRAMES:
        return {"enough": f"all {count} frames: too few to select from", "how_many": None}
    bad = health.leaving_out(np.arange(count), count - LEAST).left_out
    budget = find(Auto(), count - len(bad), capture.size)
    return {"enough": reason(budget), "how_many": budget.table}


def _unregistered(opened: LazyCapture) -> list[str]:
    """Return names of images that lie beside the frames', without those skipped."""
    known = {file for file in opened.raw.images if isinstance(file, Path)}
    posed = {Path(name).name for name in opened.skipped}
    return [
        path.name
        for folder in sorted({file.parent for file in known})
        for path in sorted(folder.iterdir(), key=lambda path: natural(path.name))
        if path.suffix.lower() in bare.ENDINGS and path not in known and path.name not in posed
    ]
