"""A worker as a reconstructor: subsets and views go out as arrays, images come back as one."""

from __future__ import annotations

import itertools
import logging
import shutil
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.programs.outcome import MISSING, Unfinished
from fsel.reconstruct.external import folder as files
from fsel.reconstruct.external.arrays import Arrays
from fsel.reconstruct.external.worker import Lost, Worker
from fsel.reconstruct.subset import distinct, restricted

Result = TypeVar("Result")

COUNTED = ("seconds", "primitives", "bytes", "peak_bytes")  # of a model, where it says so

logger = logging.getLogger(__name__)


class Served:
    """Worker bound to one capture at the reconstruction size.

    Attributes:
        resident_bytes: that it held after the last fit, where it says so.

    A request that loses the worker is repeated once, with the worker started again; what is lost
    twice is reported. A worker that was started again, or bound to another capture since, is handed
    a model's subset again before it renders it.
    """

    def __init__(self, capture: Capture, worker: Worker) -> None:
        self.capture, self.worker = capture, worker
        self._numbers = itertools.count()
        self._bound_at = 0  # the start of the worker at which it was bound to this capture
        self.arrays: Arrays | None = None  # of the whole capture, and of images to fill
        self.resident_bytes = 0
        self.dead: list[int] = []
        self.spare: list[Arrays] = []  # of dead models

    @property
    def together(self) -> int:
        """Number of subsets that the worker takes at once; 1 where it does not start."""
        try:
            self.twice(self.worker.start)
        except Unfinished:
            return 1  # a fit tells why
        return int(self.worker.stated["together"])

    def fit(self, subsets: Sequence[np.ndarray]) -> list[ServedModel]:
        """A model a subset, all by one request.

        Raises:
            ValueError: for fewer than two frames, or repeated ones.
            Unfinished: when the worker fails.
        """
        chosen = [np.sort(distinct(frames)) for frames in subsets]
        self.twice(self.bind)
        models = [ServedModel(self, next(self._numbers), frames) for frames in chosen]
        self.twice(lambda: self.fit_now(models))
        return models

    def twice(self, action: Callable[[], Result]) -> Result:
        """Result of an action, which is tried again where it lost the worker."""
        try:
            return action()
        except Lost as lost:
            logger.warning("worker started again, once: %s", lost)
        return action()

    def fit_now(self, models: Sequence[ServedModel]) -> None:
        """Have subsets fitted that lie in their models' folders, after what died is closed."""
        self.bind()
        if self.dead:
            dead, self.dead = self.dead, []
            self.worker.tell({"do": "close", "models": dead})
        subsets = [
            {"model": m.number, "folder": str(m.arrays.folder), "frames": m.frames.tolist()}
            for m in models
        ]
        with self.worker.watch() as watch:
            answer = self.worker.ask({"do": "fit", "subsets": subsets})
        if wrong := _misfitted(answer, len(models)):
            raise self.worker.lost(f"answered a fit with {wrong}")
        for model, told in zip(models, answer["models"], strict=True):
            model.take(told, watch.peak_bytes // len(models), watch.device)
            model.start = self._bound_at
        most, self.resident_bytes = self.worker.settings.memory, answer.get("resident_bytes", 0)
        if most is not None and self.resident_bytes > most:
            held = self.resident_bytes
            logger.warning("worker holds %d bytes, more than memory allows: %d", held, most)
            self.worker.outgrown = True

    def bind(self) -> None:
        """Start the worker where it does not run, and bind it where it was not bound to this."""
        worker = self.worker
        if worker.outgrown:
            worker.stop()
        worker.start()
        if worker.bound is self:
            return
        whole = "capture" in worker.stated["needs"]
        if self.arrays is None:
            self.arrays = Arrays(worker.folder / f"capture{next(worker.captures)}")
            if whole:
                self.arrays.put_frames(self.capture, points=True)
        request = {"do": "bind", "folder": str(self.arrays.folder), "capture": whole}
        worker.ask(request | {"size": list(self.capture.size)})
        worker.bound, self._bound_at = self, next(worker.bindings)
        self.dead.clear()

    def render(self, model: ServedModel, views: Views) -> np.ndarray:
        """(T, h, w, 3) float32 images, of a model that the worker holds."""
        self.bind()
        if model.start != self._bound_at:
            self.fit_now([model])
        assert self.arrays is not None
        folder, stated = model.arrays.folder, self.worker.stated
        if "files" in stated["needs"]:
            shutil.rmtree(folder / files.RENDERINGS, ignore_errors=True)
            files.write_targets(folder, views)
        width, height = views.size
        shape, kind = (len(views), height, width, 3), np.dtype(stated["pixels"])
        out = self.arrays.room("rendered", shape, kind)
        out[...] = np.nan if kind == np.float32 else 0
        request = {"do": "render", "model": model.number, "folder": str(folder)}
        request |= {"views": str(model.arrays.put_views(views)), "size": [width, height]}
        with self.worker.watch() as watch:
            self.worker.ask(request | {"out": str(self.arrays.path("rendered"))})
        model.peak_bytes = max(model.peak_bytes, watch.peak_bytes)
        if kind == np.uint8:
            return out.astype(np.float32) / 255
        if len(empty := np.flatnonzero(np.isnan(out).all(axis=(1, 2, 3)))):
            raise Unfinished(MISSING, f"target {empty[0]} of {len(out)}: nothing was rendered")
        return np.array(out)

    def __del__(self) -> None:
        if self.arrays is not None and self.worker.settings.workspace is None:
            shutil.rmtree(self.arrays.folder, ignore_errors=True)


class ServedModel:
    """Model that a worker holds; see `fsel.reconstruct.Model`. Its subset's folder goes with it.

    Args:
        served: the worker that fits it, bound to the capture.
        number: of the model.
        frames: (K,) int64, ascending.
    """

    def __init__(self, served: Served, number: int, frames: np.ndarray) -> None:
        self._served, self.number, self.frames = served, number, frames
        self.start = 0
        self.primitives = self.bytes = self.peak_bytes = 0
        self.seconds, self.device = 0.0, ""
        assert served.arrays is not None
        needs = served.worker.stated["needs"]
        own = restricted(served.capture, frames) if needs else served.capture.subset(frames)
        new = served.arrays.folder / str(number)
        self.arrays = served.spare.pop() if served.spare else Arrays(new)
        if "capture" not in needs:
            self.arrays.put_frames(own, "points" in needs)
        if "files" in needs:
            files.write_inputs(self.arrays.folder, own)

    def take(self, told: dict[str, Any], peak_bytes: int, device: str) -> None:
        """Take what a worker said of the fit; memory of a GPU is what was measured here."""
        self.primitives, self.bytes = int(told.get("primitives", 0)), int(told.get("bytes", 0))
        self.seconds = float(told.get("seconds", 0))
        self.peak_bytes = peak_bytes or int(told.get("peak_bytes", 0))
        stated = self._served.worker.stated["device"]
        self.device = device if self._served.worker.settings.gpu else told.get("device", stated)

    def render(self, views: Views) -> np.ndarray:
        """(T, h, w, 3) float32 images in [0, 1].

        Raises:
            Unfinished: when the worker fails, or leaves a view without an image.
        """
        return self._served.twice(lambda: self._served.render(self, views))

    def __del__(self) -> None:
        if not hasattr(self, "arrays"):
            return
        served = self._served
        served.dead.append(self.number)
        if served.worker.settings.workspace is None:
            if "files" in served.worker.stated["needs"]:
                shutil.rmtree(self.arrays.folder, ignore_errors=True)
            else:
                served.spare.append(self.arrays)


def _misfitted(answer: Mapping[str, Any], count: int) -> str:
    """Describe what of the answer to a fit is not allowed; empty where all is."""
    models = answer.get("models")
    if not isinstance(models, list) or len(models) != count:
        return f"models {models!r:.200}; allowed: a list of {count}"
    for told in models:
        numbers = [told.get(key, 0) for key in COUNTED] if isinstance(told, dict) else [None]
        if not all(isinstance(n, int | float) and 0 <= n < float("inf") for n in numbers):
            return f"model {told!r:.200}; allowed: an object with {', '.join(COUNTED)} from 0"
    return ""
