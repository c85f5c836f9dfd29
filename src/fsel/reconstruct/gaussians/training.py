"""The optimisation on the CPU: one step after the other."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np

from fsel.capture import Capture
from fsel.reconstruct.gaussians import densify, losses, optimiser
from fsel.reconstruct.gaussians.render import NEAREST, Canvas, camera_of
from fsel.reconstruct.gaussians.settings import GaussianSettings
from fsel.reconstruct.gaussians.table import LOGIT
from fsel.reconstruct.normalisation import Frame

RELOCATED = 100  # steps between relocations
SETTLED = 5 / 6  # share of the steps after which nothing is relocated (Kheradmand et al. 2024)
RAISED = 1 / 30  # share of the steps between two degrees of the harmonics (Kerbl et al. 2023)


class Steps(ABC):
    """Gaussians that are being fitted to all frames of a capture: what every device shares, the
    order of the views, and when what is done.

    Args:
        capture: of the selected frames alone.
        frame: the normalised frame.
        table: (n, c) float32 parameters to start from.
        background: (3,) colour behind everything.
        settings: of the reconstructor.
    """

    def __init__(
        self,
        capture: Capture,
        frame: Frame,
        table: np.ndarray,
        background: np.ndarray,
        settings: GaussianSettings,
    ) -> None:
        self.settings, self.alive, self.views = settings, len(table), len(capture)
        self.rng = np.random.default_rng(settings.seed)
        self.rates = optimiser.Rates(settings.degree, settings.steps)
        self.queue: list[int] = []
        room = np.zeros((settings.gaussians if len(table) else 0, table.shape[1]), np.float32)
        room[: len(table)] = table
        self.prepare(capture, frame, room, background)

    @abstractmethod
    def prepare(
        self, capture: Capture, frame: Frame, room: np.ndarray, background: np.ndarray
    ) -> None:
        """Put everything where the steps need it; `room` is the table, with rows to grow into."""

    @abstractmethod
    def step(self, step: int) -> float:
        """One update; returns the mean loss of its views before it, without the penalties."""

    @property
    @abstractmethod
    def kept(self) -> np.ndarray:
        """(n, c) float32, the Gaussians that add to any pixel."""

    def run(self, progress: Callable | None, stop: Callable[[], bool] | None) -> int:
        """All steps, or those before `stop` says so; returns how many were made."""
        steps = self.settings.steps if self.alive else 0
        for step in range(steps):
            if stop is not None and stop():
                return step
            loss = self.step(step)
            if progress is not None:
                progress(step + 1, steps, loss)
        return steps

    def degree(self, step: int) -> int:
        """Of the harmonics in use."""
        return min(self.settings.degree, int(step / max(RAISED * self.settings.steps, 1)))

    def relocates(self, step: int) -> bool:
        """Whether dead Gaussians move after a step."""
        return (step + 1) % RELOCATED == 0 and step < SETTLED * self.settings.steps

    def next_view(self) -> int:
        """All of them in a new order, again and again."""
        if not self.queue:
            self.queue = self.rng.permutation(self.views).tolist()
        return self.queue.pop()

    def factor(self, step: int) -> np.ndarray:
        """(alive,) factors of the opacities: zero for those that a step leaves out."""
        rate = self.settings.dropout * (step + 1) / self.settings.steps
        factor = np.ones(self.alive, np.float32)
        if rate > 0:
            factor[:] = (self.rng.random(self.alive) >= rate) / (1 - rate)
        return factor


def visible(table: np.ndarray) -> np.ndarray:
    """The Gaussians of a table that add to any pixel."""
    return table[1 / (1 + np.exp(-table[:, LOGIT].astype(np.float64))) > densify.DEAD]


class Training(Steps):
    """The steps on the CPU."""

    def prepare(
        self, capture: Capture, frame: Frame, room: np.ndarray, background: np.ndarray
    ) -> None:
        """Everything stays in memory."""
        self.table = room
        self.grad = np.zeros_like(self.table)
        self.adam = optimiser.Adam(self.table, self.rates)
        self.canvas = Canvas(len(self.table), capture.size, background)
        self.truth = np.ascontiguousarray(np.asarray(capture.images).transpose(0, 3, 1, 2))
        self.masks = capture.masks
        poses = frame.local_poses(capture.world_to_camera)
        self.cameras = [
            camera_of(pose, k, capture.size, NEAREST)
            for pose, k in zip(poses, capture.intrinsics, strict=True)
        ]
        self.window, self.pull = losses.window(np.float32), np.empty_like(self.canvas.image)

    def step(self, step: int) -> float:
        """One update; returns the mean loss of its views before it, without the penalties."""
        settings, table = self.settings, self.table[: self.alive]
        degree, factor, loss, seen = self.degree(step), self.factor(step), 0.0, []
        for _ in range(settings.views):
            view = self.next_view()
            seen.append(self.canvas.draw(table, degree, factor, self.cameras[view]).copy())
            mask = self.masks[view] if self.masks is not None else np.empty((0, 0), bool)
            loss += losses.loss_gradient(
                self.canvas.image, self.truth[view], mask, self.window, self.pull
            )
            self.canvas.pull(table, degree, self.cameras[view], self.pull, self.grad)
        touched = seen[0] if len(seen) == 1 else np.unique(np.concatenate(seen))
        optimiser.penalise(
            table, self.grad, touched, settings.opacity_penalty, settings.scale_penalty
        )
        self.adam.step(self.grad, touched, step)
        if settings.noise:
            optimiser.shake(table, touched, self.rng, self.rates.noise(step))
        if self.relocates(step):
            self.alive, changed = densify.relocate(self.table, self.alive, self.rng)
            self.adam.forget(changed)
        return loss / settings.views

    @property
    def kept(self) -> np.ndarray:
        """The Gaussians that add to any pixel."""
        return visible(self.table[: self.alive])
