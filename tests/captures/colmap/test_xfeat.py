"""XFeat's network beside torch, and its matches by hand; the trained one on a shift."""

from collections import OrderedDict

import cv2
import numpy as np
import pytest

from fsel.captures.colmap import features, weights, xfeat
from fsel.captures.colmap.xfeat import XFeat

SHAPES = {  # of the convolutions, as the paper's figure 3 has them
    "skip1": [None, (24, 1, 1)],
    "block1": [(4, 1, 3), (8, 4, 3), (8, 8, 3), (24, 8, 3)],
    "block2": [(24, 24, 3)] * 2,
    "block3": [(64, 24, 3), (64, 64, 3), (64, 64, 1)],
    "block4": [(64, 64, 3)] * 3,
    "block5": [(128, 64, 3), (128, 128, 3), (128, 128, 3), (64, 128, 1)],
    "block_fusion": [(64, 64, 3), (64, 64, 3), (64, 64, 1)],
    "heatmap_head": [(64, 64, 1), (64, 64, 1), (1, 64, 1)],
    "keypoint_head": [(64, 64, 1)] * 3 + [(65, 64, 1)],
}


def published(seed=0):
    """Random tensors under the names of the authors' file."""
    rng, state = np.random.default_rng(seed), OrderedDict()
    for block, shapes in SHAPES.items():
        for at, shape in enumerate(shapes):
            if shape is None:
                continue
            out, inner, side = shape
            weight = rng.normal(size=(out, inner, side, side)) / np.sqrt(inner * side**2 / 2)
            layer = f"{block}.{at}"
            plain = layer in xfeat.LINEAR or block == "skip1"
            parts = {"weight": weight, "bias": rng.normal(size=out)}
            if not plain:
                spread = rng.uniform(0.5, 2, out)
                parts = {"layer.0.weight": weight, "layer.1.running_mean": rng.normal(size=out)}
                parts |= {"layer.1.running_var": spread}
            state |= {f"{layer}.{part}": np.float32(value) for part, value in parts.items()}
    return state


def by_torch(state, grey):
    """The maps of a grey image, layer by layer with normalisations of their own."""
    torch = pytest.importorskip("torch")
    tools = torch.nn.functional
    state = {name: torch.from_numpy(value) for name, value in state.items()}

    def run(image, block):
        for at in range(len(SHAPES[block])):
            layer = f"{block}.{at}"
            stride = 2 if layer in xfeat.HALVING else 1
            if f"{layer}.weight" in state:
                image = tools.conv2d(image, state[f"{layer}.weight"], state[f"{layer}.bias"])
                continue
            weight = state[f"{layer}.layer.0.weight"]
            image = tools.conv2d(image, weight, stride=stride, padding=weight.shape[-1] // 2)
            moments = (state[f"{layer}.layer.1.running_{part}"] for part in ("mean", "var"))
            image = tools.batch_norm(image, *moments).relu()
        return image

    def larger(image, like):
        return tools.interpolate(image, like.shape[-2:], mode="bilinear", align_corners=False)

    image = tools.instance_norm(torch.from_numpy(grey)[None, None])
    skipped = tools.avg_pool2d(image, 4)
    skipped = tools.conv2d(skipped, state["skip1.1.weight"], state["skip1.1.bias"])
    third = run(run(run(image, "block1") + skipped, "block2"), "block3")
    fourth = run(third, "block4")
    fifth = run(fourth, "block5")
    fused = run(third + larger(fourth, third) + larger(fifth, third), "block_fusion")
    cells = tools.pixel_unshuffle(image, 8)
    likely = run(cells, "keypoint_head").softmax(dim=1)[:, :64]
    likely = tools.pixel_shuffle(likely, 8)[0, 0]
    reliable = run(fused, "heatmap_head").sigmoid()
    return fused[0].permute(1, 2, 0), likely, reliable[0].permute(1, 2, 0)


def test_the_network_is_that_of_torch():
    state = published()
    grey = np.random.default_rng(1).uniform(0, 255, (64, 96)).astype(np.float32)
    found = XFeat(xfeat.folded(state))._maps(grey)
    for mine, theirs in zip(found, by_torch(state, grey), strict=True):
        np.testing.assert_allclose(mine, theirs.numpy(), rtol=1e-3, atol=1e-4)


def test_keypoints_lie_in_the_image_the_surest_first():
    network = XFeat(xfeat.folded(published()))
    image = np.random.default_rng(2).integers(0, 255, (150, 200, 3), np.uint8)
    points, descriptors = network(image)
    assert len(points) == len(descriptors) > 10
    assert (points >= 0).all()
    assert (points <= [200, 150]).all()
    np.testing.assert_allclose(np.linalg.norm(descriptors, axis=1), 1, rtol=1e-5)


def test_peaks_are_those_of_parabolas():
    x = np.arange(5, dtype=np.float32)
    likely = 9 - (x[None] - 2.3) ** 2 - (x[:, None] - 1.8) ** 2
    found = xfeat._within_pixels(likely, np.array([2]), np.array([2]))
    np.testing.assert_allclose(found, [[0.3, -0.2]], atol=1e-6)


def test_matches_are_mutual_alike_and_like_no_other():
    def turned(*degrees):
        angles = np.radians(degrees)
        return np.stack([np.cos(angles), np.sin(angles)], axis=1).astype(np.float32)

    one = turned(0, 60, 120, 200, 270)
    # near the first; 60 lies between two; 120 has one nearer to its neighbour; 40 off; the last
    other = turned(5, 50, 71, 122, 240, 265)
    np.testing.assert_array_equal(xfeat.matches(one, other), [[0, 0], [1, 1], [2, 3], [4, 5]])
    # 50 and 70 are almost as far from 60
    assert [1, 1] not in xfeat.matches(one, turned(5, 50, 70.2, 122, 240, 265)).tolist()
    assert xfeat.matches(one, one[:1]).shape == (0, 2)
    assert xfeat.matches(one[:0], other).shape == (0, 2)


def test_the_published_network_finds_a_shift():
    if not weights.XFEAT.place.is_file():
        pytest.skip(f"no {weights.XFEAT.file} in the user's cache")
    rng = np.random.default_rng(3)
    coarse = rng.integers(0, 255, (40, 60, 3), np.uint8)
    image = cv2.resize(coarse, (480, 320), interpolation=cv2.INTER_CUBIC)
    network = features.finder("xfeat")
    (a, first), (b, second) = network(image[:256, :320]), network(image[32:288, 64:384])
    rows = xfeat.matches(first, second)
    assert len(rows) > 300
    moved = a[rows[:, 0]] - b[rows[:, 1]]
    assert np.mean(np.abs(moved - [64, 32]).max(axis=1) < 1) > 0.9
