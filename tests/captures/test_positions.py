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
NAMES = [f"{i}.jpg" for i in range(8)]
SUBTITLES = """1\r
00:00:00,000 --> 00:00:00,033\r
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


def test_positions_are_read_from_photos_and_subtitles(tmp_path):
    files = [tmp_path / f"{i}.jpg" for i in range(3)]
    minutes = [(int(v), int(v % 1 * 60), v * 60 % 1 * 60) for v in ZURICH[:2]]
    for file, south in zip(files, ("S", "", "N"), strict=True):
        exif = Image.Exif()
        if south:
            exif[positions.GPS] = {1: south, 2: minutes[0], 3: "W", 4: minutes[1], 5: 1, 6: 408.0}
        Image.new("RGB", (8, 8)).save(file, exif=exif)
    film = tmp_path / "DJI_0001.MP4"
    film.with_suffix(".SRT").write_text(SUBTITLES)
    taken = SampledFrames(
        {"film": [SampledFrame(7, 30.25, 1.0), SampledFrame(9, 99, 1)]}, {}, 0, []
    )
    sources = [Source(tmp_path, "photos", tuple(files)), Source(film, "film")]
    assert positions.stated(sources, taken) == {
        "photos/0.jpg": pytest.approx(ZURICH * -1, abs=1e-6),
        "photos/2.jpg": pytest.approx(ZURICH * [1, -1, -1], abs=1e-6),
        "film/frame_00007.jpg": pytest.approx([47.1, -8.2, 481.5]),
        "film/frame_00009.jpg": pytest.approx([47.2, -8.4, 482.5]),
    }


@pytest.mark.parametrize(("size", "used"), [(30, True), (0.1, False)])
def test_the_world_is_in_metres_where_positions_tell_them(size, used):
    """Cameras on a ring of 120 or 0.4 m, 0.3 m off; one has no position, and one is 1 km off."""
    none, lens = np.zeros((0, 3)), Camera("PINHOLE", 8, 8, (8, 8, 4, 4)).colmap
    seen, pixels = [[]] * 8, [np.zeros((0, 2))] * 8
    model = build_model(NAMES, [lens] * 8, ring(8), none, none, seen, pixels)
    at = -np.einsum("nij,ni->nj", ring(8)[:, :, :3], ring(8)[:, :, 3])
    metres = size * at[:, [1, 2, 0]]  # of another scale and turn than the model
    noise = np.random.default_rng(0).normal(0, 0.3, (8, 3))
    degrees = pycolmap.GPSTransform().enu_to_ellipsoid(metres + noise, *ZURICH)
    degrees[3, 0] += 0.01
    report = positions.align(model, dict(zip(NAMES[:7], degrees[:7], strict=True)))
    centers = [model.find_image_with_name(name).projection_center() for name in NAMES]
    expected = metres if used else at
    off = np.abs(centers - centers[0] - expected + expected[0])
    assert off.max() < (1.5 if used else 1e-9)
    assert (report["frames"], report["used"]) == (7, used)
    assert "7 of 8 placed frames" in positions.in_words(report, 8)
    assert positions.align(model, dict(zip(NAMES[:2], degrees[:2], strict=True))) is None
