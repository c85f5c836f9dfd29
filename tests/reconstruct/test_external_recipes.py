"""The recipes for published programs, with stand-ins that honour the same files."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import torch
import yaml
from plyfile import PlyData
from selection_problems import around, numbered, pointed
from small_captures import ring

from fsel.core.geometry import invert_pose
from fsel.core.programs import Unfinished
from fsel.reconstruct.external import External, ExternalSettings
from fsel.reconstruct.external.worker import close_all

SIZE = (24, 18)
FRAMES, TARGETS = np.array([5, 0, 3]), np.array([1, 6])
RECIPES = sorted((Path(__file__).parents[2] / "config" / "reconstructors").glob("*.yaml"))

# Long-LRM's model/llrm.py as far as shapes and calls go; what it was given is kept
LLRM = """
import numpy as np, torch

class LongLRM(torch.nn.Module):
    def __init__(self, config, device):
        super().__init__()
        assert config.training.perceptual_loss == 0 and config.model.merge_layers == [8]
        self.scale = torch.nn.Parameter(torch.zeros(1))

    def forward(self, data):
        images = data["input_images"]
        assert images.shape[0] == 1 and images.shape[2] == 3
        assert images.shape[3] % 16 == images.shape[4] % 16 == 0
        np.savez("inputs.npz", images=images[0], lenses=data["input_intr"][0],
                 poses=data["input_c2ws"][0])
        xyz = images.mean() * self.scale + torch.rand(1)
        names = ("xyz", "feature", "scale", "rotation", "opacity")
        return {"gaussians": {name: xyz[None] for name in names}}

class GaussianRenderer:
    @staticmethod
    def render(xyz, feature, scale, rotation, opacity, c2w, lens, width, height, degree, near, far):
        assert (degree, near) == (3, 0.01) and xyz.shape == (1,)
        with open("targets.txt", "a") as file:
            print(*c2w.flatten().tolist(), *lens.tolist(), file=file)
        return torch.full((1, height, width, 3), float(xyz))
"""

EASYDICT = """
class EasyDict(dict):
    def __init__(self, given):
        super().__init__({k: EasyDict(v) if isinstance(v, dict) else v for k, v in given.items()})
        self.__dict__ = self
"""


@pytest.fixture
def capture():
    return numbered(around(ring(8), size=SIZE))


@pytest.fixture(autouse=True)
def ended():
    yield
    close_all()


def reconstruct(capture, **settings):
    return External(capture, **settings).fit(FRAMES).render(capture.view(TARGETS))


def long_lrm(folder, weights=None):
    (folder / "model").mkdir()
    (folder / "model" / "llrm.py").write_text(LLRM)
    (folder / "easydict.py").write_text(EASYDICT)
    (folder / "paper.yaml").write_text("{data: {resize_h: 31}, model: {gaussians: {far: 9}}}")
    (folder / "default.yaml").write_text(
        """
model: {patch_size: 8, merge_layers: [8], gaussians: {sh_degree: 3, near_plane: 0.01, far_plane: 1}}
training: {perceptual_loss: 1.0}
data: {}
use_amp: false
amp_dtype: bf16
"""
    )
    torch.save({"model": {"scale": torch.ones(1)} if weights is None else weights}, folder / "w.pt")
    files = [str(folder / name) for name in ("", "paper.yaml", "default.yaml", "w.pt")]
    return {"serve": [sys.executable, "{recipes}/long_lrm.py", *files], "timeout": 600}


def test_long_lrm_is_given_the_picks_as_its_loader_makes_them(capture, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = long_lrm(tmp_path)
    images = reconstruct(capture, **settings)
    given = np.load(tmp_path / "inputs.npz")
    order = [0, 3, 5]
    # 31 rows are 41 columns of 24x18, and in whole patches of 16: 32 rows, 48 columns
    assert given["images"].shape == (3, 3, 32, 48)
    for image, frame in zip(given["images"], np.asarray(capture.images)[order], strict=True):
        np.testing.assert_allclose(
            image.mean(axis=(1, 2)), frame.mean(axis=(0, 1)) / 255, atol=0.02
        )
    np.testing.assert_allclose(
        given["lenses"], capture.intrinsics[order] * np.tile([2, 32 / 18], 2)
    )
    poses = given["poses"].astype(np.float64)
    assert np.abs(poses[:, :3, 3]).max() == pytest.approx(1)
    np.testing.assert_allclose(poses[:, :3, 3].mean(axis=0), 0, atol=1e-6)
    # targets stand to the picks as in the capture, in its unit
    own = invert_pose(capture.world_to_camera)
    unit = np.linalg.norm(own[3, :, 3] - own[0, :, 3]) / np.linalg.norm(
        poses[1, :3, 3] - poses[0, :3, 3]
    )
    targets = np.loadtxt(tmp_path / "targets.txt")
    for row, frame in zip(targets, TARGETS, strict=True):
        found = np.linalg.inv(poses[0]) @ row[:16].reshape(4, 4)
        wanted = np.linalg.inv(np.vstack([own[0], [0, 0, 0, 1]])) @ np.vstack(
            [own[frame], [0, 0, 0, 1]]
        )
        found[:3, 3] *= unit
        np.testing.assert_allclose(found, wanted, atol=1e-5)
    assert images.shape == (2, SIZE[1], SIZE[0], 3)
    # chance begins anew with every fit
    np.testing.assert_array_equal(reconstruct(capture, **settings), images)


def test_long_lrm_without_all_weights_is_told(capture, tmp_path):
    with pytest.raises(Unfinished, match=r"lacks 1 of the model's weights, such as scale"):
        reconstruct(capture, **long_lrm(tmp_path, weights={}))


# gsplat's examples/simple_trainer.py as far as fields and calls go; a pixel is a camera's height
TRAINER = """
import os
from types import SimpleNamespace
import numpy as np, torch

