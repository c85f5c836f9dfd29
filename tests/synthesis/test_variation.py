"""Varied families: what differs from shot to shot, what stays, and that layouts hold it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from fsel.geometry import camera_centers
from fsel.layouts import LAYOUTS, read_raw
from fsel.synthesis import FAMILIES, record
from fsel.synthesis.families import FAMILY
from fsel.synthesis.lens import unproject
from fsel.synthesis.record import clear_shot

CONFIG = Path(__file__).parents[2] / "config" / "labels_large.yaml"
VARIED = [family for family in FAMILIES if family.endswith("_varied")]
WHERE = {
    "dl3dv": 4.375960,
    "tanks_and_temples": 69.984872,
    "mipnerf360": 46.261358,
    "scannet_iphone": 25.694969,
    "scannetpp": 34.039997,
    "seven_scenes": 30.310932,
    "scannet": 47.764777,
    "co3d": 31.538205,
}
"""Sum of 24 camera centres of seed 7, metres, as it was before there were varied families."""


def shots(family, count=24):
    return [FAMILY[family].shot(np.random.default_rng(seed), 160) for seed in range(count)]


def back(shot):
    """Most radians about the origin that a shot's camera goes back."""
    x, y, _ = camera_centers(shot.poses(np.zeros(160))).T
    angle = np.unwrap(np.arctan2(y, x))
    angle *= np.sign(angle[-1] - angle[0])
    return (np.maximum.accumulate(angle) - angle).max()


@pytest.mark.parametrize("family", WHERE)
def test_usual_families_film_what_they_always_filmed(family):
    shot, _, _ = clear_shot(family, 7, 24)
    total = camera_centers(shot.poses(np.zeros(24))).sum()
    assert total == pytest.approx(WHERE[family], abs=1e-5)


@pytest.mark.parametrize("family", VARIED)
def test_lens_sensor_and_lingering_differ_from_shot_to_shot(family):
    made = shots(family)
    usual = FAMILY[family.removesuffix("_varied")].shot(np.random.default_rng(0), 160)
    focal = np.array([shot.camera(128, 96).params[0] for shot in made])
    assert focal.max() > 1.2 * focal.min()
    assert {shot.camera(128, 96).model for shot in made} == {usual.camera(128, 96).model}
    noise = np.array([shot.habits.noise for shot in made])
    drift = np.array([np.ptp(np.log(shot.exposure)) for shot in made])
    assert noise.max() > 4 * noise.min()
    assert drift.max() > 6 * drift.min()
    steps = [np.concatenate([np.gradient(s) * len(s) for _, s, _ in shot.passes]) for shot in made]
    still = np.array([(step < 0.15).sum() for step in steps])
    assert still.min() <= 15
    assert still.max() >= 50


def test_some_cameras_walk_back_and_on_again():
    found = np.array([back(shot) for shot in shots("tanks_and_temples_varied")])
    assert 4 <= (found > 0.5).sum() <= 16
    assert max(back(shot) for shot in shots("tanks_and_temples")) < 0.2


def test_a_varied_fisheye_stays_below_ninety_degrees():
    for shot in shots("scannetpp_varied"):
        assert np.linalg.norm(unproject(shot.camera(32, 24))[:, :2], axis=1).max() < 6


def test_clutter_stands_where_cameras_look(monkeypatch):
    """It hides a part of what they would see without it, and is not all that they see."""
    family = "mipnerf360_varied"
    shot, caster, _ = clear_shot(family, 0, 60)
    monkeypatch.setitem(FAMILY, family, replace(FAMILY[family], clutter=None))
    same, bare, _ = clear_shot(family, 0, 60)
    poses = shot.poses(np.zeros(60))
    np.testing.assert_array_equal(poses, same.poses(np.zeros(60)))
    rays = unproject(shot.camera(16, 12))
    rays = (rays @ poses[:, :, :3]).reshape(-1, 3)
    rays = (rays / np.linalg.norm(rays, axis=1, keepdims=True)).astype(np.float32)
    origins = np.repeat(camera_centers(poses), 16 * 12, axis=0).astype(np.float32)
    near, far = (np.nan_to_num(c.hit(origins, rays)[1], posinf=1e4) for c in (caster, bare))
    assert (near <= far + 1e-3).all()
    assert 0.03 < (near < 0.99 * far).mean() < 0.5


@pytest.mark.parametrize("family", VARIED)
def test_the_layout_of_the_labels_holds_poses_and_lens(family, tmp_path):
    layout = yaml.safe_load(CONFIG.read_text())["datasets"][family]["layout"]
    made = record(family, 1, frames=24, width=32, height=24)
    LAYOUTS[layout].write(made, tmp_path)
    raw = read_raw(tmp_path, layout)[1]
    stems = [Path(name).with_suffix("").as_posix() for name in raw.names]
    rows = [made.names.index(stem) for stem in stems]
    assert len(rows) >= 16
    np.testing.assert_allclose(raw.world_to_camera, made.world_to_camera[rows], atol=1e-9)
    for camera in raw.cameras:
        scale = camera.width / made.camera.width
        assert camera.model == made.camera.model
        np.testing.assert_allclose(np.array(camera.params[:4]) / scale, made.camera.params[:4])
        np.testing.assert_allclose(camera.params[4:], made.camera.params[4:], atol=1e-9)
