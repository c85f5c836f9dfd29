"""A method for NerfBaselines, registered by its spec mechanism: every view is the frames' mean.

Run in an environment of NerfBaselines, where the variable NERFBASELINES_REGISTER names this file.
"""

import json
import os
from pathlib import Path

import numpy as np


class MeanMethod:
    """Adds one training image to the mean with each iteration, and renders the mean so far."""

    def __init__(self, *, checkpoint=None, train_dataset=None, config_overrides=None):
        self.sum, self.count = np.zeros(3), 0
        if checkpoint is not None:
            saved = json.loads((Path(checkpoint) / "mean.json").read_text())
            self.sum, self.count = np.array(saved["sum"]), saved["count"]
        self.checkpoint, self.dataset = checkpoint, train_dataset

    @classmethod
    def get_method_info(cls):
        return {
            "method_id": "fsel-mean",
            "required_features": frozenset(("color", "points3D_xyz")),
            "supported_camera_models": frozenset(("pinhole",)),
            "supported_outputs": ("color",),
        }

    def get_info(self):
        steps = 0 if self.dataset is None else len(self.dataset["images"])
        step = self.count if self.checkpoint is not None else None
        info = {"num_iterations": steps, "loaded_step": step, "loaded_checkpoint": self.checkpoint}
        return {**self.get_method_info(), **info, "hparams": {}}

    def train_iteration(self, step):
        self.sum = self.sum + self.dataset["images"][step][..., :3].mean(axis=(0, 1)) / 255
        self.count += 1
        return {"loss": 0.0}

    def save(self, path):
        os.makedirs(path, exist_ok=True)
        state = {"sum": self.sum.tolist(), "count": self.count}
        (Path(path) / "mean.json").write_text(json.dumps(state))

    def get_train_embedding(self, index):
        return None

    def render(self, camera, *, options=None):
        width, height = camera.image_sizes.reshape(-1)[:2].tolist()
        color = np.tile(self.sum / self.count, (height, width, 1)).astype(np.float32)
        # the camera's height and focal length, to be found in the image
        color[0, 0] = camera.poses.reshape(3, 4)[1, 3] / 10 + 0.5
        color[0, 1] = camera.intrinsics.reshape(-1)[0] / 100
        return {"color": color}


if __name__.endswith(".py"):  # read as a spec; as a module it is the method
    from nerfbaselines import register

    register(
        {
            "id": "fsel-mean",
            "method_class": "nerfbaselines_spec:MeanMethod",
            "conda": {"environment_name": "none", "install_script": ""},
            "backends_order": ["python"],
        }
    )
