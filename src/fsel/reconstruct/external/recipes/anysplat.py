"""AnySplat (Jiang et al. 2025) from a clone of its own repository.

    python anysplat.py FOLDER REPOSITORY WEIGHTS

Run in its environment. WEIGHTS is a folder or name that `AnySplat.from_pretrained` takes. Its own
evaluation shows the targets' images to the camera head; here the model sees the selected frames
alone, and the targets' cameras are carried into its world by the similarity from the cameras that
it predicts for the selected frames to the given ones.
"""

import importlib
import json
import sys
from pathlib import Path

import cv2
import numpy as np
import torch

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
        sys.exit(f"no similarity carries the predicted cameras to the given ones: scale {scale}")
    return turn, scale, goal.mean(axis=0) - scale * source.mean(axis=0)


def opencv(frame):
    """(4, 4) camera to world of a frame, OpenCV axes."""
    return np.array(frame["transform_matrix"]) @ np.diag([1.0, -1, -1, 1])


def carried(poses, turn, scale, shift):
    """World poses in the model's world."""
    moved = poses.copy()
    moved[:, :3, :3] = turn.T @ poses[:, :3, :3]
    moved[:, :3, 3] = (poses[:, :3, 3] - shift) @ turn / scale
    return moved


def network(repository, weights):
    """The model, and the function that reads an image for it."""
    sys.path.insert(0, str(Path(repository).resolve()))
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


@torch.no_grad()
def main(where, repository, weights):
    """Render all targets of a folder."""
    folder = Path(where)
    picks = json.loads((folder / "transforms.json").read_text())["frames"]
    targets = json.loads((folder / "targets.json").read_text())["frames"]
    model, read, device = network(repository, weights)
    images = torch.stack([read(str(folder / pick["file_path"])) for pick in picks])[None].to(device)
    output = model.encoder((images + 1) * 0.5, global_step=0, visualization_dump={})
    predicted = output.pred_context_pose["extrinsic"][0].double().cpu().numpy()
    fitted = similarity(predicted, np.array([opencv(pick) for pick in picks]))
    for target in targets:
        pose = carried(opencv(target)[None], *fitted)
        lens = np.eye(3)
        lens[0] = target["fl_x"] / target["w"], 0, target["cx"] / target["w"]
        lens[1] = 0, target["fl_y"] / target["h"], target["cy"] / target["h"]
        cameras = [
            torch.tensor(found, dtype=torch.float32, device=device)[None]
            for found in (pose, lens[None])
        ]
        planes = [torch.full((1, 1), plane, device=device) for plane in (NEAR, FAR)]
        size = target["h"], target["w"]
        color = model.decoder.forward(output.gaussians, *cameras, *planes, size).color[0, 0]
        pixels = (color.clamp(0, 1) * 255).round().byte().permute(1, 2, 0).cpu().numpy()
        cv2.imwrite(str(folder / "renderings" / target["file"]), pixels[:, :, ::-1])


if __name__ == "__main__":
    main(*sys.argv[1:])
