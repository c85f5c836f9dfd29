"""Points and observations read as arrays are those that pycolmap hands out one by one."""

from struct import pack_into

import numpy as np
import pycolmap
import pytest

from fsel.captures.colmap.model import observed, points_of
from fsel.captures.layouts.colmap import load_model

FIELDS = ("xyz", "rgb", "track_point", "track_frame", "track_xy")


def one_by_one(model, rows):
    """The slow twin of `points_of`: five lists, in the order of `FIELDS`."""
    places = dict(sorted(model.points3D.items()))
    numbers = {key: number for number, key in enumerate(places)}
    tracks = {}
    for image, row in rows.items():
        for sight in model.images[image].points2D:
            if sight.has_point3D():
                tracks.setdefault((numbers[sight.point3D_id], row), sight.xy.tolist())
    track = sorted(tracks)
    return (
        [place.xyz.tolist() for place in places.values()],
        [place.color.tolist() for place in places.values()],
        [point for point, _ in track],
        [row for _, row in track],
        [tracks[key] for key in track],
    )


def check_twins(model, found, rows):
    for field, want in zip(FIELDS, one_by_one(model, rows), strict=True):
        assert getattr(found, field).tolist() == want


def scattered(seed=0, images=5, points=12):
    """A model with ids in no order, pixels without a point, and points seen twice in an image."""
    rng = np.random.default_rng(seed)
    model = pycolmap.Reconstruction()
    for key in (3, 8):
        camera = pycolmap.Camera(
            camera_id=key, model="PINHOLE", width=64, height=48, params=[60, 60, 32, 24]
        )
        model.add_camera_with_trivial_rig(camera)
    tracks = [pycolmap.Track() for _ in range(points)]
    for key in rng.permutation(40)[:images].tolist():
        pixels = rng.uniform(0, 48, (3 * points, 2))
        image = pycolmap.Image(
            image_id=key + 1,
            name=f"an image {key}.jpg",
            camera_id=3 + 5 * (key % 2),
            keypoints=pixels,
        )
        turn = pycolmap.Rotation3d(rng.normal(size=3))
        model.add_image_with_trivial_frame(image, pycolmap.Rigid3d(turn, rng.normal(size=3)))
        for at, point in zip(
            rng.permutation(3 * points), rng.integers(0, points, points), strict=False
        ):
            tracks[point].add_element(key + 1, int(at))
    keys = rng.permutation(1000)[:points].tolist()
    for key, track in zip(keys, tracks, strict=True):
        color = rng.integers(0, 255, 3, dtype=np.uint8)
        model.add_point3D_with_id(
            key, pycolmap.Point3D(xyz=rng.normal(size=3), color=color, track=track)
        )
    return model


def written(model, folder, form):
    (model.write_text if form == "text" else model.write_binary)(str(folder))
    return load_model(folder)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("form", ["binary", "text", "memory"])
def test_arrays_hold_what_pycolmap_hands_out(form, seed, tmp_path):
    model = scattered(seed)
    folder = None if form == "memory" else tmp_path
    if folder:
        model = written(model, folder, form)
    ids = list(model.images)
    found = observed(model, folder)
    for some in (ids, ids[::-2], ids[:0]):
        rows = {image: at for at, image in enumerate(some)}
        check_twins(model, points_of(found, rows, "here"), rows)


def test_no_point_is_no_points(tmp_path):
    model = written(scattered(points=0), tmp_path, "binary")
    rows = dict.fromkeys(model.images, 0)
    assert points_of(observed(model, tmp_path), rows, "here") is None


def test_text_beside_binary_files_is_not_read(tmp_path):
    """COLMAP reads binary files where all three are there, otherwise text."""
    scattered(0).write_text(str(tmp_path))
    scattered(1).write_binary(str(tmp_path))
    for name in ("images.bin", "points3D.bin"):
        model = load_model(tmp_path)
        rows = {image: at for at, image in enumerate(model.images)}
        check_twins(model, points_of(observed(model, tmp_path), rows, "here"), rows)
        (tmp_path / name).unlink()


def changed(folder, name, at, form, value):
    """Observations of a binary model with one number of a file changed."""
    scattered().write_binary(str(folder))
    content = bytearray((folder / name).read_bytes())
    pack_into(form, content, at, value)
    (folder / name).write_bytes(content)
    model = load_model(folder)
    rows = {image: at for at, image in enumerate(model.images)}
    return points_of(observed(model, folder), rows, folder)


def test_a_damaged_number_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"point \d+ lies at \[nan, .*, not finite"):
        changed(tmp_path, "points3D.bin", 16, "<d", np.nan)
    first = (tmp_path / "images.bin").read_bytes().index(b".jpg\0") + 5 + 8
    with pytest.raises(ValueError, match=r"'an image \d+.jpg' observes point 1001, which is not"):
        changed(tmp_path, "images.bin", first + 16, "<Q", 1001)
    points = np.frombuffer((tmp_path / "images.bin").read_bytes(), "<u8", 3 * 36, first)[2::3]
    seen = int(np.flatnonzero(points < 1000)[0])
    with pytest.raises(ValueError, match=r"point \d+ is seen at \[inf, "):
        changed(tmp_path, "images.bin", first + 24 * seen, "<d", np.inf)
