"""The sparse grid: refinement, neighbours, total variation and Adam."""

import numpy as np
import pytest
import torch

from fsel.core.limits import THREADS
from fsel.reconstruct.radiance_field.grid import Grid, grown
from fsel.reconstruct.radiance_field.training import Pixels, _Optimiser, adam_step, add_variation

F = np.float32


def linear(side=9):
    """A full grid whose density and colours are linear in place."""
    grid = Grid.full(side, 0.0, np.zeros(3), 1)
    place = np.stack(np.unravel_index(np.arange(side**3), (side,) * 3), axis=1) / (side - 1)
    grid.density[:] = place @ [1.0, -2.0, 0.5]
    grid.color[:, :3] = place
    return grid


@pytest.mark.parametrize("side", [9, 12, 17, 20])
def test_refinement_reproduces_a_linear_field(side):
    fine = linear().refined(linear().cells, side, -1.0)
    place = np.stack(np.unravel_index(np.arange(side**3), (side,) * 3), axis=1) / (side - 1)
    assert fine.occupied.sum() == (side - 1) ** 3
    np.testing.assert_array_equal(fine.index, np.arange(side**3))
    np.testing.assert_allclose(fine.density, place @ [1.0, -2.0, 0.5], atol=1e-6)
    np.testing.assert_allclose(fine.color[:, :3], place, atol=1e-6)


def test_refinement_covers_what_was_kept_and_no_more_than_it_touches():
    kept = np.zeros((9,) * 3, bool)
    kept[3, 4, 5] = True
    fine = linear().refined(kept, 17, -1.0)
    found = np.argwhere(fine.cells)
    np.testing.assert_array_equal(found.min(axis=0), [6, 8, 10])
    np.testing.assert_array_equal(found.max(axis=0), [7, 9, 11])
    assert len(fine.density) == 27
    assert (fine.index >= 0).sum() == 27


def test_vertices_that_a_grid_lacks_are_empty_and_take_the_colour_of_those_it_has():
    kept = np.zeros((9,) * 3, bool)
    kept[3, 4, 5] = True
    part = linear().refined(kept, 9, -1.0)
    part.density[:], part.color[:] = 2.0, 0.25
    wider = part.refined(grown(kept), 9, -1.0)
    outer = wider.index[np.ravel_multi_index((2, 4, 5), (9,) * 3)]
    inner = wider.index[np.ravel_multi_index((3, 4, 5), (9,) * 3)]
    assert (wider.density[outer], wider.density[inner]) == (-1.0, 2.0)
    assert wider.color[inner, 0] == 0.25
    assert wider.color[outer, 0] == 0


def test_growth_stays_inside_the_cube():
    cells = np.zeros((5,) * 3, bool)
    cells[3, 3, 3] = True
    found = grown(cells)
    assert found.sum() == 8
    assert not found[4].any()


def test_variation_equals_automatic_differentiation():
    kept = np.random.default_rng(0).random((6,) * 3) > 0.6
    kept[-1], kept[:, -1], kept[:, :, -1] = False, False, False
    grid = linear(6).refined(kept, 6, -1.0)
    rows = grid.neighbours()
    values = np.random.default_rng(1).normal(size=(len(rows), 4)).astype(F)
    given = torch.tensor(values, requires_grad=True)
    total = 0
    for axis in range(3):
        own = np.flatnonzero(rows[:, axis] >= 0)
        gap = given[rows[own, axis]] - given[own]
        total = total + torch.nn.functional.huber_loss(gap, 0 * gap, reduction="sum", delta=0.7)
    (0.3 * total / 0.7).backward()
    gradient, count = np.ones((len(values) + 1, 4), F), len(values)
    for part in ((0, count // 3), (count // 3, count)):
        add_variation(rows, values, F(0.3), F(0.7), gradient, 36, *part)
    np.testing.assert_allclose(gradient[:-1] - 1, given.grad.numpy(), atol=1e-6)


def test_neighbours_are_one_vertex_away():
    grid = linear(5)
    rows = grid.neighbours()
    at = np.ravel_multi_index((1, 2, 3), (5,) * 3)
    wanted = [np.ravel_multi_index(place, (5,) * 3) for place in ((2, 2, 3), (1, 3, 3), (1, 2, 4))]
    assert rows[at].tolist() == wanted
    assert rows[np.ravel_multi_index((4, 4, 4), (5,) * 3)].tolist() == [-1, -1, -1]


def test_adam_is_the_published_one():
    """Kingma and Ba 2015, algorithm 1."""
    rng = np.random.default_rng(0)
    values = rng.normal(size=20).astype(F)
    wanted, first, second = values.astype(float), 0.0, 0.0
    moments = np.zeros(20, F), np.zeros(20, F)
    for turn in range(1, 6):
        gradient = rng.normal(size=20).astype(F)
        first, second = 0.9 * first + 0.1 * gradient, 0.99 * second + 0.01 * gradient**2
        wanted -= 0.1 * first / (1 - 0.9**turn) / np.sqrt(second / (1 - 0.99**turn))
        adam_step(values, gradient, moments, 0.1, turn)
        assert not gradient.any()
    np.testing.assert_allclose(values, wanted, rtol=1e-4, atol=1e-6)


def test_adam_leaves_what_has_no_gradient():
    values, moments = np.ones(2, F), (np.ones(2, F), np.ones(2, F))
    adam_step(values, np.array([0, 1], F), moments, 0.1, 3)
    assert values[0] == 1
    assert values[1] < 1
    assert moments[0][0] == 1


@pytest.mark.parametrize("count", ["1", "2"])
def test_a_step_whose_rays_meet_nothing_has_the_background_s_error(count, monkeypatch):
    monkeypatch.setenv(THREADS, count)
    rays = np.tile(np.array([0, 0, 0, 0, 0, 1], F), (300, 1))
    pixels = Pixels(rays, np.ones((300, 3), F), 0.1, np.full(3, 0.5, F))
    grid = Grid.full(24, 0.0, np.zeros(3), 1)
    optimiser = _Optimiser(grid, pixels, least=np.inf)
    loss = optimiser.step(np.arange(300), np.random.default_rng(0), 1, 1.0)
    assert loss == pytest.approx(3 * 0.5**2)
