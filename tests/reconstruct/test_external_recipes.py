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

# runs a script with one folder more to import from
FOUND = """
import runpy, sys
sys.path.append({here!r})
sys.argv = sys.argv[1:]
sys.path.insert(0, "")
runpy.run_path(sys.argv[0], run_name="__main__")
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
    return {"serve": [sys.executable, "{recipes}/long_lrm.py", *files], "timeout": 120}


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
    close_all()  # chance begins anew with every fit
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


# ffgs as far as calls go: a pixel is where a camera stands
FFGS = """
from types import SimpleNamespace
import torch

class Cameras:
    def __init__(self, poses, lenses, size):
        self.c2w, self.intrinsics, self.size = poses[None], lenses[None], size

class Views:
    def __init__(self, images, intrinsics, c2w):
        assert images.dtype == torch.uint8 and images.shape[1] == 3
        assert intrinsics.shape == (len(images), 3, 3) and c2w.shape == (len(images), 4, 4)
        self.c2w = c2w

class GSPipeline:
    processor = SimpleNamespace(config=SimpleNamespace(camera_spread=0.5), camera_input="given")

    @classmethod
    def from_pretrained(cls, folder, device, local_files_only):
        assert local_files_only
        return cls()

    def __call__(self, views):
        gaussians = SimpleNamespace(num_gaussians=len(views.c2w))
        return SimpleNamespace(to_world=lambda: SimpleNamespace(gaussians=gaussians))

    def render(self, output, cameras):
        places = cameras.c2w[0, :, :3, 3] / 8 + 0.5
        return {"images": [places[:, :, None, None].expand(-1, -1, *cameras.size)]}
"""


def test_a_model_of_ffgs_is_given_the_selected_cameras_in_its_unit(capture, tmp_path):
    (tmp_path / "ffgs.py").write_text(FFGS)
    serve = [sys.executable, "-c", FOUND.format(here=str(tmp_path)), "{recipes}/ffgs.py"]
    model = External(capture, serve=[*serve, str(tmp_path)]).fit(FRAMES)
    assert model.primitives == 3
    images = model.render(capture.view(TARGETS))
    centers = capture.centers[[0, 3, 5]]
    unit = np.linalg.norm(centers[1:] - centers[0], axis=1).mean() / 0.5
    wanted = np.clip((capture.centers[TARGETS] - centers.mean(axis=0)) / unit / 8 + 0.5, 0, 1)
    assert images.shape == (2, SIZE[1], SIZE[0], 3)
    np.testing.assert_allclose(images[:, 5, 5], wanted, atol=1e-6)


# Nerfstudio and tyro as far as the worker calls them: a pixel is where the camera stands
NERFSTUDIO_FILES = {
    "tyro.py": """
import json
from pathlib import Path
from types import SimpleNamespace
from nerfstudio.utils.writer import EVENT_WRITERS

ended = []

def cli(union, args):
    assert union == "union" and args[0] == "nerfacto" and "nerfstudio-data" in args
    options = dict(zip(args[1:-7:2], args[2:-7:2]))
    scene = json.loads((Path(options["--data"]) / "transforms.json").read_text())
    assert len(scene["frames"]) == 3 and options["--steps"] == "5"
    model = SimpleNamespace(device="cpu", get_outputs_for_camera=lambda camera: camera.seen)
    model.eval = lambda: model
    loading = SimpleNamespace(terminate=lambda: ended.append("loading"), join=int)
    writing = SimpleNamespace(close=lambda: ended.append("writing"))
    def train():
        assert len(ended) % 2 == len(EVENT_WRITERS) == 0
        EVENT_WRITERS.append(SimpleNamespace(tb_writer=writing))
    pipeline = SimpleNamespace(model=model, datamanager=SimpleNamespace(data_procs=[loading]))
    trainer = SimpleNamespace(setup=int, train=train, pipeline=pipeline)
    manager = SimpleNamespace(datamanager=SimpleNamespace(data=None))
    return SimpleNamespace(set_timestamp=int, data=options["--data"], pipeline=manager,
                           machine=SimpleNamespace(seed=42), setup=lambda **ranks: trainer)
""",
    "nerfstudio/cameras/cameras.py": """
from types import SimpleNamespace

CameraType = SimpleNamespace(PERSPECTIVE=1)

class Cameras:
    def __init__(self, poses, fx, fy, cx, cy, width, height, camera_type):
        assert poses.shape == (1, 3, 4) and fx.shape == (1,) and camera_type == 1
        self.seen = {"rgb": (poses[0, :, 3] / 4 + 0.5).expand(height, width, 3)}

    def to(self, device):
        return self
""",
    "nerfstudio/configs/method_configs.py": "AnnotatedBaseConfigUnion = 'union'",
    "nerfstudio/utils/writer.py": "EVENT_WRITERS = []",
    "nerfstudio/scripts/train.py": "def _set_random_seed(seed): assert seed == 42",
}


def test_nerfstudio_in_a_worker_trains_and_renders_in_the_normalised_world(capture, tmp_path):
    for name, text in NERFSTUDIO_FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    serve = [sys.executable, "-c", FOUND.format(here=str(tmp_path)), "{recipes}/nerfstudio.py"]
    reconstructor = External(pointed(capture), serve=[*serve, "nerfacto", "--steps", "5"])
    reconstructor.fit(FRAMES)
    model = reconstructor.fit(FRAMES)  # nothing of the first is there
    images = model.render(capture.view(TARGETS))
    centers = capture.centers[[0, 3, 5]]
    middle = centers.mean(axis=0)
    unit = np.linalg.norm(centers - middle, axis=1).max()
    wanted = np.clip((capture.centers[TARGETS] - middle) / unit / 4 + 0.5, 0, 1)
    np.testing.assert_allclose(images[:, 5, 5], wanted, atol=1e-6)
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
