"""Rendering of splats: one by one, filling of holes against a plain twin, four lanes at once."""

import numba
import numpy as np
import pytest

from fsel.reconstruct.splats import render, simd

F = np.float32


def splat(x, y, z, opacity=1.0):
    return [x, y, z, opacity, z]


def rendered(splats, colors):
    return render.render_view(
        np.array(splats, F).T.copy(),
        np.column_stack([colors, np.ones(len(colors))]).astype(F),
        np.eye(3, 4, dtype=F),
        np.array([10, 10, 8, 8], F),
        16,
        16,
        F(0.06),
        F(0.5),
        F(10),
    )


def test_one_splat_on_a_pixel_centre_fills_that_pixel():
    total = rendered([splat(0.1, 0.1, 2.0, 0.25)], [[10, 20, 30]])
    # x = 10 * 0.1 / 2 + 8 = 8.5, the centre of pixel 8; the weight is the opacity
    assert np.argwhere(total[..., 3] > 1e-4).tolist() == [[8, 8]]
    np.testing.assert_allclose(total[8, 8], np.array([10, 20, 30, 1]) / 4, rtol=1e-4)


def test_a_splat_between_pixels_is_shared_bilinearly():
    total = rendered([splat(0.1, 0.15, 2.0, 0.5)], [[1, 1, 1]])
    np.testing.assert_allclose(total[8:10, 8, 3], [0.75 / 2, 0.25 / 2], rtol=1e-3)


def test_the_front_surface_hides_the_back():
    total = rendered([splat(0.1, 0.1, 2.0), splat(0.4, 0.4, 8.0)], [[255, 0, 0], [0, 255, 0]])
    assert total[8, 8, 1] == 0


def test_a_faint_floater_hides_nothing():
    crowd = [splat(0.4, 0.4, 8.0)] * 20
    total = rendered([splat(0.05, 0.05, 1.0, 0.3), *crowd], [[255, 0, 0]] + [[0, 255, 0]] * 20)
    assert total[8, 8, 1] > 0


def test_holes_take_the_surrounding_colour():
    total = np.ones((9, 9, 4), F) * np.array([50, 60, 70, 1], F)
    total[4, 4] = 0
    filled = render.fill_holes(total, F(1))
    np.testing.assert_allclose(filled[4, 4], [50, 60, 70], rtol=1e-4)
    assert np.isfinite(render.fill_holes(np.zeros((5, 7, 4), F), F(1))).all()


def plain_fill(total, full):
    """Pull-push, one pixel at a time."""
    height, width = total.shape[:2]
    under = np.zeros((height, width, 3))
    if max(height, width) > 1:
        padded = np.pad(total, ((0, height % 2), (0, width % 2), (0, 0)))
        coarse = plain_fill(sum(padded[y::2, x::2] for y in (0, 1) for x in (0, 1)) / 4, full)
        for y, x in np.ndindex(height, width):
            v = np.clip((y - 0.5) / 2, 0, coarse.shape[0] - 1)
            u = np.clip((x - 0.5) / 2, 0, coarse.shape[1] - 1)
            for i, j in np.ndindex(coarse.shape[:2]):
                share = max(1 - abs(v - i), 0) * max(1 - abs(u - j), 0)
                under[y, x] += share * coarse[i, j]
    own = np.minimum(total[..., 3:] / full, 1)
    return (1 - own) * under + own * total[..., :3] / np.maximum(total[..., 3:], 1e-9)


@pytest.mark.parametrize("shape", [(8, 8), (7, 10), (5, 3), (1, 6), (9, 1), (1, 1)])
def test_filling_equals_plain_pull_push(shape):
    rng = np.random.default_rng(3)
    total = rng.gamma(2, 3, (*shape, 4)).astype(F)
    total[rng.random(shape) < 0.4] = 0
    filled = render.fill_holes(total, F(12))
    # a pixel is mixed below a quarter of the typical weight: below 3
    np.testing.assert_allclose(filled, plain_fill(total.astype(float), 3.0), rtol=2e-5, atol=2e-6)


def test_four_lanes_are_added_at_any_offset():
    total, values = np.arange(9, dtype=F), np.array([7, 1, 2, 3, 4, 9], F)

    @numba.njit
    def add(total, values):
        simd.add_scaled(total, 3, F(0.5), values, 1)

    add(total, values)
    np.testing.assert_array_equal(total, [0, 1, 2, 3.5, 5, 6.5, 8, 7, 8])


@pytest.mark.parametrize("shape", [(7, 9), (8, 9), (1, 2), (1, 1)])
@pytest.mark.parametrize("decimals", [8, 1])
def test_typical_weight_is_the_median_of_what_was_met(shape, decimals):
    total = 0.1 + 50 * np.random.default_rng(0).random((*shape, 4)).astype(F) ** 4
    total = total.round(decimals)  # few decimals: many equal weights
    if shape[1] == 9:
        total[::3, ::2, 3] = 0
    weights = total[..., 3]
    assert render.typical_weight(total) == np.median(weights[weights > 0])
    assert render.typical_weight(np.zeros((*shape, 4), F)) == 1
