"""LPIPS against its definition layer by layer, on backbones of known random weights."""

import numpy as np
import pytest
from safetensors.torch import save_file

from fsel.metrics import METRICS, checked, lpips

torch = pytest.importorskip("torch", reason="torch is not installed")
backbones = pytest.importorskip("fsel.metrics.backbones")

# of ImageNet, in [-1, 1]
STATISTICS = (-0.030, -0.088, -0.188), (0.458, 0.448, 0.450)
SIDES = {"alex": (31, 40), "vgg": (24, 16)}


def random_backbone(net, seed=0):
    """Layers of a backbone as torchvision has them, with random weights."""
    torch.manual_seed(seed)
    layers = []
    for layer in backbones.BACKBONES[net]:
        layers += [torch.nn.MaxPool2d(layer.pooled, 2)] if layer.pooled else []
        assert len(layers) == layer.number
        how = (layer.window, layer.stride, layer.padding)
        layers += [torch.nn.Conv2d(*layer.channels, *how), torch.nn.ReLU()]
    return torch.nn.Sequential(*layers)


def random_state(net):
    """A whole file, as a fetched one: features and heads, which are positive as the authors'."""
    state = {f"features.{k}": v for k, v in random_backbone(net).state_dict().items()}
    for name, shape in backbones.shapes_of(net).items():
        if name.startswith("lin"):
            state[name] = torch.rand(shape)
    return state


smaller = pytest.mark.parametrize("net", ["alex"])


@pytest.fixture(params=["alex", "vgg"])
def net(request):
    return request.param


@pytest.fixture
def weights(net, tmp_path):
    path = tmp_path / f"{net}.safetensors"
    save_file(random_state(net), path)
    return str(path)


def views(net, count=3, seed=0, noise=0.2):
    rng = np.random.default_rng(seed)
    truth = rng.integers(0, 256, (count, *SIDES[net], 3), dtype=np.uint8)
    rendered = np.clip(truth / 255 + noise * rng.normal(size=truth.shape), 0, 1)
    return rendered.astype(np.float32), truth


@smaller
def test_identical_views_are_at_distance_0_and_noise_is_farther(net, weights):
    rendered, truth = views(net)
    same = (truth / np.float32(255)).astype(np.float32)
    np.testing.assert_array_equal(lpips.score(same, truth, None, net, weights), 0)
    near = lpips.score(views(net, noise=0.02)[0], truth, None, net, weights)
    assert (near < lpips.score(rendered, truth, None, net, weights)).all()


@smaller
def test_batches_change_nothing(net, weights, monkeypatch):
    rendered, truth = views(net, count=5)
    whole = lpips.score(rendered, truth, None, net, weights)
    monkeypatch.setattr(backbones, "PIXELS", {"cpu": 2 * truth[0, ..., 0].size, "cuda": 1})
    np.testing.assert_allclose(lpips.score(rendered, truth, None, net, weights), whole, rtol=1e-5)


@smaller
def test_nothing_outside_a_mask_counts_and_a_whole_mask_is_none(net, weights):
    rendered, truth = views(net)
    mask = np.zeros(truth.shape[:3], bool)
    mask[:, 4:12, 3:11] = True
    other = np.where(mask[..., None], rendered, 1 - rendered)
    inside = lpips.score(rendered, truth, mask, net, weights)
    np.testing.assert_array_equal(lpips.score(other, truth, mask, net, weights), inside)
    assert (inside > 0).all()
    whole = lpips.score(rendered, truth, np.ones_like(mask), net, weights)
    plain = lpips.score(rendered, truth, None, net, weights)
    np.testing.assert_allclose(whole, plain, rtol=1e-5)


