"""`fsel info`: what a capture holds, and how many of its frames are worth keeping."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fsel.cli import posing
from fsel.cli.console import Console
from fsel.cli.request import reasons
from fsel.export.service import BLURRED, relative_sharpness
from fsel.geometry import lengths
from fsel.layouts import bare, images
from fsel.layouts.base import natural
from fsel.layouts.gate import sample
from fsel.layouts.opening import Opened
from fsel.layouts.previews import sharpness_of_files
from fsel.points import SparsePoints
from fsel.request.focus import scene_bounds
from fsel.request.scene_depth import viewing_distance, worth_keeping


def run(asked: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    opened = posing.opened(asked, console)
    sharpness = sharpness_of_files(opened.raw.images, opened.longest, console.bar("sharpness"))
    with console.clock("points"):
        drawn, raw = sample(opened.raw)
        points = raw.sparse()
    result = described(
        opened, sharpness, drawn, None if points is None else points.without_pixels()
    )
    frames, kept = result["frames"], len(result["worth_keeping"])
    console.say("capture", f"{frames} frames, {opened.layout}, passes: {result['passes']}")
    console.say("cameras", ", ".join(result["cameras"]))
    if opened.raw.dropped:
        console.say("left out", reasons(opened.raw.dropped))
    if result["unregistered"]:
        few = ", ".join(result["unregistered"][:5])
        console.say("no pose", f"{len(result['unregistered'])} more images there: {few}")
    console.say("points", str(result["points"]) if result["points"] else "none")
    console.say(
        "poses",
        f"extent {result['extent']:.4g}, step {result['step']:.4g}, looking "
        f"{result['distance']:.4g} far (medians, world units)",
    )
    low, high = (" ".join(f"{x:.4g}" for x in end) for end in result["bounds"])
    console.say("bounds", f"{low} to {high} (of cameras and 98 % of the points; see --box)")
    console.say("agree", str(opened.agreement))
    blurred = result["blurred"]
    console.say("blurred", f"{len(blurred)}: {', '.join(blurred[:5])}" if blurred else "none")
    console.say(
        "keep",
        f"about {kept} of {frames}: the others lie within 8 degrees of parallax of one of them",
    )
    console.give(result | {"agreement": str(opened.agreement)})


def described(
    opened: Opened, sharpness: np.ndarray, drawn: np.ndarray, points: SparsePoints | None
) -> dict:
    """What the command prints, with names in full.

    Args:
        opened: the capture.
        sharpness: (N,) of its frames.
        drawn: (m,) frames that the points' tracks number, ascending.
        points: sparse points, or None.
    """
    capture, centers = opened.capture, opened.capture.centers
    far = viewing_distance(capture.view(drawn), points)
    distance = np.interp(np.arange(len(capture)), drawn, far)
    keep = worth_keeping(capture.views, distance)
    blurred = relative_sharpness(sharpness) < BLURRED
    cameras = dict.fromkeys(f"{c.model} {c.width}x{c.height}" for c in opened.raw.cameras)
    return {
        "layout": opened.layout,
        "frames": len(capture),
        "passes": len(set(capture.sequences)),
        "cameras": list(cameras),
        "dropped": opened.raw.dropped,
        "unregistered": _unregistered(opened.raw.images),
        "points": 0 if points is None else len(points.xyz),
        "extent": float(2 * lengths(centers - centers.mean(axis=0)).max()),
        "step": float(np.median(lengths(np.diff(centers, axis=0)))) if len(capture) > 1 else 0.0,
        "distance": float(np.median(distance)),
        "bounds": scene_bounds(replace(capture, points=points)).tolist(),
        "blurred": [capture.names[i] for i in np.flatnonzero(blurred)],
        "worth_keeping": [capture.names[i] for i in keep],
    }


def _unregistered(files: Sequence[images.Image]) -> list[str]:
    """Names of images that lie beside the frames' and are none of them."""
    known = {file for file in files if isinstance(file, Path)}
    folders = sorted({file.parent for file in known})
    return [
        path.name
        for folder in folders
        for path in sorted(folder.iterdir(), key=lambda path: natural(path.name))
        if path.suffix.lower() in bare.ENDINGS and path not in known
    ]
