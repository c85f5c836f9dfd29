"""The Python calls on whatever holds a capture: a folder, a video, a COLMAP model, a JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import wraps
from inspect import BoundArguments, signature
from pathlib import Path
from typing import Any

import numpy as np

from fsel.captures.colmap.camera import pycolmap
from fsel.captures.images import video
from fsel.captures.layouts import colmap, nerfstudio
from fsel.captures.lazy import LazyCapture, open_capture, opened, posed, unread
from fsel.core.capture import Capture
from fsel.core.outputs import staged
from fsel.core.wording import unexpected
from fsel.selection import api
from fsel.selection.export import subset

ACCEPTED = (
    "a folder, a video, a Capture (fsel.read_capture), a pycolmap.Reconstruction, or the content "
    "of a transforms.json"
)
GIVEN = {"reconstruction": colmap.LAYOUT, "transforms.json": nerfstudio.LAYOUT}


@dataclass(frozen=True, repr=False)
class Selection(api.Selection):
    """Picked frames, best first, with their capture; see `fsel.selection.select.Selection`.

    Attributes:
        capture: that was selected from.
    """

    capture: Capture = field(kw_only=True)

    def export(
        self,
        folder: str | Path,
        *,
        link: bool = False,
        long_side: int | None = None,
        points: str = "seen",
        force: bool = False,
    ) -> Path:
        """Write the picks as captures that trainers read, and frames.txt, as `fsel select` does.

        Args:
            folder: to write; it appears whole or not at all.
            link: whether images are hard links.
            long_side: pixels that the images are reduced to; None as they are.
            points: `seen` by two picks, `all` or `none`.
            force: whether what an earlier export wrote, and nobody changed, is replaced.

        Returns:
            The folder.

        Raises:
            ValueError: for a capture that has no image files.
            FileExistsError: for a folder that is there already.
        """
        source = _with_files(self.capture)
        subset.check_cameras(source.raw, undistort=False)
        form = subset.Form(link=link, long_side=long_side, points=points)
        with staged(Path(folder), [], force) as stage:
            subset.write(stage, source, self.indices, self.held_out, form)
            names = "".join(f"{name}\n" for name in self.names)
            (stage / "frames.txt").write_text(names, encoding="utf-8")
        return Path(folder)


@wraps(api.select)
def select(
    capture: Capture | str | Path | Mapping[str, Any] | pycolmap.Reconstruction,
    *arguments: Any,
    **options: Any,
) -> Selection:
    held = captured(capture)
    given = signature(api.select).bind(held, *arguments, **options)
    known = held.capture if isinstance(held, LazyCapture) else held
    if isinstance(held, LazyCapture) and not held.pictured:
        given.arguments |= _unseen(given, known)
    return Selection(**vars(api.select(*given.args, **given.kwargs)), capture=known)


def captured(
    source: Capture | str | Path | Mapping[str, Any] | pycolmap.Reconstruction,
) -> Capture | LazyCapture:
    """Open what holds a capture.

    Raises:
        TypeError: for anything else.
        ValueError, FileNotFoundError: as `fsel.read_capture`.
    """
    if isinstance(source, Capture):
        return source
    if isinstance(source, str | Path):
        return _filmed(Path(source)) if video.is_video(Path(source)) else open_capture(source)
    if isinstance(source, Mapping):
        name, folder = "transforms.json", Path()
        raw = nerfstudio.from_json(Path(name), folder, content=dict(source))
    elif isinstance(source, pycolmap.Reconstruction):
        name, folder = "reconstruction", Path()
        raw = colmap.from_model(source, folder, Path(name))
    else:
        raise unexpected("capture", source, ACCEPTED)
    if any(Path(str(file)).is_file() for file in raw.images):
        return opened(GIVEN[name], raw, folder)
    return posed(name, raw)


def _filmed(film: Path) -> LazyCapture:
    """The capture of a video, as the command line finds its poses."""
    from fsel.cli import posing
    from fsel.cli.console import Console
    from fsel.cli.parser import parsed

    return posing.opened(parsed(["info", str(film)]), Console(quiet=True, as_json=False))


def _unseen(given: BoundArguments, capture: Capture) -> dict[str, Any]:
    """Arguments that `fsel select --geometry-only` adds: nothing is tried on images."""
    stated = given.arguments
    if "sharpness" in api.method_of(stated.get("method"), stated.get("weights")).reads:
        capture.images[0]  # refused
    added = {"patience": 0, "sharpness": np.zeros(len(capture))}
    return {name: value for name, value in added.items() if name not in stated}


def _with_files(capture: Capture) -> LazyCapture:
    """The capture and the files behind it."""
    if capture.files is None:
        raise ValueError(
            f"{capture!r}: was not read from image files, which an export is made of. "
            "Hint: fsel.select(folder, ...)"
        )
    layout = capture.source.partition(" at ")[0]
    return unread(layout, capture.files, capture)