class Config:
    def __init__(self, data_dir, strategy, **fields):
        self.__dict__ |= fields | {"data_dir": data_dir, "strategy": strategy, "sh_degree": 3}
        assert self.max_steps == 7 and type(strategy).__name__ == "MCMCStrategy"
        assert fields["opacity_reg"] == fields["scale_reg"] == 0.01  # as its subcommand mcmc

class Runner:
    device = "until it was closed"

    def __init__(self, local_rank, rank, size, cfg):
        assert os.path.isfile(os.path.join(cfg.data_dir, "sparse", "0", "images.bin"))
        transform = np.diag([2.0, 2, 2, 1])
        transform[:3, 3] = 1, 2, 3
        self.cfg, self.parser = cfg, SimpleNamespace(transform=transform)
        self.trainset = SimpleNamespace(indices=np.arange(1, 3))
        self.writer = SimpleNamespace(close=lambda: setattr(self, "device", "cpu"))

    def train(self):
        self.splats = {"means": torch.zeros(len(self.trainset.indices), 3)}

    def rasterize_splats(self, camtoworlds, Ks, width, height, sh_degree):
        assert torch.allclose(torch.linalg.det(camtoworlds), torch.ones(1), atol=1e-5)
        values = torch.tensor([camtoworlds[0, 1, 3] / 8, Ks[0, 0, 0] / 100, Ks[0, 1, 2] / 100])
        return values.expand(1, height, width, 3), None, None
"""


def test_the_trainer_of_gsplat_is_given_all_picks_and_the_targets_follow_its_world(
    capture, tmp_path
):
    (tmp_path / "simple_trainer.py").write_text(TRAINER)
    serve = [sys.executable, "{recipes}/gsplat.py", str(tmp_path), "mcmc", "max_steps=7"]
    model = External(capture, serve=serve).fit(FRAMES)
    assert model.primitives == 3  # none is held out
    images = model.render(capture.view(TARGETS))
    lens = capture.intrinsics[TARGETS]
    heights = np.clip((2 * capture.centers[TARGETS, 1] + 2) / 8, 0, 1)
    wanted = np.stack([heights, lens[:, 0] / 100, lens[:, 3] / 100], axis=1)
    np.testing.assert_allclose(images[:, 5, 5], wanted, atol=1e-6)


# fits by writing the scene that Nerfstudio would train on
SCENE = """
import sys, types
sys.path.insert(0, {recipes!r})
sys.modules["torch"] = types.SimpleNamespace(no_grad=lambda: lambda render: render)
import nerfstudio
from fsel_worker import camera_to_world, middle_and_unit, serve

def fit(subset):
    world = middle_and_unit(camera_to_world(subset.world_to_camera)[:, :3, 3])
    assert "--auto-scale-poses" in nerfstudio.arguments("data", ["nerfacto", "--steps", "5"])
    return nerfstudio.write_scene(subset, *world)

serve(fit, None, needs=["points", "files"])
"""


def test_nerfstudio_is_given_the_picks_in_a_world_that_no_target_decides(capture):
    text = SCENE.format(recipes=str(ExternalSettings.recipes))
    model = External(pointed(capture), serve=[sys.executable, "-c", text]).fit(FRAMES)
    centers = capture.centers[[0, 3, 5]]
    middle = centers.mean(axis=0)
    unit = np.linalg.norm(centers - middle, axis=1).max()
    data = model.arrays.folder / "nerfstudio"
    content = json.loads((data / "transforms.json").read_text())
    placed = np.array([frame["transform_matrix"] for frame in content["frames"]])[:, :3, 3]
    np.testing.assert_allclose(placed, (centers - middle) / unit, atol=1e-12)
    assert content["test_filenames"] == [f"images/{row:06d}.png" for row in range(3)]
    assert (data / content["test_filenames"][0]).is_file()
    points = PlyData.read(data / content["ply_file_path"])["vertex"]
    assert points["red"].dtype == np.uint8
    found = np.stack([points[axis] for axis in "xyz"], axis=1) * unit + middle
    np.testing.assert_allclose(found, pointed(capture).points.xyz[[0, 3]], atol=1e-5)


@pytest.mark.parametrize("path", RECIPES, ids=lambda path: path.stem)
def test_a_shipped_recipe_is_taken_as_it_is(path, tmp_path):
    section = yaml.safe_load(path.read_text())["reconstruction"]
    settings = ExternalSettings(**section["settings"])
    words = settings.command(settings.serve, tmp_path)
    script = next(word for word in words if word.endswith(".py"))
    assert Path(script).is_file()
    assert Path(script).stem == path.stem
