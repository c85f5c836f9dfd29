"""Metrics against scikit-image and a plain twin."""

import numpy as np
import pytest
from scipy.ndimage import convolve
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from fsel.metrics import REGISTERED, Metric, headings, score_views, units


def pair(seed, h=48, w=64, noise=0.1):
    rng = np.random.default_rng(seed)
    ramp = np.linspace(0, 1, w)[None, :, None] * np.linspace(0.3, 1, h)[:, None, None]
    image = ramp + 0.2 * np.sin(np.arange(w) / 3)[None, :, None] * np.ones((h, 1, 3))
    truth = (np.clip(image, 0, 1) * 255).astype(np.uint8)
    rendered = np.clip(truth / 255 + noise * rng.normal(size=truth.shape), 0, 1)
    return rendered.astype(np.float32), truth


# scikit-image's form of the window and covariances of Wang et al. 2004
WANG = {"data_range": 1, "channel_axis": -1, "full": True}
WANG |= {"gaussian_weights": True, "sigma": 1.5, "use_sample_covariance": False}


def plain_gmsd(rendered, truth, counted=...):
    luma = [im @ [0.299, 0.587, 0.114] for im in (rendered.astype(float), truth / 255)]
    h, w = luma[0].shape[0] // 2, luma[0].shape[1] // 2
    maps = []
    for im in luma:
        im = im[: 2 * h, : 2 * w].reshape(h, 2, w, 2).mean(axis=(1, 3))
        kernel = np.array([[1, 0, -1]] * 3) / 3
        across, down = convolve(im, kernel), convolve(im, kernel.T)
        maps.append(np.hypot(across, down)[1:-1, 1:-1])
    c = 170 / 255**2
    return ((2 * maps[0] * maps[1] + c) / (maps[0] ** 2 + maps[1] ** 2 + c))[counted].std()


@pytest.mark.parametrize("noise", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("size", [(48, 64), (49, 63), (12, 11)])
def test_equal_to_the_oracles(noise, size):
    rendered, truth = pair(1, *size, noise=noise)
    got = score_views(rendered[None], truth[None])[0]
    reference = truth / 255
    psnr = peak_signal_noise_ratio(reference, rendered.astype(float), data_range=1)
    ssim, _ = structural_similarity(reference, rendered.astype(float), **WANG)
    np.testing.assert_allclose(got[0], psnr, rtol=1e-7)
    np.testing.assert_allclose(got[1], ssim, atol=1e-5)
    if size != (12, 11):
        np.testing.assert_allclose(got[2], plain_gmsd(rendered, truth), atol=1e-6)


def test_identical_images():
    _, truth = pair(0)
    got = score_views((truth / np.float32(255))[None].astype(np.float32), truth[None])[0]
    assert got[0] == 100
    np.testing.assert_allclose(got[1:], [1, 0], atol=1e-6)


@pytest.mark.parametrize("level", [0, 255])
def test_flat_images_are_finite(level):
    truth = np.full((1, 48, 64, 3), level, np.uint8)
    assert np.isfinite(score_views(np.full(truth.shape, 0.5, np.float32), truth)).all()


def test_views_are_independent():
    a, b = pair(1), pair(2)
    both = score_views(np.stack([a[0], b[0]]), np.stack([a[1], b[1]]))
    np.testing.assert_array_equal(both[1], score_views(b[0][None], b[1][None])[0])


def oblong(top, bottom, left, right, h=48, w=64):
    mask = np.zeros((1, h, w), bool)
    mask[0, top:bottom, left:right] = True
    return mask


@pytest.mark.parametrize(
    "mask", [oblong(10, 30, 20, 50), oblong(0, 48, 0, 9), oblong(9, 10, 9, 10)]
)
def test_inside_a_mask_equal_to_the_oracles(mask):
    rendered, truth = pair(3)
    got = score_views(rendered[None], truth[None], mask)[0]
    reference = truth / 255
    shown = np.where(mask[0, ..., None], rendered.astype(float), reference)
    error = ((shown - reference)[mask[0]] ** 2).mean()
    _, windows = structural_similarity(reference, shown, **WANG)
    middles = np.zeros_like(mask[0])
    middles[5:-5, 5:-5] = mask[0, 5:-5, 5:-5]
    np.testing.assert_allclose(got[0], -10 * np.log10(error), rtol=1e-7)
    np.testing.assert_allclose(got[1], windows[middles].mean(), atol=1e-5)
    touched = mask[0].reshape(24, 2, 32, 2).any(axis=(1, 3))[1:-1, 1:-1]
    np.testing.assert_allclose(got[2], plain_gmsd(shown, truth, touched), atol=1e-6)


def test_nothing_outside_a_mask_counts():
    rendered, truth = pair(4)
    mask = oblong(12, 31, 20, 41)
    other = np.where(mask[0, ..., None], rendered, 1 - rendered)
    np.testing.assert_array_equal(
        score_views(other[None], truth[None], mask), score_views(rendered[None], truth[None], mask)
    )
    inside = np.where(mask[0, ..., None], 1 - rendered, rendered)
    assert score_views(inside[None], truth[None], mask)[0, 0] < 15


@pytest.mark.parametrize("mask", [oblong(0, 0, 0, 0), oblong(0, 3, 0, 64), oblong(0, 48, 61, 64)])
def test_a_mask_without_a_whole_window_is_refused(mask):
    rendered, truth = pair(6)
    good = oblong(10, 20, 10, 20)
    masks, twice = np.concatenate([good, mask]), (2, 1, 1, 1)
    with pytest.raises(ValueError, match="mask of view 1 has no pixel 5 or more"):
        score_views(np.tile(rendered, twice), np.tile(truth, twice), masks)


def test_wrong_sizes_are_refused():
    with pytest.raises(ValueError, match="equal size"):
        score_views(np.zeros((1, 8, 9, 3), np.float32), np.zeros((1, 8, 8, 3), np.uint8))


def test_a_rendering_that_is_not_finite_is_refused_with_its_view():
    truth = np.zeros((3, 20, 20, 3), np.uint8)
    rendered = np.zeros((3, 20, 20, 3), np.float32)
    rendered[1, 5, 5, 0] = np.nan
    with pytest.raises(ValueError, match="view 1 "):
        score_views(rendered, truth)


def test_another_metric_is_scored_beside_those_of_the_one_pass(monkeypatch):
    def largest(rendered, truth, masks):
        return np.abs(rendered - truth / 255).max(axis=(1, 2, 3))

    monkeypatch.setitem(REGISTERED, "largest", Metric("largest", "Max", False, largest, unit="1"))
    rng = np.random.default_rng(0)
    truth = rng.integers(0, 256, (2, 12, 12, 3), dtype=np.uint8)
    rendered = rng.random((2, 12, 12, 3), dtype=np.float32)
    usual = score_views(rendered, truth)
    found = score_views(rendered, truth, metrics=("largest", "gmsd", "psnr"))
    np.testing.assert_array_equal(found[:, 1:], usual[:, [2, 0]])
    np.testing.assert_array_equal(found[:, 0], largest(rendered, truth, None))
    np.testing.assert_array_equal(score_views(rendered, truth, metrics=["largest"]), found[:, :1])
    assert headings(["psnr", "largest"]) == [r"PSNR$\uparrow$", r"Max$\downarrow$"]
    assert units(["psnr", "ssim", "largest"]) == {"psnr": "dB", "largest": "1"}
