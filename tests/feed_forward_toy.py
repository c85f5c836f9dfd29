"""A model for `ffgs`, registered as its own are: Gaussians and cameras that are known beforehand.

It reads the number of each image from its top left pixel, and has learned each one's camera. So
what it predicts tells which images it saw, and in which order.
"""

from dataclasses import dataclass, field

import torch
from ffgs import Cameras, Gaussians, ImageFitConfig, ModelSpec, Prepared, Processor, register_model
from huggingface_hub import PyTorchModelHubMixin
from torch import nn


class Toy(nn.Module, PyTorchModelHubMixin):
    """Predicts the cameras of the images that it sees, and always the same Gaussians."""

    def __init__(self, frames: int = 1, gaussians: int = 1, harmonics: int = 1):
        super().__init__()
        self.register_buffer("poses", torch.zeros(frames, 4, 4))
        self.register_buffer("means", torch.zeros(gaussians, 3))
        self.register_buffer("scales", torch.zeros(gaussians, 3))
        self.register_buffer("quats", torch.zeros(gaussians, 4))
        self.register_buffer("opacities", torch.zeros(gaussians))
        self.register_buffer("colors", torch.zeros(gaussians, harmonics, 3))

    def forward(self, images):
        numbers = (images[0, :, 0, 0, 0] * 255).round().long()
        return self, numbers


@dataclass
class ToyConfig(ImageFitConfig):
    image_shape: list[int] = field(default_factory=lambda: [18, 24])
    crop_mode: str = "none"


class ToyProcessor(Processor):
    config_cls = ToyConfig
    camera_input = "none"

    def preprocess(self, views, device):
        return Prepared(self.fit_views(views).images.to(device), None)

    def postprocess(self, output):
        model, _ = output
        parts = (model.means, model.scales, model.quats, model.opacities, model.colors)
        degree = round(model.colors.shape[1] ** 0.5) - 1
        return Gaussians(*(part[None] for part in parts), sh_degree=degree)

    def predicted_cameras(self, output):
        model, numbers = output
        shape = tuple(self.config.image_shape)
        k = torch.eye(3).expand(len(numbers), 3, 3)
        return Cameras(model.poses[numbers], k, shape, normalized_intrinsics=True)

    def render_planes(self, frame):
        return 0.01, 100.0


SPEC = register_model(ModelSpec("toy", Toy, ToyProcessor))
