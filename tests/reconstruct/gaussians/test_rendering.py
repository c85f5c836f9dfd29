"""Rendering: cases worked by hand, harmonics, tiles and sorting against plain twins."""

import math

import gaussian_twin as twin
import numpy as np
import pytest
import torch

from fsel.reconstruct.gaussians import parameters, projection, tiles
from fsel.reconstruct.gaussians.parameters import width_of
from fsel.reconstruct.gaussians.render import Canvas, camera_of

F = np.float32
FRONT = np.eye(3, 4)
INTRINSICS = np.array([10.0, 10.0, 8.5, 8.5])
SIZE = (17, 17)
GREY = np.array([0.1, 0.1, 0.1])


def logit(p):
    return math.log(p / (1 - p))


def gaussian(z=2.0, x=0.0, sigma=0.2, opacity=0.5, rgb=(0.5, 0.5, 0.5)):
    """A round Gaussian of one colour: of variance 100 sigma^2 / z^2 + 0.3 pixels^2."""
    row = np.zeros(14)
    row[:3], row[3:6], row[6], row[10] = (x, 0, z), math.log(sigma), 1, logit(opacity)
    row[11:] = (np.array(rgb) - 0.5) / parameters.C0
    return row


def draw(*rows, background=GREY, size=SIZE):
    """(h, w, 3) image and (h, w) light that passes, of a camera at the origin."""
    table = np.array(rows, F)
    canvas = Canvas(len(rows), size, background)
    camera = camera_of(FRONT, INTRINSICS, size, 0.01)
    canvas.draw(table, 0, np.ones(len(rows), F), camera)
    return canvas.image.transpose(1, 2, 0), canvas.rest


def test_one_gaussian_by_hand():
    image, rest = draw(gaussian(rgb=(0.9, 0.2, 0.0)))
    # variance 1 + 0.3 pixels^2; its middle is the centre of pixel 8, at (8.5, 8.5)
    for dx, dy in [(0, 0), (1, 0), (0, -2), (2, 1)]:
        alpha = 0.5 * math.exp(-0.5 * (dx**2 + dy**2) / 1.3)
        assert rest[8 + dy, 8 + dx] == pytest.approx(1 - alpha, rel=1e-6)
        expected = alpha * np.array([0.9, 0.2, 0.0]) + (1 - alpha) * GREY
        np.testing.assert_allclose(image[8 + dy, 8 + dx], expected, rtol=2e-6)


def test_a_gaussian_ends_where_alpha_is_one_255th():
    _, rest = draw(gaussian())
    # 0.5 exp(-r^2 / 2.6) = 1 / 255 at r^2 = 12.6: (3, 1) and 10 are inside, (3, 2) and 13 outside
    assert rest[8, 8 + 3] < 1
    assert rest[8 + 1, 8 + 3] < 1
    assert rest[8 + 2, 8 + 3] == 1
    assert rest[8, 8 + 4] == 1
    assert (rest < 1).sum() == sum(
        dx**2 + dy**2 < 12.6 for dx in range(-8, 9) for dy in range(-8, 9)
    )


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_two_gaussians_are_composited_by_depth_in_any_order(order):
    rows = [gaussian(2.0, opacity=0.5, rgb=(1, 0, 0)), gaussian(4.0, opacity=0.8, rgb=(0, 1, 0))]
    image, rest = draw(*(rows[i] for i in order))
    expected = 0.5 * np.array([1, 0, 0]) + 0.5 * 0.8 * np.array([0, 1, 0]) + 0.5 * 0.2 * GREY
    np.testing.assert_allclose(image[8, 8], expected, rtol=2e-6)
    assert rest[8, 8] == pytest.approx(0.1, rel=2e-6)


def test_alpha_is_held_at_99_hundredths():
    _, rest = draw(gaussian(opacity=0.9999))
    assert rest[8, 8] == pytest.approx(0.01, rel=1e-5)


def test_a_pixel_is_finished_before_its_light_falls_below_a_ten_thousandth():
    rows = [gaussian(z, opacity=0.985, rgb=c) for z, c in ((2, (1, 0, 0)), (3, (0, 1, 0)))]
    image, rest = draw(*rows, gaussian(4, opacity=0.985, rgb=(0, 0, 1)), gaussian(5, opacity=0.1))
    # 0.015^2 passes; the third would leave 3e-6, so neither it nor the faint fourth is added
    assert rest[8, 8] == pytest.approx(0.015**2, rel=3e-5)
    expected = [0.985, 0.985 * 0.015, 0] + 0.015**2 * GREY
    np.testing.assert_allclose(image[8, 8], expected, rtol=3e-5)


def test_nothing_is_drawn_of_what_is_behind_or_beside_or_has_no_opacity():
    rows = [gaussian(z=-2.0), gaussian(z=0.005), gaussian(x=50.0), gaussian(opacity=0.003)]
    image, rest = draw(*rows)
    assert (rest == 1).all()
    np.testing.assert_array_equal(image, np.broadcast_to(F(GREY), image.shape))


