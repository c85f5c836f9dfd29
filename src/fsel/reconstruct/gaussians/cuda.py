"""The same optimisation on a GPU: gsplat (Ye et al. 2025) rasterises, torch differentiates.

Parameters, settings, rates, penalties, noise and relocation are those of the CPU, and the order of
the views. What differs is the rasteriser, which cuts a Gaussian off elsewhere and sums in any
order: two fits are not equal to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import conv2d, normalize

from fsel.capture import Capture, Views
from fsel.reconstruct import gpu
from fsel.reconstruct.gaussians import densify, losses, optimiser
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.gaussians.projection import LOW_PASS
from fsel.reconstruct.gaussians.render import NEAREST
from fsel.reconstruct.gaussians.table import COLOR, LOGIT, MEAN, SCALE, TURN
from fsel.reconstruct.gaussians.training import Steps, visible
from fsel.reconstruct.normalisation import Frame

DEVICE = "cuda"


def rasterization(**given: Any) -> tuple[Tensor, Tensor, dict]:
    """gsplat's, imported when it is called: it looks for CUDA then."""
    import gsplat

    return gsplat.rasterization(**given)


class Cameras:
    """Views in the normalised frame, as gsplat states them.

    Args:
        frame: the normalised frame.
        views: n poses and intrinsics of one size.
    """

    def __init__(self, frame: Frame, views: Views) -> None:
        poses = np.tile(np.eye(4), (len(views), 1, 1))
        poses[:, :3] = frame.local_poses(views.world_to_camera)
        matrices = np.tile(np.eye(3), (len(views), 1, 1))
        matrices[:, [0, 1], [0, 1]] = views.intrinsics[:, :2]
        matrices[:, :2, 2] = views.intrinsics[:, 2:]
        self.poses, self.matrices = on_device(poses), on_device(matrices)
        self.size = views.size

    def draw(
        self,
        row: int,
        table: Tensor,
        degree: int,
        factor: Tensor | float,
        background: Tensor,
        near: float,
    ) -> tuple[Tensor, Tensor]:
        """Render one view.

        Args:
            row: of the view.
            table: (n, c) parameters, n > 0.
            degree: of the harmonics in use.
            factor: (n,) factors of the opacities, or one for all.
            background: (3,) colour behind everything.
            near: least depth, in the normalised frame.

        Returns:
            (h, w, 3) image, and (n,) bool, which Gaussians the view sees.
        """
        width, height = self.size
        image, _, found = rasterization(
            means=table[:, MEAN],
            quats=table[:, TURN],
            scales=table[:, SCALE].exp(),
            opacities=table[:, LOGIT].sigmoid() * factor,
            colors=table[:, COLOR:].reshape(len(table), -1, 3),
            sh_degree=degree,
            viewmats=self.poses[row, None],
            Ks=self.matrices[row, None],
            width=width,
            height=height,
            near_plane=near,
            eps2d=LOW_PASS,
            packed=False,
            backgrounds=background[None],
        )
        return image[0], (found["radii"][0].reshape(len(table), -1) > 0).all(dim=1)


class CudaTraining(Steps):
    """The steps on a GPU."""

    def prepare(
        self, capture: Capture, frame: Frame, room: np.ndarray, background: np.ndarray
    ) -> None:
        """Everything goes to the GPU's memory."""
        self.table = on_device(room)
        self.first, self.second = torch.zeros_like(self.table), torch.zeros_like(self.table)
        self.count = torch.zeros((len(room), 1), device=DEVICE)
        self.background = on_device(background)
        self.cameras = Cameras(frame, capture.views)
        self.truth = torch.from_numpy(np.ascontiguousarray(capture.images)).to(DEVICE)
        self.masks = None
        if capture.masks is not None:
            self.masks = torch.from_numpy(np.ascontiguousarray(capture.masks)).to(DEVICE)
        self.random = torch.Generator(DEVICE).manual_seed(self.settings.seed)

    def step(self, step: int) -> float:
        """One update; returns the mean loss of its views before it, without the penalties."""
        settings = self.settings
        table = self.table[: self.alive].clone().requires_grad_()
        factor, loss = on_device(self.factor(step)), 0.0
        touched = torch.zeros(self.alive, dtype=torch.bool, device=DEVICE)
        for _ in range(settings.views):
            view = self.next_view()
            image, seen = self.cameras.draw(
                view, table, self.degree(step), factor, self.background, NEAREST
            )
            mask = None if self.masks is None else self.masks[view]
            found = image_loss(image, self.truth[view].float() / 255, mask)
            found.backward()
            loss += found.item()
            touched |= seen
        penalty(table, settings.opacity_penalty, settings.scale_penalty).backward()
        with torch.no_grad():
            self._update(table.grad, touched, step)
            if settings.noise:
                moved = shaken(self.table[: self.alive], self.rates.noise(step), self.random)
                self.table[: self.alive, MEAN] += torch.where(touched[:, None], moved, 0)
        if self.relocates(step):
            self._relocate()
        return loss / settings.views

    def _update(self, grad: Tensor, touched: Tensor, step: int) -> None:
        """Adam on the touched rows; each counts its own steps."""
        rows = touched.nonzero()[:, 0]
        grad, (keep1, keep2) = grad[rows], optimiser.DECAYS
        self.count[rows] += 1
        first = keep1 * self.first[rows] + (1 - keep1) * grad
        second = keep2 * self.second[rows] + (1 - keep2) * grad**2
        self.first[rows], self.second[rows] = first, second
        past = self.count[rows]
        spread = (second / (1 - keep2**past)).sqrt() + optimiser.TINY
        rates = on_device(self.rates.at(step))
        self.table[rows] -= rates * first / (1 - keep1**past) / spread

    def _relocate(self) -> None:
        """As on the CPU, and there: it is rare, and draws from NumPy's generator."""
        table = self.table.cpu().numpy()
        self.alive, changed = densify.relocate(table, self.alive, self.rng)
        self.table.copy_(torch.from_numpy(table))
        for state in (self.first, self.second, self.count):
            state[torch.from_numpy(changed).to(DEVICE)] = 0

    @property
    def kept(self) -> np.ndarray:
        """The Gaussians that add to any pixel."""
        return visible(self.table[: self.alive].cpu().numpy())


