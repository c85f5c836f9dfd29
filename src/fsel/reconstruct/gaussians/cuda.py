"""The same optimisation on a GPU: gsplat (Ye et al. 2025) rasterises, torch differentiates.

Parameters, settings, rates, penalties, noise and relocation are those of the CPU, and the order of
the views. What differs is the rasteriser, which cuts a Gaussian off elsewhere and sums in any
order: two fits are not equal to the bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from fsel.core.capture import Views
from fsel.reconstruct import gpu
from fsel.reconstruct.gaussians import densify, optimiser
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.gaussians.projection import LOW_PASS
from fsel.reconstruct.gaussians.render import NEAREST
from fsel.reconstruct.gaussians.settings import GaussianSettings
from fsel.reconstruct.gaussians.table import COLOR, LOGIT, MEAN, SCALE, TURN
from fsel.reconstruct.gaussians.torch_terms import image_loss, penalty, shaken
from fsel.reconstruct.gaussians.training import Begun, Order, Steps, visible
from fsel.reconstruct.normalisation import Frame

DEVICE = "cuda"
HIDDEN = -30.0  # logit of an opacity far below what is drawn
PIXELS = 1 << 22  # that are rendered at once
GAUSSIANS = 1 << 20  # that are fitted at once


def together(settings: GaussianSettings, size: tuple[int, int]) -> int:
    """Number of subsets that are fitted at once."""
    return max(1, min(GAUSSIANS // settings.gaussians, PIXELS // (size[0] * size[1])))


def rasterization(**given: Any) -> tuple[Tensor, Tensor, dict]:
    """Call gsplat's function, imported only then: it looks for CUDA when imported."""
    import gsplat

    return gsplat.rasterization(**given)


class Parts(NamedTuple):
    """Parameters of Gaussians, apart: (..., n, 3), (..., n, 3), (..., n, 4), (..., n) and
    (..., n, 3 (degree + 1)^2); see `table`."""

    mean: Tensor
    scale: Tensor
    turn: Tensor
    logit: Tensor
    color: Tensor

    @classmethod
    def of(cls, table: Tensor) -> Parts:
        """Copies, of (..., n, c) parameters."""
        columns = (MEAN, SCALE, TURN, LOGIT, slice(COLOR, None))
        return cls(*(table[..., of].contiguous() for of in columns))

    def joined(self) -> Tensor:
        """(..., n, c), what `of` took apart."""
        return torch.cat([*self[:3], self.logit[..., None], self.color], dim=-1)


def draw(
    parts: Parts,
    poses: Tensor,
    matrices: Tensor,
    size: tuple[int, int],
    degree: int,
    factor: Tensor | float,
    background: Tensor,
    near: float,
) -> tuple[Tensor, Tensor]:
    """Render views of scenes, which may be many.

    Args:
        parts: of the scenes, n > 0.
        poses: (..., v, 4, 4) of the views of each scene, in its normalised frame.
        matrices: (..., v, 3, 3) intrinsics.
        size: width and height of all views.
        degree: of the harmonics in use.
        factor: (..., n) factors of the opacities, or one for all.
        background: (..., 3) colour behind everything.
        near: least depth, in the normalised frame.

    Returns:
        (..., v, h, w, 3) images, and (..., v, n) bool, which Gaussians a view sees.
    """
    image, _, record = rasterization(
        means=parts.mean,
        quats=parts.turn,
        scales=parts.scale.exp(),
        opacities=parts.logit.sigmoid() * factor,
        colors=parts.color.unflatten(-1, (-1, 3)),
        sh_degree=degree,
        viewmats=poses,
        Ks=matrices,
        width=size[0],
        height=size[1],
        near_plane=near,
        eps2d=LOW_PASS,
        packed=False,
        backgrounds=background[..., None, :].expand(*poses.shape[:-2], 3).contiguous(),
    )
    return image, (record["radii"] > 0).all(dim=-1)


def cameras(frame: Frame, views: Views) -> tuple[Tensor, Tensor]:
    """(v, 4, 4) poses in a normalised frame and (v, 3, 3) intrinsics, as gsplat states them."""
    poses = np.tile(np.eye(4), (len(views), 1, 1))
    poses[:, :3] = frame.local_poses(views.world_to_camera)
    matrices = np.tile(np.eye(3), (len(views), 1, 1))
    matrices[:, [0, 1], [0, 1]] = views.intrinsics[:, :2]
    matrices[:, :2, 2] = views.intrinsics[:, 2:]
    return on_device(poses), on_device(matrices)