def test_published_constants_of_the_harmonics():
    values = np.empty(16)
    parameters.basis(3, 1.0, 0.0, 0.0, values)
    # the constants printed in the reference implementation of Kerbl et al. 2023
    wanted = [0.28209479177387814, -0.4886025119029199, -0.31539156525252005]
    wanted += [0.5462742152960396, 0.4570457994644658, -0.5900435899266435]
    assert values[[0, 3, 6, 8, 13, 15]].tolist() == wanted
    diagonal = math.sqrt(0.5)
    parameters.basis(3, diagonal, diagonal, 0.0, values)
    assert values[4] == pytest.approx(1.0925484305920792 / 2, rel=1e-12)


def test_the_harmonics_are_orthonormal_and_equal_the_twins():
    nodes, weights = np.polynomial.legendre.leggauss(8)
    turns = 2 * np.pi * np.arange(16) / 16
    z, turn = (a.ravel() for a in np.meshgrid(nodes, turns, indexing="ij"))
    flat = np.sqrt(1 - z**2)
    directions = np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)
    values = np.empty((len(z), 16))
    for row, direction in zip(values, directions, strict=True):
        parameters.basis(3, *direction, row)
    area = np.repeat(weights, 16) * 2 * np.pi / 16
    np.testing.assert_allclose((values * area[:, None]).T @ values, np.eye(16), atol=1e-12)
    expected = twin.harmonics(3, torch.tensor(directions)).numpy()
    np.testing.assert_allclose(values, expected, atol=1e-12)


def test_degree_three_renders_as_the_twin_does():
    rng = np.random.default_rng(3)
    table = rng.normal(0, 0.3, (60, width_of(3)))
    table[:, :3] = rng.uniform(-1, 1, (60, 3)) + [0, 0, 2.5]
    table[:, 3:6] -= 2
    table[:, 10] = rng.normal(0, 2, 60)
    canvas = Canvas(60, SIZE, GREY)
    camera = camera_of(FRONT, INTRINSICS, SIZE, 0.01)
    canvas.draw(table.astype(F), 3, np.ones(60, F), camera)
    given = (torch.tensor(a) for a in (table, np.ones(60), FRONT, INTRINSICS, GREY))
    rows, factor, pose, k, background = given
    expected = twin.render(rows, 3, factor, pose, k, SIZE, 0.01, background).numpy()
    np.testing.assert_allclose(canvas.image, expected, atol=3e-5)


def test_depths_are_sorted_stably():
    depth = np.random.default_rng(0).uniform(0.01, 900, 5000).astype(np.float32)
    depth[1000:2000] = depth[:1000]
    np.testing.assert_array_equal(tiles.by_depth(depth), np.argsort(depth, kind="stable"))
    assert len(tiles.by_depth(depth[:0])) == 0


def test_every_tile_lists_the_gaussians_that_reach_its_pixels_nearest_first():
    rng = np.random.default_rng(1)
    width, height = 45, 30  # not multiples of a tile
    rows = np.zeros((300, projection.COLUMNS), F)
    for row in rows:
        axes = np.exp(rng.normal(0.5, 1, 2))
        turn = rng.uniform(0, np.pi)
        mix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) * axes
        a, b, c = (mix @ mix.T + 0.3 * np.eye(2)).ravel()[[0, 1, 3]]
        opacity = rng.uniform(1.01 / 255, 1)
        reach = 2 * math.log(255 * opacity)
        row[projection.U], row[projection.V] = rng.uniform([-9, -9], [54, 39])
        row[[projection.XX, projection.XY, projection.YY]] = np.array([-c / 2, b, -a / 2]) / (
            a * c - b * b
        )
        row[projection.PEAK], row[projection.RANGE] = math.log(opacity), reach
        row[projection.HALF_X], row[projection.HALF_Y] = math.sqrt(reach * a), math.sqrt(reach * c)
        row[projection.LEAN] = b / a
    lines, same = np.empty((len(rows), 2), np.int16), np.arange(len(rows), dtype=np.int32)
    ordered, rank = np.empty_like(rows), np.empty_like(same)
    tiles.arrange(same, same, rows, height, ordered, rank, lines, 0, len(rows))
    starts, members = tiles.assign(ordered, lines, width, 0, -(-height // tiles.TILE))
    across = -(-width // tiles.TILE)
    assert len(starts) == across * -(-height // tiles.TILE) + 1
    listed = 0
    for t in range(len(starts) - 1):
        own = members[starts[t] : starts[t + 1]]
        assert (np.diff(own) > 0).all()
        left, top = t % across * tiles.TILE, t // across * tiles.TILE
        x, y = np.meshgrid(
            np.arange(left, min(left + tiles.TILE, width)) + 0.5,
            np.arange(top, min(top + tiles.TILE, height)) + 0.5,
        )
        dx, dy = x - rows[:, projection.U, None, None], y - rows[:, projection.V, None, None]
        xx, xy, yy, peak = (
            rows[:, k, None, None]
            for k in (projection.XX, projection.XY, projection.YY, projection.PEAK)
        )
        alpha = np.exp(peak + xx * dx**2 + xy * dx * dy + yy * dy**2)
        needed = np.flatnonzero((alpha >= 1 / 255).any(axis=(1, 2)))
        assert set(needed) <= set(own)
        listed += len(needed)
    assert len(members) < 1.1 * listed  # few are listed in vain
