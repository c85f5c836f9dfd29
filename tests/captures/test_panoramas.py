"""360-degree panoramas: cut into views once they are placed, and picked whole or by view."""

import numpy as np
import pycolmap
import pytest
from small_captures import record_of, run, select, write_video

from fsel.captures.colmap.mapping import Mapped
from fsel.captures.colmap.model import build_model
from fsel.captures.images import files as image_files
from fsel.captures.poses import sfm
from fsel.captures.poses.panoramas import VIEWS
from fsel.core.capture import Capture
from fsel.core.geometry import pixel_rays
from fsel.selection.panoramas import panorama_of
from fsel.synthetic import rooms
from fsel.synthetic.caster import Caster

WIDTH, HEIGHT, COUNT, SIDE = 256, 128, 6, 64
LEVEL = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])  # looks along y of a world with z up


def poses():
    """Level cameras on a bow through the room, a little turned to each other."""
    turns = 0.2 * np.arange(COUNT)
    rotations = [
        LEVEL @ [[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]] for a in turns
    ]
    centers = np.stack([np.sin(turns), 0.5 * np.cos(turns), np.full(COUNT, 1.5)], axis=1)
    return np.array([np.c_[r, -r @ c] for r, c in zip(rotations, centers, strict=True)])


def seen(caster, pose, rays, size):
    """(h, w, 3) levels that a camera sees along (n, 3) rays, and the (n, 3) places."""
    directions = (rays / np.linalg.norm(rays, axis=1)[:, None] @ pose[:, :3]).astype(np.float32)
    center = -pose[:, :3].T @ pose[:, 3]
    origins = np.tile(center.astype(np.float32), (len(rays), 1))
    levels = np.clip(caster.colors(origins, directions), 0, 1) * 255
    places = center + directions * caster.hit(origins, directions)[1][:, None]
    return levels.reshape(size[1], size[0], 3).astype(np.uint8), places


@pytest.fixture(scope="module")
def world():
    """The scene, panoramas of it, and their model with points in three of their directions."""
    caster = Caster(rooms.living_room(np.random.default_rng(3), 6, 5))
    sphere = pycolmap.Camera(
        model="EQUIRECTANGULAR", width=WIDTH, height=HEIGHT, params=[WIDTH, HEIGHT]
    )
    v, u = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    rays = np.asarray(sphere.cam_ray_from_img(np.stack([u.ravel(), v.ravel()], axis=1)))
    images, places = zip(
        *(seen(caster, pose, rays, (WIDTH, HEIGHT)) for pose in poses()), strict=True
    )
    xyz = places[0][100::977]
    pixels = [np.asarray(sphere.img_from_cam(xyz @ p[:, :3].T + p[:, 3])) for p in poses()]
    names = [f"{i}.png" for i in range(COUNT)]
    every = [np.arange(len(xyz))] * COUNT
    model = build_model(
        names, [sphere] * COUNT, poses(), xyz, np.zeros((len(xyz), 3), np.uint8), every, pixels
    )
    return caster, np.stack(images), model


@pytest.fixture
def placed(world, tmp_path, monkeypatch):
    """A folder of panoramas, whose poses are known to what places them."""
    monkeypatch.setenv("FSEL_CACHE", str(tmp_path / "cache"))

    def place(raw, work, start):
        work.folder.mkdir(exist_ok=True)
        return Mapped(pycolmap.Reconstruction(world[2]))

    monkeypatch.setattr(sfm, "place", place)
    monkeypatch.chdir(tmp_path)
    image_files.write(world[1], tmp_path / "around", [f"{i}.png" for i in range(COUNT)])
    return tmp_path


def test_views_show_what_cameras_there_would_see(world, placed):
    """In colours, and in the places of points; all views of a panorama have its centre."""
    assert run("poses", "around", "-o", "views") == 0
    model = pycolmap.Reconstruction(placed / "views" / "sparse" / "0")
    rays = pixel_rays(np.array([SIDE / 2] * 4), SIDE, SIDE)
    for image in model.images.values():
        view, _, name = image.name.partition("/")
        pose = poses()[int(name[0])]
        shown = image_files.load(placed / "views" / "images" / image.name).astype(int)
        expected, _ = seen(
            world[0], np.asarray(VIEWS[view]) @ pose, rays.reshape(-1, 3), (SIDE, SIDE)
        )
        assert np.median(np.abs(shown - expected)) < 8
    assert len(model.images) == COUNT * len(VIEWS)
    assert model.compute_num_observations() > 3 * COUNT * 5
    for point in model.points3D.values():
        for element in point.track.elements:
            image = model.images[element.image_id]
            at = image.project_point(point.xyz)
            assert np.linalg.norm(at - image.points2D[element.point2D_idx].xy) < 0.01


def test_panoramas_are_picked_whole_or_by_view(placed, capsys):
    line = ("around", "--poses", "colmap", "--max-error", "9")
    assert select(*line, "-k", "2", "-o", "whole") == 0
    names = [frame["name"] for frame in record_of(placed / "whole")["frames"]]
    first, second = names[:5], names[5:]
    for views in (first, second):
        assert sorted(name.partition("/")[0] for name in views) == sorted(VIEWS)
        assert len({name.partition("/")[2] for name in views}) == 1
    assert first[0][-5] != second[0][-5]
    assert select(*line, "-k", "2", "--method", "uniform", "-o", "even") == 0
    assert len(record_of(placed / "even")["frames"]) == 10
    assert select(*line, "-k", "7", "--views", "-o", "views") == 0
    assert len(record_of(placed / "views")["frames"]) == 7
    (placed / "kept.txt").write_text("left/4.png\n")
    assert select(*line, "-k", "1", "--always", "kept.txt", "-o", "kept") == 0
    names = [frame["name"] for frame in record_of(placed / "kept")["frames"]]
    assert names[0] == "left/4.png"
    assert {name.partition("/")[2] for name in names} == {"4.png"}
    capsys.readouterr()
    assert select(*line, "-k", "6", "-o", "no") == 1
    assert "k is 6, but COLMAP placed 6 of 6" in capsys.readouterr().err
    assert select(*line, "-k", "auto", "-o", "no") == 1
    assert "--views" in capsys.readouterr().err


def test_panoramas_stand_alone(world, placed, capsys):
    """Neither another camera beside them nor a program that places perspective images."""
    write_video(placed / "flat.avi", [world[1][0][:, :192]] * 5)
    assert run("poses", "around", "flat.avi", "-o", "no") == 1
    assert "panoramas (2:1) and other images" in capsys.readouterr().err
    assert run("poses", "around", "--by", "true", "-o", "no") == 1
    assert "--by" in capsys.readouterr().err


def test_cameras_in_different_places_are_no_panorama():
    """Files of one name in several folders are views of one panorama in one place alone."""
    names = tuple(f"{view}/{i}.png" for view in ("a", "b") for i in range(3))
    turned = np.concatenate([poses()[:3], VIEWS["right"] @ poses()[:3]])
    shape = np.zeros((6, 8, 8, 3), np.uint8)
    capture = Capture(names, turned, np.full((6, 4), 8.0), shape, ("a",) * 3 + ("b",) * 3)
    np.testing.assert_array_equal(panorama_of(capture), [0, 1, 2] * 2)
    turned[4, :, 3] += 0.1
    assert panorama_of(capture.subset(np.arange(6))) is None
