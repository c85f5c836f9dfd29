"""Published feed-forward models of 3D Gaussians through the package `ffgs`, as a worker.

    python ffgs.py MODEL [WEIGHTS]

Run in an environment with ffgs, gsplat and a GPU. MODEL is a name in the zoo of ffgs, or a folder
that its `save_pretrained` wrote; WEIGHTS is a file of a zoo model's weights, by default that in the
cache of Hugging Face: nothing is downloaded. A model that predicts cameras is placed by the
similarity from those that it predicts for the selected frames to the given ones.
"""

import os
import sys

import numpy as np
import torch
from fsel_worker import camera_to_world, serve


def pipeline_of(ffgs, model, weights, device):
    """The model on its device, its weights compared with the sha256 that the zoo states."""
    if os.path.isdir(model):
        return ffgs.GSPipeline.from_pretrained(model, device=device)
    from huggingface_hub import try_to_load_from_cache
    from safetensors.torch import load_file

    entry = ffgs.zoo.get_entry(model)
    pinned, spec = entry.weights, ffgs.get_model_spec(entry.model_type)
    file = weights or try_to_load_from_cache(pinned.repo, pinned.file, revision=pinned.revision)
    how = f"`hf download {pinned.repo} {pinned.file} --revision {pinned.revision}` fetches them"
    if not isinstance(file, str) or not os.path.isfile(file):
        sys.exit(f"{model}: no weights; {how} (licence: {entry.license})")
    if ffgs.zoo.sha256_file(file) != pinned.sha256:
        sys.exit(f"{file}: sha256 is not {pinned.sha256}, of {model}; {how}")
    state = load_file(file) if file.endswith(".safetensors") else torch.load(file, "cpu")
    network = spec.model_cls(**entry.model)
    network.load_state_dict(spec.convert_state_dict(state) if spec.convert_state_dict else state)
    processor = spec.processor_cls(entry.processor)
    return ffgs.GSPipeline(network, processor, entry.model_type).to(device)


def world_of(poses, processor):
    """The middle of the selected cameras, and the unit that a model is given them in."""
    centers = poses[:, :3, 3]
    middle = centers.mean(axis=0)
    unit = np.linalg.norm(centers - middle, axis=1).max()
    spread = getattr(processor.config, "camera_spread", None)
    if spread is not None and processor.camera_input != "none":
        unit = np.linalg.norm(centers[1:] - centers[0], axis=1).mean() / spread
    return middle, unit or 1.0


def main(model, weights=None):
    """Serve it."""
    del sys.path[0]  # this file has the package's name
    import ffgs
    import ffgs.zoo

    device = "cuda" if torch.cuda.is_available() else "cpu"
    pipeline = pipeline_of(ffgs, model, weights, device)

    def cameras(views, size, middle, unit):
        poses = camera_to_world(views.world_to_camera)
        poses[:, :3, 3] = (poses[:, :3, 3] - middle) / unit
        lenses = np.tile(np.eye(3), (len(poses), 1, 1))
        lenses[:, [0, 1, 0, 1], [0, 1, 2, 2]] = views.intrinsics
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
