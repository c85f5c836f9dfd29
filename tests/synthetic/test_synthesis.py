"""Embedded captures: reproducible, clear of objects, and true to their own geometry."""

import importlib
from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from fsel.captures.colmap.camera import Camera
from fsel.captures.layouts.contract import SUBJECT
from fsel.core.geometry import camera_centers
from fsel.synthetic import FAMILIES, record, trajectories
from fsel.synthetic.families import FAMILY
from fsel.synthetic.record import clear_shot, film, motion, project, unproject
from fsel.synthetic.trajectories import Habits, Shot

SUBJECTS = ("scannet", "co3d")
WHERE = {
    "dl3dv": 4.375960,
    "tanks_and_temples": 69.984872,
    "mipnerf360": 46.261358,
    "scannet_iphone": 38.367116,
    "scannetpp": 36.952484,
    "seven_scenes": 30.310932,
    "scannet": 47.764777,
    "co3d": 31.538205,
}
"""Sum of 24 camera centres of seed 7, metres: every table is made of these paths."""


@pytest.fixture(scope="module", params=FAMILIES)
def recording(request):
    return request.param, record(request.param, 3, frames=24, width=64, height=48)


def test_equal_seeds_give_equal_bytes_and_others_differ():
    first, second, other = (
        record("scannetpp", seed, frames=12, width=32, height=24) for seed in (1, 1, 2)
    )
    for field in ("images", "depth", "world_to_camera", "xyz", "track_xy"):
        np.testing.assert_array_equal(getattr(first, field), getattr(second, field))
    assert (first.images != other.images).mean() > 0.5


@pytest.mark.parametrize("family", FAMILIES)
def test_families_film_what_they_always_filmed(family):
    shot, _, _ = clear_shot(family, 7, 24)
    total = camera_centers(shot.poses(np.zeros(24))).sum()
    assert total == pytest.approx(WHERE[family], abs=1e-5)


