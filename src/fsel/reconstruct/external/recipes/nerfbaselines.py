"""Methods of NerfBaselines (Kulhanek and Sattler 2024) through its own command.

    python nerfbaselines.py fit FOLDER --method gaussian-splatting [options of nerfbaselines train]
    python nerfbaselines.py render FOLDER [options of nerfbaselines render-trajectory]

The command `nerfbaselines` must be on the path. It knows the selected frames alone: they are its
training images, and its test images too, since it refuses none.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

WORK = "nerfbaselines"
NEVER = str(10**9)  # iterations after which it evaluates


def fit(folder, options):
    """Train; the checkpoint is in FOLDER/nerfbaselines/output."""
    data = folder / WORK / "data"
    data.mkdir(parents=True)
    names = sorted(path.name for path in (folder / "images").iterdir())
    for part in ("images", "sparse"):
        os.symlink(folder / part, data / part)
    for split in ("train", "test"):
        (data / f"{split}_list.txt").write_text("\n".join(names))
    command = ["nerfbaselines", "train", "--data", str(data)]
    command += ["--output", str(folder / WORK / "output"), "--disable-output-artifact"]
    command += ["--logger", "none", "--eval-few-iters", NEVER, "--eval-all-iters", NEVER]
    subprocess.run([*command, *options], check=True)


def trajectory(targets):
    """The targets as NerfBaselines states a camera path; its axes are OpenCV's."""
    frames = []
    for target in targets:
        matrix = target["transform_matrix"]
        pose = [[row[0], -row[1], -row[2], row[3]] for row in matrix[:3]]
        frames.append(
            {
                "pose": [value for row in pose for value in row],
                "intrinsics": [target[key] for key in ("fl_x", "fl_y", "cx", "cy")],
                "appearance_weights": [],
            }
        )
    size = [targets[0]["w"], targets[0]["h"]]
    head = {"format": "nerfbaselines-v1", "camera_model": "pinhole", "image_size": size}
    return {**head, "fps": 1, "source": None, "frames": frames}


def render(folder, options):
    """Render every target from the last checkpoint."""
    targets = json.loads((folder / "targets.json").read_text())["frames"]
    path, out = folder / WORK / "trajectory.json", folder / WORK / "rendered"
    path.write_text(json.dumps(trajectory(targets)))
    checkpoints = (folder / WORK / "output").glob("checkpoint-*")
    last = max(checkpoints, key=lambda found: int(found.name.rpartition("-")[2]))
    command = ["nerfbaselines", "render-trajectory", "--checkpoint", str(last)]
    command += ["--trajectory", str(path), "--output", str(out), "--output-names", "color"]
    subprocess.run([*command, *options], check=True)
    for row, target in enumerate(targets):
        shutil.move(str(next(out.rglob(f"{row:05d}.png"))), folder / "renderings" / target["file"])


if __name__ == "__main__":
    task, where, *rest = sys.argv[1:]
    {"fit": fit, "render": render}[task](Path(where).resolve(), rest)
