"""`fsel view`: a splat, or a capture's points, with cameras and photos, as a page for a browser."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np

from fsel.captures.images.previews import in_turn, jpeg, reduced
from fsel.cli import open_capture
from fsel.cli.console import Console
from fsel.cli.open_capture import as_written, open_as, record_of
from fsel.core.outputs import staged
from fsel.core.wording import counted
from fsel.pages import viewer
from fsel.pages.report import REPORT, with_view
from fsel.pages.shown import SIDE, adds, picture_side
from fsel.pages.viewer.bundle import script
from fsel.reconstruct import ply
from fsel.selection.export.forms import CLOUD
from fsel.selection.export.record import RECORD

MODEL = "/model.ply"
KINDS = "a .ply of Gaussians, a folder that `fsel select` wrote, or a capture"


@dataclass(frozen=True)
class Sources:
    """Files and folders that a command line names; see `sources_of`."""

    model: Path | None
    selection: Path | None
    record: dict
    capture: Path | None

    @property
    def read(self) -> list[Path]:
        """The files and folders that are read."""
        paths = (self.model, self.selection, self.capture)
        return [path for path in paths if path is not None]


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    sources = sources_of(args.source)
    if args.out is not None and args.out.suffix.lower() != ".html":
        raise ValueError(f"{args.out}: a page is written as .html. Hint: -o NAME.html")
    script()  # a viewer that cannot be made is refused before work
    if args.serve is not None:
        _serve(args, sources, console)
        return
    with staged(args.out, sources.read, args.force, folder=False) as stage:
        content, _ = _scene(args, sources, console)
        page = _page(sources, content)
        stage.write_text(page, encoding="utf-8")
    console.say("written", f"{args.out}: {len(page) / 1e6:.1f} MB, for a browser")
    console.give({"page": str(args.out.resolve()), "cameras": len(content["cameras"])})


def sources_of(given: list[Path]) -> Sources:
    """Sort the given paths: a model, a selection (which names its capture), or a capture.

    Raises:
        ValueError: for a path that is none of these, or two of a kind.
    """
    found: dict[str, Path] = {}
    for path in given:
        if not path.exists():
            raise ValueError(f"{path}: is not there. Hint: {KINDS}")
        if path.is_file() and path.suffix.lower() == ".ply":
            kind = "model"
        else:
            kind = "selection" if (path / RECORD).is_file() else "capture"
        if kind in found:
            raise ValueError(f"{path}: a second {kind} beside {found[kind]}; allowed: one")
        found[kind] = path
    model, record = found.get("model"), {}
    if "selection" in found:
        record = record_of(found["selection"])
        inside = [ply for ply in found["selection"].glob("*.ply") if ply.name != CLOUD]
        model = model or (inside[0] if len(inside) == 1 else None)
    stated = Path(record["capture"]["folder"]) if record else None
    return Sources(model, found.get("selection"), record, found.get("capture", stated))


def _scene(
    args: argparse.Namespace, sources: Sources, console: Console, url: str | None = None
) -> tuple[dict, ply.Cloud | None]:
    """Return the content of the page, and the Gaussians that it shows."""
    cloud = None
    if sources.model is not None:
        cloud = ply.read(sources.model)
        if not len(cloud.xyz):
            raise ValueError(f"{sources.model}: holds no Gaussians, so nothing would be seen")
        console.say("model", f"{len(cloud.xyz)} Gaussians, harmonics of degree {cloud.degree}")
    if sources.capture is None:
        return viewer.scene(None, [], cloud, url=url), cloud
    args.capture = sources.capture
    open_as(args, sources.record)
    opened = open_capture.opened(args, console, args.long_side)
    capture = opened.capture if cloud is not None else opened.with_all_points()
    capture = as_written(capture, sources.record)
    side = args.long_side * picture_side(len(capture)) // SIDE  # many would make a page too large
    pictures = in_turn(
        lambda at: jpeg(reduced(np.asarray(capture.images[at]), side)),
        opened.raw.images,
        console.bar("pictures"),
    )
    cameras = _cameras(capture.names, pictures, sources.record)
    said = ", ".join(
        f"{sum(one.state == state for one in cameras)} {told['label']}"
        for state, told in viewer.STATES.items()
        if any(one.state == state for one in cameras)
    )
    console.say("capture", f"{counted(len(cameras), 'camera')}, {opened.layout}: {said}")
    return viewer.scene(capture, cameras, cloud, capture.points, url), cloud


def _cameras(
    names: Sequence[str], pictures: Sequence[bytes], record: dict
) -> list[viewer.ViewerCamera]:
    """Return every frame with its state in the selection, if there is one, and its picture."""
    picked = {entry["name"]: entry for entry in record.get("frames", ())}
    reasons = {entry["name"]: entry["reason"] for entry in record.get("left", ())}
    held = set(record.get("targets", {}).get("held_out", ()))
    bad = {entry["name"] for entry in record.get("bad") or () if entry["left_out"]}

    def told(name: str) -> tuple[str, str]:
        if name in picked:
            entry = picked[name]
            return "pick", f"pick {entry['order']} of {len(picked)}: {adds(entry)}"
        if name in held:
            return "held", "held out"
        state = "bad" if name in bad else "left" if record else "frame"
        return state, reasons.get(name, "")

    return [
        viewer.ViewerCamera(name, *told(name), picture, picked.get(name, {}).get("order"))
        for name, picture in zip(names, pictures, strict=True)
    ]


def _page(sources: Sources, content: dict) -> str:
    """The report of the selection, if there is one, with the scene in it; or the scene alone."""
    if sources.selection is None:
        names = [path.name for path in sources.read]
        return viewer.page(f"fsel view: {', '.join(names)}", content)
    file = sources.selection / REPORT
    try:
        return with_view(file.read_text(encoding="utf-8"), viewer.component(content))
    except (OSError, ValueError) as error:
        raise ValueError(f"{file}: {error}") from error


def _serve(args: argparse.Namespace, sources: Sources, console: Console) -> None:
    """Answer a browser on this machine until Ctrl-C."""
    answers: dict[str, tuple[str, bytes]] = {}
    with _server(args.serve, answers) as server:
        content, cloud = _scene(args, sources, console, url=MODEL)
        answers["/"] = ("text/html; charset=utf-8", _page(sources, content).encode())
        if cloud is not None:
            moved = viewer.moved(cloud, np.array(content["origin"]))
            answers[MODEL] = ("application/octet-stream", moved)
        console.say("serving", f"http://127.0.0.1:{server.server_port}/ until Ctrl-C")
        with suppress(KeyboardInterrupt):
            server.serve_forever()


def _server(port: int, answers: dict[str, tuple[str, bytes]]) -> ThreadingHTTPServer:
    """Start a server of this machine that gives (type, content) of each path.

    Raises:
        ValueError: for a port that cannot be had.
    """

    class Answers(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            kind, body = answers.get(self.path, ("text/plain", b""))
            self.send_response(200 if self.path in answers else 404)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            with suppress(ConnectionError):  # the page was closed
                self.wfile.write(body)

        def log_message(self, *said: object) -> None:
            """Nothing: a person looks at the page."""

    try:
        return ThreadingHTTPServer(("127.0.0.1", port), Answers)
    except OSError as error:
        raise ValueError(f"--serve {port}: {error.strerror}. Hint: another port") from error
