"""`fsel view`: a splat, or a capture's points, with cameras and photos, as a page for a browser."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fsel.captures.forms import CLOUD
from fsel.captures.images.previews import SIDE, in_turn, jpeg, picture_side, reduced
from fsel.cli import open_capture
from fsel.cli.console import Console
from fsel.cli.open_capture import open_as, record_of
from fsel.core.outputs import staged
from fsel.core.wording import counted
from fsel.pages import viewer
from fsel.pages.report import REPORT, with_view
from fsel.pages.shown import adds
from fsel.reconstruct import ply
from fsel.selection.export.record import RECORD

KINDS = "a .ply of Gaussians, a folder that `fsel select` wrote, or a capture"


Sources = dict[str, Path]
"""Files and folders that are shown: `model`, `selection` and `capture`, those that there are."""


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    sources = sources_of(args.source)
    if args.out.suffix.lower() != ".html":
        raise ValueError(f"{args.out}: a page must be an .html file. Hint: -o NAME.html")
    with staged(args.out, sources.values(), args.force, folder=False) as stage:
        content = _scene(args, sources, console)
        page = _page(sources, content)
        stage.write_text(page, encoding="utf-8")
    console.say("written", f"{args.out}: {len(page) / 1e6:.1f} MB, opens in a browser")
    console.give({"page": str(args.out.resolve()), "cameras": len(content["cameras"])})


def sources_of(given: list[Path]) -> Sources:
    """Sort the given paths: a model, a selection (which names its capture), a capture; one each."""
    found: Sources = {}
    for path in given:
        if not path.exists():
            raise ValueError(f"{path}: does not exist. Hint: {KINDS}")
        if path.is_file() and path.suffix.lower() == ".ply":
            kind = "model"
        else:
            kind = "selection" if (path / RECORD).is_file() else "capture"
        if kind in found:
            raise ValueError(f"{path}: a second {kind} beside {found[kind]}; allowed: one")
        found[kind] = path
    if "selection" in found:
        stated = record_of(found["selection"])["capture"]["folder"]
        found.setdefault("capture", Path(stated))
        inside = [ply for ply in found["selection"].glob("*.ply") if ply.name != CLOUD]
        if len(inside) == 1:
            found.setdefault("model", inside[0])
    return found


def _scene(args: argparse.Namespace, sources: Sources, console: Console) -> dict:
    """Return the content of the page."""
    cloud = None
    if "model" in sources:
        cloud = ply.read(sources["model"])
        ply.check_filled(sources["model"], len(cloud.xyz))
        console.say("model", f"{len(cloud.xyz)} Gaussians, harmonics of degree {cloud.degree}")
    if "capture" not in sources:
        return viewer.scene(None, [], cloud)
    args.capture = sources["capture"]
    record = record_of(sources["selection"]) if "selection" in sources else {}
    open_as(args, record)
    opened = open_capture.opened(args, console, args.long_side)
    capture = opened.capture if cloud is not None else opened.with_all_points()
    side = args.long_side * picture_side(len(capture)) // SIDE  # many would make a page too large
    pictures = in_turn(
        lambda at: jpeg(reduced(np.asarray(capture.images[at]), side)),
        opened.raw.images,
        console.bar("pictures"),
    )
    cameras = _cameras(capture.names, pictures, record)
    states = Counter(camera.state for camera in cameras)
    said = [f"{states[key]} {one['label']}" for key, one in viewer.STATES.items() if states[key]]
    counts = counted(len(cameras), "camera")
    console.say("capture", f"{counts}, {opened.layout}: {', '.join(said)}")
    return viewer.scene(capture, cameras, cloud, capture.points)


def _cameras(
    names: Sequence[str], pictures: Sequence[bytes], record: dict
) -> list[viewer.ViewerCamera]:
    """Return every frame with its state in the selection, if there is one, and its picture."""
    picked = {entry["name"]: entry for entry in record.get("frames", ())}
    reasons = {entry["name"]: entry["reason"] for entry in record.get("left", ())}
    held_out = set(record.get("targets", {}).get("held_out", ()))
    bad = {entry["name"] for entry in record.get("bad") or () if entry["left_out"]}
    cameras = []
    for name, picture in zip(names, pictures, strict=True):
        order, note = None, reasons.get(name, "")
        state = "bad" if name in bad else "left" if record else "frame"
        if name in picked:
            order = picked[name]["order"]
            state, note = "pick", f"pick {order} of {len(picked)}: {adds(picked[name])}"
        elif name in held_out:
            state, note = "held", "held out"
        cameras.append(viewer.ViewerCamera(name, state, note, picture, order))
    return cameras


def _page(sources: Sources, content: dict) -> str:
    """Return the report of the selection, if there is one, with the scene in it; or the scene."""
    if "selection" not in sources:
        names = [path.name for path in sources.values()]
        return viewer.page(f"fsel view: {', '.join(names)}", content)
    file = sources["selection"] / REPORT
    try:
        return with_view(file.read_text(encoding="utf-8"), viewer.component(content))
    except (OSError, ValueError) as error:
        raise ValueError(f"{file}: {error}") from error