def test_equal_to_the_definition_layer_by_layer(net, weights):
    rendered, truth = views(net, count=1)
    state, distance = random_state(net), 0.0
    signals = [
        (torch.from_numpy(np.moveaxis(x, 3, 1).astype(np.float64)) * 2 - 1 - shift) / scale
        for x in (rendered, truth / 255)
        for shift, scale in [[torch.tensor(v)[:, None, None] for v in STATISTICS]]
    ]
    compared, head = {"alex": (1, 4, 7, 9, 11), "vgg": (3, 8, 15, 22, 29)}[net], 0
    with torch.inference_mode():
        for number, layer in enumerate(random_backbone(net).double()):
            signals = [layer(signal) for signal in signals]
            if number in compared:
                a, b = (signal / (signal.norm(dim=1, keepdim=True) + 1e-10) for signal in signals)
                weight = state[f"lin{head}.model.1.weight"]
                distance += (weight[0] * (a - b) ** 2).sum(1).mean().item()
                head += 1
    got = lpips.score(rendered, truth, None, net, weights)
    np.testing.assert_allclose(got, [distance], rtol=1e-5)


def test_masked_positions_by_hand():
    """Positions are alike but for the second: half of the weight is on it, or none."""
    model = backbones.Lpips("alex", random_state("alex"))
    model.heads = [torch.tensor([1.0, 2.0, 4.0])[None, :, None, None]]
    first, second = torch.zeros(1, 3, 1, 2), torch.zeros(1, 3, 1, 2)
    first[0, 0], second[0, 0, 0, 0], second[0, 2, 0, 1] = 1.0, 1.0, 1.0
    assert model.apart([first], [second]).item() == pytest.approx((0 + (1 + 4)) / 2, rel=1e-6)
    counted = torch.tensor([[[[1.0, 0.0]]]])
    assert model.apart([first], [second], counted).item() == pytest.approx(0, abs=1e-10)


def test_too_small_views_are_refused_and_the_least_are_not(net, weights):
    least = backbones.LEAST[net]
    fits = np.zeros((1, least, least, 3), np.uint8)
    assert lpips.score(fits.astype(np.float32), fits, None, net, weights) == 0
    small = fits[:, 1:]
    with pytest.raises(ValueError, match=f"needs images of {least} pixels or more"):
        lpips.score(small.astype(np.float32), small, None, net, weights)


def test_missing_weights_are_refused(net, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FSEL_CACHE", str(tmp_path))
    with pytest.raises(FileNotFoundError, match=r"no/such.safetensors"):
        checked({"psnr": {}, "lpips": {"net": net, "weights": "no/such.safetensors"}})
    with pytest.raises(FileNotFoundError, match=r"lpips.weights is None"):
        checked(["lpips"])


def test_damaged_weights_and_those_of_another_backbone_are_named(tmp_path):
    path = tmp_path / "alex.safetensors"
    for content in (b"", b"x" * 40):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"alex.safetensors: not a readable file of weights"):
            backbones.Lpips.read("alex", path)
    save_file(random_state("vgg"), path)
    with pytest.raises(ValueError, match=r"net alex: features.0.weight is \(64, 3, 3, 3\)"):
        checked({"lpips": {"net": "alex", "weights": str(path)}})


def test_settings_of_a_metric_without_are_refused():
    with pytest.raises(ValueError, match=r"metric 'ssim' has no settings, got \['window'\]"):
        checked({"ssim": {"window": 7}})
    assert list(checked(METRICS)) == list(METRICS)


@smaller
def test_the_truth_s_features_are_kept_and_never_another_s(net, weights, tmp_path):
    rendered, truth = views(net)
    first = lpips.score(rendered, truth, None, net, weights)
    np.testing.assert_array_equal(lpips.score(rendered, truth.copy(), None, net, weights), first)
    changed = truth.copy()
    changed[0] = 255 - changed[0]
    other = lpips.score(rendered, changed, None, net, weights)
    assert other[0] != first[0]
    np.testing.assert_array_equal(other[1:], first[1:])
    truth[0] = changed[0]  # the same array, with other pixels
    np.testing.assert_array_equal(lpips.score(rendered, truth, None, net, weights), other)
