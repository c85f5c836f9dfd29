"""Gaussians on a GPU: the whole path here with gsplat's own formulas in torch in place of its
kernels, and with its kernels where a GPU is."""

import sys
from dataclasses import replace

import numpy as np
import pytest
import torch
from coloured_wall import psnr, wall
from scipy.spatial.transform import Rotation

from fsel.reconstruct import check_needs, gpu, memory, needs_gpu
from fsel.reconstruct.gaussians import Gaussians, cuda, losses, optimiser, torch_terms
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.gaussians.render import NEAREST
from fsel.reconstruct.gaussians.settings import GaussianSettings
from fsel.reconstruct.gaussians.table import width_of
from fsel.reconstruct.gaussians.training import Begun, Training
from fsel.reconstruct.normalisation import Frame

FRAMES = np.array([0, 2, 3, 6])


PARTS = ("means", "quats", "scales", "opacities", "colors", "viewmats", "Ks", "backgrounds")


def by_formulas(**given):
    """gsplat's rasterization of views of scenes, (..., v, h, w, 3), one after the other.

    Takes the keywords of `gsplat.rasterization` that are used, and no others.
    """
    assert given.keys() == {*PARTS, "sh_degree", "width", "height", "near_plane", "eps2d", "packed"}
    scenes, views = given["means"].shape[:-2], given["viewmats"].shape[-3]
    assert all(given[part].shape[: len(scenes)] == scenes for part in PARTS)
    assert given["viewmats"].shape[-2:] == (4, 4)
    drawn = [
        one_view(**given | {part: given[part][scene] for part in PARTS}, row=row)
        for scene in np.ndindex(scenes)
        for row in range(views)
    ]
    images, radii = (torch.stack(parts) for parts in zip(*drawn, strict=True))
    images = images.reshape(*scenes, views, *images.shape[1:])
    return images, None, {"radii": radii.reshape(*scenes, views, *radii.shape[1:])}


def one_view(row, **given):
    """As gsplat's `_torch_impl` states it, composited pixel by pixel."""
    parts = pytest.importorskip("gsplat.cuda._torch_impl")
    pose, size = given["viewmats"][row, None], (given["width"], given["height"])
    covariances, _ = parts._quat_scale_to_covar_preci(
        given["quats"], given["scales"], compute_preci=False
    )
    radii, at, depth, conics, _ = parts._fully_fused_projection(
        *(given["means"], covariances, pose, given["Ks"][row, None]),
        *(*size, given["eps2d"], given["near_plane"]),
    )
    radii = radii * (given["opacities"] >= 1 / 255)[None, :, None]  # as its kernel does
    directions = given["means"] - torch.linalg.inv(pose)[0, :3, 3]
    colors = parts._spherical_harmonics(given["sh_degree"], directions, given["colors"])
    colors = (colors + 0.5).clamp_min(0)
    order = torch.argsort(depth[0])
    order = order[(radii[0, order] > 0).all(dim=1)]
    y, x = torch.meshgrid(*(torch.arange(n).float() + 0.5 for n in size[::-1]), indexing="ij")
    dx, dy = (grid - at[0, order, i, None, None] for i, grid in enumerate((x, y)))
    a, b, c = conics[0, order].T[..., None, None]
    alpha = torch.exp(-0.5 * (a * dx**2 + c * dy**2) - b * dx * dy)
    alpha = alpha * given["opacities"][order, None, None]
    alpha = torch.where(alpha < 1 / 255, 0, alpha.clamp_max(0.999))
    light = torch.cat([torch.ones(1, *size[::-1]), torch.cumprod(1 - alpha, dim=0)])
    image = torch.einsum("nyx,nc->yxc", light[:-1] * alpha, colors[order])
    return image + light[-1][..., None] * given["backgrounds"][row], radii[0]


@pytest.fixture
def pretended(monkeypatch):
    """The path of the GPU on the CPU."""
    torch.set_default_dtype(torch.float32)
    monkeypatch.setattr(cuda, "DEVICE", "cpu")
    monkeypatch.setattr(cuda, "rasterization", by_formulas)
    monkeypatch.setattr(gpu, "Peak", lambda device: memory.Peak())
    monkeypatch.setattr(gpu, "name", lambda: "pretended")


@pytest.fixture(scope="module")
def capture():
    found = wall(size=(20, 15))
    rng = np.random.default_rng(0)
    turned = found.world_to_camera.copy()  # cameras that look past each other, off the axes
    turned[:, :, :3] = Rotation.from_rotvec(rng.normal(0, 0.1, (8, 3))).as_matrix()
    return replace(found, world_to_camera=turned)


