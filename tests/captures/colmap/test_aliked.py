"""ALIKED's network beside torch, and its keypoints by hand; the trained one on a shift."""

import cv2
import numpy as np
import pytest

from fsel.captures.colmap import aliked, features, weights
from fsel.captures.colmap.aliked import Aliked

SHAPES = {"block1": (3, 16), "block2": (16, 32), "block3": (32, 64), "block4": (64, 128)}
DEFORMED = ("block3", "block4")


def published():
    """Random tensors under the names of the authors' file."""
    rng, state = np.random.default_rng(0), {}

    def add(name, out, inner, side, bias=True):
        state[f"{name}.weight"] = rng.normal(size=(out, inner, side, side)) / np.sqrt(inner * side)
        if bias:
            state[f"{name}.bias"] = rng.normal(size=out)

    for block, (inner, out) in SHAPES.items():
        for at, width in ((1, inner), (2, out)):
            layer, norm = f"{block}.conv{at}", f"{block}.bn{at}"
            if block in DEFORMED:
                add(f"{layer}.offset_conv", 18, width, 3)
                layer += ".regular_conv"
            add(layer, out, width, 3, bias=False)
            for part in ("weight", "bias", "running_mean"):
                state[f"{norm}.{part}"] = rng.normal(size=out)
            state[f"{norm}.running_var"] = rng.uniform(5, 9, out)
        if block != "block1":
            add(f"{block}.downsample", out, inner, 1)
    for at, inner in enumerate((16, 32, 64, 128), 1):
        add(f"conv{at}", 32, inner, 1, bias=False)
    for at, (out, inner, side) in enumerate([(8, 128, 1), (4, 8, 3), (4, 4, 3), (1, 4, 3)]):
        add(f"score_head.{2 * at}", out, inner, side, bias=False)
    add("desc_head.offset_conv.0", 32, 128, 3)
    add("desc_head.offset_conv.2", 32, 32, 1)
    add("desc_head.sf_conv", 128, 128, 1, bias=False)
    state["desc_head.agg_weights"] = rng.normal(size=(16, 128, 128))
    return {name: np.float32(value) for name, value in state.items()}


