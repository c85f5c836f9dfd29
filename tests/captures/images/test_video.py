"""Videos: frames out of them, which images are matched, and what is written."""

import os
import struct

import cv2
import numpy as np
import pytest
from small_captures import write_video

from fsel.captures.colmap import pairs
from fsel.captures.images import files as image_files
from fsel.captures.images import video


def texture(seed=0):
    noise = np.random.default_rng(seed).integers(0, 255, (16, 24, 3), dtype=np.uint8)
    return cv2.resize(noise, (96, 64), interpolation=cv2.INTER_NEAREST)


def shaky(count, sharp):
    """A texture that is blurred in every frame but the given ones."""
    blurred = cv2.GaussianBlur(texture(), (0, 0), 3)
    return [texture() if i in sharp else blurred for i in range(count)]


def test_the_sharpest_frame_of_each_stretch_is_kept(tmp_path):
    """Three seconds at ten frames: six stretches of five frames."""
    sharp = [2, 5, 14, 16, 23, 29]
    path = write_video(tmp_path / "walk.avi", shaky(30, sharp))
    kept = video.thin(path, tmp_path / "images", 2.0)
    assert [shot.index for shot in kept] == sharp
    np.testing.assert_allclose([shot.seconds for shot in kept], np.array(sharp) / 10, atol=0.01)
    names = sorted(file.name for file in (tmp_path / "images").iterdir())
    assert names == [f"frame_{i:05d}.jpg" for i in sharp]
    written = image_files.load(tmp_path / "images" / names[0]).astype(int)
    assert np.abs(written - texture()).mean() < 25  # colours of hard edges, JPEG twice
    kept = video.thin(path, tmp_path / "fewer", video.Sampling(frames=3).pace(path))
    assert [shot.index // 10 for shot in kept] == [0, 1, 2]


def test_without_a_wish_four_a_second_are_taken_but_neither_too_few_nor_too_many(tmp_path):
    """Of a video of three seconds at ten frames."""
    path = write_video(tmp_path / "walk.avi", shaky(30, range(30)))
    assert video.Sampling(least=6).pace(path) == 4  # 12 frames
    assert video.Sampling().pace(path) == pytest.approx(video.LEAST / 3)
    assert len(video.thin(path, tmp_path / "images", video.Sampling().pace(path))) == 30
    assert video.Sampling(rate=1.0).pace(path) == 1
    long = write_video(tmp_path / "long.avi", shaky(30, []), rate=0.25)  # two minutes
    assert video.Sampling().pace(long) == pytest.approx(300 / 120)
    assert video.Sampling(least=600).pace(long) == pytest.approx(600 / 120)


def test_parts_of_a_video_are_taken_denser(tmp_path):
    path = write_video(tmp_path / "walk.avi", shaky(30, range(30)))
    kept = video.thin(path, tmp_path / "images", 5.0, within=[(0.5, 1.0), (2.85, 9)])
    assert [shot.index for shot in kept] == [5, 6, 8, 10, 29]


def panorama(shift):
    """A picture of all directions, turned by columns: its ends join up."""
    wide = cv2.resize(texture(), (192, 96), interpolation=cv2.INTER_CUBIC)
    around = cv2.GaussianBlur(np.hstack([wide, wide[:, ::-1]]), (0, 0), 2)
    return np.roll(around[::2, ::2], shift, axis=1)


def test_the_ends_of_a_panorama_join_up():
    assert panorama(0).shape == (48, 192, 3)
    both = np.repeat(panorama(30), 2, axis=0)
    assert video.is_panorama(both)
    assert not video.is_panorama(both[:, :144][8:80])  # 2:1, and its ends differ
    assert not video.is_panorama(np.zeros_like(both))


def test_stretches_are_of_time_where_the_rate_varies(tmp_path, monkeypatch):
    """The clock runs ten times slower over the last ten frames: most stretches are theirs."""
    path = write_video(tmp_path / "walk.avi", shaky(30, range(30)))
    real = video._shots

    def slowed(*arguments):
        for shot, image in real(*arguments):
            late = max(shot.index - 20, 0)
            yield (
                video.SampledFrame(shot.index, (min(shot.index, 20) + 10 * late) / 110, 1.0),
                image,
            )

    monkeypatch.setattr(video, "_shots", slowed)
    kept = video.thin(path, tmp_path / "images", 11.0)
    assert [shot.index for shot in kept] == [0, 10, *range(20, 30)]


def turned(path):
    """The same video with a display matrix that says: turn it by 90 degrees."""
    content = bytearray(path.read_bytes())
    at = content.index(b"tkhd") + 4
    start = at + (52 if content[at] == 1 else 40)  # version, dates, ids, duration, layer, volume
    one = 0x10000
    matrix = (0, one, 0, -one & 0xFFFFFFFF, 0, 0, 0, 0, 0x40000000)
    content[start : start + 36] = struct.pack(">9I", *matrix)
    path.write_bytes(content)


def test_videos_held_upright_come_upright(tmp_path):
    path = write_video(tmp_path / "walk.mp4", shaky(12, range(12)), code="mp4v")
    turned(path)
    video.thin(path, tmp_path / "images", 4.0)
    shown = image_files.load(next((tmp_path / "images").iterdir()))
    assert shown.shape == (96, 64, 3)
    clockwise = cv2.rotate(texture(), cv2.ROTATE_90_CLOCKWISE)
    assert np.abs(shown.astype(int) - clockwise).mean() < 20


@pytest.mark.parametrize(("code", "hdr"), [(1, False), (16, True), (18, True)])
def test_hdr_is_told_by_the_transfer_function(code, hdr, tmp_path):
    """Primaries, transfer function and matrix of ITU-T H.273 stand behind the name of the box."""
    path = tmp_path / "walk.mov"
    path.write_bytes(b"moov" * 9 + struct.pack(">I8s3HB", 19, b"colrnclx", 9, code, 9, 0) + b"mdat")
    assert video.is_hdr(path) == hdr
    path.write_bytes(b"\x1a\x45\xdf\xa3" + bytes(99) + b"\x55\xba\x81" + bytes([code, 0]))
    assert video.is_hdr(path) == hdr


def test_a_sequence_is_matched_near_and_ever_farther():
    found = pairs.in_sequence(100)
    assert [j for i, j in found if i == 0] == [*pairs.STEPS, 16, 32, 64]
    assert [j for i, j in found if i == 95] == [96, 97, 98, 99]
    assert pairs.every_pair(3) == [(0, 1), (0, 2), (1, 2)]


def test_images_that_look_alike_close_a_loop():
    """Of 40 places on a circle, the last is the first again; neighbours are known already."""
    turn = 2 * np.pi * np.arange(40) / 39
    vectors = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    known = pairs.in_sequence(40)
    found = pairs.alike(vectors, known)
    assert (0, 39) in found
    assert not set(found) & set(known)
    assert all(i < j for i, j in found)


def test_vlad_is_the_sum_of_offsets_from_the_words():
    words = np.array([[0.0, 0], [10, 0]], np.float32)
    features = np.array([[3.0, 0], [0, 4], [10, 2]], np.float32)
    expected = np.array([3, 4, 0, 5]) / 5 / np.sqrt(2)
    np.testing.assert_allclose(pairs._vlad(features, words), expected, rtol=1e-6)


@pytest.mark.parametrize("size", [(64, 48), (65, 49)])
def test_a_video_has_its_frames_at_an_even_size(size, tmp_path):
    shades = [0, 60, 120, 180, 240]
    frames = [np.full((size[1], size[0], 3), [shade, 128, 128], np.uint8) for shade in shades]
    video.write_video(tmp_path / "a.mp4", frames, 25)
    film = cv2.VideoCapture(str(tmp_path / "a.mp4"))
    read = [film.read()[1] for _ in frames]
    assert not film.read()[0]
    assert film.get(cv2.CAP_PROP_FPS) == 25
    assert {frame.shape for frame in read} == {(48, 64, 3)}
    np.testing.assert_allclose([frame[..., 2].mean() for frame in read], shades, atol=8)


ENCODER = """#!/bin/sh
if [ "$1" = -encoders ]; then echo " V....D libx264"; else for place; do :; done; cat > "$place"; fi
"""


def test_the_system_s_ffmpeg_encodes_where_it_can(tmp_path, monkeypatch):
    program, frames = tmp_path / "ffmpeg", np.arange(240, dtype=np.uint8).reshape(2, 8, 5, 3)
    program.write_text(ENCODER)
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    video.write_video(tmp_path / "a.mp4", frames, 25)
    assert (tmp_path / "a.mp4").read_bytes() == frames[:, :, :4].tobytes()
    program.write_text(ENCODER.replace("; fi", "; exit 3; fi"))
    with pytest.raises(OSError, match="exit code 3"):
        video.write_video(tmp_path / "a.mp4", frames, 25)


def test_a_video_without_a_codec_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(video, "CODECS", ())
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(OSError, match=r"a\.mp4: OpenCV has no codec"):
        video.write_video(tmp_path / "a.mp4", [np.zeros((4, 4, 3), np.uint8)], 25)
