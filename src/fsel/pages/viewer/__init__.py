"""A scene in a browser: a splat or points, the cameras around it, and their photos, in one page."""

from __future__ import annotations

import base64
import gzip
import io
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from fsel.core.capture import Capture
from fsel.core.geometry import upwards
from fsel.core.points import SparsePoints
from fsel.core.subsets import evenly
from fsel.pages.shell import data, head, source
from fsel.reconstruct import ply
from fsel.reconstruct.gaussians.render import NEAREST
from fsel.selection.paths import attention

WEB = Path(__file__).parent / "web"
SCRIPT = WEB.with_name("bundle.js")  # `make viewer` makes it of what is in `web`
STATES = {  # colours of the report
    "pick": {"colour": "#d55e00", "label": "picked"},
    "held": {"colour": "#0072b2", "label": "held out"},
    "left": {"colour": "#b5b5b5", "label": "left out"},
    "bad": {"colour": "#b00020", "label": "bad"},
    "frame": {"colour": "#b5b5b5", "label": "frames"},
}
MOST_POINTS = 20_000
BITS = 11  # of a mantissa that are kept in the page, of 23: half the bytes, less than 0.05 %
BEHIND = (0.13, 0.13, 0.13)  # colour behind points
BACK = {True: 1.4, False: 1.9}  # times as far from the middle as the first camera: where the page's
# view of a splat begins, and of points, which hide nothing
UNCOLOURED = 190  # grey of points without colours
RAISED = 0.25  # of the extent, upwards of that
DOWN = np.array([0.0, 1.0, 0.0])  # of the world, where no camera tells: as COLMAP's first camera


@dataclass(frozen=True)
class ViewerCamera:
    """A camera as the page shows it."""

    name: str  # of its frame
    state: str  # a key of `STATES`
    note: str = ""  # what a person should know of it
    picture: bytes | None = None  # JPEG of its frame as its camera sees it
    order: int | None = None  # of a pick, from 1


def packed(cloud: ply.Cloud, origin: np.ndarray) -> bytes:
    """Return a `.ply` file of a cloud around an origin, (3,), with parameters rounded to `BITS`, as
    a gzip file of half the size."""
    gone, thin = 23 - BITS, {}
    for name in ("harmonics", "logit", "log_scale", "turn"):
        bits = getattr(cloud, name).astype(np.float32).view(np.uint32) + (1 << (gone - 1))
        thin[name] = (bits >> gone << gone).view(np.float32)
    stream = io.BytesIO()
    ply.write(stream, replace(cloud, xyz=cloud.xyz - origin, **thin))
    return gzip.compress(stream.getvalue(), 6, mtime=0)


def scene(
    capture: Capture | None,
    cameras: Sequence[ViewerCamera],
    cloud: ply.Cloud | None,
    points: SparsePoints | None = None,
) -> dict:
    """Return the content of a page, for the script's `mount`; lengths in world units.

    Args:
        capture: whose `cameras` are shown, one a frame; None shows none.
        cloud: Gaussians; None shows the `points`.

    Returns:
        `origin`, which everything is relative to; `model` or `points`; the `cameras` with poses (12
        numbers, world to camera), intrinsics and size; and the view that the page begins with.
    """
    content = np.empty((0, 3)) if points is None else points.xyz
    if cloud is not None:
        content = cloud.xyz
    middle, reach, start, up = _beginning(capture, content, BACK[cloud is not None])
    origin = middle.astype(np.float32).astype(np.float64)
    scene = {
        "origin": origin.tolist(),
        "up": up.tolist(),
        "target": (middle - origin).tolist(),
        "start": (start - origin).tolist(),
        "extent": reach,
        "near": reach / 1000 if cloud is None else NEAREST,
        "background": BEHIND if cloud is None else cloud.background.tolist(),
        "states": STATES,
        "cameras": [] if capture is None else _cameras(capture, cameras, origin),
        "model": None,
        "points": None,
    }
    if cloud is not None:
        scene["model"] = base64.b64encode(packed(cloud, origin)).decode()
    elif points is not None:
        some = evenly(len(points.xyz), MOST_POINTS)
        places = (points.xyz[some] - origin).astype(np.float32).round(5)
        colours = points.rgb[some] if points.rgb.any() else np.full((len(some), 3), UNCOLOURED)
        scene["points"] = {"xyz": places.tolist(), "rgb": colours.tolist()}
    return scene


def _beginning(
    capture: Capture | None, content: np.ndarray, back: float
) -> tuple[np.ndarray, float, np.ndarray, np.ndarray]:
    """Return middle and extent of a scene, where its view begins, and the upward direction."""
    middle = np.median(content, axis=0) if len(content) else np.zeros(3)
    if capture is None:
        reach = float(np.median(np.linalg.norm(content - middle, axis=1))) * 3 or 1.0
        return middle, reach, middle - reach * np.array([0.0, 0.3, 1.0]), -DOWN
    try:
        middle = attention(capture.centers, capture.axes)
    except ValueError:  # no common point: what is seen has its own middle
        middle = middle if len(content) else capture.centers.mean(axis=0)
    reach = float(np.linalg.norm(capture.centers - middle, axis=1).max()) or 1.0
    up = upwards(capture.world_to_camera)
    start = middle + back * (capture.centers[0] - middle) + RAISED * reach * up
    return middle, reach, start, up


def _cameras(capture: Capture, cameras: Sequence[ViewerCamera], origin: np.ndarray) -> list[dict]:
    poses = capture.world_to_camera.copy()
    poses[:, :, 3] += poses[:, :, :3] @ origin
    return [
        asdict(camera)
        | {
            "picture": camera.picture and source(camera.picture),
            "pose": pose.ravel().round(8).tolist(),
            "intrinsics": intrinsics.round(4).tolist(),
            "size": capture.size,
        }
        for camera, pose, intrinsics in zip(cameras, poses, capture.intrinsics, strict=True)
    ]


def component(content: dict) -> str:
    """Return an element that shows a `scene`; scripts find it as `view`, to `fly` and `leave`."""
    style, script = (f.read_text(encoding="utf-8") for f in (WEB / "viewer.css", SCRIPT))
    find = "document.getElementById"
    mounted = f"fselViewer.mount({find}('view'), JSON.parse({find}('view-data').textContent))"
    return (
        f"<style>{style}</style><div id='view'></div><script>{script}</script>"
        f"{data('view-data', content)}"
        f"<script>window.view = {mounted};</script>"
    )


def page(title: str, content: dict) -> str:
    """Return a page of one scene, which opens from disk; see `scene`."""
    whole = "html, body, #view { height: 100%; margin: 0; }"
    return "\n".join([head(title, whole), component(content), "</body></html>"])
