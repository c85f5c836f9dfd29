"""Long-LRM (Ziwen et al. 2025) through its own `main.py --evaluation`.

    python long_lrm.py FOLDER REPOSITORY CONFIG DEFAULT_CONFIG CHECKPOINT

Run in its environment (torch, PyYAML, OpenCV), with `torchrun` on the path. REPOSITORY is a clone
of arthurhero/Long-LRM; the two configurations are files of it. What its loader reads is one scene
whose every E-th frame is a target; the selected frames are listed under the key that it would keep
the choice of its own k-means under. Targets have black images: only its own metrics read them.

Its loader turns every fault into another scene, or another choice of frames, without an error. So
the frames, poses and scale that it says it used are compared with those that it was given.
"""

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import yaml

WORK = "long_lrm"
TOLERANCE = 1e-3  # of what it computes in float32


def entry(path, frame):
    """A frame of the scene's list."""
    pose = np.array(frame["transform_matrix"]) @ np.diag([1.0, -1, -1, 1])
    lens = {"h": frame["h"], "w": frame["w"], "fx": frame["fl_x"], "fy": frame["fl_y"]}
    lens |= {"cx": frame["cx"], "cy": frame["cy"]}
    return {"file_path": path, "w2c": np.linalg.inv(pose).tolist(), **lens}


def write_scene(folder, work, targets, picks):
    """The scene's file: targets at every E-th place, picks between, the first pick as filling.

    Returns:
        The scene's name, the places of the picks, the places of the targets, and E.
    """
    every = -(-(len(targets) + len(picks)) // len(targets))
    between = [at for at in range(every * len(targets)) if at % every]
    frames = [None] * (every * len(targets))
    for row, target in enumerate(targets):
        name = f"black_{row:06d}.png"
        cv2.imwrite(str(work / name), np.zeros((target["h"], target["w"], 3), np.uint8))
        frames[row * every] = entry(name, target)
    for row, at in enumerate(between):
        pick = picks[row] if row < len(picks) else picks[0]
        frames[at] = entry(str(folder / pick["file_path"]), pick)
    chosen = between[: len(picks)]
    name = "fsel_" + hashlib.sha256(json.dumps(frames).encode()).hexdigest()[:16]
    scene = {"scene_name": name, "frames": frames}
    scene[f"fold_{every}_kmeans_{len(picks)}_input"] = chosen
    (work / "scene.json").write_text(json.dumps(scene))
    (work / "scenes.txt").write_text(str(work / "scene.json") + "\n")
    return name, chosen, list(range(0, len(frames), every)), every


def write_config(source, work, checkpoint, picks, targets, every):
    """A configuration of Long-LRM, changed to evaluate the scene alone."""
    config = yaml.safe_load(Path(source).read_text())
    config["data"] = {**config.get("data", {}), "square_crop": False}
    config["data_eval"] = {
        **config.get("data_eval", {}),
        "data_path": str(work / "scenes.txt"),
        "input_frame_select_type": "kmeans",
        "target_frame_select_type": "uniform_every",
        "target_uniform_every": every,
        "num_input_frames": picks,
        "num_target_frames": targets,
        "target_has_input": False,
        "min_frame_dist": "all",
        "max_frame_dist": every * targets,  # read even where min_frame_dist is "all"
        "shuffle_input_prob": 0.0,
        "reverse_input_prob": 0.0,
    }
    training = {"resume_ckpt": str(checkpoint), "batch_size_per_gpu": 1}
    training |= {"perceptual_loss": 0.0, "gaussian_depth_loss": 0.0}  # else it loads networks
    config["training"] = {**config.get("training", {}), **training}
    config["evaluation_dir"] = str(work / "evaluation")
    config["checkpoint_dir"] = str(work / "checkpoints")
    (work / "fsel.yaml").write_text(yaml.safe_dump(config))


def normalisation(picks):
    """(4, 4) world to the mean camera of the inputs, and the scale, as its loader computes them."""
    poses = np.array([pick["transform_matrix"] for pick in picks]) @ np.diag([1.0, -1, -1, 1])
    position, forward, down = (poses[:, :3, column].mean(axis=0) for column in (3, 2, 1))
    forward = forward / np.linalg.norm(forward)
    down = down - down @ forward * forward
    down = down / np.linalg.norm(down)
    mean = np.eye(4)
    mean[:3] = np.stack([np.cross(down, forward), down, forward, position], axis=1)
    inverse = np.linalg.inv(mean)
    return inverse, 1 / np.abs((inverse @ poses)[:, :3, 3]).max()


def check_used(scene, chosen, targets, picks):
    """Refuse renderings of other frames, poses or scales than were given."""
    if not scene.is_dir():
        written = sorted(path.name for path in scene.parent.glob("*"))
        sys.exit(f"Long-LRM evaluated another scene: {written} in the place of {scene.name}")
    for name, wanted in (("input_frame_idx", chosen), ("target_frame_idx", targets)):
        used = np.loadtxt(scene / f"{name}.txt", dtype=int, ndmin=1).tolist()
        if used != wanted:
            sys.exit(f"Long-LRM used other frames: {name} is {used}, given {wanted}")
    inverse, scale = normalisation(picks)
    used = np.loadtxt(scene / "pos_avg_inv.txt")
    if not np.allclose(used[:3, :3], inverse[:3, :3], atol=TOLERANCE):
        sys.exit(
            f"Long-LRM used other poses: pos_avg_inv is {used.tolist()}, not {inverse.tolist()}"
        )
    used = float(np.loadtxt(scene / "scene_scale.txt"))
    if not abs(used / scale - 1) < TOLERANCE:
        sys.exit(f"Long-LRM used another scale: scene_scale is {used}, not {scale}")


def main(where, repository, config, default, checkpoint):
    """Render all targets of a folder."""
    folder = Path(where).resolve()
    work = folder / WORK
    work.mkdir()
    targets = json.loads((folder / "targets.json").read_text())["frames"]
    picks = json.loads((folder / "transforms.json").read_text())["frames"]
    name, chosen, places, every = write_scene(folder, work, targets, picks)
    write_config(config, work, Path(checkpoint).resolve(), len(picks), len(targets), every)
    command = ["torchrun", "--standalone", "--nproc_per_node", "1", "main.py", "--evaluation"]
    command += ["--config", str(work / "fsel.yaml")]
    command += ["--default-config", str(Path(default).resolve())]
    subprocess.run(command, cwd=repository, check=True)
    scene = work / "evaluation" / "fsel" / name
    check_used(scene, chosen, places, picks)
    for row, target in enumerate(targets):
        # it renders at a multiple of its patches; the cameras were scaled alike
        image = cv2.imread(str(scene / "rendering" / f"{row}.png"))
        size = (target["w"], target["h"])
        out = folder / "renderings" / target["file"]
        cv2.imwrite(str(out), cv2.resize(image, size, interpolation=cv2.INTER_AREA))
    shutil.rmtree(work)


if __name__ == "__main__":
    main(*sys.argv[1:])
