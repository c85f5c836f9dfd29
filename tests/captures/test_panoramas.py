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
from fsel.core.geometry import pixel_rays, poses_at
from fsel.selection.panoramas import panorama_of
from fsel.synthetic import rooms
from fsel.synthetic.caster import Caster

WIDTH, HEIGHT, COUNT, SIDE = 256, 128, 6, 64
TURNS = 0.2 * np.arange(COUNT)
AXES = [[[np.cos(a), np.sin(a), 0], [0, 0, -1], [-np.sin(a), np.cos(a), 0]] for a in TURNS]
CENTERS = np.stack([np.sin(TURNS), 0.5 * np.cos(TURNS), np.full(COUNT, 1.5)], axis=1)
POSES = poses_at(CENTERS, np.array(AXES))  # level, on a bow through the room, z up
NAMES = [f"{i}.png" for i in range(COUNT)]


def seen(caster, pose, rays, size):
    """(h, w, 3) levels that a camera sees along (n, 3) rays, and the (n, 3) places."""
    directions = (rays / np.linalg.norm(rays, axis=1)[:, None] @ pose[:, :3]).astype(np.float32)
    origins = np.tile(-pose[:, :3].T @ pose[:, 3], (len(rays), 1)).astype(np.float32)
    levels = np.clip(caster.colors(origins, directions), 0, 1) * 255
    places = origins + directions * caster.hit(origins, directions)[1][:, None]
    return levels.reshape(size[1], size[0], 3).astype(np.uint8), places.astype(float)


@pytest.fixture(scope="module")
def world():
    """The scene, panoramas of it, and their model with points in all directions."""
    caster, size = Caster(rooms.living_room(np.random.default_rng(3), 6, 5)), [WIDTH, HEIGHT]
    sphere = pycolmap.Camera(model="EQUIRECTANGULAR", width=WIDTH, height=HEIGHT, params=size)
    pixels = np.stack(np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5), axis=-1)
    rays = np.asarray(sphere.cam_ray_from_img(pixels.reshape(-1, 2)))
    images, places = zip(*(seen(caster, pose, rays, size) for pose in POSES), strict=True)
    xyz = places[0][100::977]
    at = [np.asarray(sphere.img_from_cam(xyz @ pose[:, :3].T + pose[:, 3])) for pose in POSES]
    points = xyz, np.zeros((len(xyz), 3), np.uint8), [np.arange(len(xyz))] * COUNT, at
    return caster, np.stack(images), build_model(NAMES, [sphere] * COUNT, POSES, *points)


@pytest.fixture
def placed(world, tmp_path, monkeypatch):
    """A folder of panoramas, whose poses are known to what places them."""

    def place(raw, work, start):
        work.folder.mkdir(exist_ok=True)
        return Mapped(pycolmap.Reconstruction(world[2]))

    monkeypatch.setenv("FSEL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(sfm, "place", place)
    monkeypatch.chdir(tmp_path)
    image_files.write(world[1], tmp_path / "around", NAMES)
    return tmp_path


def test_views_show_what_cameras_there_would_see(world, placed, capsys):
    """In colours, and in the places of points."""
    assert run("poses", "around", "-o", "views") == 0
    model = pycolmap.Reconstruction(placed / "views" / "sparse" / "0")
    assert len(model.images) == COUNT * len(VIEWS)
    assert model.compute_num_observations() > 15 * COUNT
    rays = pixel_rays(np.array([SIDE / 2] * 4), SIDE, SIDE).reshape(-1, 3)
    for image in model.images.values():
        view, _, name = image.name.partition("/")
        shown = image_files.load(placed / "views" / "images" / image.name).astype(int)
        pose = VIEWS[view] @ POSES[NAMES.index(name)]
        assert np.median(np.abs(shown - seen(world[0], pose, rays, (SIDE, SIDE))[0])) < 8
        for point in (p for p in image.points2D if p.has_point3D()):
            at = image.project_point(model.points3D[point.point3D_id].xyz)
            assert np.linalg.norm(at - point.xy) < 0.01
    write_video(placed / "flat.avi", [world[1][0][:, :192]] * 5)
    assert run("poses", "around", "flat.avi", "-o", "no") == 1
    assert run("poses", "around", "--by", "true", "-o", "no") == 1
    assert run("select", "flat.avi", "-k", "2", "--views", "-o", "no") == 1
    said = capsys.readouterr().err
    assert "flat.avi: --views" in said
    assert "panoramas (2:1) and other images" in said
    assert "--by" in said


def test_panoramas_are_picked_whole_or_by_view(placed, capsys):
    (placed / "kept.txt").write_text("left/4.png\n")
    found = []
    for more in ("-k 2", "-k 2 --method uniform", "-k 7 --views", "-k 1 --always kept.txt"):
        out = f"out{len(found)}"
        assert select("around", "--poses", "colmap", *more.split(), "-o", out) == 0
        found.append([frame["name"] for frame in record_of(placed / out)["frames"]])
    for names in (found[0][:5], found[0][5:], found[1][:5], found[3]):
        views, _, panorama = zip(*(name.partition("/") for name in names), strict=True)
        assert sorted(views) == sorted(VIEWS)
        assert len(set(panorama)) == 1
    assert [len(names) for names in found] == [10, 10, 7, 5]
    assert found[3][0] == "left/4.png"
    capsys.readouterr()
    for k, said in (("6", "k is 6, but COLMAP placed 6 of 6"), ("auto", "--views")):
        assert select("around", "--poses", "colmap", "-k", k, "-o", "no") == 1
        assert said in capsys.readouterr().err


def test_cameras_in_different_places_are_no_panorama():
    """Files of one name in several folders are views of one panorama in one place alone."""
    names = tuple(f"{view}/{name}" for view in ("a", "b") for name in NAMES)
    both = np.concatenate([POSES, VIEWS["right"] @ POSES])
    images = np.zeros((len(both), 8, 8, 3), np.uint8)
    capture = Capture(names, both, np.full((len(both), 4), 8.0), images, names)
    np.testing.assert_array_equal(panorama_of(capture), [*range(COUNT)] * 2)
    both[4, :, 3] += 0.1
    assert panorama_of(capture.subset(np.arange(len(both)))) is None
