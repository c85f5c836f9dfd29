"""`fsel select --blocks`: a selection of each overlapping block of a large scene."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from itertools import chain
from pathlib import Path

from fsel.captures.quality.examination import examined
from fsel.cli.console import Console
from fsel.core.files import json_text
from fsel.core.subsets import evenly
from fsel.selection.blocks import blocks_of
from fsel.selection.request import SelectionRequest

ALONE = ("targets", "method", "weights", "always", "never", "masks", "box")  # no blocks


def vet(args: argparse.Namespace) -> None:
    """Refuse what does not go with blocks."""
    stated = [f"--{name}" for name in ALONE if getattr(args, name)]
    if stated or not isinstance(args.k, int):
        raise ValueError(f"--blocks excludes {', '.join(stated) or '-k auto'}. Hint: -k 40")


def run(
    request: SelectionRequest,
    count: int,
    select: Callable[[SelectionRequest, str], dict],
    out: Path,
    console: Console,
) -> dict:
    """Select from each block into a folder of its own, and list which picks blocks share.

    A block begins with earlier ones' picks among its frames, up to half of its own.
    """
    source, k = request.opened, request.k
    assert source is not None
    assert isinstance(k, int)
    entries: list[dict] = []
    blocks, health = blocks_of(source.with_all_points(), count), None
    if not request.keep_bad:  # of the whole: blocks overlap, and images take longest to read
        shown, bar = max(map(len, blocks)), console.bar("health")
        health = examined(source, bar, images=request.pictured, shown=shown)
    for number, frames in enumerate(blocks, 1):
        part, folder = source.part(frames), f"block_{number}"
        taken = {name for entry in entries for name in entry["picks"]}
        known = [name for name in part.capture.names if name in taken]
        always = [known[at] for at in evenly(len(known), k // 2)]
        found = health and health.part(frames)
        made = select(replace(request, source=part, always=always, health=found), folder)
        picks = [entry["name"] for entry in made["frames"]]
        own = {"picks": picks, "frames": part.capture.names, "tried": made["tried"]}
        entries.append({"folder": folder} | own)
    for entry in entries:
        picked, beside = set(entry["picks"]), [other for other in entries if other is not entry]
        same = {other["folder"]: [p for p in other["picks"] if p in picked] for other in beside}
        entry["shared"] = {folder: names for folder, names in same.items() if names}
        text = "".join(f"{name}\n" for name in dict.fromkeys(chain(*same.values())))
        (out / entry["folder"] / "shared.txt").write_text(text, encoding="utf-8")
    (out / "blocks.json").write_text(json_text({"blocks": entries}), encoding="utf-8")
    return {"blocks": entries}