class CudaTraining(Steps):
    """The steps on a GPU, of many subsets at once: a step renders one view of each.

    A small scene leaves a GPU idle. Subsets share nothing but the kernels' launches: each has its
    own order of views, and its Gaussians meet no others.

    Args:
        begun: the subsets, of one capture.
        settings: of the reconstructor.
    """

    def __init__(self, begun: Sequence[Begun], settings: GaussianSettings) -> None:
        super().__init__(settings)
        self.size = begun[0].capture.size
        self.alive = [len(one.table) for one in begun]
        self.orders = [Order(len(one.capture), settings.seed) for one in begun]
        self.first_rows = np.cumsum([0, *(len(one.capture) for one in begun)])[:-1]
        self.table = on_device(np.stack([one.room(settings.gaussians) for one in begun]))
        self.born = self._born()
        self._hide()
        self.first, self.second = torch.zeros_like(self.table), torch.zeros_like(self.table)
        self.count = torch.zeros(self.table.shape[:2], device=DEVICE)
        self.background = on_device(np.stack([one.background for one in begun]))
        views = [cameras(one.frame, one.capture.views) for one in begun]
        self.poses, self.matrices = (torch.cat(parts) for parts in zip(*views, strict=True))
        self.truth = _bytes(np.concatenate([np.asarray(one.capture.images) for one in begun]))
        masks = [one.capture.masks for one in begun if one.capture.masks is not None]
        self.masks = _bytes(np.concatenate(masks)) if masks else None
        self.random = torch.Generator(DEVICE).manual_seed(settings.seed)

    def step(self, step: int) -> Tensor:
        """One update; returns the mean loss of its views before it, without the penalties."""
        settings, born = self.settings, self.born
        parts, factor = Parts.of(self.table), self._factor(step)
        for part in parts:
            part.requires_grad_()
        loss = torch.zeros(len(born), device=DEVICE)
        touched = torch.zeros_like(born)
        for _ in range(settings.views):
            rows = torch.tensor(self._next_views(), device=DEVICE)
            poses, matrices = self.poses[rows, None], self.matrices[rows, None]
            image, seen = draw(
                *(parts, poses, matrices, self.size, self.degree(step)),
                *(factor, self.background, NEAREST),
            )
            mask = None if self.masks is None else self.masks[rows]
            losses = image_loss(image[:, 0], self.truth[rows].float() / 255, mask)
            losses.sum().backward()
            loss += losses.detach()
            touched |= seen[:, 0]
        weights = settings.opacity_penalty, settings.scale_penalty
        penalty(parts.logit, parts.scale, born, *weights).sum().backward()
        with torch.no_grad():
            self._update(Parts(*(part.grad for part in parts)).joined(), touched, step)
            if settings.noise:
                moved = shaken(self.table, self.rates.noise(step), self.random)
                self.table[..., MEAN] += torch.where(touched[..., None], moved, 0)
        if self.relocates(step):
            self._relocate()
        return loss.mean() / settings.views

    def _born(self) -> Tensor:
        """(b, n) bool, the rows in use."""
        places = torch.arange(self.table.shape[1], device=DEVICE)
        return places < torch.tensor(self.alive, device=DEVICE)[:, None]

    def _hide(self) -> None:
        """Rows that wait to be used are seen by no view: nothing updates them."""
        self.table[~self.born] = 0
        self.table[..., TURN.start][~self.born] = 1
        self.table[..., LOGIT][~self.born] = HIDDEN

    def _next_views(self) -> np.ndarray:
        """(b,) rows of all views, one of each subset."""
        return self.first_rows + [order.next_view() for order in self.orders]

    def _factor(self, step: int) -> Tensor | float:
        """(b, n) factors of the opacities: zero for those that a step leaves out."""
        rate = self.dropped(step)
        if not rate:
            return 1.0
        drawn = torch.rand(self.table.shape[:2], generator=self.random, device=DEVICE)
        return (drawn >= rate) / (1 - rate)

    def _update(self, grad: Tensor, touched: Tensor, step: int) -> None:
        """Adam on the touched rows; each counts its own steps."""
        keep1, keep2 = optimiser.DECAYS
        self.count += touched
        touched = touched[..., None].to(grad.dtype)
        self.first.lerp_(grad, (1 - keep1) * touched)
        self.second.lerp_(grad.square_(), (1 - keep2) * touched)
        past = self.count.clamp_min(1)[..., None]
        spread = (self.second / (1 - keep2**past)).sqrt_().add_(optimiser.TINY)
        rates = on_device(self.rates.at(step)) * touched / (1 - keep1**past)
        self.table -= rates * self.first / spread

    def _relocate(self) -> None:
        """Relocate as on the CPU, and there: it is rare, and draws from NumPy's generator."""
        tables = self.table.cpu().numpy()
        for n, (table, order) in enumerate(zip(tables, self.orders, strict=True)):
            self.alive[n], changed = densify.relocate(table, self.alive[n], order.rng)
            rows = torch.from_numpy(changed).to(DEVICE)
            for state in (self.first, self.second, self.count):
                state[n, rows] = 0
        self.table.copy_(torch.from_numpy(tables))
        self.born = self._born()

    @property
    def kept(self) -> list[np.ndarray]:
        """Gaussians of each subset that add to any pixel."""
        tables = self.table.cpu().numpy()
        return [visible(table[:n]) for table, n in zip(tables, self.alive, strict=True)]


@dataclass(frozen=True)
class CudaModel(GaussianModel):
    """Model like `GaussianModel`, rendered on the GPU that it was fitted on."""

    def render(self, views: Views) -> np.ndarray:
        """(T, h, w, 3) float32 images in [0, 1] at the given poses."""
        if not self.primitives:
            return super().render(views)
        width, height = views.size
        out = np.empty((len(views), height, width, 3), np.float32)
        with torch.no_grad(), gpu.memory_errors(f"rendering {len(views)} views"):
            parts, background = Parts.of(on_device(self.table)), on_device(self.background)
            poses, matrices = cameras(self.frame, views)
            for at in range(0, len(views), chunk := max(1, PIXELS // (width * height))):
                rows = slice(at, at + chunk)
                image, _ = draw(
                    *(parts, poses[rows], matrices[rows], views.size),
                    *(self.degree, 1.0, background, self.near),
                )
                out[rows] = image.clamp(0, 1).cpu().numpy()
        return out


def on_device(values: np.ndarray) -> Tensor:
    """A float32 copy on the GPU."""
    return torch.tensor(values, dtype=torch.float32, device=DEVICE)


def _bytes(values: np.ndarray) -> Tensor:
    """A copy on the GPU, of the same type."""
    return torch.from_numpy(values).to(DEVICE)
