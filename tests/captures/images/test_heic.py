"""Photos as phones keep them."""

import numpy as np
import pytest
from PIL import Image

from fsel.captures.images import files as image_files

pillow_heif = pytest.importorskip("pillow_heif")


@pytest.fixture
def photo(tmp_path):
    """A photo that was held upright: stored across, with an EXIF that has a focal length."""
    across = np.zeros((48, 64, 3), np.uint8)
    across[:24, :32] = [255, 0, 0]
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned clockwise
    exif.get_ifd(0x8769)[0xA405] = 26  # mm, of a 35 mm film
    stored = pillow_heif.from_pillow(Image.fromarray(across))
    stored.save(tmp_path / "IMG_1.HEIC", quality=95, exif=exif.tobytes())
    return tmp_path / "IMG_1.HEIC"


def test_a_photo_becomes_an_upright_jpeg_that_keeps_its_focal_length(photo, tmp_path):
    image_files.write_photo(photo, tmp_path / "photo.jpg", upright=True)
    shown = image_files.load(tmp_path / "photo.jpg")
    size = pillow_heif.open_heif(photo).size
    assert shown.shape == (*size[::-1], 3)
    assert (shown[..., 0] > 128).mean() == pytest.approx(0.25, abs=0.03)
    with Image.open(tmp_path / "photo.jpg") as jpeg:
        exif = jpeg.getexif()
        assert exif.get(0x0112, 1) == 1
        assert exif.get_ifd(0x8769)[0xA405] == 26


def test_what_is_damaged_is_refused_by_name(photo):
    assert image_files.fault(photo) == ""
    photo.write_bytes(photo.read_bytes()[:-50])
    with pytest.raises(ValueError, match=r"IMG_1\.HEIC: not a readable image"):
        image_files.check_pixels(photo)
    assert image_files.fault(photo).startswith("not a readable image")
