"""Methods of Nerfstudio (Tancik et al. 2023), as a worker.

    python nerfstudio.py nerfacto [options of ns-train, before the dataparser]

The world is centred at the selected cameras and scaled by their distance, here and not by
Nerfstudio, whose own normalisation would depend on the targets.
"""

import json
import sys
from pathlib import Path

import numpy as np
import torch
from fsel_worker import camera_to_world, middle_and_unit, serve

WORK = "nerfstudio"
NEVER = str(10**9)  # steps after which it evaluates


def write_scene(subset, middle, unit):
    """Write the selected frames and points in the normalised world; returns their folder."""
    folder = Path(subset.folder)
    data, content = folder / WORK, json.loads((folder / "transforms.json").read_text())
    data.mkdir()
    (data / "images").symlink_to(folder / "images")
    for frame in content["frames"]:
        frame.pop("mask_path", None)
        matrix = np.array(frame["transform_matrix"])
        matrix[:3, 3] = (matrix[:3, 3] - middle) / unit
        frame["transform_matrix"] = matrix.tolist()
    if "ply_file_path" in content:
        content["ply_file_path"] = "points.ply"
        rows = np.concatenate([(subset.xyz - middle) / unit, subset.rgb], axis=1)
        kinds = ["float x", "float y", "float z", "uchar red", "uchar green", "uchar blue"]
        head = ["ply", "format ascii 1.0", f"element vertex {len(rows)}"]
        head += [f"property {kind}" for kind in kinds] + ["end_header"]
        shown = {"header": "\n".join(head), "comments": "", "fmt": ["%.9g"] * 3 + ["%d"] * 3}
        np.savetxt(data / "points.ply", rows, **shown)
    (data / "transforms.json").write_text(json.dumps(content))
    return data


def arguments(data, options):
    """Words of `ns-train` after the command, for the scene in a folder."""
    method, *further = options
    words = [method, "--data", str(data), "--output-dir", str(data)]
    words += ["--experiment-name", "trained", "--timestamp", "run", "--vis", "tensorboard"]
    for kind in ("batch", "image", "all-images"):
        words += [f"--steps-per-eval-{kind}", NEVER]
    parser = ["nerfstudio-data", "--orientation-method", "none", "--center-method", "none"]
    return [*words, *further, *parser, "--auto-scale-poses", "False"]


def stop(trainer, writers):
    """End what outlives a trainer: processes that load images, and writers of its events."""
    for process in getattr(trainer.pipeline.datamanager, "data_procs", ()):
        process.terminate()
        process.join()
    for writer in writers:
        if hasattr(writer, "tb_writer"):
            writer.tb_writer.close()
    writers.clear()  # a list of Nerfstudio's; the next trainer would write to them too


def main(*options):
    """Serve a method: train as `ns-train` does, and render by the model's own function."""
    del sys.path[0]  # this file has the package's name
    import tyro
    from nerfstudio.cameras.cameras import Cameras, CameraType
    from nerfstudio.configs.method_configs import AnnotatedBaseConfigUnion
    from nerfstudio.scripts.train import _set_random_seed
    from nerfstudio.utils.writer import EVENT_WRITERS

    def fit(subset):
        middle, unit = middle_and_unit(camera_to_world(subset.world_to_camera)[:, :3, 3])
        words = arguments(write_scene(subset, middle, unit), options)
        config = tyro.cli(AnnotatedBaseConfigUnion, args=words)
        config.set_timestamp()
        config.pipeline.datamanager.data = config.data
        _set_random_seed(config.machine.seed)
        trainer = config.setup(local_rank=0, world_size=1)
        trainer.setup()
        try:
            trainer.train()
        finally:
            stop(trainer, EVENT_WRITERS)
        return trainer.pipeline.model.eval(), middle, unit

    @torch.no_grad()
    def render(made, views):
        model, middle, unit = made
        poses = camera_to_world(views.world_to_camera)[:, :3] @ np.diag([1.0, -1, -1, 1])
        poses[:, :, 3] = (poses[:, :, 3] - middle) / unit
        poses, lenses = torch.tensor(poses).float(), torch.tensor(views.intrinsics).float()
        found = []
        for row in range(len(views)):
            lens, kind = lenses[row, :, None], CameraType.PERSPECTIVE
            camera = Cameras(poses[row : row + 1], *lens, *views.size, camera_type=kind)
            rgb = model.get_outputs_for_camera(camera.to(model.device))["rgb"]
            found.append(rgb.clamp(0, 1).cpu().numpy())
        return np.stack(found)

    serve(fit, render, name=options[0], needs=["points", "files"])


if __name__ == "__main__":
    main(*sys.argv[1:])
