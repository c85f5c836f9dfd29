"""Descriptors and sharpness: contracts, a plain convolution, what they should be blind to."""

import sys

import numpy as np
import pytest
from scipy.ndimage import convolve, gaussian_filter

from fsel.captures.images.previews import sharpness
from fsel.features import appearance
from fsel.features.appearance import descriptors


def pictures(n=4, height=24, width=32, seed=0):
    rng = np.random.default_rng(seed)
    noise = gaussian_filter(rng.normal(size=(n, height, width, 3)), (0, 2, 2, 0))
    spread = noise / np.abs(noise).max()
    return (128 + 120 * spread).astype(np.uint8)


def test_descriptors_are_unit_rows_one_image_at_a_time():
    images = pictures()
    rows = descriptors(images, "lab_hog")
    assert rows.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1, atol=1e-6)
    np.testing.assert_array_equal(rows[2:3], descriptors(images[2:3], "lab_hog"))


@pytest.mark.parametrize("shape", [(128, 95), (54, 96), (37, 41)])
def test_sizes_that_the_grid_does_not_divide(shape):
    images = np.random.default_rng(0).integers(0, 256, (2, *shape, 3)).astype(np.uint8)
    vectors = descriptors(images, "lab_hog")
    assert np.isfinite(vectors).all()
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1, rtol=1e-6)


def test_the_same_place_is_more_alike_than_another():
    images = pictures(6)
    nearly = np.roll(images, 1, axis=2)
    likeness = descriptors(images, "lab_hog") @ descriptors(nearly, "lab_hog").T
    np.testing.assert_array_equal(likeness.argmax(axis=1), np.arange(6))


def test_opposite_gradients_are_one_edge():
    step = np.zeros((1, 32, 32, 3), np.uint8)
    step[:, :, 16:] = 200
    ramp = descriptors(step, "lab_hog")[0, 48:]
    mirrored = descriptors(step[:, :, ::-1], "lab_hog")[0, 48:]
    np.testing.assert_allclose(ramp, mirrored, atol=1e-5)


@pytest.mark.parametrize("level", [0, 90, 255])
def test_a_flat_image_has_a_finite_descriptor(level):
    rows = descriptors(np.full((1, 24, 32, 3), level, np.uint8), "lab_hog")
    assert np.isfinite(rows).all()
    assert np.linalg.norm(rows) <= 1 + 1e-6


@pytest.mark.parametrize(
    ("kind", "weights", "error", "said"),
    [
        ("vgg", None, ValueError, "vgg"),
        ("lab_hog", "weights.pth", ValueError, "lab_hog"),
        ("dinov2", None, FileNotFoundError, "None"),
        ("dinov2", "no/such/file.pth", FileNotFoundError, "no/such/file.pth"),
    ],
)
def test_what_cannot_be_described_is_refused(kind, weights, error, said):
    with pytest.raises(error, match=said):
        descriptors(pictures(1), kind, weights)


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    checkpoint = tmp_path / "dino.pth"
    checkpoint.write_bytes(b"")
    monkeypatch.setitem(sys.modules, "timm", None)
    with pytest.raises(ImportError, match=r"fsel\[weights\]"):
        descriptors(pictures(1), "dinov2", str(checkpoint))


def test_dinov2_hands_the_checkpoint_over_and_normalises(tmp_path, monkeypatch):
    torch = pytest.importorskip("torch")
    seen = {}

    class Network(torch.nn.Module):
        def forward(self, batch):
            seen.setdefault("batches", []).append(tuple(batch.shape))
            return batch.mean(dim=(2, 3))

    class Timm:
        @staticmethod
        def create_model(name, **options):
            seen.update(options, name=name)
            return Network()

    checkpoint = tmp_path / "dino.pth"
    checkpoint.write_bytes(b"")
    monkeypatch.setitem(sys.modules, "timm", Timm)
    monkeypatch.setattr(appearance, "BATCH", 2)
    grey = np.full((3, 24, 32, 3), 255, np.uint8)
    grey[2, ..., 0] = 0  # of the second batch
    rows = descriptors(grey, "dinov2", str(checkpoint))
    white = (1 - np.array([0.485, 0.456, 0.406])) / np.array([0.229, 0.224, 0.225])
    dark = np.array([-0.485 / 0.229, white[1], white[2]])
    expected = [v / np.linalg.norm(v) for v in (white, white, dark)]
    np.testing.assert_allclose(rows, expected, atol=1e-6)
    assert seen["name"] == "vit_small_patch14_dinov2.lvd142m"
    assert seen["pretrained_cfg_overlay"] == {"file": str(checkpoint)}
    assert seen["batches"] == [(2, 3, 224, 224), (1, 3, 224, 224)]


def test_sharpness_against_a_plain_convolution():
    images = pictures(3, seed=5)
    kernel = [[0, 1, 0], [1, -4, 1], [0, 1, 0]]
    for image, value in zip(images, sharpness(images), strict=True):
        luma = image @ np.array([0.299, 0.587, 0.114])
        assert value == pytest.approx(convolve(luma, kernel, mode="mirror").var(), rel=1e-9)