def some_table(count=25, seed=0):
    rng = np.random.default_rng(seed)
    table = rng.normal(0, 0.3, (count, width_of(2))).astype(np.float32)
    table[:, 2] += 4
    table[:, 3:6] = rng.uniform(-3, -0.5, (count, 3))
    table[:, 6:10] = 2 * Rotation.random(count, rng=rng).as_quat(scalar_first=True)
    table[:, 10] = rng.uniform(-2, 3, count)
    return table


@pytest.mark.usefixtures("pretended")
def test_gsplat_is_told_the_same_scene_as_the_cpu_draws(capture):
    frame, background = Frame(np.array([0.1, -0.2, 0.3]), 1.1), np.array([0.2, 0.5, 0.9])
    given = {"frame": frame, "table": some_table(), "background": background, "near": NEAREST}
    own = GaussianModel(**given).render(capture.views)
    other = cuda.CudaModel(**given).render(capture.views)
    assert own.std() > 0.05
    # gsplat ends a Gaussian at 3.33 standard deviations, where at most 1/255 is left
    np.testing.assert_allclose(other, own, atol=2 / 255)
    assert np.abs(other - own).mean() < 2e-4


@pytest.mark.usefixtures("pretended")
@pytest.mark.parametrize("masked", [False, True])
def test_a_step_goes_where_the_cpu_s_goes(capture, masked):
    masks = None
    if masked:
        masks = np.ones((8, 15, 20), bool)
        masks[:, 3:9, 4:12] = False
    scene, frame = replace(capture, masks=masks), Frame.of(capture)
    settings = GaussianSettings(steps=40, gaussians=40, noise=False, views=2)
    background = np.array([0.3, 0.3, 0.3], np.float32)
    begun = [Begun(scene, frame, some_table(), background)]
    own, other = Training(begun, settings), cuda.CudaTraining(begun, settings)
    before = own.table.copy()
    for step in (5, 6):  # the first two in which harmonics are in use
        lost = own.step(step), other.step(step)
        assert lost[0] == pytest.approx(lost[1].item(), rel=2e-3)
    found, moved = (now[:25] - before[:25] for now in (other.table[0].numpy(), own.table))
    assert np.abs(moved).min(axis=0)[:11].max() > 0
    # Adam's first steps are the rates times the gradients' signs, for all but the tiniest gradients
    same = np.isclose(found, moved, rtol=0.05, atol=1e-5)
    assert same.mean() > 0.99
    np.testing.assert_array_equal(other.count[0].numpy() > 0, own.adam.count > 0)


@pytest.mark.usefixtures("pretended")
@pytest.mark.parametrize(
    "changed", [{}, {"views": 2, "steps": 10}, {"initial": "points", "steps": 10}]
)
def test_subsets_that_are_fitted_together_do_not_meet(capture, changed):
    # of sparse points there are fewer than the budget: rows wait; the noise's draws are shared
    # and each subset has a background of its own
    settings = {"steps": 105, "gaussians": 50, "noise": False, "device": "cuda", **changed}
    settings["background"] = "mean"
    subsets = [FRAMES, np.array([0, 3]), np.array([7, 4, 5])]
    many = list(Gaussians(capture, **settings).fit_many(subsets))
    for model, frames in zip(many, subsets, strict=True):
        alone = Gaussians(capture, **settings).fit(frames)
        assert model.steps == settings["steps"]
        assert model.frame.unit == alone.frame.unit
        np.testing.assert_allclose(model.table, alone.table, atol=2e-3)  # rounding grows


def test_as_many_are_fitted_together_as_there_is_room_for(monkeypatch):
    settings = GaussianSettings(gaussians=100)
    monkeypatch.setattr(cuda, "GAUSSIANS", 450)
    assert cuda.together(settings, (10, 10)) == 4
    monkeypatch.setattr(cuda, "PIXELS", 250)
    assert cuda.together(settings, (10, 10)) == 2
    assert cuda.together(settings, (100, 100)) == 1


@pytest.mark.usefixtures("pretended")
def test_a_fit_learns_and_says_what_it_was_made_on(capture):
    settings = {"steps": 110, "gaussians": 60, "degree": 1, "seed": 3}
    losses_seen = []
    model = Gaussians(capture, **settings, device="cuda").fit(
        FRAMES, lambda *told: losses_seen.append(told)
    )
    assert isinstance(model, cuda.CudaModel)
    assert (model.device, model.steps, model.degree) == ("pretended", 110, 1)
    assert 0 < model.primitives <= 60
    assert losses_seen[-1][2] < losses_seen[0][2] / 2
    same = Gaussians(capture, **settings).fit(FRAMES)
    assert psnr(model, capture, FRAMES) == pytest.approx(psnr(same, capture, FRAMES), abs=1.5)


