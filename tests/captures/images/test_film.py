"""Videos that are written, read back; captions."""

import cv2
import numpy as np
import pytest

from fsel.captures.images import video
from fsel.captures.images.video import captioned, write_video


@pytest.mark.parametrize("size", [(64, 48), (65, 49)])
def test_a_video_has_its_frames_at_an_even_size(size, tmp_path):
    shades = [0, 60, 120, 180, 240]
    frames = [np.full((size[1], size[0], 3), [shade, 128, 128], np.uint8) for shade in shades]
    write_video(tmp_path / "a.mp4", frames, 25)
    video = cv2.VideoCapture(str(tmp_path / "a.mp4"))
    read = [video.read()[1] for _ in frames]
    assert not video.read()[0]
    assert video.get(cv2.CAP_PROP_FPS) == 25
    assert {frame.shape for frame in read} == {(48, 64, 3)}
    np.testing.assert_allclose([frame[..., 2].mean() for frame in read], shades, atol=8)


def test_a_video_without_a_codec_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(video, "CODECS", ())
    with pytest.raises(OSError, match=r"a\.mp4: OpenCV has no codec"):
        write_video(tmp_path / "a.mp4", [np.zeros((4, 4, 3), np.uint8)], 25)


def test_a_caption_is_above_the_image():
    image = np.full((48, 480, 3), 7, np.uint8)
    above = captioned(image, "fsel")
    np.testing.assert_array_equal(above[30:], image)
    assert above[:30].min() < 100 < above[:30].mean()
