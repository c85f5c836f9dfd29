"""Loss, penalties and noise of the optimisation in torch, for many scenes at once."""

from __future__ import annotations

from functools import cache

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import normalize

from fsel.reconstruct.gaussians import losses, optimiser
from fsel.reconstruct.gaussians.table import LOGIT, SCALE, TURN


def image_loss(image: Tensor, truth: Tensor, mask: Tensor | None) -> Tensor:
    """(b,), of each image what `losses.loss_gradient` computes.

    Args:
        image, truth: (b, h, w, 3), float, in [0, 1].
        mask: (b, h, w) bool, or None for all pixels.
    """
    if mask is not None:
        image, truth = (torch.where(mask[..., None], part, 0) for part in (image, truth))
    absolute = (image - truth).abs().mean(dim=(1, 2, 3))
    a, b = image.permute(0, 3, 1, 2), truth.permute(0, 3, 1, 2)
    mean_a, mean_b, aa, bb, ab = _smooth(torch.stack([a, b, a * a, b * b, a * b]))
    c1, c2 = losses.STABLE
    top = (2 * mean_a * mean_b + c1) * (2 * (ab - mean_a * mean_b) + c2)
    squares = mean_a**2 + mean_b**2
    similarity = top / ((squares + c1) * (aa + bb - squares + c2))
    apart = (1 - similarity).mean(dim=(1, 2, 3))
    return (1 - losses.SSIM_SHARE) * absolute + losses.SSIM_SHARE * apart


def _smooth(maps: Tensor) -> Tensor:
    """(..., h, w) maps convolved with the window of SSIM, zeros beyond the image."""
    down, across = (_convolving(n, maps.dtype, maps.device) for n in maps.shape[-2:])
    return down @ maps @ across


@cache
def _convolving(n: int, dtype: torch.dtype, device: torch.device) -> Tensor:
    """(n, n) what convolves n values with the window: a GPU multiplies matrices faster."""
    half = np.zeros(max(n, losses.REACH + 1))
    half[: losses.REACH + 1] = losses.window(np.float64)
    apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    return torch.tensor(half[apart], dtype=dtype, device=device)


def penalty(logit: Tensor, scale: Tensor, born: Tensor, opacity: float, size: float) -> Tensor:
    """(b,), of each scene what `optimiser.penalise` is the gradient of.

    Args:
        logit: (b, n) of the opacities.
        scale: (b, n, 3) logarithms of the standard deviations.
        born: (b, n) bool, the rows that count.
        opacity, size: weights of the mean opacity and of the mean standard deviation.
    """
    share = born / born.sum(dim=1, keepdim=True)
    return ((opacity * logit.sigmoid() + size * scale.exp().mean(dim=-1)) * share).sum(dim=1)


def shaken(table: Tensor, size: float, random: torch.Generator) -> Tensor:
    """(..., 3) moves of (..., c) rows as `optimiser.shake` makes them, zero where not faint."""
    logit = table[..., LOGIT]
    falls = optimiser.SHARP * (logit.sigmoid() - optimiser.FAINT)
    reach = torch.where(logit < optimiser.SILENT, size / (1 + falls.exp()), 0)
    shape = (*logit.shape, 3)
    normal = torch.randn(shape, generator=random, device=table.device, dtype=table.dtype)
    axes = rotations(table[..., TURN])
    along = (2 * table[..., SCALE]).exp() * torch.einsum("...ij,...i->...j", axes, normal)
    return reach[..., None] * torch.einsum("...ij,...j->...i", axes, along)


def rotations(turns: Tensor) -> Tensor:
    """(..., 3, 3) matrices of (..., 4) quaternions w, x, y, z of any length but zero."""
    w, x, y, z = normalize(turns, dim=-1).unbind(-1)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return torch.stack([torch.stack(row, dim=-1) for row in rows], dim=-2)