@pytest.mark.usefixtures("pretended")
def test_nothing_to_see_is_the_background(capture):
    empty = np.empty((0, width_of(2)), np.float32)
    model = cuda.CudaModel(Frame(np.zeros(3), 1.0), empty, np.array([0.25, 0.5, 1]))
    assert (model.render(capture.views) == [0.25, 0.5, 1]).all()


@pytest.mark.parametrize("masked", [False, True])
def test_the_loss_is_that_of_the_cpu(masked):
    rng = np.random.default_rng(0)
    image, truth = rng.random((3, 18, 23)), rng.integers(0, 256, (3, 18, 23), dtype=np.uint8)
    mask = rng.random((18, 23)) > 0.3 if masked else np.empty((0, 0), bool)
    pull = np.empty_like(image)
    value = losses.loss_gradient(image, truth, mask, losses.window(float), pull)
    tensor = torch.tensor(np.stack([image.transpose(1, 2, 0)] * 2))
    tensor[1] /= 2
    tensor.requires_grad_()
    target = torch.tensor(np.stack([truth.transpose(1, 2, 0) / 255] * 2))
    found = torch_terms.image_loss(
        tensor, target, torch.tensor(np.stack([mask] * 2)) if masked else None
    )
    found.sum().backward()
    assert found[0].item() == pytest.approx(value, rel=1e-9)
    assert abs(found[1].item() - value) > 1e-3
    np.testing.assert_allclose(tensor.grad[0].numpy().transpose(2, 0, 1), pull, atol=1e-10)


def test_penalties_and_noise_are_those_of_the_cpu():
    table = some_table().astype(np.float64)
    tensor = torch.tensor(np.concatenate([table, table[:3]])[None], requires_grad=True)
    born = torch.arange(len(table) + 3) < len(table)
    torch_terms.penalty(tensor[..., 10], tensor[..., 3:6], born[None], 0.3, 0.7).sum().backward()
    grad = np.zeros_like(table)
    optimiser.penalise(table, grad, np.arange(len(table), dtype=np.int32), 0.3, 0.7)
    np.testing.assert_allclose(tensor.grad[0, :-3].numpy(), grad, atol=1e-12)
    assert not tensor.grad[0, -3:].any()
    many = np.tile(table[:1], (20_000, 1))
    many[:, 10] = np.log(0.005 / 0.995)
    many[:, :3], many[-1, 10] = 0, 0.0
    moves = torch_terms.shaken(torch.tensor(many), 2.0, torch.Generator().manual_seed(0)).numpy()
    optimiser.shake(many, np.arange(len(many)), np.random.default_rng(0), 2.0)
    expected = np.cov(many[:-1, :3].T)
    np.testing.assert_allclose(np.cov(moves[:-1].T), expected, atol=0.04 * expected.max())
    assert not moves[-1].any()


def test_a_gpu_is_asked_for_and_refused_by_name(monkeypatch):
    wanted = {"name": "gaussians", "settings": {"device": "cuda"}}
    assert needs_gpu(wanted)
    assert not needs_gpu({"name": "gaussians", "settings": {}})
    with pytest.raises(ValueError, match="'gaussians': device must be one of cpu, cuda, got 'gpu'"):
        check_needs({"name": "gaussians", "settings": {"device": "gpu"}})
    monkeypatch.setitem(sys.modules, "gsplat", None)
    with pytest.raises(ValueError, match=r"renders by gsplat, which is not installed. Hint: pip"):
        check_needs(wanted)


@pytest.mark.skipif(torch.cuda.is_available(), reason="asks what is said where no GPU is")
def test_without_a_gpu_it_is_refused_before_any_work():
    pytest.importorskip("gsplat")
    wanted = {"name": "gaussians", "settings": {"device": "cuda"}}
    with pytest.raises(ValueError, match=r"'gaussians': device is cuda, and torch .* no GPU"):
        check_needs(wanted)
    check_needs(wanted, devices=False)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="compares with a GPU, and there is none")
def test_a_gpu_renders_and_learns_what_the_cpu_does():
    pytest.importorskip("gsplat")
    scene = wall(size=(120, 90))
    settings = {"steps": 400, "gaussians": 3000}
    own = Gaussians(scene, **settings).fit(FRAMES)
    other = Gaussians(scene, **settings, device="cuda").fit(FRAMES)
    assert other.device == torch.cuda.get_device_name()
    assert other.peak_bytes > 0
    assert psnr(other, scene, FRAMES) == pytest.approx(psnr(own, scene, FRAMES), abs=0.5)
    held_out = np.array([1, 4, 5])
    assert psnr(other, scene, held_out) == pytest.approx(psnr(own, scene, held_out), abs=0.5)
    drawn = cuda.CudaModel(own.frame, own.table, own.background, own.near).render(scene.views)
    np.testing.assert_allclose(drawn, own.render(scene.views), atol=2 / 255)
