"""Any program as a reconstructor: a worker gets subsets and views, and returns images."""

from __future__ import annotations

import itertools
import logging
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import cv2
import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.forms import Subset, write_trained
from fsel.core.capture import Capture, Views
from fsel.core.points import NO_POINTS, RawPoints
from fsel.core.programs import MISSING, Unfinished
from fsel.core.registry import settings_from
from fsel.reconstruct.configured import ConfiguredReconstructor
from fsel.reconstruct.external.worker import ExternalSettings, Lost, shared
from fsel.reconstruct.selected import distinct, restricted

__all__ = ["External", "ExternalModel", "ExternalSettings"]

Result = TypeVar("Result")

COUNTED = ("primitives", "bytes", "peak_bytes")  # of a model, where the worker says so
POINTS = ("xyz", "rgb", "track_point", "track_frame")

logger = logging.getLogger(__name__)


class External(ConfiguredReconstructor[ExternalSettings]):
    """A worker bound to one capture; see `ExternalSettings`.

    A program sees the selected frames alone, in the order of the capture: their images, cameras and
    masks, and the sparse points that at least two of them see. A request that loses the worker is
    repeated once, with the worker started again. A worker that was started again, or bound to
    another capture since, gets a model's subset again before it renders it.
    """

    settings_type = ExternalSettings

    def __init__(self, capture: Capture, **settings: Any) -> None:
        super().__init__(capture, **settings)
        self.worker = shared(self.settings)  # by the captures of this process
        self._numbers = itertools.count()
        self._bound_at = 0  # the start of the worker at which it was bound to this capture
        self.arrays: Arrays | None = None  # of images to fill
        self.dead: list[int] = []  # models that are no longer used
        self.spare: list[Arrays] = []  # folders of theirs that may be used again

    @classmethod
    def check(cls, **settings: Any) -> None:
        """Refuse settings outside their range; or an environment, a program, a file, a GPU."""
        if missing := settings_from(ExternalSettings, settings).missing():
            raise ExceptionGroup("what is needed and is not here", missing)

    @classmethod
    def needs_gpu(cls, **settings: Any) -> bool:
        """Return what the setting `gpu` says."""
        return settings_from(ExternalSettings, settings).gpu

    def fit(self, frames: np.ndarray) -> ExternalModel:
        """Have the worker reconstruct from (K,) int64 distinct frames, K >= 2; `Unfinished` when it
        fails."""
        frames = np.sort(distinct(frames))
        self.twice(self._bind)
        model = ExternalModel(self, next(self._numbers), frames)
        self.twice(lambda: self._fit(model))
        return model

    def twice(self, action: Callable[[], Result]) -> Result:
        """Return the result of an action, which is tried again where it lost the worker."""
        try:
            return action()
        except Lost as lost:
            logger.warning("worker started again, once: %s", lost)
        return action()

    def _bind(self) -> None:
        """Start the worker unless it runs, and bind it unless it is bound to this."""
        worker = self.worker
        worker.start()
        if worker.bound is self:
            return
        if self.arrays is None:
            self.arrays = Arrays(worker.folder / f"capture{next(worker.captures)}")
        worker.ask({"do": "bind", "size": list(self.capture.size)})
        worker.bound, self._bound_at = self, next(worker.bindings)
        self.dead.clear()

    def _fit(self, model: ExternalModel) -> None:
        """Close the models that died, and fit the subset in a model's folder."""
        self._bind()
        if self.dead:
            dead, self.dead = self.dead, []
            self.worker.tell({"do": "close", "models": dead})
        request = {"do": "fit", "model": model.number, "folder": str(model.arrays.folder)}
        answer = self.worker.ask(request | {"frames": model.frames.tolist()})
        for key in (*COUNTED, "seconds"):
            value = answer.setdefault(key, 0)
            if not isinstance(value, int | float) or not 0 <= value < float("inf"):
                raise self.worker.lost(f"answered a fit with {key} {value!r:.200}; allowed: from 0")
        for key in COUNTED:
            setattr(model, key, int(answer[key]))
        model.seconds = float(answer["seconds"])
        model.device = answer.get("device", self.worker.stated["device"])
        model.start = self._bound_at

    def render(self, model: ExternalModel, views: Views) -> np.ndarray:
        """Return (T, h, w, 3) float32 images of a model, once."""
        self._bind()
        if model.start != self._bound_at:
            self._fit(model)
        assert self.arrays is not None
        width, height = views.size
        shape = (len(views), height, width, 3)
        kind = np.dtype(self.worker.stated["pixels"])
        out = self.arrays.room("rendered", shape, kind)
        out[...] = np.nan if kind == np.float32 else 0
        request = {"do": "render", "model": model.number, "folder": str(model.arrays.folder)}
        rows = np.concatenate([views.world_to_camera.reshape(-1, 12), views.intrinsics], axis=1)
        request |= {"views": str(model.arrays.put("views", rows)), "size": [width, height]}
        self.worker.ask(request | {"out": str(self.arrays.path("rendered"))})
        if kind == np.uint8:
            return out.astype(np.float32) / 255
        if len(empty := np.flatnonzero(np.isnan(out).all(axis=(1, 2, 3)))):
            raise Unfinished(MISSING, f"target {empty[0]} of {len(out)}: nothing was rendered")
        return np.array(out)

    def __del__(self) -> None:
        arrays = getattr(self, "arrays", None)  # settings may have been refused
        if arrays is not None:
            shutil.rmtree(arrays.folder, ignore_errors=True)


