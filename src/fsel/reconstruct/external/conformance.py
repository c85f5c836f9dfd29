"""Checks that a program keeps the protocol of a worker, on a small capture made for it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fsel.core.capture import Capture
from fsel.core.programs.outcome import Unfinished
from fsel.reconstruct.external.serving import Served, ServedModel
from fsel.reconstruct.external.settings import ExternalSettings
from fsel.reconstruct.external.worker import GRACE, Worker

SCHEMA = Path(__file__).with_name("worker.schema.json")
FRAMES, SIZE, OTHER_SIZE = 16, (64, 48), (40, 56)
TOLERANCE = 1 / 255  # between images that should be the same
FITS, GROWTH = 20, 1 << 20  # fits after which memory is compared, and bytes a fit it may grow by


def ring(count: int, size: tuple[int, int]) -> Capture:
    """Cameras on a circle that look at its middle, a checked ball, in images of some size.

    Args:
        count: frames.
        size: (width, height).
    """
    angles = 2 * np.pi * np.arange(count) / count / 2
    forward = np.stack([-np.cos(angles), np.zeros(count), -np.sin(angles)], axis=1)
    down = np.tile([0.0, 1, 0], (count, 1))
    rotations = np.stack([np.cross(down, forward), down, forward], axis=1)
    poses = np.concatenate([rotations, np.tile([[0.0], [0], [3]], (count, 1, 1))], axis=2)
    width, height = size
    cameras = np.tile([width, width, width / 2, height / 2], (count, 1)).astype(np.float64)
    x, y = np.meshgrid((np.arange(width) + 0.5) / width - 0.5, (np.arange(height) + 0.5) / width)
    y = y - height / width / 2
    inside = x**2 + y**2 < 0.09
    bend = np.arcsin(np.clip(x / 0.3, -1, 1))
    images = [
        np.where(inside, np.sin(9 * (bend + angle)) * np.sin(30 * y) > 0, 0.5) for angle in angles
    ]
    grey = (np.stack(images) * 200 + 20).astype(np.uint8)
    names = tuple(f"{i:02d}.png" for i in range(count))
    colours = np.repeat(grey[..., None], 3, axis=3)
    return Capture(names, poses, cameras, colours, names, source="a ball made for the check")


@dataclass(frozen=True)
class Checked:
    """Outcome of one check.

    Attributes:
        title: what was checked.
        wrong: what is wrong; empty where all is well.
        note: what else was seen.
    """

    title: str
    wrong: str = ""
    note: str = ""


class Checks:
    """The checks of one program.

    Args:
        settings: with `serve`.
    """

    def __init__(self, settings: ExternalSettings) -> None:
        self.worker = Inspected(settings)
        self.served = Served(ring(FRAMES, SIZE), self.worker)

    def run(self) -> Iterator[Checked]:
        """Yield the outcome of every check; none is made after the first, where that fails."""
        for title, check in CHECKS.items():
            try:
                yield Checked(title, note=check(self) or "")
            except (Unfinished, Violation) as error:
                yield Checked(title, wrong=str(error))
                if check is Checks.states_itself:
                    break
        self.worker.close()

    def states_itself(self) -> str:
        """Check what it says when it starts."""
        self.worker.start()
        stated = self.worker.stated
        needs = ", ".join(stated["needs"]) or "the selected frames alone"
        return (
            f"{stated['name']} {stated['version']} on {stated['device']}; needs {needs}; "
            f"{stated['together']} at once; {stated['pixels']}"
        )

    def fits_and_renders(self) -> None:
        """Check images of three views, and of one of them."""
        model = self._fitted(range(0, 12, 2))
        images = self._rendered(model, [1, 3, 5])
        if images.min() < -TOLERANCE or images.max() > 1 + TOLERANCE:
            raise Violation(f"values from {images.min():g} to {images.max():g}; allowed: 0 to 1")
        self._same(self._rendered(model, [3]), images[1:2], "a view alone and among others")

    def keeps_models_apart(self) -> None:
        """Check that a model stays what it was while others are fitted."""
        first = self._fitted(range(0, 12, 2))
        before = self._rendered(first, [1])
        self._fitted(range(1, 9))
        self._same(self._rendered(first, [1]), before, "a model before and after another fit")

    def repeats_itself(self) -> str:
        """Say how far two fits of the same frames differ."""
        one, two = (self._rendered(self._fitted(range(4, 10)), [1, 3]) for _ in range(2))
        apart = float(np.abs(one - two).max())
        return f"two fits of the same frames differ by {apart:.2g}" if apart else "to the bit"

    def answers_errors(self) -> None:
        """Check that a model that is not there is an error, after which it goes on."""
        self.served.twice(self.served.bind)
        request = {
            "do": "render",
            "model": 10**6,
            "folder": str(self.worker.folder),
            "size": [4, 3],
        }
        request |= {"views": "no/views.npy", "out": "no/out.npy"}
        try:
            self.worker.ask(request)
        except Unfinished:
            if not self.worker.running:
                raise
        else:
            raise Violation("a model that was never fitted was rendered without an error")
        self._fitted(range(2, 8))

    def takes_batches(self) -> str:
        """Check subsets fitted at once against each alone."""
        count = self.served.together
        if count == 1:
            return "one at a time"
        subsets = [np.arange(at, at + 5) for at in range(min(count, FRAMES - 5))]
        for model, frames in zip(self.served.fit(subsets), subsets, strict=True):
            alone = self._rendered(self._fitted(frames), [15])
            self._same(self._rendered(model, [15]), alone, "a subset alone and in a batch")
        return f"{len(subsets)} subsets"

    def forgets_what_was_closed(self) -> str:
        """Check that memory does not grow with the number of fits."""
        held = []
        for at in range(FITS + 5):
            self._rendered(self._fitted(range(at % 8, at % 8 + 6)), [15])
            held.append(self.served.resident_bytes)
        if not held[-1]:
            return "it does not tell resident_bytes"
        growth = (held[-1] - held[4]) // FITS
        if growth > GROWTH:
            raise Violation(f"memory grows by {growth / 1e6:.1f} MB a fit; allowed: 1")
        return f"{held[-1] / 1e6:.0f} MB"

    def takes_another_capture(self) -> None:
        """Check frames of another size, and the first capture again."""
        before = self._rendered(self._fitted(range(6)), [7])
        other = Served(ring(FRAMES - 4, OTHER_SIZE), self.worker)
        other.fit([np.arange(5)])[0].render(other.capture.view(np.arange(6, 8)))
        self._same(self._rendered(self._fitted(range(6)), [7]), before, "before and after another")

    def ends_with_its_input(self) -> None:
        """Check that it ends by itself."""
        self.worker.start()
        code = self.worker.stop()
        if code is not None and code < 0:
            raise Violation(f"it did not end within {GRACE:g} s of the end of its input")
        if code:
            raise Violation(f"it ended with exit code {code}; allowed: 0")

    def _fitted(self, frames: Any) -> ServedModel:
        return self.served.fit([np.array(frames)])[0]

    def _rendered(self, model: ServedModel, frames: list[int]) -> np.ndarray:
        images = model.render(self.served.capture.view(np.array(frames)))
        if not np.isfinite(images).all():
            raise Violation("images have values that are not finite")
        return images

    def _same(self, one: np.ndarray, other: np.ndarray, what: str) -> None:
        apart = float(np.abs(one - other).max())
        if apart > TOLERANCE:
            raise Violation(f"{what} differ by {apart:.3g}; allowed: {TOLERANCE:.3g}")


class Inspected(Worker):
    """A worker whose answers are compared with the schema."""

    def ask(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """The answer to a request.

        Raises:
            Violation: for an answer that the schema does not allow; else as of a worker.
        """
        answer = super().ask(request)
        for error in _validator(request["do"]).iter_errors(answer):
            raise Violation(f"answer to {request['do']!r}: {error.json_path}: {error.message}")
        return answer


@cache
def _validator(kind: str) -> Any:
    from jsonschema import Draft202012Validator  # here: selecting does without

    definitions = json.loads(SCHEMA.read_text(encoding="utf-8"))["$defs"]
    return Draft202012Validator({"$ref": f"#/$defs/{kind}", "$defs": definitions})


class Violation(Exception):
    """Something that the protocol does not allow."""


CHECKS: dict[str, Callable[[Checks], str | None]] = {
    "states itself": Checks.states_itself,
    "fits and renders": Checks.fits_and_renders,
    "keeps models apart": Checks.keeps_models_apart,
    "repeats itself": Checks.repeats_itself,
    "answers errors and goes on": Checks.answers_errors,
    "takes batches": Checks.takes_batches,
    "forgets what was closed": Checks.forgets_what_was_closed,
    "takes another capture": Checks.takes_another_capture,
    "ends with its input": Checks.ends_with_its_input,
}
