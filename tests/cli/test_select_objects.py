"""`fsel select --box` and `--masks`: picks for an object."""

import cv2
import numpy as np
from small_captures import camera_path, record_of, ring, select


def object_masks(folder, point):
    """A disc where a point of the ring's middle is seen, in every third frame."""
    folder.mkdir()
    for i, pose in enumerate(ring(24)[::3]):
        x, y, z = pose[:, :3] @ point + pose[:, 3]
        mask = np.zeros((48, 64), np.uint8)
        cv2.circle(mask, (round(60 * x / z + 31.5), round(61 * y / z + 23.5)), 4, 255, -1)
        cv2.imwrite(str(folder / f"frame_{3 * i:03d}.png"), mask)


def test_a_selection_for_an_object_looks_at_the_object(capture, tmp_path):
    """Half of the path looks away: only the views that see the object are served."""
    path = ring(24)
    path[12:] = np.diag([-1.0, 1, -1]) @ path[12:]  # each turned about its own upright axis
    targets = ["--targets", camera_path(tmp_path, path), "-k", 6]
    object_masks(tmp_path / "shapes", np.zeros(3))
    box = ["--box", -0.3, -0.3, -0.3, 0.3, 0.3, 0.3]
    asked = {"free": [], "box": box, "masks": ["--masks", tmp_path / "shapes"]}
    for name, more in asked.items():
        assert select(capture, *targets, *more, "-o", tmp_path / name) == 0
    assert record_of(tmp_path / "free")["targets"]["views"] == 24
    for name in ("box", "masks"):
        content = record_of(tmp_path / name)
        assert content["targets"]["views"] == 12
        assert all(entry["index"] <= 13 for entry in content["frames"])
    assert record_of(tmp_path / "box")["settings"]["box"] == box[1:]
