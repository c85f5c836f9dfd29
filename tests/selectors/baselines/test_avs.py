"""AVS: how strange renderings are; its picks are tested in test_splat_views.py."""

import cv2
import numpy as np

from fsel.selectors.baselines.avs import statistics, strangeness, tiles


def photo(seed, size=(72, 96)):
    """Smooth noise with edges, as natural images have."""
    rng = np.random.default_rng(seed)
    coarse = rng.random((6, 8, 3)).astype(np.float32)
    smooth = cv2.resize(coarse, size[::-1], interpolation=cv2.INTER_CUBIC)
    return np.clip(smooth + 0.3 * (smooth > 0.6) + rng.normal(0, 0.02, smooth.shape), 0, 1)


def test_a_damaged_rendering_is_stranger_than_a_photo():
    photos = np.stack([np.round(photo(seed) * 255).astype(np.uint8) for seed in range(6)])
    other = photo(9)
    rng = np.random.default_rng(0)
    noisy = np.clip(other + rng.normal(0, 0.2, other.shape), 0, 1)
    holes = np.where(rng.random(other.shape[:2])[..., None] < 0.3, 0, other)
    flat = np.full_like(other, 0.5)
    found = strangeness(np.stack([photo(0), other, noisy, holes, flat]), photos)
    assert set(found.argsort()[:2].tolist()) == {0, 1}
    assert found[2:].min() > 1.5 * found[:2].max()


def test_the_distance_is_that_of_mahalanobis():
    photos = np.stack([np.round(photo(seed) * 255).astype(np.uint8) for seed in range(8)])
    natural = np.array([statistics(tile) for one in photos for tile in tiles(one)])
    assert natural.shape == (72, 36)
    spread = np.cov(natural.T)
    spread += (1e-3 * np.mean(np.diag(spread)) + 1e-12) * np.eye(36)
    own = statistics(photos[0])
    expected = (own - natural.mean(axis=0)) @ np.linalg.inv(spread) @ (own - natural.mean(axis=0))
    np.testing.assert_allclose(strangeness(photos[:1] / 255, photos), expected, rtol=1e-6)


def test_tiles_and_what_has_no_statistics():
    content = np.arange(9 * 12 * 3, dtype=np.uint8).reshape(9, 12, 3)
    np.testing.assert_array_equal(tiles(content)[5], content[3:6, 8:])
    assert np.isfinite(statistics(np.full((2, 2, 3), 7, np.uint8))).all()
