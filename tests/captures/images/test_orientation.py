"""Images whose EXIF asks for a turn: stored pixels are read, and what is written asks for none."""

import struct
import zlib

import cv2
import numpy as np
import pycolmap
import pytest

from fsel.captures.images import files as image_files
from fsel.captures.images import previews
from fsel.selection import focus

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


def block(value, order="<", kind=3):
    """EXIF of two entries: the width, then the orientation; numbers of two or of four bytes."""
    word = struct.pack(
        f"{order}HH" if kind == 3 else f"{order}I", *([value, 0] if kind == 3 else [value])
    )
    head = (b"II" if order == "<" else b"MM") + struct.pack(f"{order}HI", 42, 8)
    width = struct.pack(f"{order}HHII", 0x0100, 4, 1, 48)
    return (
        head
        + struct.pack(f"{order}H", 2)
        + width
        + struct.pack(f"{order}HHI", 0x0112, kind, 1)
        + word
        + bytes(4)
    )


def tagged(ending, value, order="<", kind=3, shot=SHOT, exif=None):
    """The file of an image that states an orientation."""
    settings = {".webp": [cv2.IMWRITE_WEBP_QUALITY, 101], ".jpg": [cv2.IMWRITE_JPEG_QUALITY, 100]}
    content = cv2.imencode(ending, shot[..., ::-1], settings.get(ending, []))[1].tobytes()
    exif = exif or block(value, order, kind)
    if ending == ".jpg":
        inside = b"Exif\0\0" + exif
        return content[:2] + b"\xff\xe1" + struct.pack(">H", len(inside) + 2) + inside + content[2:]
    if ending == ".png":
        chunk = b"eXIf" + exif
        packed = struct.pack(">I", len(exif)) + chunk + struct.pack(">I", zlib.crc32(chunk))
        return content[:33] + packed + content[33:]
    if ending == ".webp":
        extended = struct.pack("<4sIB3x", b"VP8X", 10, 8) + b"\x2f\0\0\x0f\0\0"
        inside = b"WEBP" + extended + content[12:] + struct.pack("<4sI", b"EXIF", len(exif)) + exif
        return b"RIFF" + struct.pack("<I", len(inside)) + inside
    return tiff(shot, value, order)


def tiff(shot, value, order):
    """Uncompressed, its pixels behind the header."""
    height, width = shot.shape[:2]
    pixels, at = shot.tobytes(), 8 + shot.nbytes
    bits = at + 2 + 10 * 12 + 4
    entries = [
        (256, 4, 1, width), (257, 4, 1, height), (258, 3, 3, bits), (259, 3, 1, 1),
        (262, 3, 1, 2), (273, 4, 1, 8), (274, 3, 1, value), (277, 3, 1, 3),
        (278, 4, 1, height), (279, 4, 1, len(pixels)),
    ]  # fmt: skip
    content = (b"II" if order == "<" else b"MM") + struct.pack(f"{order}HI", 42, at) + pixels
    content += struct.pack(f"{order}H", len(entries))
    for tag, kind, count, number in entries:
        short = kind == 3 and count == 1
        content += struct.pack(f"{order}HHI", tag, kind, count)
        content += (
            struct.pack(f"{order}HH", number, 0) if short else struct.pack(f"{order}I", number)
        )
    return content + bytes(4) + struct.pack(f"{order}HHH", 8, 8, 8)


def shown(content):
    """What a reader that applies EXIF makes of a file, RGB."""
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def close(image, expected):
    assert image.shape == expected.shape
    assert np.abs(image.astype(int) - expected).max() <= 8


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("value", range(2, 9))
@pytest.mark.parametrize("ending", [".jpg", ".png", ".webp"])
def test_copies_ask_for_no_turn(ending, value, order, tmp_path):
    content, file, place = tagged(ending, value, order), tmp_path / f"a{ending}", tmp_path / "b.png"
    file.write_bytes(content)
    close(shown(content), SHOWN[value])  # the file means what the test says
    assert image_files.orientation(file) == value
    assert image_files.size_of(file) == (48, 16)
    close(image_files.load(file), SHOT)
    for upright, expected in ((False, SHOT), (True, SHOWN[value])):
        image_files.write_photo(file, place, upright=upright)
        close(shown(place.read_bytes()), expected)
        close(image_files.load(place), expected)
        assert image_files.orientation(place) == 1


def test_a_tiff_that_asks_for_a_turn_is_refused(tmp_path):
    file = tmp_path / "a.tiff"
    file.write_bytes(tagged(".tiff", 1))
    close(image_files.load(file), SHOT)
    file.write_bytes(tagged(".tiff", 6))
    with pytest.raises(ValueError, match=r"a\.tiff: a TIFF that asks for a turn"):
        image_files.load(file)


def test_every_reader_of_ours_sees_stored_pixels(tmp_path):
    file = tmp_path / "a.jpg"
    file.write_bytes(tagged(".jpg", 6))
    close(pycolmap.Bitmap.read(str(file), True).to_array(), SHOT)
    close(image_files.load_for(file, 48), SHOT)
    (picture,) = previews.thumbnails([file], 48, 48)
    close(shown(picture), SHOT)
    np.testing.assert_array_equal(focus.load_white(file), SHOT[..., 0] > 200)
    np.testing.assert_array_equal(image_files.load_mask(file, (200, 255)), SHOT[..., 0] > 200)


def test_an_upright_photo_keeps_what_its_exif_says_of_the_lens(tmp_path):
    """35 mm equivalent of 50 mm, in the EXIF block that COLMAP looks at."""
    entry = struct.pack("<HHII", 0x8769, 4, 1, 38) + bytes(4)
    inner = struct.pack("<HHHIHHI", 1, 0xA405, 3, 1, 50, 0, 0)
    exif = b"II*\0" + struct.pack("<IH", 8, 2) + struct.pack("<HHIHH", 0x0112, 3, 1, 6, 0)
    inside = b"Exif\0\0" + exif + entry + inner
    content = tagged(".jpg", 1)
    plain = content[:2] + content[2 + 2 + struct.unpack(">H", content[4:6])[0] :]
    segment = b"\xff\xe1" + struct.pack(">H", len(inside) + 2) + inside
    source, place = tmp_path / "a.jpg", tmp_path / "b.jpg"
    source.write_bytes(plain[:2] + segment + plain[2:])
    image_files.write_photo(source, place, upright=True)
    close(shown(place.read_bytes()), SHOWN[6])
    close(image_files.load(place), SHOWN[6])
    focal = pycolmap.Bitmap.read(str(source), True).exif_focal_length()
    assert focal is not None
    assert pycolmap.Bitmap.read(str(place), True).exif_focal_length() == pytest.approx(focal)


@pytest.mark.parametrize("ending", [".jpg", ".png", ".webp"])
def test_numbers_of_four_bytes_and_damaged_exif(ending, tmp_path):
    file = tmp_path / f"a{ending}"
    file.write_bytes(tagged(ending, 6, kind=4))
    assert image_files.orientation(file) == 6
    file.write_bytes(tagged(ending, 6, exif=b"II*\0\xff\xff\xff\x7f" + block(6)[8:]))
    assert image_files.orientation(file) == 1
    close(image_files.load(file), SHOT)