@dataclass(frozen=True)
class CudaModel(GaussianModel):
    """As `GaussianModel`, rendered on the GPU that it was fitted on."""

    def render(self, views: Views) -> np.ndarray:
        """(T, h, w, 3) float32 images in [0, 1] at the given poses."""
        if not self.primitives:
            return super().render(views)
        out = np.empty((len(views), *views.size[::-1], 3), np.float32)
        with torch.no_grad(), gpu.memory_errors(f"rendering {len(views)} views"):
            table, background = on_device(self.table), on_device(self.background)
            cameras = Cameras(self.frame, views)
            for row in range(len(views)):
                image, _ = cameras.draw(row, table, self.degree, 1.0, background, self.near)
                out[row] = image.clamp(0, 1).cpu().numpy()
        return out


def on_device(values: np.ndarray) -> Tensor:
    """A float32 copy on the GPU."""
    return torch.tensor(values, dtype=torch.float32, device=DEVICE)


def image_loss(image: Tensor, truth: Tensor, mask: Tensor | None) -> Tensor:
    """What `losses.loss_gradient` computes.

    Args:
        image, truth: (h, w, 3), float, in [0, 1].
        mask: (h, w) bool, or None for all pixels.
    """
    if mask is not None:
        image, truth = (torch.where(mask[..., None], part, 0) for part in (image, truth))
    absolute = (image - truth).abs().mean()
    a, b = image.permute(2, 0, 1), truth.permute(2, 0, 1)
    mean_a, mean_b, aa, bb, ab = _smooth(torch.stack([a, b, a * a, b * b, a * b]))
    c1, c2 = losses.STABLE
    top = (2 * mean_a * mean_b + c1) * (2 * (ab - mean_a * mean_b) + c2)
    squares = mean_a**2 + mean_b**2
    similarity = top / ((squares + c1) * (aa + bb - squares + c2))
    return (1 - losses.SSIM_SHARE) * absolute + losses.SSIM_SHARE * (1 - similarity).mean()


def _smooth(maps: Tensor) -> Tensor:
    """(m, 3, h, w) maps convolved with the window of SSIM, zeros beyond the image."""
    half = torch.tensor(losses.window(np.float64), dtype=maps.dtype, device=maps.device)
    window = torch.cat([half.flip(0), half[1:]])
    flat = maps.reshape(-1, 1, *maps.shape[2:])
    flat = conv2d(flat, window[None, None, None, :], padding=(0, losses.REACH))
    return conv2d(flat, window[None, None, :, None], padding=(losses.REACH, 0)).reshape(maps.shape)


def penalty(table: Tensor, opacity: float, scale: float) -> Tensor:
    """What `optimiser.penalise` is the gradient of."""
    return opacity * table[:, LOGIT].sigmoid().mean() + scale * table[:, SCALE].exp().mean()


def shaken(table: Tensor, size: float, random: torch.Generator) -> Tensor:
    """(n, 3) moves as `optimiser.shake` makes them, those of Gaussians that are not faint zero."""
    logit = table[:, LOGIT]
    falls = optimiser.SHARP * (logit.sigmoid() - optimiser.FAINT)
    reach = torch.where(logit < optimiser.SILENT, size / (1 + falls.exp()), 0)
    normal = torch.randn(len(table), 3, generator=random, device=table.device, dtype=table.dtype)
    axes = rotations(table[:, TURN])
    along = (2 * table[:, SCALE]).exp() * torch.einsum("nij,ni->nj", axes, normal)
    return reach[:, None] * torch.einsum("nij,nj->ni", axes, along)


def rotations(turns: Tensor) -> Tensor:
    """(n, 3, 3) matrices of (n, 4) quaternions w, x, y, z of any length but zero."""
    w, x, y, z = normalize(turns, dim=1).unbind(1)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return torch.stack([torch.stack(row, dim=1) for row in rows], dim=1)
