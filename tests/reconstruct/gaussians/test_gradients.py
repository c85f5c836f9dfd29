"""The kernels against the torch twin in float64: images, losses and every gradient."""

import gaussian_twin as twin
import numpy as np
import pytest
import torch

from fsel.reconstruct.gaussians import losses
from fsel.reconstruct.gaussians.parameters import width_of
from fsel.reconstruct.gaussians.render import Canvas, camera_of

F = np.float32
SIZE, NEAR = (37, 29), 0.05
BACKGROUND = np.array([0.2, 0.5, 0.9])


def scene(count, degree, seed=0):
    """Random Gaussians: long, faint, opaque, large, behind the camera and beside the image."""
    rng = np.random.default_rng(seed)
    table = rng.normal(0, 0.4, (count, width_of(degree)))
    table[:, :3] = rng.uniform(-1.6, 1.6, (count, 3)) + [0, 0, 2.0]
    table[:, 3:6] = rng.normal(-2.2, 0.8, (count, 3))
    table[:, 6:10] = rng.normal(0, 1, (count, 4))
    table[:, 10] = rng.normal(1.0, 3.0, count)
    return table.astype(F)


def camera():
    rotation = twin.rotations(torch.tensor([[0.98, 0.05, -0.1, 0.03]]))[0].numpy()
    pose = np.column_stack([rotation, [0.1, -0.2, 0.3]])
    return pose, np.array([31.0, 33.0, 19.5, 13.0])


def pair(table, degree, factor, truth, mask=None):
    """Image, loss and gradient of the kernels, then of the twin."""
    pose, k = camera()
    seen = camera_of(pose, k, SIZE, NEAR)
    canvas = Canvas(len(table), SIZE, BACKGROUND)
    canvas.draw(table, degree, factor, seen)
    image, slope, grad = canvas.image, np.empty_like(canvas.image), np.zeros_like(table)
    masked = np.empty((0, 0), bool) if mask is None else mask
    value = losses.loss_gradient(image, truth, masked, losses.window(), slope)
    canvas.backward(table, degree, seen, slope, grad)
    slow = torch.tensor(table.astype(float), requires_grad=True)
    given = (torch.tensor(factor.astype(float)), torch.tensor(pose), torch.tensor(k), SIZE, NEAR)
    picture = twin.render(slow, degree, *given, torch.tensor(BACKGROUND))
    told = None if mask is None else torch.tensor(mask)
    expected = twin.loss(picture, torch.tensor(truth / 255), told)
    expected.backward()
    return (image, value, grad), (picture.detach().numpy(), expected.item(), slow.grad.numpy())


def truth_of(seed):
    return np.random.default_rng(seed).integers(0, 256, (3, SIZE[1], SIZE[0]), dtype=np.uint8)


@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("masked", [False, True])
def test_images_losses_and_gradients_equal_the_twins(degree, masked):
    table = scene(120, degree, seed=degree)
    factor = np.where(np.arange(120) % 7 == 0, F(0), F(1.1))
    mask = np.arange(SIZE[0]) < 20 + np.zeros((SIZE[1], 1)) if masked else None
    (image, value, grad), (picture, expected, slope) = pair(
        table, degree, factor, truth_of(degree), mask
    )
    np.testing.assert_allclose(image, picture, rtol=0, atol=1e-5)
    assert value == pytest.approx(expected, rel=1e-6)
    scale = np.abs(slope).max(axis=0)
    assert (scale[: 11 + 3 * (degree + 1) ** 2] > 0).all()
    np.testing.assert_allclose(grad / scale, slope / scale, rtol=0, atol=2e-5)
