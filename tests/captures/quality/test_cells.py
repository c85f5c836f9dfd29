"""Detail in cells: a plain twin, and what does not move it."""

import cv2
import numpy as np
import pytest

from fsel.captures.quality.cells import CELL, GRID, KERNELS, Cells, measured, sharpness


def texture(seed=0, size=(360, 480)):
    rng = np.random.default_rng(seed)
    layers = [cv2.GaussianBlur(rng.normal(0, 30 * s, size), (0, 0), s) for s in (0.8, 3, 12)]
    grey = np.clip(100 + sum(layers), 15, 160)
    return np.repeat(grey[..., None], 3, axis=2).round().astype(np.uint8)


def of(*images):
    return Cells.of([measured(image) for image in images])


def lost(image, changed):
    """Natural logarithm of the sharpness that a change takes, along the direction of the most."""
    before, after = sharpness(of(image, changed))
    return (before - after).max()


def slow(image):
    """Energy of the cells and variance around them, without noise taken off, in loops."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float64)
    rows, columns = (n // CELL for n in grey.shape)
    padded = np.pad(grey, 1, mode="symmetric")
    energy, variance = np.zeros((4, rows, columns)), np.zeros((rows, columns))
    for row in range(rows):
        for column in range(columns):
            down, right = (
                slice(CELL * row, CELL * (row + 1)),
                slice(CELL * column, CELL * (column + 1)),
            )
            around = [slice(CELL * max(0, n - 1), CELL * (n + 2)) for n in (row, column)]
            whole = grey[: CELL * rows, : CELL * columns]
            variance[row, column] = whole[around[0], around[1]].var()
            for kernel, weights in enumerate(KERNELS):
                response = np.zeros((CELL, CELL))
                for y in range(3):
                    for x in range(3):
                        part = padded[down.start + y : down.stop + y, right.start + x :]
                        response += weights[y, x] * part[:, :CELL]
                energy[kernel, row, column] = (response**2).mean()
    return energy, variance


def test_cells_are_those_of_the_plain_loops():
    image = texture(size=(130, 250))
    energy, variance, color = measured(image)
    expected, spread = slow(image)
    noise = np.percentile(expected.reshape(4, -1), 5, axis=1)
    np.testing.assert_allclose(
        energy[:, :5, :10], expected - noise[:, None, None], rtol=1e-3, atol=0.05
    )
    np.testing.assert_allclose(variance[:5, :10], spread - noise.mean() / 6, rtol=1e-3, atol=0.5)
    np.testing.assert_allclose(color[1, 0, 0], image[:CELL, :CELL, 1].mean(), rtol=1e-5)
    assert energy.shape == (4, GRID, GRID)
    assert not variance[5:].any()
    assert not variance[:, 10:].any()


@pytest.mark.parametrize(
    "change",
    [
        lambda image: image * 1.4 + 6,
        lambda image: image * 0.6,
        lambda image: 255 * (image / 255) ** 0.8,
        lambda image: 255 * (image / 255) ** 1.3,
        lambda image: image + np.random.default_rng(1).normal(0, 3, image.shape),
        lambda image: np.where(np.arange(480)[:, None] < 150, 255, image),
    ],
    ids=["gain", "dark", "gamma", "deeper gamma", "noise", "burnt window"],
)
def test_exposure_and_noise_hardly_move_the_sharpness(change):
    changed = np.clip(change(texture().astype(float)), 0, 255).round().astype(np.uint8)
    assert abs(lost(texture(), changed)) < 0.3


@pytest.mark.parametrize("angle", [0, 30, 45, 80, 135])
def test_motion_is_seen_in_every_direction(angle):
    kernel = cv2.warpAffine(
        np.pad(np.full((1, 5), 0.2), ((6, 6), (4, 4))),
        cv2.getRotationMatrix2D((6, 6), angle, 1),
        (13, 13),
    )
    assert lost(texture(), cv2.filter2D(texture(), -1, kernel / kernel.sum())) > 1.2


@pytest.mark.parametrize(
    "image",
    [np.full((360, 480, 3), 90, np.uint8), texture()[:40, :60], np.zeros((1, 1, 3), np.uint8)],
)
def test_what_shows_too_little_is_unknown(image):
    assert np.isnan(sharpness(of(image))).all()


def test_a_clipped_image_is_unknown():
    cells = of(np.full((360, 480, 3), 255, np.uint8))
    assert not cells.color.any()
    assert np.isnan(sharpness(cells)).all()


def test_pixels_lie_in_cells():
    cells = of(texture())
    pixels = np.array([[0, 0], [47.9, 24], [96, 0], [2000, 2000]])
    scale = np.array([1, 1, 0.5, 1])
    assert cells.at(pixels, scale).tolist() == [0, GRID + 1, 2, GRID * GRID - 1]
