"""Methods of NerfBaselines (Kulhanek and Sattler 2024) by their common interface, as a worker.

    python nerfbaselines.py METHOD [BACKEND [KEY=VALUE ...]]

Run in an environment of NerfBaselines; the method runs where its BACKEND has it (`conda`, `docker`,
`apptainer`, `python`), started once. Further words override the method's configuration. It knows
the selected frames alone.
"""

import os
import sys

import numpy as np
from fsel_worker import camera_to_world, serve


def scene(subset, load_dataset, info):
    """The selected frames as NerfBaselines' own loader reads a COLMAP model."""
    folder = os.path.join(subset.folder, "nerfbaselines")
    os.makedirs(folder)
    for part in ("images", "sparse"):
        os.symlink(os.path.join(subset.folder, part), os.path.join(folder, part))
    for split in ("train", "test"):
        with open(os.path.join(folder, split + "_list.txt"), "w") as file:
            file.write("\n".join(sorted(os.listdir(os.path.join(folder, "images")))))
    models = info.get("supported_camera_models", frozenset(("pinhole",)))
    features = info.get("required_features", frozenset())
    asked = {"features": features, "supported_camera_models": models, "load_features": True}
    return load_dataset(folder, split="train", **asked)


def main(name, backend=None, *given):
    """Serve a method."""
    del sys.path[0]  # this file has the package's name
    import nerfbaselines
    from nerfbaselines import build_method_class, new_cameras
    from nerfbaselines.datasets import load_dataset
    from nerfbaselines.training import get_presets_and_config_overrides

    spec = nerfbaselines.get_method_spec(name)
    own = dict(word.split("=", 1) for word in given)
    with build_method_class(spec, backend) as method_class:
        info = method_class.get_method_info()

        def fit(subset):
            data = scene(subset, load_dataset, info)
            _, settings = get_presets_and_config_overrides(
                spec, data["metadata"], presets=None, config_overrides=own
            )
            method = method_class(train_dataset=data, config_overrides=settings)
            for step in range(method.get_info()["num_iterations"]):
                method.train_iteration(step)
            return method

        def render(method, views):
            count = len(views)
            poses = camera_to_world(views.world_to_camera)[:, :3]
            cameras = new_cameras(
                poses=poses.astype(np.float32),
                intrinsics=views.intrinsics.astype(np.float32),
                camera_models=np.zeros(count, np.uint8),
                image_sizes=np.tile(np.array(views.size, np.int32), (count, 1)),
            )
            images = [method.render(cameras[row].item())["color"] for row in range(count)]
            return np.clip(np.stack(images)[..., :3], 0, 1)

        serve(fit, render, name=name, version=nerfbaselines.__version__, needs=["files"])


if __name__ == "__main__":
    main(*sys.argv[1:])