@pytest.mark.parametrize(("seed", "outward"), [(7, True), (8, False)])
def test_some_rooms_are_filmed_towards_their_walls(seed, outward):
    shot, _, _ = clear_shot("scannet_iphone", seed, 24)
    poses = shot.poses(np.zeros(24))
    across = np.einsum("ni,ni->n", poses[:, 2, :2], camera_centers(poses)[:, :2])
    assert ((across > 0).mean() > 0.8) == outward


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", [0, 1])
def test_cameras_are_never_inside_or_against_an_object(family, seed):
    """Rays in 300 directions of our own: none is short, none first meets a back face."""
    shot, caster, _ = clear_shot(family, seed, 160)
    poses = shot.poses(np.zeros(160))
    centers = -np.einsum("nij,ni->nj", poses[:, :, :3], poses[:, :, 3])
    rays = np.random.default_rng(5).normal(size=(300, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    origins = np.repeat(centers, len(rays), axis=0).astype(np.float32)
    rays = np.tile(rays, (len(centers), 1)).astype(np.float32)
    which, distance = caster.hit(origins, rays)
    met = which >= 0
    assert distance[met].min() > 0.85 * FAMILY[family].clearance
    a, b, c = caster.scene.finish()[0].transpose(1, 0, 2)
    outwards = np.cross(b - a, c - a)[which[met]]
    assert (np.einsum("ni,ni->n", outwards, rays[met]) < 0).all()


@pytest.mark.parametrize("side", [0.3, 30.0])
def test_a_path_against_or_inside_an_object_is_refused(monkeypatch, side):
    """A pillar on the way round the table; a solid as large as the place with the camera in it."""
    setting = FAMILY["scannet_iphone"]

    def blocked(rng):
        scene = setting.scene(rng)
        if side > 1:
            scene.meshes.clear()
        where = (1.9, 0, 0) if side < 1 else (0, 0, -side / 2)
        scene.box((side, side, max(2.5, side)), where, scene.materials[0])
        return scene

    # the package's function of the same name hides the module
    monkeypatch.setattr(importlib.import_module("fsel.synthetic.record"), "ATTEMPTS", 3)
    monkeypatch.setitem(FAMILY, "scannet_iphone", replace(setting, scene=blocked))
    with pytest.raises(RuntimeError, match="scannet_iphone"):
        clear_shot("scannet_iphone", 0, 60)


@pytest.mark.parametrize("family", SUBJECTS)
@pytest.mark.parametrize("seed", range(2))
def test_the_cameras_see_the_object(family, seed):
    """Enough frames show it for fifteen targets and their like, and it never fills the image."""
    made = record(family, seed, frames=60, width=64, height=48)
    share = made.masks[:, 3:-3, 3:-3].mean(axis=(1, 2))
    assert (share >= 0.02).sum() >= 15
    assert np.median(share[share >= 0.02]) > 0.03
    assert share.max() < 0.9


def first_met(triangles, origin, ray):
    """Number of the triangle that a ray meets first (Moeller and Trumbore 1997), over them all."""
    a, b, c = triangles
    across = np.cross(ray, c - a)
    volume = np.einsum("ni,ni->n", b - a, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.einsum("ni,ni->n", origin - a, across) / volume
        side = np.cross(origin - a, b - a)
        v, distance = side @ ray / volume, np.einsum("ni,ni->n", c - a, side) / volume
        met = (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0)
    return np.where(met, distance, np.inf).argmin() if met.any() else None


@pytest.mark.parametrize("family", SUBJECTS)
def test_a_pixel_has_the_number_of_the_object_that_its_ray_meets(family):
    shot, caster, _ = clear_shot(family, 1, 24)
    made = record(family, 1, frames=24, width=64, height=48)
    meshes = caster.scene.meshes
    owner = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])
    corners = np.concatenate([mesh.triangles for mesh in meshes]).transpose(1, 0, 2)
    frame = int(made.masks.sum(axis=(1, 2)).argmax())
    pose = shot.poses(np.zeros(24))[frame]
    rays = unproject(made.camera).reshape(48, 64, 3) @ pose[:, :3]
    number_of = {mesh: n for n, group in caster.scene.objects.items() for mesh in group}
    numbers = []
    for row, column in product(range(1, 48, 8), range(1, 64, 8)):
        met = first_met(corners, -pose[:, :3].T @ pose[:, 3], rays[row, column])
        number = 0 if met is None else number_of.get(owner[met], 0)
        assert made.objects[frame, row, column] == number
        numbers.append(number)
    assert numbers.count(SUBJECT) > 3
    assert len(set(numbers)) > (2 if family == "scannet" else 1)


def test_tracks_agree_with_poses_lens_and_depth(recording):
    """Every observation lies within a pixel of its point, and nothing stands before the point."""
    made = recording[1]
    pose = made.world_to_camera[made.track_frame]
    local = np.einsum("lij,lj->li", pose[:, :, :3], made.xyz[made.track_point]) + pose[:, :, 3]
    xy = project(made.camera, local)
    error = np.linalg.norm(xy - made.track_xy, axis=1)
    assert error.max() < 1
    assert 0.2 < np.median(error) < 0.5
    column, row = np.clip(xy, 0, [63.9, 47.9]).astype(int).T
    z = made.depth[made.track_frame, row, column]
    assert (np.abs(z / local[:, 2] - 1) < 0.021).all()
    assert np.bincount(made.track_point).min() >= 3


def test_motion_counts_translation_by_depth_and_rotation_alike():
    camera = Camera("PINHOLE", 64, 48, (50.0, 50.0, 32.0, 24.0))
    rays = unproject(camera)
    still = np.tile(np.eye(3, 4), (3, 1, 1))
    begin, end = still.copy(), still.copy()
    begin[0, 0, 3], end[0, 0, 3] = -0.05, 0.05  # 0.1 to the side
    turn = cv2.Rodrigues(np.array([0, 0, 0.02]))[0]  # about the axis: none in the middle
    end[2, :, :3] = turn
    depth = np.full((3, 48, 64), 2.0)
    moved = motion(begin, still, end, depth, camera, rays)
    assert moved[0] == pytest.approx(50 * 0.1 / 2)
    assert moved[1] == pytest.approx(0, abs=1e-9)
    assert 0.02 * 25 < moved[2] < 0.02 * np.hypot(32, 24)
    near = np.where(np.arange(48)[:, None] < 24, 2.0, 0.5) * np.ones((1, 48, 64))
    assert motion(begin[:1], still[:1], end[:1], near, camera, rays) == pytest.approx(10)


@pytest.mark.parametrize("family", FAMILIES)
def test_shake_comes_in_bursts_where_the_camera_does_not_linger(family):
    shot, _, _ = clear_shot(family, 1, 160)
    shaken = np.linalg.norm(np.concatenate([p[2] for p in shot.passes]), axis=1)
    hit = shaken > 0.4 * shot.habits.strength
    assert 4 <= hit.sum() <= 60
    steps = np.concatenate([np.gradient(p[1]) * len(p[1]) for p in shot.passes])
    assert (steps < 0.15).sum() >= 4
    assert not (hit & (steps < 0.05)).any()


def _panned(pixels: float) -> tuple[np.ndarray, int]:
    """A frame's middle row, as the camera pans over a bright bar; and the rays a pixel."""
    camera = Camera("PINHOLE", 64, 48, (50.0, 50.0, 32.0, 24.0))
    still = trajectories.Path(
        position=lambda s: np.zeros((len(s), 3)),
        look=lambda s: np.tile([0.0, 1.0, 0.0], (len(s), 1)),
        roll=lambda s: np.zeros(len(s)),
    )
    pan = np.tile([0, pixels / 50, 0], (2, 1))
    shot = Shot(
        names=("a", "b"),
        sequences=("capture",) * 2,
        passes=((still, np.array([0.0, 1.0]), pan),),
        camera=lambda w, h: camera,
        habits=Habits(lingers=0, blurs=0, strength=0, drift=0, noise=0),
        exposure=np.ones(2),
        bad=np.zeros(2, bool),
        lost=np.zeros(2, bool),
    )
    counts = []

    def colors(origins, rays):
        counts.append(len(rays))
        bar = np.abs(rays[:, 0] / rays[:, 1]) < 0.75 / 50  # a pixel and a half wide
        return np.repeat(bar[:, None], 3, axis=1).astype(np.float32)

    depth = np.full((2, 48, 64), 5.0)
    rng = np.random.default_rng(0)
    images = film(SimpleNamespace(colors=colors), shot, unproject(camera), depth, camera, rng)
    return images[0, 24, :, 0] / 255.0, len(counts) // 2


@pytest.mark.parametrize("pixels", [5, 10, 15])
def test_a_pan_smears_without_ghosts(pixels):
    """The bar covers the whole way that it moves, with no gap between separate copies of it."""
    row, rays = _panned(pixels)
    middle = slice(32 - pixels // 2 + 1, 32 + pixels // 2 - 1)
    assert row[middle].min() > 0.5 * row.max()
    assert row[: 32 - pixels // 2 - 3].max() == 0
    assert row[32 + pixels // 2 + 3 :].max() == 0
    assert rays > pixels


def test_a_still_camera_does_not_smear():
    row, rays = _panned(0)
    assert (row > 0).sum() <= 4
    assert rays == 3


def test_shaken_frames_are_less_sharp():
    made = record("scannetpp", 5, frames=60)
    assert 1 <= made.bad.sum() < 30
    sharp = [
        cv2.Laplacian(cv2.cvtColor(i, cv2.COLOR_RGB2GRAY), cv2.CV_64F).var() for i in made.images
    ]
    sharp = np.array(sharp)
    assert np.median(sharp[made.bad]) < 0.7 * np.median(sharp[~made.bad])


def test_several_passes_of_one_room():
    made = record("seven_scenes", 0, frames=40, width=32, height=24)
    assert sorted(set(made.sequences)) == ["seq-01", "seq-02", "seq-03", "seq-04"]
    assert made.names[0] == "seq-01/frame-000000"


def test_lens_round_trip(recording):
    camera = recording[1].camera
    rays = unproject(camera)
    x, y = np.meshgrid(np.arange(64) + 0.5, np.arange(48) + 0.5)
    expected = np.stack([x.ravel(), y.ravel()], axis=1)
    np.testing.assert_allclose(project(camera, rays * 3), expected, atol=1e-6)


@pytest.mark.parametrize(("family", "frames"), [("kitti", 24), ("dl3dv", 3)])
def test_impossible_requests_are_refused(family, frames):
    with pytest.raises(ValueError, match=r"kitti|3"):
        record(family, 0, frames=frames)
