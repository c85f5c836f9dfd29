"""Positions by satellite: of photos, of a drone's subtitles; the world in metres that they give."""

import numpy as np
import pycolmap
import pytest
from PIL import Image
from small_captures import ring

from fsel.captures.colmap.camera import Camera
from fsel.captures.colmap.model import build_model
from fsel.captures.images.video import SampledFrame
from fsel.captures.poses import positions
from fsel.captures.sampling import SampledFrames, Source

ZURICH = np.array([47.3769, 8.5417, 408.0])
SUBTITLES = """1\r
00:00:00,000 --> 00:00:00,033\r
<font size="28">FrameCnt: 1, DiffTime: 33ms\r
[iso: 100] [latitude: 47.0] [longitude: -8.0] [rel_alt: 10.100 abs_alt: 480.5] </font>\r
\r
2\r
00:01:00,500 --> 00:01:01,000\r
[latitude: 47.2] [longtitude: -8.4] [altitude: 482.5]\r
\r
3\r
00:02:00,000 --> 00:02:00,033\r
[latitude: 0.000000] [longitude: 0.000000] [abs_alt: 0]\r
"""


def ring_model(names):
    """A model of cameras on a ring, without points."""
    none, lens = np.zeros((0, 3)), Camera("PINHOLE", 8, 8, (8, 8, 4, 4)).colmap
    seen, pixels = [[]] * len(names), [np.zeros((0, 2))] * len(names)
    return build_model(names, [lens] * len(names), ring(len(names)), none, none, seen, pixels)


def write_photo(file, where=None, south="N"):
    exif = Image.Exif()
    if where is not None:
        minutes = [(int(v), int(v % 1 * 60), v * 60 % 1 * 60) for v in where[:2]]
        exif[positions.GPS] = {
            1: south,
            2: minutes[0],
            3: "W",
            4: minutes[1],
            5: b"\x01",
            6: where[2],
        }
    Image.new("RGB", (8, 8)).save(file, exif=exif)


def test_positions_are_read_from_photos_and_subtitles(tmp_path):
    files = [tmp_path / f"{i}.jpg" for i in range(3)]
    for file, where, side in zip(files, (ZURICH, None, ZURICH), ("S", "N", "N"), strict=True):
        write_photo(file, where, side)
    video = tmp_path / "DJI_0001.MP4"
    video.with_suffix(".SRT").write_text(SUBTITLES)
    shots = [SampledFrame(7, 30.25, 1.0), SampledFrame(9, 99.0, 1.0)]
    taken = SampledFrames({"film": shots}, {}, 0, [])
    sources = [Source(tmp_path, "photos", tuple(files)), Source(video, "film")]
    found = positions.stated(sources, taken)
    assert found == {
        "photos/0.jpg": pytest.approx(ZURICH * -1, abs=1e-6),
        "photos/2.jpg": pytest.approx(ZURICH * [1, -1, -1], abs=1e-6),
        "film/frame_00007.jpg": pytest.approx([47.1, -8.2, 481.5]),
        "film/frame_00009.jpg": pytest.approx([47.2, -8.4, 482.5]),
    }


def test_the_world_is_in_metres_where_positions_tell_them():
    """Eight cameras on a ring; one position is wrong by a kilometre, and one is missing."""
    names = [f"{i}.jpg" for i in range(8)]
    at = -np.einsum("nij,ni->nj", ring(8)[:, :, :3], ring(8)[:, :, 3])
    metres = 30 * at[:, [1, 2, 0]]  # of another scale and turn than the model
    degrees = pycolmap.GPSTransform().enu_to_ellipsoid(metres, *ZURICH)
    degrees[3, 0] += 0.01
    known = dict(zip(names[:7], degrees[:7], strict=True))
    model = ring_model(names)
    report = positions.align(model, known)
    centers = np.array([model.find_image_with_name(name).projection_center() for name in names])
    moved = centers - centers[0]
    np.testing.assert_allclose(moved, metres - metres[0], atol=0.01)  # of a tangent plane nearby
    assert (report["frames"], report["used"]) == (7, True)
    assert "7 of 8 placed frames" in positions.in_words(report, 8)


def test_positions_that_tell_too_little_leave_the_world_alone():
    names = [f"{i}.jpg" for i in range(8)]
    model, rng = ring_model(names), np.random.default_rng(0)
    before = model.images[1].projection_center()
    near = {name: tuple(ZURICH + rng.normal(0, [2e-5, 2e-5, 2])) for name in names}
    report = positions.align(model, near)
    assert not report["used"]
    assert "scale stays unknown" in positions.in_words(report, 8)
    assert positions.align(model, dict(list(near.items())[:2])) is None
    np.testing.assert_array_equal(model.images[1].projection_center(), before)