class ByTorch:
    """The network as the paper has it, layer by layer."""

    def __init__(self, state):
        self.torch = pytest.importorskip("torch")
        self.state = {name: self.torch.from_numpy(value) for name, value in state.items()}
        self.tools = self.torch.nn.functional

    def convolved(self, image, layer, **how):
        bias = self.state.get(f"{layer}.bias")
        return self.tools.conv2d(image, self.state[f"{layer}.weight"], bias, **how)

    def normed(self, image, block, at):
        layer = f"{block}.conv{at}"
        if block in DEFORMED:
            image = self.deformed(image, layer)
        else:
            image = self.convolved(image, layer, padding=1)
        parts = ("running_mean", "running_var", "weight", "bias")
        return self.tools.batch_norm(image, *(self.state[f"{block}.bn{at}.{p}"] for p in parts))

    def sampled(self, image, x, y):
        """Values at places of torch's own grid."""
        high, wide = image.shape[2:]
        grid = self.torch.stack([2 * x / (wide - 1) - 1, 2 * y / (high - 1) - 1], dim=-1)
        return self.tools.grid_sample(image, grid[None], align_corners=True)[0]

    def deformed(self, image, layer):
        high, wide = image.shape[2:]
        offsets = self.convolved(image, f"{layer}.offset_conv", padding=1)[0]
        offsets = offsets.clamp(-max(high, wide) / 4, max(high, wide) / 4)
        y, x = self.torch.meshgrid(*map(self.torch.arange, (high, wide)), indexing="ij")
        weight, out = self.state[f"{layer}.regular_conv.weight"], 0
        for tap in range(9):
            row, column = (
                y + tap // 3 - 1 + offsets[2 * tap],
                x + tap % 3 - 1 + offsets[2 * tap + 1],
            )
            seen = self.sampled(image, column, row)
            out = out + self.torch.einsum("ob,bhw->ohw", weight[:, :, tap // 3, tap % 3], seen)
        return out[None]

    def maps(self, image):
        levels = []
        for number, block in enumerate(SHAPES):
            if number:
                image = self.tools.avg_pool2d(image, 2 if number == 1 else 4)
            out = self.normed(self.torch.selu(self.normed(image, block, 1)), block, 2)
            out = out + self.convolved(image, f"{block}.downsample") if number else out
            levels.append(image := self.torch.selu(out))
        size = levels[0].shape[2:]
        levels = [self.torch.selu(self.convolved(v, f"conv{at}")) for at, v in enumerate(levels, 1)]
        how = {"size": size, "mode": "bilinear", "align_corners": True}
        maps = self.torch.cat([self.tools.interpolate(level, **how) for level in levels], dim=1)
        likely = self.torch.selu(self.convolved(maps, "score_head.0"))
        for at in (2, 4):
            likely = self.torch.selu(self.convolved(likely, f"score_head.{at}", padding=1))
        likely = self.convolved(likely, "score_head.6", padding=1).sigmoid()
        return self.tools.normalize(maps, dim=1), likely[0, 0]

    def described(self, maps, at):
        found = []
        for x, y in self.torch.from_numpy(at):
            near = maps[:, :, int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2]
            hidden = self.torch.selu(self.convolved(near, "desc_head.offset_conv.0"))
            most = max(maps.shape[2:]) / 4
            by = self.convolved(hidden, "desc_head.offset_conv.2").clamp(-most, most).view(2, 1, 16)
            seen = self.convolved(
                self.sampled(maps, x + by[0], y + by[1])[None], "desc_head.sf_conv"
            )
            agg = self.state["desc_head.agg_weights"]
            found.append(self.torch.einsum("cp,pcd->d", self.torch.selu(seen)[0, :, 0], agg))
        return self.tools.normalize(self.torch.stack(found), dim=1)


def test_the_network_is_that_of_torch():
    state = published()
    mine, theirs = Aliked(aliked.folded(state)), ByTorch(state)
    image = np.random.default_rng(1).uniform(size=(3, 64, 96)).astype(np.float32)
    maps, likely = mine._maps(image)
    expected, scores = theirs.maps(theirs.torch.from_numpy(image)[None])
    np.testing.assert_allclose(maps, expected[0].numpy(), rtol=1e-3, atol=1e-4)
    np.testing.assert_allclose(likely, scores.numpy(), rtol=1e-3, atol=1e-4)
    at = np.random.default_rng(2).uniform(3, 60, (20, 2)).astype(np.float32)
    found = theirs.described(expected, at)
    np.testing.assert_allclose(mine._described(maps, at), found.numpy(), rtol=1e-3, atol=1e-4)


def test_sides_that_are_no_multiples_are_padded():
    network = Aliked(aliked.folded(published()))
    image = np.random.default_rng(3).uniform(size=(3, 50, 70)).astype(np.float32)
    edges = ((0, 0), (7, 7), (13, 13))
    for mine, whole in zip(
        network._maps(image), network._maps(np.pad(image, edges, mode="edge")), strict=True
    ):
        np.testing.assert_array_equal(mine, whole[..., 7:57, 13:83])
    points, descriptors = network(np.uint8(255 * image.transpose(1, 2, 0)))
    assert len(points) == len(descriptors) > 10
    assert ((points > 0) & (points < [70, 50])).all()
    np.testing.assert_allclose(np.linalg.norm(descriptors, axis=1), 1, rtol=1e-5)


def test_images_without_keypoints_have_no_descriptors():
    network = Aliked(aliked.folded(published()))
    maps, _ = network._maps(np.zeros((3, 64, 64), np.float32))
    assert network._described(maps, np.zeros((0, 2), np.float32)).shape == (0, 128)


def test_keypoints_are_peaks_between_pixels_the_highest_first():
    likely = np.zeros((40, 60), np.float32)
    likely[10, 20], likely[10, 21] = 0.8, 0.8 - 0.1 * np.log(2)  # half its share
    likely[30, 45] = 0.9
    likely[32, 46] = 0.7  # too near
    likely[20, 1] = 0.9  # at the edge
    likely[25, 25] = 0.09  # too low
    found = aliked.keypoints(likely)
    assert len(found) == 2
    np.testing.assert_allclose(found[0], [45.01, 30.02], atol=0.3)
    assert 20.3 < found[1, 0] < 20.34
    assert found[1, 1] == pytest.approx(10, abs=1e-5)
    np.testing.assert_allclose(aliked.keypoints(likely / 10)[:, 1].round(), [30, 10, 25])


def test_dim_images_are_lit():
    bright = np.random.default_rng(4).uniform(size=(50, 60, 3)).astype(np.float32)
    assert aliked._lit(bright) is bright
    lit = aliked._lit(0.1 + bright / 20)
    assert np.subtract(*np.percentile(lit, [99, 1])) == pytest.approx(0.6, abs=0.01)
    assert np.isfinite(aliked._lit(0 * bright)).all()


def test_the_published_networks_find_a_shift():
    if not weights.ALIKED.place.is_file():
        pytest.skip(f"no {weights.ALIKED.file} in the user's cache")
    rng = np.random.default_rng(3)
    coarse = rng.integers(0, 255, (40, 60, 3), np.uint8)
    image = cv2.resize(coarse, (480, 320), interpolation=cv2.INTER_CUBIC)
    find, match = features.finder("aliked"), features.matcher("aliked")
    one, other = ((*find(seen), (320, 256)) for seen in (image[:256, :320], image[32:288, 64:384]))
    rows = match(one, other)
    assert len(rows) > 150
    moved = one[0][rows[:, 0]] - other[0][rows[:, 1]]
    assert np.mean(np.abs(moved - [64, 32]).max(axis=1) < 1) > 0.9
