"""Image files: sizes without decoding, bounds, and what a decoder would refuse."""

import struct
import zlib

import cv2
import numpy as np
import pytest

from fsel.captures.images import files as image_files

SHOT = np.random.default_rng(0).integers(0, 255, (24, 40, 3), dtype=np.uint8)


def encoded(ending, shot=SHOT, settings=()):
    return cv2.imencode(ending, shot, list(settings))[1].tobytes()


def check(content, folder, name="a.img"):
    (folder / name).write_bytes(content)
    return image_files.size_of(folder / name)


@pytest.mark.parametrize("ending", [".png", ".jpg", ".bmp", ".tiff", ".webp"])
def test_the_size_of_every_format(ending, tmp_path):
    assert check(encoded(ending), tmp_path) == (40, 24)


@pytest.mark.parametrize("ending", [".png", ".jpg"])
@pytest.mark.parametrize("share", [0.05, 0.5, 0.95])
def test_a_file_cut_short_is_named(ending, share, tmp_path):
    content = encoded(ending)
    with pytest.raises(ValueError, match=r"a\.img: image file is truncated"):
        check(content[: int(share * len(content))], tmp_path)


def test_a_jpeg_starts_with_a_marker(tmp_path):
    """Decoders know it by its first three bytes."""
    content = encoded(".jpg")
    with pytest.raises(ValueError, match=r"a\.img: not a readable image"):
        check(content[:2] + b"h" + content[3:], tmp_path)


def claimed_png(width, height):
    """A PNG whose header alone is large."""
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(b"")), (b"IEND", b"")]
    packed = [
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    ]
    return b"".join([b"\x89PNG\r\n\x1a\n", *packed])


def claimed_jpeg(width, height):
    content = bytearray(encoded(".jpg"))
    at = content.index(b"\xff\xc0") + 5
    content[at : at + 4] = struct.pack(">HH", height, width)
    return bytes(content)


@pytest.mark.parametrize("claimed", [claimed_png, claimed_jpeg])
@pytest.mark.parametrize("side", [20_000, 60_000])
def test_what_a_header_claims_is_bounded_before_decoding(claimed, side, tmp_path, monkeypatch):
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("it was decoded"))
    path = tmp_path / "a.img"
    path.write_bytes(claimed(side, side))
    for read in (
        image_files.size_of,
        image_files.load,
        lambda file: image_files.load_mask(file, (1, 255)),
    ):
        with pytest.raises(ValueError, match=rf"a\.img: .*{side**2} pixels"):
            read(path)


def flipped(content, until):
    for at in range(until):
        for bits in (0x01, 0x55, 0x80, 0xFF):
            yield content[:at] + bytes([content[at] ^ bits]) + content[at + 1 :]


@pytest.mark.parametrize(
    ("ending", "settings"),
    [(".png", ()), (".jpg", ()), (".jpg", (cv2.IMWRITE_JPEG_PROGRESSIVE, 1))],
)
@pytest.mark.usefixtures("capfd")
def test_damage_is_refused_by_name_where_it_is_decoded(ending, settings, tmp_path):
    """OpenCV is the oracle: what it takes of damaged headers passes, but for few."""
    content, path = encoded(ending, settings=settings), tmp_path / f"a{ending}"
    until = len(content) if ending == ".png" else content.index(b"\xff\xda") + 4
    taken, passed = [], []
    for changed in list(flipped(content, until))[:: 29 if ending == ".png" else 3]:
        path.write_bytes(changed)
        taken.append(cv2.imdecode(np.frombuffer(changed, np.uint8), cv2.IMREAD_COLOR) is not None)
        fault = image_files.fault(path)
        passed.append(not fault)
        assert "\n" not in fault
    assert not any(p and not t for p, t in zip(passed, taken, strict=True))
    assert sum(t and not p for p, t in zip(passed, taken, strict=True)) < 0.05 * len(taken)


@pytest.mark.parametrize(("side", "factor"), [(100, 2), (50, 4), (16, 8), (101, 1)])
def test_huge_jpegs_are_decoded_at_twice_the_size_to_come_or_more(
    side, factor, tmp_path, monkeypatch
):
    small = np.random.default_rng(0).integers(0, 255, (5, 7, 3), dtype=np.uint8)
    image = cv2.resize(small, (400, 304), interpolation=cv2.INTER_CUBIC)
    image_files.write(image[None], tmp_path, ["a.jpg"])
    path = tmp_path / "a.jpg"
    assert image_files.load_for(path, side).shape == (304, 400, 3)  # as it is, up to the bound
    assert image_files.load_for(path, side / 3, approximate=True).shape[1] == 400 // factor
    monkeypatch.setattr(image_files, "HUGE", 400 * 304 - 1)
    found = image_files.load_for(path, side)
    assert found.shape == (304 // factor, 400 // factor, 3)
    wanted = cv2.resize(image_files.load(path), found.shape[1::-1], interpolation=cv2.INTER_AREA)
    assert np.abs(found.astype(float) - wanted).mean() < 1.0
