"""Settings of the reconstructor `feed_forward`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from fsel.reconstruct import gpu


@dataclass(frozen=True)
class FeedForwardSettings:
    """Settings of a feed-forward model.

    Attributes:
        model: name in the zoo of `ffgs`, or a folder that its `save_pretrained` wrote.
        weights: file of a zoo model's weights; null finds it in the cache of Hugging Face.
        device: `cuda`, where gsplat renders, or `cpu`, where the rasteriser of `gaussians` does.
        processor: what the model's processor does otherwise than in its configuration, such as
            `{crop_mode: pad}`.
    """

    model: str = "anysplat/default"
    weights: str | None = None
    device: str = "cuda"
    processor: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.model, str) or not self.model:
            raise ValueError(f"model must be a name or a folder, got {self.model!r}")
        if self.weights is not None and not isinstance(self.weights, str):
            raise ValueError(f"weights must be a file or null, got {self.weights!r}")
        gpu.check_name(self.device)
        if not isinstance(self.processor, Mapping):
            raise ValueError(f"processor must be a mapping, got {self.processor!r}")
