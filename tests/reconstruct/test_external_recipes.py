"""The recipes for published programs, with stand-ins that honour the same files."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation
from selection_problems import capture_of
from small_captures import ring

from fsel.data.geometry import invert_pose
from fsel.reconstruct.external import External, ExternalSettings
from fsel.reconstruct.outcome import Unfinished

SIZE = (24, 18)
FRAMES, TARGETS = np.array([5, 0, 3]), np.array([1, 6])
RECIPES = sorted((Path(__file__).parents[2] / "config" / "reconstructors").glob("*.yaml"))
# virtual environments that have them
NERFBASELINES = os.environ.get("FSEL_NERFBASELINES")
NERFSTUDIO = os.environ.get("FSEL_NERFSTUDIO")
# what config/reconstructors/nerfstudio.yaml says of a CPU, and a model small enough for it
ON_A_CPU = ["--machine.device-type", "cpu", "--pipeline.model.implementation", "torch"]
ON_A_CPU += ["--mixed-precision", "False"]
SMALL = ["--pipeline.model.log2-hashmap-size", "12", "--max-num-iterations", "40"]
SMALL += ["--pipeline.datamanager.train-num-rays-per-batch", "128"]
ALEXNET = """
import sys, torch, torchvision
torch.save(torchvision.models.alexnet().state_dict(), sys.argv[1])
"""

# `torchrun`: its own options are left out
TORCHRUN = """#!/bin/sh
shift 3
exec "$PYTHON" "$@"
"""

# Long-LRM's main.py as far as files go; FAULT says what its loader would hide
LONG_LRM = """
import argparse, json, os, sys
from pathlib import Path
import cv2, numpy as np, yaml

parser = argparse.ArgumentParser()
parser.add_argument("--config")
parser.add_argument("--default-config")
parser.add_argument("--evaluation", action="store_true")
args = parser.parse_args()
assert args.evaluation and Path("main.py").is_file()
config = yaml.safe_load(open(args.config))
default = yaml.safe_load(open(args.default_config))
data = {**default["data"], **config["data"], **config["data_eval"]}
path = Path(open(data["data_path"]).read().strip())
scene, fault = json.load(open(path)), os.environ.get("FAULT", "")
frames, every = scene["frames"], data["target_uniform_every"]
assert data["min_frame_dist"] == "all" and data["max_frame_dist"] > 0
assert len(frames) - 1 >= data["num_input_frames"] + data["num_target_frames"] - 1
key = f"fold_{every}_kmeans_{data['num_input_frames']}_input"
inputs, targets = sorted(scene[key]), list(range(0, len(frames), every))
if fault == "frames":
    inputs[-1] += 1
name = "other" if fault == "scene" else scene["scene_name"]
poses = np.linalg.inv([frames[i]["w2c"] for i in inputs])
position, forward, down = (poses[:, :3, c].mean(0) for c in (3, 2, 1))
forward /= np.linalg.norm(forward)
down -= down @ forward * forward
down /= np.linalg.norm(down)
mean = np.vstack([np.stack([np.cross(down, forward), down, forward, position], 1), [0, 0, 0, 1]])
inverse = np.linalg.inv(mean)
scale = 1 / np.abs((inverse @ poses)[:, :3, 3]).max() * (2 if fault == "scale" else 1)
out = Path(config["evaluation_dir"], Path(args.config).stem, name)
(out / "rendering").mkdir(parents=True)
np.savetxt(out / "pos_avg_inv.txt", inverse.astype(np.float32))
np.savetxt(out / "scene_scale.txt", [np.float32(scale)])
np.savetxt(out / "input_frame_idx.txt", inputs, fmt="%i")
np.savetxt(out / "target_frame_idx.txt", targets, fmt="%i")
seen = np.mean([cv2.imread(str(path.parent / frames[i]["file_path"])) for i in inputs])
for row, at in enumerate(targets):
    assert not cv2.imread(str(path.parent / frames[at]["file_path"])).any()
    center = np.linalg.inv(frames[at]["w2c"])[:3, 3]  # what it was asked to render from
    image = np.full((32, 48, 3), seen)
    image[:, :] = center * 20 + 128
    cv2.imwrite(str(out / "rendering" / f"{row}.png"), image[:, :, ::-1].round().astype(np.uint8))
"""

ANYSPLAT = """
from pathlib import Path
from types import SimpleNamespace
import numpy as np, torch

HERE = Path(__file__).parents[3]