class ExternalModel:
    """Model of (K,) frames that a worker holds by a number; its subset's folder goes with it."""

    def __init__(self, reconstructor: External, number: int, frames: np.ndarray) -> None:
        self._reconstructor, self.number, self.frames = reconstructor, number, frames
        self.start = 0
        self.primitives = self.bytes = self.peak_bytes = 0
        self.seconds, self.device = 0.0, ""
        assert reconstructor.arrays is not None
        needs, capture = reconstructor.worker.stated["needs"], reconstructor.capture
        own = restricted(capture, frames) if needs else capture.subset(frames)
        spare, new = reconstructor.spare, reconstructor.arrays.folder / str(number)
        self.arrays = spare.pop() if spare else Arrays(new)
        self.arrays.put_frames(own, "points" in needs)
        if "files" in needs:
            write_files(self.arrays.folder, own)

    def render(self, views: Views) -> np.ndarray:
        """Return (T, h, w, 3) float32 images in [0, 1]; `Unfinished` when the worker fails, or
        leaves a view without an image."""
        return self._reconstructor.twice(lambda: self._reconstructor.render(self, views))

    def __del__(self) -> None:
        if not hasattr(self, "arrays"):
            return
        owner = self._reconstructor
        owner.dead.append(self.number)
        if "files" in owner.worker.stated["needs"]:
            shutil.rmtree(self.arrays.folder, ignore_errors=True)
        else:
            owner.spare.append(self.arrays)


class Arrays:
    """A new folder of `.npy` files that stay mapped: making files takes milliseconds."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir()
        self.folder = folder
        self._mapped: dict[str, np.memmap] = {}

    def path(self, name: str) -> Path:
        """Return the file of an array."""
        return self.folder / f"{name}.npy"

    def room(self, name: str, shape: tuple[int, ...], kind: np.dtype) -> np.memmap:
        """Return a mapped array, with its former content."""
        found = self._mapped.get(name)
        if found is None or found.shape != shape or found.dtype != kind:
            path = self.path(name)
            path.unlink(missing_ok=True)
            found = np.lib.format.open_memmap(path, mode="w+", dtype=kind, shape=shape)
            self._mapped[name] = found
        return found

    def put(self, name: str, array: np.ndarray) -> Path:
        """Write an array; return its file."""
        self.room(name, array.shape, array.dtype)[...] = array
        return self.path(name)

    def put_frames(self, capture: Capture, points: bool) -> None:
        """Write the frames' images, masks and cameras, and the sparse points."""
        for name in ("images", "masks", "world_to_camera", "intrinsics"):
            if (array := getattr(capture, name)) is not None:
                self.put(name, array)
        if points and capture.points is not None:
            for name in POINTS:
                self.put(name, getattr(capture.points, name))


def write_files(folder: Path, capture: Capture) -> None:
    """Write a capture of the selected frames alone as trainers read them.

    images/000000.png ...   the frames, undistorted, in the capture's order
    masks/000000.png.png .. white where a pixel counts, when the capture has masks
    transforms.json         their cameras as nerfstudio states them, in the capture's own world
    sparse/0/*.bin          their cameras as COLMAP states them, and the points that two of them see
    sparse_pc.ply           those points
    """
    names = [f"{row:06d}.png" for row in range(len(capture))]
    for row, name in enumerate(names):
        _write(folder / "images" / name, np.asarray(capture.images[row])[:, :, ::-1])
        if capture.masks is not None:
            mask = np.asarray(capture.masks[row]).astype(np.uint8) * 255
            _write(folder / "masks" / f"{name}.png", mask)
    pinholes = capture.intrinsics.tolist()
    cameras = [Camera("PINHOLE", *capture.size, tuple(params)) for params in pinholes]
    poses, masked = capture.world_to_camera, capture.masks is not None
    sizes = [capture.size] * len(names)
    write_trained(Subset(names, cameras, sizes, poses, _pixels(capture), masked), folder)


def _write(path: Path, image: np.ndarray) -> None:
    path.parent.mkdir(exist_ok=True)
    if not cv2.imwrite(str(path), image):
        raise OSError(f"{path}: could not be written")


def _pixels(capture: Capture) -> RawPoints:
    """Return a capture's points, seen where its cameras project them."""
    points = capture.points or NO_POINTS
    poses, pinholes = (
        array[points.track_frame] for array in (capture.world_to_camera, capture.intrinsics)
    )
    turned = np.einsum("nij,nj->ni", poses[:, :, :3], points.xyz[points.track_point])
    local = turned + poses[:, :, 3]
    pixels = local[:, :2] / local[:, 2:] * pinholes[:, :2] + pinholes[:, 2:]
    return RawPoints(points.xyz, points.rgb, points.track_point, points.track_frame, pixels)
