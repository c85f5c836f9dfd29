"""Masks that features are kept to: of a folder, or by a program."""

import os
import re
import sys
from pathlib import Path

import cv2
import numpy as np
import pycolmap
import pytest
from small_captures import run

from fsel.captures.colmap import features, runs
from fsel.captures.colmap.estimator import program
from fsel.captures.colmap.runs import Work
from fsel.captures.images import files as image_files
from fsel.captures.layouts import bare
from fsel.captures.poses import sfm

RIGHT = np.uint8(255) * np.tile(np.arange(160) >= 80, (120, 1))
NAMES = [f"{i}.png" for i in range(3)]
ROOT = Path(__file__).resolve().parents[3]
REMBG = f"""#!{sys.executable}
import shutil, sys
from pathlib import Path
assert sys.argv[1:] == "p -om -m u2net_human_seg images masks".split(), sys.argv
for file in Path("images").iterdir():
    shutil.copy("../../people/0.png", Path("masks", file.stem + ".png"))
"""
MEDIAPIPE = """
import numpy as np
from types import SimpleNamespace as S
left = S(process=lambda image: S(segmentation_mask=1.0 * (np.indices(image.shape[:2])[1] < 76)))
solutions = S(pose=S(Pose=lambda **_: left))
"""
MOGRIFY = f"""#!{sys.executable}
import sys, cv2
assert sys.argv[1] == "-negate"
for name in sys.argv[2:]:
    cv2.imwrite(name, 255 - cv2.imread(name))
"""


@pytest.fixture
def photos(tmp_path, monkeypatch):
    noise = np.random.default_rng(0).integers(0, 255, (3, 15, 20, 3), np.uint8)
    large = [cv2.resize(image, (160, 120), interpolation=cv2.INTER_CUBIC) for image in noise]
    image_files.write(np.stack(large), tmp_path / "photos", NAMES)
    image_files.write(np.stack([RIGHT] * 3), tmp_path / "masks", NAMES)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FSEL_CACHE", str(tmp_path / "cache"))
    return tmp_path / "photos"


class Everywhere:
    """A network that finds a feature in each corner."""

    def find(self, image):
        return np.array([[1.0, 1], [158, 1], [1, 118], [158, 118]]), np.zeros((4, 8), np.float32)


def by_rembg(folder, monkeypatch):
    """The program of the recipe in the documentation; what it calls are stand-ins."""
    for name, script in (("rembg", REMBG), ("mogrify", MOGRIFY)):
        (folder / name).write_text(script)
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=os.pathsep)
    image_files.write(255 - RIGHT[None], folder / "people", NAMES[:1])
    text = " ".join((ROOT / "docs" / "cli.md").read_text().split())
    (line,) = re.findall(r'rembg.*?: `"(.*?)"`', text)
    return program((line,), "mask-by")


def by_example(folder, monkeypatch):
    """The program of the examples; the package that finds people is a stand-in."""
    (folder / "mediapipe.py").write_text(MEDIAPIPE)
    line = f"env PYTHONPATH={folder} {sys.executable} {ROOT}/examples/mask_people.py"
    return program((line,), "mask-by")


@pytest.mark.parametrize("kind", ["folder", "program", "example", "network"])
def test_features_are_kept_to_what_is_white(kind, photos, tmp_path, monkeypatch):
    monkeypatch.setattr(features, "network", Everywhere)
    work = Work(tmp_path / "work", features="aliked" if kind == "network" else "sift")
    work.folder.mkdir()
    raw, database = bare.read(photos), work.folder / sfm.DATABASE
    names = runs.linked(raw.images, work.folder / "images", work)
    by = {"program": by_rembg, "example": by_example}
    made = by[kind](tmp_path, monkeypatch) if kind in by else tmp_path / "masks"
    sfm._mask(raw, names, work.folder, made)
    runs.extract(database, work.folder / "images", names, work)
    with pycolmap.Database.open(str(database)) as stored:
        for image in stored.read_all_images():
            found = stored.read_keypoints(image.image_id)
            assert len(found) > 1
            assert found[:, 0].min() >= 79


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("poses photos --masks gone", "gone: no such folder of masks"),
        ("poses photos --masks few", "'2.png'"),
        ("poses photos --masks small", "0.png: the mask has 160x60 pixels, its image 160x120"),
        ("poses photos --masks few --by true", "not for --by"),
        ("poses photos --mask-by true --by true", "not for --by"),
        ("poses photos --mask-by false", "masks by false"),
        ("select few -k 2 --masks poses:few", "--masks poses:DIR is for poses"),
    ],
)
def test_masks_that_do_not_fit_are_refused(line, said, photos, tmp_path, capsys):
    image_files.write(np.stack([RIGHT] * 2), tmp_path / "few", NAMES[:2])
    image_files.write(np.stack([RIGHT[::2]] * 3), tmp_path / "small", NAMES)
    assert run(*line.split(), "-o", "out") == 1
    assert said in capsys.readouterr().err
