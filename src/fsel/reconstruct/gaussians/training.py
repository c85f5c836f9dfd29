"""The optimisation: one step after the other, and relocation of faint Gaussians between them.

Relocation, and growth within a budget, are those of 3DGS-MCMC (Kheradmand et al. 2024): a Gaussian
of opacity o that becomes n Gaussians in one place gets the opacities and the scales at which the n
together look as it did (their equation 9).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from fsel.core.capture import Capture
from fsel.reconstruct.gaussians import losses, optimiser
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.gaussians.parameters import LOGIT, SCALE
from fsel.reconstruct.gaussians.render import NEAREST, Canvas, camera_of
from fsel.reconstruct.gaussians.settings import GaussianSettings

RELOCATED = 100  # steps between relocations
SETTLED = 5 / 6  # share of the steps after which nothing is relocated (Kheradmand et al. 2024)
RAISED = 1 / 30  # share of the steps between two degrees of the harmonics (Kerbl et al. 2023)

Progress = Callable[[int, int, float], None]

DEAD = 0.005  # opacity at which a Gaussian is relocated
GROWTH = 1.05  # of the number of Gaussians, at each relocation, until the budget is full
MOST = 51  # Gaussians that one may become
LARGEST = 1 - 1e-7  # opacity


class Order:
    """The order of the views, and the generator of all else that is drawn."""

    def __init__(self, views: int, seed: int) -> None:
        self.rng, self.views = np.random.default_rng(seed), views
        self._queue: list[int] = []

    def next_view(self) -> int:
        """Return the next one: all of them in a new order, again and again."""
        if not self._queue:
            self._queue = self.rng.permutation(self.views).tolist()
        return self._queue.pop()


class Training:
    """The steps on a capture of the selected frames alone, from a model of some Gaussians."""

    def __init__(self, capture: Capture, start: GaussianModel, settings: GaussianSettings) -> None:
        self.start, self.settings = start, settings
        self.rates = optimiser.Rates(settings.degree, settings.steps)
        self.alive, self.order = len(start.table), Order(len(capture), settings.seed)
        self.table = np.zeros((settings.gaussians, start.table.shape[1]), np.float32)
        self.table[: self.alive] = start.table
        self.grad = np.zeros_like(self.table)
        self.adam = optimiser.Adam(self.table, self.rates)
        self.window, self.capture = losses.window(), capture
        self.coarse = round(settings.coarse * settings.steps)  # steps at half the size
        self.look(capture.resized(max(capture.size) // 2) if self.coarse else capture)

    def look(self, capture: Capture) -> None:
        """Take the images, masks and cameras of a capture for the steps to come."""
        self.canvas = Canvas(len(self.table), capture.size, self.start.background)
        self.slope = np.empty_like(self.canvas.image)
        self.truth = np.ascontiguousarray(np.asarray(capture.images).transpose(0, 3, 1, 2))
        self.masks = capture.masks
        poses = self.start.frame.local_poses(capture.world_to_camera)
        self.cameras = [
            camera_of(pose, k, capture.size, NEAREST)
            for pose, k in zip(poses, capture.intrinsics, strict=True)
        ]

    def run(self, progress: Progress | None, stop: Callable[[], bool] | None) -> GaussianModel:
        """Make all steps, or those before `stop` says so; see `Gaussians.fit`."""
        steps = self.settings.steps
        for step in range(steps):
            if stop is not None and stop():
                return self.model(step)
            loss = self.step(step)
            if progress is not None:
                progress(step + 1, steps, loss)
        return self.model(steps)

    def step(self, step: int) -> float:
        """Update once; return the loss of its view before it, without the penalties."""
        if step == self.coarse > 0:
            self.look(self.capture)
        settings, table = self.settings, self.table[: self.alive]
        degree, factor, view = self.degree(step), self.factor(step), self.order.next_view()
        touched = self.canvas.draw(table, degree, factor, self.cameras[view])

        def update(first: int, last: int) -> None:
            optimiser.penalise(table, self.grad, touched[first:last], *optimiser.PENALTIES)
            self.adam.step(self.grad, touched[first:last], step)

        mask = self.masks[view] if self.masks is not None else np.empty((0, 0), bool)
        loss = losses.loss_gradient(
            self.canvas.image, self.truth[view], mask, self.window, self.slope
        )
        self.canvas.backward(table, degree, self.cameras[view], self.slope, self.grad, update)
        optimiser.shake(table, touched, self.order.rng, self.rates.noise(step))
        if (step + 1) % RELOCATED == 0 and step < SETTLED * settings.steps:
            self.alive, changed = relocate(self.table, self.alive, self.order.rng)
            self.adam.forget(changed)
        return loss

    def degree(self, step: int) -> int:
        """Return the degree of the harmonics in use."""
        return min(self.settings.degree, int(step / max(RAISED * self.settings.steps, 1)))

    def factor(self, step: int) -> np.ndarray:
        """Return (alive,) factors of the opacities: zero for those that a step leaves out."""
        rate = self.settings.dropout * (step + 1) / self.settings.steps
        factor = np.ones(self.alive, np.float32)
        if rate > 0:
            factor[:] = (self.order.rng.random(self.alive) >= rate) / (1 - rate)
        return factor

    def model(self, steps: int) -> GaussianModel:
        """Return the Gaussians that add to any pixel, after some steps."""
        table = self.table[: self.alive]
        kept = table[1 / (1 + np.exp(-table[:, LOGIT].astype(np.float64))) > DEAD]
        return replace(self.start, table=kept, steps=steps)


def split_opacity(opacity: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return the opacity of each of `shares` Gaussians that together pass the light of one."""
    return 1 - (1 - opacity) ** (1 / shares)


def split_scale(opacity: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return the factor of the standard deviations at which they keep the mass along a ray."""
    part = split_opacity(opacity, shares)
    powers = part[..., None] ** np.arange(1, MOST + 1)
    return opacity / (powers * _coefficients()[shares]).sum(axis=-1)


@cache
def _coefficients() -> np.ndarray:
    """Return (MOST + 1, MOST) factors of the part's powers, a row a number of Gaussians."""
    table = np.zeros((MOST + 1, MOST))
    for n in range(1, MOST + 1):
        for k in range(n):
            # the binomials of column k add to the next column's
            table[n, k] = math.comb(n, k + 1) * (-1) ** k / math.sqrt(k + 1)
    return table


def relocate(table: np.ndarray, alive: int, rng: np.random.Generator) -> tuple[int, np.ndarray]:
    """Move dead Gaussians of a (budget, c) table onto living ones, drawn by their opacities, and
    add new ones while the budget lasts; return the rows in use afterwards, and those that
    changed."""
    opacity = 1 / (1 + np.exp(-table[:alive, LOGIT].astype(np.float64)))
    dead = np.flatnonzero(opacity <= DEAD)
    weight = np.where(opacity > DEAD, opacity, 0.0)
    grown = min(len(table), int(GROWTH * alive))
    guests = np.concatenate([dead, np.arange(alive, grown)])
    if not weight.any() or not len(guests):
        return alive, guests[:0]
    hosts = rng.choice(alive, len(guests), p=weight / weight.sum())
    shares = np.minimum(np.bincount(hosts, minlength=alive) + 1, MOST)
    split = np.flatnonzero(shares > 1)
    whole = np.minimum(opacity[split], LARGEST)
    part = np.maximum(split_opacity(whole, shares[split]), DEAD)
    table[split, LOGIT] = np.log(part / (1 - part))
    table[split, SCALE] += np.log(split_scale(whole, shares[split]))[:, None]
    table[guests] = table[hosts]
    return grown, np.concatenate([split, guests])
