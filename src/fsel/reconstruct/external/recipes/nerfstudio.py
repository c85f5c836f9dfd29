"""Methods of Nerfstudio (Tancik et al. 2023), as a worker or through its two commands.

    python nerfstudio.py serve nerfacto [options of ns-train, before the dataparser]
    python nerfstudio.py fit FOLDER nerfacto [the same]
    python nerfstudio.py render FOLDER [options of ns-render dataset]

The first is a worker, which imports torch and Nerfstudio once; the others start both for a subset.

The world is centred at the selected cameras and scaled by their distance, here and not by
Nerfstudio, whose own normalisation would depend on the targets. They join the test split, with
black images that nothing reads but the loader, when the model is trained.
"""

import json
import os
import shutil
import struct
import subprocess
import sys
import zlib
from pathlib import Path

WORK = "nerfstudio"
NEVER = str(10**9)  # steps after which it evaluates
LENS = ("w", "h", "fl_x", "fl_y", "cx", "cy")


def black(path, width, height):
    """An 8-bit RGB image of zeros; this file needs no package."""
    rows = zlib.compress(bytes(height * (1 + 3 * width)))
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)), (b"IDAT", rows)]
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, data in [*chunks, (b"IEND", b"")]:
            check = struct.pack(">I", zlib.crc32(kind + data))
            file.write(struct.pack(">I", len(data)) + kind + data + check)


def normalisation(frames):
    """Middle of the selected cameras, and their largest distance from it."""
    centers = [[row[3] for row in frame["transform_matrix"][:3]] for frame in frames]
    middle = [sum(center[axis] for center in centers) / len(centers) for axis in range(3)]
    away = [sum((center[axis] - middle[axis]) ** 2 for axis in range(3)) for center in centers]
    return middle, max(away) ** 0.5 or 1.0


def placed(frame, middle, unit):
    """A frame's entry in the normalised world."""
    matrix = [list(row) for row in frame["transform_matrix"]]
    for axis in range(3):
        matrix[axis][3] = (matrix[axis][3] - middle[axis]) / unit
    return {**{key: frame[key] for key in LENS}, "transform_matrix": matrix}


def write_scene(folder, targets):
    """Write transforms.json of the selected frames, and of targets once they are known."""
    data, given = folder / WORK / "data", json.loads((folder / "transforms.json").read_text())
    (data / "images").mkdir(parents=True, exist_ok=True)
    middle, unit = normalisation(given["frames"])
    trained, tested = [], []
    for frame in given["frames"]:
        link = data / frame["file_path"]
        if not link.exists():
            os.symlink(folder / frame["file_path"], link)
        trained.append({"file_path": frame["file_path"], **placed(frame, middle, unit)})
    for target in targets:
        name = "images/target_" + target["file"]
        black(data / name, target["w"], target["h"])
        tested.append({"file_path": name, **placed(target, middle, unit)})
    content = {"camera_model": "OPENCV", "frames": trained + tested}
    for split, frames in (("train", trained), ("val", trained), ("test", tested or trained)):
        content[split + "_filenames"] = [frame["file_path"] for frame in frames]
    if "ply_file_path" in given:
        write_points(folder / given["ply_file_path"], data / "points.ply", middle, unit)
        content["ply_file_path"] = "points.ply"
    (data / "transforms.json").write_text(json.dumps(content))
    return data


def write_points(source, path, middle, unit):
    """The points in the normalised world, as text: COLMAP writes float x y z, then bytes r g b."""
    head, _, body = source.read_bytes().partition(b"end_header\n")
    size = 27 if b"nx" in head else 15
    rows = [body[at : at + size] for at in range(0, len(body), size)]
    lines = ["ply", "format ascii 1.0", f"element vertex {len(rows)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"property uchar {color}" for color in ("red", "green", "blue")] + ["end_header"]
    for row in rows:
        point = struct.unpack("<3f", row[:12])
        xyz = [(point[axis] - middle[axis]) / unit for axis in range(3)]
        lines.append(" ".join(map(str, [*xyz, *row[-3:]])))
    path.write_text("\n".join(lines) + "\n")


def arguments(folder, options):
    """Words of `ns-train` after the command, for the scene of the selected frames."""
    data = write_scene(folder, [])
    method, *further = options
    words = [method, "--data", str(data), "--output-dir", str(folder / WORK)]
    words += ["--experiment-name", "trained", "--timestamp", "run", "--vis", "tensorboard"]
    for kind in ("batch", "image", "all-images"):
        words += [f"--steps-per-eval-{kind}", NEVER]
    parser = ["nerfstudio-data", "--orientation-method", "none", "--center-method", "none"]
    return [*words, *further, *parser, "--auto-scale-poses", "False"]


def fit(folder, options):
    """Train; the model is in FOLDER/nerfstudio/trained."""
    subprocess.run(["ns-train", *arguments(folder, options)], check=True)


def stop(trainer, writers):
    """End what outlives a trainer: processes that load images, and writers of its events."""
    for process in getattr(trainer.pipeline.datamanager, "data_procs", ()):
        process.terminate()
        process.join()
    for writer in writers:
        if hasattr(writer, "tb_writer"):
            writer.tb_writer.close()
    writers.clear()  # a list of Nerfstudio's; the next trainer would write to them too


def serve_method(options):
    """Serve a method: train as `ns-train` does, and render by the model's own function."""
    del sys.path[0]  # this file has the package's name
    import numpy as np
    import torch
    import tyro
    from fsel_worker import camera_to_world, serve
    from nerfstudio.cameras.cameras import Cameras, CameraType
    from nerfstudio.configs.method_configs import AnnotatedBaseConfigUnion
    from nerfstudio.scripts.train import _set_random_seed
    from nerfstudio.utils.writer import EVENT_WRITERS

    def fitted(subset):
        folder = Path(subset.folder)
        config = tyro.cli(AnnotatedBaseConfigUnion, args=arguments(folder, options))
        config.set_timestamp()
        config.pipeline.datamanager.data = config.data
        _set_random_seed(config.machine.seed)
        trainer = config.setup(local_rank=0, world_size=1)
        trainer.setup()
        try:
            trainer.train()
        finally:
            stop(trainer, EVENT_WRITERS)
        given = json.loads((folder / "transforms.json").read_text())["frames"]
        return trainer.pipeline.model.eval(), normalisation(given)

    @torch.no_grad()
    def images(made, views):
        model, (middle, unit) = made
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

    serve(fitted, images, name=options[0], needs=["files"])


def render(folder, options):
    """Render every target."""
    targets = json.loads((folder / "targets.json").read_text())["frames"]
    write_scene(folder, targets)
    config = next((folder / WORK / "trained").glob("*/run/config.yml"))
    out = folder / WORK / "rendered"
    command = ["ns-render", "dataset", "--load-config", str(config), "--output-path", str(out)]
    command += ["--split", "test", "--rendered-output-names", "rgb", "--image-format", "png"]
    # unless told to, torch from 2.6 on reads no checkpoint with NumPy's numbers, as this one has
    trusted = {**os.environ, "TORCH_FORCE_NO_WEIGHTS_ONLY_LOAD": "1"}
    subprocess.run([*command, *options], check=True, env=trusted)
    for target in targets:
        found = next(out.rglob("target_" + target["file"]))
        shutil.move(str(found), str(folder / "renderings" / target["file"]))


if __name__ == "__main__":
    task, *rest = sys.argv[1:]
    if task == "serve":
        serve_method(rest)
    else:
        {"fit": fit, "render": render}[task](Path(rest[0]).resolve(), rest[1:])
