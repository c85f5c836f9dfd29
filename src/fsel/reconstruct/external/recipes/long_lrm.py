"""Long-LRM (Ziwen et al. 2025) from a clone of arthurhero/Long-LRM, as a worker.

    python long_lrm.py REPOSITORY CONFIG DEFAULT_CONFIG CHECKPOINT

Run in its environment; the two configurations are files of the repository. Images, cameras and the
scale of the world are made from the selected frames as its `data/dataset.py` makes them; its own
loader chooses frames by itself, and answers every fault with another scene.
"""

import os
import sys

import cv2
import numpy as np
import torch
import yaml
from fsel_worker import camera_to_world, serve

SEED = 1111  # of its main.py; Gaussians beyond the most opaque are kept by chance
KINDS = {"fp16": torch.float16, "bf16": torch.bfloat16}
PARTS = ("xyz", "feature", "scale", "rotation", "opacity")


def merged(default, own):
    """A configuration over its defaults, key by key."""
    both = dict(default)
    for key, value in own.items():
        known = both.get(key)
        both[key] = merged(known, value) if isinstance(known, dict) else value
    return both


def network(repository, config, default, checkpoint):
    """The model with its weights, its renderer, its configuration and the device."""
    sys.path.insert(0, os.path.abspath(repository))
    from easydict import EasyDict
    from model import llrm

    with open(default) as file, open(config) as own:
        found = merged(yaml.safe_load(file), yaml.safe_load(own))
    found["training"].update(perceptual_loss=0.0, gaussian_depth_loss=0.0)  # else it loads networks
    settings = EasyDict(found)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    model = llrm.LongLRM(settings, device).to(device).eval()
    weights = torch.load(checkpoint, map_location=device)["model"]
    absent = model.load_state_dict(weights, strict=False).missing_keys
    if absent:
        sys.exit(f"{checkpoint}: lacks {len(absent)} of the model's weights, such as {absent[0]}")
    return model, llrm.GaussianRenderer, settings, device


def working_size(size, settings):
    """The (width, height) that images are brought to: of its configuration, in whole patches."""
    width, height = size
    high, wide = (settings.data.get(key, -1) for key in ("resize_h", "resize_w"))
    if high == -1 and wide == -1:
        high, wide = height, width
    elif high == -1:
        high = int(wide / width * height)
    elif wide == -1:
        wide = int(high / height * width)
    patch = settings.model.patch_size * 2 ** len(settings.model.get("merge_layers", []))
    return round(wide / patch) * patch, round(high / patch) * patch


def normalisation(poses):
    """(4, 4) world to the mean camera of the inputs, and their largest coordinate in it."""
    position, forward, down = (poses[:, :3, column].mean(axis=0) for column in (3, 2, 1))
    forward = forward / np.linalg.norm(forward)
    down = down - down @ forward * forward
    down = down / np.linalg.norm(down)
    mean = np.eye(4)
    mean[:3] = np.stack([np.cross(down, forward), down, forward, position], axis=1)
    inverse = np.linalg.inv(mean)
    return inverse, np.abs((inverse @ poses)[:, :3, 3]).max()


def main(*files):
    """Serve it."""
    model, renderer, settings, device = network(*files)
    gaussians = settings.model.gaussians
    how = {"device_type": "cuda", "dtype": KINDS[settings.amp_dtype], "enabled": settings.use_amp}

    def tensor(array):
        return torch.tensor(np.asarray(array), dtype=torch.float32, device=device)

    def cameras(views, given, size, inverse, unit):
        poses = inverse @ camera_to_world(views.world_to_camera)
        poses[:, :3, 3] /= unit
        lenses = views.intrinsics * np.tile(np.array(size) / given, 2)
        return tensor(lenses)[None], tensor(poses)[None]

    @torch.no_grad()
    def fit(subset):
        torch.manual_seed(SEED)
        given = subset.images.shape[2], subset.images.shape[1]
        size = working_size(given, settings)
        inverse, reach = normalisation(camera_to_world(subset.world_to_camera))
        unit = settings.data.get("scene_scale", 1.0) * reach
        lenses, poses = cameras(subset, given, size, inverse, unit)
        images = np.stack([cv2.resize(image, size) for image in subset.images]) / 255
        inputs = {"input_images": tensor(images).permute(0, 3, 1, 2)[None]}
        with torch.autocast(**how):
            made = model({**inputs, "input_intr": lenses, "input_c2ws": poses})["gaussians"]
        return [made[part][0] for part in PARTS], (given, size, inverse, unit)

    @torch.no_grad()
    def render(made, views):
        parts, (given, size, *world) = made
        lenses, poses = cameras(views, given, size, *world)
        shape = *size, gaussians.sh_degree, gaussians.near_plane, gaussians.far_plane
        images = []
        for row in range(len(views)):
            made = renderer.render(*parts, poses[0, row], lenses[0, row], *shape)
            image = made[0].clamp(0, 1).cpu().numpy()
            images.append(cv2.resize(image, views.size, interpolation=cv2.INTER_AREA))
        return np.stack(images)

    serve(fit, render, name="long_lrm", device=device)


if __name__ == "__main__":
    main(*sys.argv[1:])
