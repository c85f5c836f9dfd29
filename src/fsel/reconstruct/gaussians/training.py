"""The optimisation on the CPU: one step after the other."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import NamedTuple, SupportsFloat

import numpy as np

from fsel.core.capture import Capture
from fsel.reconstruct.gaussians import densify, losses, optimiser
from fsel.reconstruct.gaussians.render import NEAREST, Canvas, camera_of
from fsel.reconstruct.gaussians.settings import GaussianSettings
from fsel.reconstruct.gaussians.table import LOGIT
from fsel.reconstruct.normalisation import Frame

RELOCATED = 100  # steps between relocations
SETTLED = 5 / 6  # share of the steps after which nothing is relocated (Kheradmand et al. 2024)
RAISED = 1 / 30  # share of the steps between two degrees of the harmonics (Kerbl et al. 2023)


class Begun(NamedTuple):
    """A subset before the first step.

    Attributes:
        capture: of the selected frames alone.
        frame: the normalised frame.
        table: (n, c) float32 parameters to start from, n > 0 for steps.
        background: (3,) colour behind everything.
    """

    capture: Capture
    frame: Frame
    table: np.ndarray
    background: np.ndarray

    def room(self, budget: int) -> np.ndarray:
        """(budget, c) float32, the table with rows to grow into."""
        room = np.zeros((budget, self.table.shape[1]), np.float32)
        room[: len(self.table)] = self.table
        return room


class Order:
    """The chance of one fit: which view comes next, and all else that is drawn.

    Args:
        views: how many there are.
        seed: of the fit.
    """

    def __init__(self, views: int, seed: int) -> None:
        self.rng, self.views = np.random.default_rng(seed), views
        self._queue: list[int] = []

    def next_view(self) -> int:
        """All of them in a new order, again and again."""
        if not self._queue:
            self._queue = self.rng.permutation(self.views).tolist()
        return self._queue.pop()


class Steps(ABC):
    """Gaussians that are being fitted: what every device shares, when what is done.

    Args:
        settings: of the reconstructor.
    """

    def __init__(self, settings: GaussianSettings) -> None:
        self.settings = settings
        self.rates = optimiser.Rates(settings.degree, settings.steps)

    @abstractmethod
    def step(self, step: int) -> SupportsFloat:
        """One update; returns the mean loss of its views before it, without the penalties."""

    @property
    @abstractmethod
    def kept(self) -> list[np.ndarray]:
        """Gaussians of each subset that add to any pixel, (n, c) float32."""

    def run(self, progress: Callable | None, stop: Callable[[], bool] | None) -> int:
        """All steps, or those before `stop` says so; returns how many were made."""
        steps = self.settings.steps
        for step in range(steps):
            if stop is not None and stop():
                return step
            loss = self.step(step)
            if progress is not None:
                progress(step + 1, steps, float(loss))
        return steps

    def degree(self, step: int) -> int:
        """Degree of the harmonics in use."""
        return min(self.settings.degree, int(step / max(RAISED * self.settings.steps, 1)))

    def relocates(self, step: int) -> bool:
        """Say whether dead Gaussians move after a step."""
        return (step + 1) % RELOCATED == 0 and step < SETTLED * self.settings.steps

    def dropped(self, step: int) -> float:
        """Share of the Gaussians that a step leaves out."""
        return self.settings.dropout * (step + 1) / self.settings.steps


def visible(table: np.ndarray) -> np.ndarray:
    """The Gaussians of a table that add to any pixel."""
    return table[1 / (1 + np.exp(-table[:, LOGIT].astype(np.float64))) > densify.DEAD]


class Training(Steps):
    """The steps on the CPU, of one subset.

    Args:
        begun: holding that subset alone.
        settings: of the reconstructor.
    """

    def __init__(self, begun: Sequence[Begun], settings: GaussianSettings) -> None:
        super().__init__(settings)
        (one,) = begun
        capture, frame, table, background = one
        self.alive, self.order = len(table), Order(len(capture), settings.seed)
        self.table = one.room(settings.gaussians)
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
        self.window, self.slope = losses.window(np.float32), np.empty_like(self.canvas.image)

    def step(self, step: int) -> float:
        """One update; returns the mean loss of its views before it, without the penalties."""
        settings, table = self.settings, self.table[: self.alive]
        degree, factor, loss, seen = self.degree(step), self.factor(step), 0.0, []
        for _ in range(settings.views):
            view = self.order.next_view()
            seen.append(self.canvas.draw(table, degree, factor, self.cameras[view]).copy())
            mask = self.masks[view] if self.masks is not None else np.empty((0, 0), bool)
            loss += losses.loss_gradient(
                self.canvas.image, self.truth[view], mask, self.window, self.slope
            )
            self.canvas.backward(table, degree, self.cameras[view], self.slope, self.grad)
        touched = seen[0] if len(seen) == 1 else np.unique(np.concatenate(seen))
        optimiser.penalise(
            table, self.grad, touched, settings.opacity_penalty, settings.scale_penalty
        )
        self.adam.step(self.grad, touched, step)
        if settings.noise:
            optimiser.shake(table, touched, self.order.rng, self.rates.noise(step))
        if self.relocates(step):
            self.alive, changed = densify.relocate(self.table, self.alive, self.order.rng)
            self.adam.forget(changed)
        return loss / settings.views

    def factor(self, step: int) -> np.ndarray:
        """(alive,) factors of the opacities: zero for those that a step leaves out."""
        rate, factor = self.dropped(step), np.ones(self.alive, np.float32)
        if rate > 0:
            factor[:] = (self.order.rng.random(self.alive) >= rate) / (1 - rate)
        return factor

    @property
    def kept(self) -> list[np.ndarray]:
        """The Gaussians that add to any pixel."""
        return [visible(self.table[: self.alive])]
