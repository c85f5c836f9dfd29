"""Images whose EXIF asks for a turn: stored pixels are read, and what is written asks for none."""

import cv2
import numpy as np
import pycolmap
import pytest
from PIL import Image

from fsel.captures.images import files as image_files
from fsel.captures.images import previews
from fsel.captures.images.masks import load_white

SHOT = np.zeros((16, 48, 3), np.uint8)  # RGB; a dark quarter tells each turn from the others
SHOT[:8, :16], SHOT[8:, :16], SHOT[:, 16:] = 40, 120, 220
# by the standard's table: where the stored first row and first column are to be shown
SHOWN = {
    1: SHOT,
    2: np.fliplr(SHOT),
    3: np.rot90(SHOT, 2),
    4: np.flipud(SHOT),
    5: SHOT.transpose(1, 0, 2),
    6: np.rot90(SHOT, -1),
    7: np.rot90(SHOT, 2).transpose(1, 0, 2),
    8: np.rot90(SHOT),
}
SETTINGS = {".jpg": {"quality": 100}, ".webp": {"lossless": True}}


def tagged(file, value, exif=None):
    """A photo that states an orientation, and a lens of 50 mm."""
    if exif is None:
        exif = Image.Exif()
        exif[image_files.ORIENTATION] = value
        exif.get_ifd(0x8769)[0xA405] = 50  # mm, of a 35 mm film
    Image.fromarray(SHOT).save(file, exif=exif, **SETTINGS.get(file.suffix, {}))
    return file


def shown(content):
    """What a reader that applies EXIF makes of a file, RGB."""
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def close(image, expected):
    assert image.shape == expected.shape
    assert np.abs(image.astype(int) - expected).max() <= 8


@pytest.mark.parametrize("value", range(2, 9))
@pytest.mark.parametrize("ending", [".jpg", ".png", ".webp"])
def test_copies_ask_for_no_turn(ending, value, tmp_path):
    file, place = tagged(tmp_path / f"a{ending}", value), tmp_path / f"b{ending}"
    close(shown(file.read_bytes()), SHOWN[value])  # the file means what the test says
    assert image_files.orientation(file) == value
    assert image_files.size_of(file) == (48, 16)
    close(image_files.load(file), SHOT)
    for upright, expected in ((False, SHOT), (True, SHOWN[value])):
        image_files.write_photo(file, place, upright=upright)
        close(shown(place.read_bytes()), expected)
        close(image_files.load(place), expected)
        assert image_files.orientation(place) == 1


def test_a_tiff_that_asks_for_a_turn_is_refused(tmp_path):
    close(image_files.load(tagged(tmp_path / "a.tiff", 1)), SHOT)
    with pytest.raises(ValueError, match=r"b\.tiff: a rotated TIFF"):
        image_files.load(tagged(tmp_path / "b.tiff", 6))


def test_every_reader_of_ours_sees_stored_pixels(tmp_path):
    file = tagged(tmp_path / "a.jpg", 6)
    close(pycolmap.Bitmap.read(str(file), True).to_array(), SHOT)
    close(image_files.load_for(file, 48), SHOT)
    (picture,) = previews.thumbnails([file], 48, 48)
    close(shown(picture), SHOT)
    np.testing.assert_array_equal(load_white(file), SHOT[..., 0] > 200)
    np.testing.assert_array_equal(image_files.load_mask(file, (200, 255)), SHOT[..., 0] > 200)


@pytest.mark.parametrize("upright", [True, False])
def test_a_copy_keeps_what_its_exif_says_of_the_lens(upright, tmp_path):
    file, place = tagged(tmp_path / "a.jpg", 6), tmp_path / "b.jpg"
    image_files.write_photo(file, place, upright=upright)
    with Image.open(place) as photo:
        assert photo.getexif().get_ifd(0x8769)[0xA405] == 50
    guessed, stated = (
        pycolmap.Bitmap.read(str(path), True).exif_focal_length() for path in (place, file)
    )
    assert guessed == pytest.approx(stated)
    assert 50 < stated < 70


@pytest.mark.parametrize("ending", [".jpg", ".png", ".webp"])
def test_damaged_exif_asks_for_no_turn(ending, tmp_path):
    file = tagged(tmp_path / f"a{ending}", 6, exif=b"Exif\0\0II*\0\xff\xff\xff\x7f" + bytes(20))
    assert image_files.orientation(file) == 1
    close(image_files.load(file), SHOT)


@pytest.fixture
def heic(tmp_path):
    """A photo that was held upright: stored across, with an EXIF that has a focal length."""
    pillow_heif = pytest.importorskip("pillow_heif")
    across = np.zeros((48, 64, 3), np.uint8)
    across[:24, :32] = [255, 0, 0]
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned clockwise
    exif.get_ifd(0x8769)[0xA405] = 26  # mm, of a 35 mm film
    stored = pillow_heif.from_pillow(Image.fromarray(across))
    stored.save(tmp_path / "IMG_1.HEIC", quality=95, exif=exif.tobytes())
    return tmp_path / "IMG_1.HEIC"


def test_a_photo_becomes_an_upright_jpeg_that_keeps_its_focal_length(heic, tmp_path):
    image_files.write_photo(heic, tmp_path / "photo.jpg", upright=True)
    shown = image_files.load(tmp_path / "photo.jpg")
    assert shown.shape == (64, 48, 3)
    assert (shown[..., 0] > 128).mean() == pytest.approx(0.25, abs=0.03)
    with Image.open(tmp_path / "photo.jpg") as jpeg:
        exif = jpeg.getexif()
        assert exif.get(0x0112, 1) == 1
        assert exif.get_ifd(0x8769)[0xA405] == 26


def test_what_is_damaged_is_refused_by_name(heic):
    assert image_files.fault(heic) == ""
    heic.write_bytes(heic.read_bytes()[:-50])
    with pytest.raises(ValueError, match=r"IMG_1\.HEIC: not a readable image"):
        image_files.check_pixels(heic)
    assert image_files.fault(heic).startswith("not a readable image")
