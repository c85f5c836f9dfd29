"""Samples, compositing and gradients: by hand, and against automatic differentiation."""

import numpy as np
import pytest
import radiance_twin
import torch

from fsel.reconstruct.radiance_field import passes, rays
from fsel.reconstruct.radiance_field.grid import Grid

F = np.float32
SIDE = 41  # cells of 0.1
ALONG_X = np.array([-0.95, 0.05, 0.05, 1.0, 0.0, 0.0], F)
WHITE = np.ones(3, F)


def slabs(*given):
    """A field of slabs across x: (first cell, cells, density, raw colour) each."""
    cells = np.zeros((SIDE,) * 3, bool)
    density, color = np.full((SIDE,) * 3, F(-9)), np.zeros((SIDE,) * 3 + (4,), F)
    for first, count, sigma, raw in given:
        cells[first : first + count, :-1, :-1] = True
        density[first : first + count + 1] = np.log(sigma)
        color[first : first + count + 1, ..., :3] = raw
    index = np.arange(SIDE**3, dtype=np.int32)
    return Grid(SIDE, cells.reshape(-1), index, density.reshape(-1), color.reshape(-1, 4), 1)


def seen(grid, ray, background):
    out = np.empty((1, 3), F)
    given = grid.shape, grid.field, 1, background.astype(F), 0.0
    passes.render_rays(ray[None], 0.0, *given, out)
    return out[0]


def sigmoid(raw):
    return 1 / (1 + np.exp(-np.asarray(raw)))


FRONT, BEHIND, GREY = np.array([2.0, 0, -1]), np.array([-2.0, 1, 0.5]), np.zeros(3)
THICK, NEAR, FAR = 1 - np.exp([-1.5, -0.8, -0.6])  # opacities: Beer and Lambert


@pytest.mark.parametrize(
    ("given", "start", "background", "wanted"),
    [
        ([(20, 5, 3.0, FRONT)], -0.95, WHITE, THICK * sigmoid(FRONT) + (1 - THICK) * WHITE),
        (
            [(15, 2, 4.0, FRONT), (24, 3, 2.0, BEHIND)],
            *(-0.95, 0 * WHITE, NEAR * sigmoid(FRONT) + (1 - NEAR) * FAR * sigmoid(BEHIND)),
        ),
        ([], -0.95, np.array([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]),
        ([(20, 5, 3.0, GREY)], 0.8, WHITE, WHITE),
        ([(15, 2, 1e5, GREY), (24, 3, 2.0, GREY + 9)], -0.95, WHITE, [0.5, 0.5, 0.5]),
    ],
    ids=["a slab", "the front one hides", "empty space", "it starts behind", "opaque"],
)
def test_slabs_by_hand(given, start, background, wanted):
    ray = np.array([start, *ALONG_X[1:]], F)
    np.testing.assert_allclose(seen(slabs(*given), ray, background), wanted, rtol=2e-6)


def test_the_densest_matter_has_no_infinite_gradient():
    grid = slabs((15, 2, 1.0, np.zeros(3)))
    grid.density[:] = 1e4
    given = ALONG_X[None], np.zeros((1, 3), F), np.ones(1, F), 0.0, grid
    assert all(np.isfinite(part).all() for part in gradients_of(*given, WHITE)[1])


def gradients_of(lines, truth, late, near, grid, background):
    """The squared errors of rays, and the gradients of their mean, in two ranges of vertices."""
    kept = passes.record(len(lines), grid.shape[0], grid.harmonics, truth)
    given = lines, truth, late, near, grid.shape, grid.field, grid.harmonics, background, 0.0
    errors, ends = passes.loss_and_gradient(*given, len(lines), kept)
    count, width = grid.color.shape
    gradients = np.zeros(count + 1, F), np.zeros((count + 1) * width, F)
    for part in ((0, count // 2), (count // 2, count)):
        rays.add_up(kept, ends, gradients, *part)
    return errors, (gradients[0][:-1], gradients[1][:-width])


def random_problem(count, seed=0):
    """A random field on 9 vertices a side, a third of its cells empty, and rays through it."""
    rng = np.random.default_rng(seed)
    side = 9
    cells = np.zeros((side,) * 3, bool)
    cells[:-1, :-1, :-1] = rng.random((side - 1,) * 3) > 0.3
    width = rays.width_of(count)
    color = np.zeros((side**3, width))
    color[:, : 3 * count] = rng.normal(size=(side**3, 3 * count))
    density = rng.normal(-0.5, 0.7, side**3)
    field = np.arange(side**3, dtype=np.int32), density.astype(F), color.astype(F)
    lines = rng.normal(size=(12, 6))
    lines[:, :3] *= 0.7  # some start outside the cube that is not contracted
    lines[:, 3:] /= np.linalg.norm(lines[:, 3:], axis=1, keepdims=True)
    given = lines, rng.random((12, 3)), 1 - rng.random(12), rng.random(3)
    return Grid(side, cells.reshape(-1), *field, count), *(part.astype(F) for part in given)


@pytest.mark.parametrize("count", [1, 4, 9])
def test_loss_and_gradient_equal_automatic_differentiation(count):
    grid, lines, truth, late, background = random_problem(count)
    errors, gradients = gradients_of(lines, truth, late, 0.05, grid, background)
    shape = (grid.side,) * 3
    lines, truth, late, background = (x.astype(float) for x in (lines, truth, late, background))
    density = torch.tensor(grid.density.reshape(shape).astype(float), requires_grad=True)
    kept = grid.color[:, : 3 * count].reshape(*shape, count, 3).astype(float)
    color = torch.tensor(kept, requires_grad=True)
    seen = [
        radiance_twin.colour_of(
            line, 0.05, share, grid.shape, density, color, torch.tensor(background)
        )
        for line, share in zip(lines, late, strict=True)
    ]
    slow = ((torch.stack(seen) - torch.tensor(truth)) ** 2).sum() / len(lines)
    slow.backward()
    assert errors.mean() == pytest.approx(slow.item(), rel=1e-6)
    found = gradients[0].reshape(shape), gradients[1].reshape(grid.color.shape)
    for got, wanted in (
        (found[0], density.grad.numpy()),
        (found[1][:, : 3 * count].reshape(kept.shape), color.grad.numpy()),
    ):
        assert np.abs(wanted).max() > 1e-3
        np.testing.assert_allclose(got, wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())
    assert not found[1][:, 3 * count :].any()


def test_images_have_samples_in_the_middle_of_their_steps():
    grid, lines, truth, late, background = random_problem(4)
    passes.render_rays(lines, 0.05, grid.shape, grid.field, 4, background, 0.0, out := truth * 0)
    for share, same in ((late * 0 + F(0.5), True), (late, False)):
        errors, _ = gradients_of(lines, out, share, 0.05, grid, background)
        assert (errors.max() < 1e-10) == same


def test_largest_weights_are_those_of_the_compositing():
    grid = slabs((15, 1, 4.0, np.zeros(3)), (24, 1, 2.0, np.zeros(3)))
    found = passes.largest_weights(ALONG_X[None], 0.0, grid.shape, grid.field).reshape((SIDE,) * 3)
    a, b = 1 - np.exp(-0.4), 1 - np.exp(-0.2)
    assert found[15, 20, 20] == pytest.approx(a, rel=1e-5)
    assert found[24, 20, 20] == pytest.approx((1 - a) * b, rel=1e-5)
    assert np.count_nonzero(found) == 2
