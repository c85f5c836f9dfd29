"""Published feed-forward models of 3D Gaussians through the package `ffgs`, as a worker.

    python ffgs.py MODEL

Run in an environment with ffgs, gsplat and a GPU. MODEL is a name in the zoo of ffgs, whose weights
must be in the cache of Hugging Face, since nothing is downloaded; or a folder that
`save_pretrained` wrote. A model that predicts cameras is placed by the similarity from those that
it predicts for the selected frames to the given ones.
"""

import sys

import numpy as np
import torch
from fsel_worker import camera_matrices, camera_to_world, middle_and_unit, serve


def world_of(poses, processor):
    """The middle of the selected cameras, and the unit that a model is given them in."""
    centers = poses[:, :3, 3]
    middle, unit = middle_and_unit(centers)
    spread = getattr(processor.config, "camera_spread", None)
    if spread is not None and processor.camera_input != "none":
        unit = np.linalg.norm(centers[1:] - centers[0], axis=1).mean() / spread or 1.0
    return middle, unit


def main(model):
    """Serve it."""
    del sys.path[0]  # this file has the package's name
    import ffgs

    device = "cuda" if torch.cuda.is_available() else "cpu"
    pipeline = ffgs.GSPipeline.from_pretrained(model, device=device, local_files_only=True)

    def cameras(views, size, middle, unit):
        poses = camera_to_world(views.world_to_camera)
        poses[:, :3, 3] = (poses[:, :3, 3] - middle) / unit
        lenses = camera_matrices(views.intrinsics)
        return ffgs.Cameras(torch.tensor(poses).float(), torch.tensor(lenses).float(), size[::-1])

    @torch.no_grad()
    def fit(subset):
        world = world_of(camera_to_world(subset.world_to_camera), pipeline.processor)
        given = cameras(subset, subset.images.shape[2:0:-1], *world)
        images = torch.from_numpy(np.ascontiguousarray(subset.images.transpose(0, 3, 1, 2)))
        made = pipeline(ffgs.Views(images, given.intrinsics[0], given.c2w[0])).to_world()
        return Made(made, world)

    @torch.no_grad()
    def render(made, views):
        images = pipeline.render(made.output, cameras(views, views.size, *made.world))["images"][0]
        return images.permute(0, 2, 3, 1).float().clamp(0, 1).cpu().numpy()

    serve(fit, render, name=model, device=device)


class Made:
    """Gaussians in the model's frame, where that lies in the world, and how many there are."""

    def __init__(self, output, world):
        self.output, self.world = output, world
        self.primitives = output.gaussians.num_gaussians


if __name__ == "__main__":
    main(*sys.argv[1:])