class AnySplat:
    @classmethod
    def from_pretrained(cls, weights):
        found = cls()
        found.poses, found.seen = torch.from_numpy(np.load(weights)), []
        found.encoder = found.encode
        found.decoder = SimpleNamespace(forward=found.paint)
        return found

    def to(self, device):
        return self

    def eval(self):
        return self

    def encode(self, images, global_step, visualization_dump):
        numbers = (images[0, :, 0, 0, 0] * 255).round().long()
        cameras = {"extrinsic": self.poses[numbers][None]}
        return SimpleNamespace(gaussians=None, pred_context_pose=cameras)

    def paint(self, gaussians, poses, lenses, near, far, size):
        self.seen.append(torch.cat([poses[0, 0].flatten(), lenses[0, 0].flatten()]).numpy())
        np.save(HERE / "seen.npy", self.seen)
        return SimpleNamespace(color=torch.full((1, 1, 3, *size), 0.2 * len(self.seen)))
"""

IMAGE = """
import cv2, torch

def process_image(path):
    image = cv2.imread(path)[:, :, ::-1].copy()
    return torch.from_numpy(image).permute(2, 0, 1).float() / 255 * 2 - 1
"""


@pytest.fixture
def capture():
    poses = ring(8)
    rotations = poses[:, :, :3]
    centers = -np.einsum("nij,ni->nj", rotations, poses[:, :, 3])
    found = capture_of(centers, rotations, size=SIZE)
    images = np.asarray(found.images).copy()
    images[:, 0, 0, 0] = np.arange(8)
    return replace(found, images=images)


def reconstruct(capture, **settings):
    return External(capture, **settings).fit(FRAMES).render(capture.view(TARGETS))


def long_lrm(folder, fault=""):
    (folder / "bin").mkdir()
    (folder / "bin" / "torchrun").write_text(TORCHRUN)
    (folder / "bin" / "torchrun").chmod(0o755)
    (folder / "main.py").write_text(LONG_LRM)
    (folder / "paper.yaml").write_text("data: {resize_h: 540, min_frame_dist: all}\n")
    (folder / "default.yaml").write_text("data: {square_crop: true}\n")
    files = [str(folder), *(str(folder / f"{name}.yaml") for name in ("paper", "default"))]
    return {
        "venv": str(folder),
        "prefix": ["env", f"PYTHON={sys.executable}", f"FAULT={fault}"],
        "render": [sys.executable, "{recipes}/long_lrm.py", "{folder}", *files, "weights.pt"],
    }


def test_long_lrm_is_given_the_picks_and_renders_the_targets(capture, tmp_path):
    images = reconstruct(capture, **long_lrm(tmp_path))
    assert images.shape == (2, SIZE[1], SIZE[0], 3)
    for image, center in zip(images, capture.centers[TARGETS], strict=True):
        np.testing.assert_allclose(image[9, 9] * 255, center * 20 + 128, atol=0.6)


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("scene", r"evaluated another scene: \['other'\] in the place of fsel_"),
        ("frames", r"used other frames: input_frame_idx is \[1, 2, 5\], given \[1, 2, 4\]"),
        ("scale", "used another scale"),
    ],
)
def test_what_the_loader_of_long_lrm_hides_is_found(capture, tmp_path, fault, said):
    with pytest.raises(Unfinished, match=said) as failure:
        reconstruct(capture, **long_lrm(tmp_path, fault))
    assert failure.value.outcome == "failed"


def test_anysplat_is_placed_by_the_selected_cameras(capture, tmp_path):
    turn, scale, shift = (
        Rotation.from_rotvec([1, -0.4, 0.2]).as_matrix(),
        0.2,
        np.array([3.0, 1, 2]),
    )
    c2w = invert_pose(capture.world_to_camera)
    own = np.tile(np.eye(4), (8, 1, 1))  # the stand-in's world
    own[:, :3, :3], own[:, :3, 3] = turn @ c2w[:, :, :3], scale * c2w[:, :, 3] @ turn.T + shift
    np.save(tmp_path / "poses.npy", own)
    for path, text in {"model/model/anysplat.py": ANYSPLAT, "utils/image.py": IMAGE}.items():
        (tmp_path / "src" / path).parent.mkdir(parents=True)
        (tmp_path / "src" / path).write_text(text)
    render = [sys.executable, "{recipes}/anysplat.py", "{folder}", str(tmp_path)]
    images = reconstruct(capture, render=[*render, str(tmp_path / "poses.npy")])
    np.testing.assert_allclose(images[:, 0, 0, 0], [51 / 255, 102 / 255], atol=1e-6)
    seen = np.load(tmp_path / "seen.npy")
    np.testing.assert_allclose(seen[:, :16].reshape(2, 4, 4), own[TARGETS], atol=1e-5)
    lens = [0.8, 0, 0.5, 0, 0.8 * 24 / 18, 0.5, 0, 0, 1]
    np.testing.assert_allclose(seen[:, 16:], [lens, lens], atol=1e-6)


@pytest.mark.skipif(
    not NERFBASELINES, reason="FSEL_NERFBASELINES names no virtual environment of nerfbaselines"
)
def test_nerfbaselines_trains_and_renders(capture):
    here = Path(__file__).parents[1]
    recipe = ["python", "{recipes}/nerfbaselines.py"]
    registered = [f"NERFBASELINES_REGISTER={here / 'nerfbaselines_spec.py'}", f"PYTHONPATH={here}"]
    images = reconstruct(
        capture,
        venv=NERFBASELINES,
        prefix=["env", *registered],
        fit=[*recipe, "fit", "{folder}", "--method", "fsel-mean", "--backend", "python"],
        render=[*recipe, "render", "{folder}", "--backend", "python"],
    )
    mean = np.asarray(capture.images, np.float64)[[0, 3, 5]].mean(axis=(0, 1, 2)) / 255
    np.testing.assert_allclose(images[:, 9, 9], [mean, mean], atol=1 / 255)
    # the method wrote the camera into the first pixels
    np.testing.assert_allclose(images[:, 0, 0, 0] * 10 - 5, capture.centers[TARGETS, 1], atol=0.05)
    np.testing.assert_allclose(images[:, 0, 1, 0] * 100, capture.intrinsics[TARGETS, 0], atol=0.5)


def test_the_scene_for_nerfstudio_is_normalised_by_the_selected_cameras(capture, tmp_path):
    model = External(capture, render=["true"], workspace=str(tmp_path)).fit(FRAMES)
    recipes = Path(sys.modules["fsel.reconstruct.external"].__file__).parent / "recipes"
    (tmp_path / "ns-train").write_text("#!/bin/sh\nexit 0\n")
    (tmp_path / "ns-train").chmod(0o755)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    command = [sys.executable, str(recipes / "nerfstudio.py"), "fit", str(model.folder), "nerfacto"]
    subprocess.run(command, check=True, env={**os.environ, "PATH": path})
    data = model.folder / "nerfstudio" / "data"
    content = json.loads((data / "transforms.json").read_text())
    found = np.array([frame["transform_matrix"] for frame in content["frames"]])[:, :3, 3]
    centers = capture.centers[[0, 3, 5]]
    away = centers - centers.mean(axis=0)
    np.testing.assert_allclose(found, away / np.linalg.norm(away, axis=1).max(), atol=1e-12)
    assert content["test_filenames"] == [f"images/{row:06d}.png" for row in range(3)]


@pytest.mark.skipif(
    not NERFSTUDIO, reason="FSEL_NERFSTUDIO names no virtual environment of nerfstudio"
)
def test_nerfstudio_trains_and_renders_on_a_cpu(capture, tmp_path):
    """nerfacto for some steps on a scene of one colour; minutes."""
    images = np.full_like(np.asarray(capture.images), (230, 20, 130))
    # for a score that nobody asks for it loads AlexNet, and downloads it where it is not there
    weights = tmp_path / "hub" / "checkpoints" / "alexnet-owt-7be5be79.pth"
    weights.parent.mkdir(parents=True)
    subprocess.run([f"{NERFSTUDIO}/bin/python", "-c", ALEXNET, str(weights)], check=True)
    recipe = yaml.safe_load((RECIPES[0].parent / "nerfstudio.yaml").read_text())
    section = recipe["reconstruction"]["settings"] | {"venv": NERFSTUDIO, "gpu": False}
    section |= {"prefix": ["env", f"TORCH_HOME={tmp_path}"], "timeout": 900}
    section["fit"] = [*section["fit"], *ON_A_CPU, *SMALL]
    rendered = reconstruct(replace(capture, images=images), **section)
    assert rendered.shape == (2, SIZE[1], SIZE[0], 3)
    red, green, blue = rendered.mean(axis=(0, 1, 2))
    assert red > blue + 0.05 > green + 0.1


@pytest.mark.parametrize("path", RECIPES, ids=lambda path: path.stem)
def test_a_shipped_recipe_is_taken_as_it_is(path, tmp_path):
    section = yaml.safe_load(path.read_text())["reconstruction"]
    settings = ExternalSettings(**section["settings"])
    words = settings.command(settings.render, tmp_path)
    assert str(tmp_path) in words
    script = next(word for word in words if word.endswith(".py"))
    assert Path(script).is_file()
    assert Path(script).stem == path.stem
