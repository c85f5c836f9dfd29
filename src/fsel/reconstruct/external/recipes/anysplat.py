"""AnySplat (Jiang et al. 2025) from a clone of its own repository, as a worker.

    python anysplat.py REPOSITORY WEIGHTS

Run in its environment. WEIGHTS is a folder or name that `AnySplat.from_pretrained` takes. Its own
evaluation shows the targets' images to the camera head; here the model sees the selected frames
alone, and the targets' cameras are carried into its world by the similarity from the cameras that
it predicts for the selected frames to the given ones.
"""

import glob
import importlib
import os
import sys

import numpy as np
import torch
from fsel_worker import camera_to_world, serve

HOMES = ("src.model.model.anysplat", "src.model.arch.anysplat")
NEAR, FAR = 0.01, 100.0  # of its own evaluation


def similarity(predicted, given):
    """Rotation, scale and shift that carry predicted camera-to-world poses to the given ones.

    The rotation is the mean of the views' (SVD), scale and shift are least squares of the centres.

    Args:
        predicted, given: (K, 4, 4).
    """
    total = (given[:, :3, :3] @ predicted[:, :3, :3].transpose(0, 2, 1)).sum(axis=0)
    left, _, right = np.linalg.svd(total)
    turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    source, goal = predicted[:, :3, 3] @ turn.T, given[:, :3, 3]
    offset, wanted = source - source.mean(axis=0), goal - goal.mean(axis=0)
    spread = (offset**2).sum()
    scale = (offset * wanted).sum() / spread if spread > 0 else 0.0
    if not scale > 0:
        raise ValueError(
            f"no similarity carries the predicted cameras to the given ones: scale {scale}"
        )
    return turn, scale, goal.mean(axis=0) - scale * source.mean(axis=0)


def carried(poses, turn, scale, shift):
    """World poses in the model's world."""
    moved = poses.copy()
    moved[:, :3, :3] = turn.T @ poses[:, :3, :3]
    moved[:, :3, 3] = (poses[:, :3, 3] - shift) @ turn / scale
    return moved


def network(repository, weights):
    """The model, the function that reads an image for it, and the device."""
    sys.path.insert(0, os.path.abspath(repository))
    for home in HOMES:
        try:
            found = importlib.import_module(home)
            break
        except ModuleNotFoundError as error:
            if not home.startswith(str(error.name)):
                raise
    else:
        sys.exit(f"{repository}: has none of {', '.join(HOMES)}")
    device = "cuda" if torch.cuda.is_available() else "cpu"
    model = found.AnySplat.from_pretrained(weights).to(device).eval()
    return model, importlib.import_module("src.utils.image").process_image, device


def main(repository, weights):
    """Serve it."""
    model, read, device = network(repository, weights)

    @torch.no_grad()
    def fit(subset):
        paths = sorted(glob.glob(os.path.join(subset.folder, "images", "*.png")))
        images = torch.stack([read(path) for path in paths])[None].to(device)
        output = model.encoder((images + 1) * 0.5, global_step=0, visualization_dump={})
        predicted = output.pred_context_pose["extrinsic"][0].double().cpu().numpy()
        fitted = similarity(predicted, camera_to_world(subset.world_to_camera))
        return output.gaussians, fitted

    @torch.no_grad()
    def render(made, views):
        gaussians, fitted = made
        width, height = views.size
        images = []
        poses = carried(camera_to_world(views.world_to_camera), *fitted)
        for row, pose in enumerate(poses):
            fx, fy, cx, cy = views.intrinsics[row]
            share = [[fx / width, 0, cx / width], [0, fy / height, cy / height], [0, 0, 1]]
            cameras = [
                torch.tensor(found, dtype=torch.float32, device=device)[None, None]
                for found in (pose, np.array(share))
            ]
            planes = [torch.full((1, 1), plane, device=device) for plane in (NEAR, FAR)]
            made = model.decoder.forward(gaussians, *cameras, *planes, (height, width))
            images.append(made.color[0, 0].clamp(0, 1).permute(1, 2, 0).cpu().numpy())
        return np.stack(images)

    serve(fit, render, name="anysplat", device=device, needs=["files"])


if __name__ == "__main__":
    main(*sys.argv[1:])
