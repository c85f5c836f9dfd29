"""Losses, Adam, penalties, noise, relocation: against torch, published formulas and by hand."""

import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from fsel.reconstruct.gaussians import losses, optimiser, training
from fsel.reconstruct.gaussians.parameters import width_of

F = np.float32
NO_MASK = np.empty((0, 0), bool)


def test_the_window_is_the_published_one():
    weights = losses.window()
    assert weights[0] + 2 * weights[1:].sum() == pytest.approx(1, rel=1e-7)
    # 11 pixels of sigma 1.5, as pytorch-msssim and the reference implementation print them
    np.testing.assert_allclose(weights[:3], [0.266012, 0.213006, 0.109361], atol=1e-6)


@pytest.mark.parametrize("mask", [NO_MASK, np.zeros((13, 17), bool)])
def test_equal_images_and_an_empty_mask_have_no_loss_and_no_gradient(mask):
    truth = np.random.default_rng(0).integers(0, 256, (3, 13, 17), dtype=np.uint8)
    image, slope = np.ones((3, 13, 17), F), np.full((3, 13, 17), F(np.nan))
    if not len(mask):
        image = truth * F(1 / 255)
    assert abs(losses.loss_gradient(image, truth, mask, losses.window(), slope)) < 1e-6
    assert np.abs(slope).max() < 1e-6


def test_l1_of_two_constant_images_by_hand():
    image, truth = np.full((3, 40, 40), F(0.5)), np.full((3, 40, 40), 51, np.uint8)
    slope = np.empty_like(image)
    value = losses.loss_gradient(image, truth, NO_MASK, losses.window(), slope)
    # truth is 0.2; far from the edge SSIM is (2 * 0.1 + 1e-4) / (0.25 + 0.04 + 1e-4)
    inner = 1 - 0.2001 / 0.2901
    assert 0.8 * 0.3 + 0.2 * inner == pytest.approx(value, abs=0.02)
    assert slope[0, 20, 20] > 0


def test_adam_updates_touched_rows_alone_as_published():
    """Kingma and Ba 2015, algorithm 1."""
    rng = np.random.default_rng(0)
    table = rng.normal(size=(5, width_of(1))).astype(F)
    before = table.copy()
    adam = optimiser.Adam(table, optimiser.Rates(1, 40))
    expected, first, second = before[[1, 3]].astype(float), 0.0, 0.0
    for step in range(30):
        grad, slope = np.zeros_like(table), rng.normal(size=(2, table.shape[1]))
        grad[[1, 3]] = slope
        first, second = 0.9 * first + 0.1 * slope, 0.999 * second + 0.001 * slope**2
        whole, square = first / (1 - 0.9 ** (step + 1)), second / (1 - 0.999 ** (step + 1))
        expected -= adam.rates.at(step) * whole / np.sqrt(square)
        adam.step(grad, np.array([1, 3], np.int32), step)
        assert not grad.any()
    np.testing.assert_allclose(table[[1, 3]], expected, rtol=1e-5, atol=2e-5)
    np.testing.assert_array_equal(table[[0, 2, 4]], before[[0, 2, 4]])


def test_a_row_that_is_seen_late_starts_with_a_whole_step():
    table = np.zeros((2, width_of(0)), F)
    adam = optimiser.Adam(table, optimiser.Rates(0, 100))
    for step in range(50):
        adam.step(np.ones_like(table), np.array([0], np.int32), step)
    adam.step(np.ones_like(table), np.array([1], np.int32), 50)
    assert table[1, 10] == pytest.approx(-optimiser.RATES["logit"], rel=1e-5)
    adam.forget(np.array([0]))
    last = table[0, 10]
    adam.step(np.full_like(table, 7), np.array([0], np.int32), 51)
    assert table[0, 10] - last == pytest.approx(-optimiser.RATES["logit"], rel=1e-5)


def test_the_means_rate_falls_from_the_published_first_to_the_last():
    rates = optimiser.Rates(0, 2000)
    assert rates.pace == pytest.approx(math.sqrt(15))
    first = rates.at(0)
    assert first[3] == pytest.approx(math.sqrt(15) * 5e-3)
    assert first[10] == pytest.approx(5e-2)
    assert first[:3] == pytest.approx(math.sqrt(15) * 1.1 * 1.6e-4)
    assert optimiser.Rates(0, 60_000).pace == 1
    assert rates.published_mean(0) == pytest.approx(1.1 * 1.6e-4)
    assert rates.published_mean(1000) == pytest.approx(1.1 * 1.6e-5)
    assert rates.published_mean(2000) == pytest.approx(1.1 * 1.6e-6)
    assert rates.noise(0) == pytest.approx(5e5 * 1.1 * 1.6e-4)


def test_penalties_are_the_gradients_of_mean_opacity_and_mean_scale():
    table = np.random.default_rng(0).normal(size=(6, 14)).astype(F)
    tensor = torch.tensor(table, requires_grad=True)
    value = 0.3 * torch.sigmoid(tensor[:, 10]).mean() + 0.7 * tensor[:, 3:6].exp().mean()
    value.backward()
    grad = np.zeros_like(table)
    optimiser.penalise(table, grad, np.array([0, 4], np.int32), 0.3, 0.7)
    np.testing.assert_allclose(grad[[0, 4]], tensor.grad.numpy()[[0, 4]], rtol=1e-5)
    assert not grad[[1, 2, 3, 5]].any()


def test_noise_moves_faint_gaussians_along_their_axes():
    count, turn = 20_000, Rotation.from_quat([0.3, -0.2, 0.5, 0.8])
    table = np.zeros((count, 14), F)
    table[:, 3:6], table[:, 10] = np.log([0.5, 0.1, 0.02]), math.log(0.005 / 0.995)
    table[:, 6:10] = 3 * turn.as_quat(scalar_first=True)
    table[-1, 10] = 0.0  # opacity 1/2: stays
    optimiser.shake(table, np.arange(count - 1), np.random.default_rng(0), 2.0)
    axes = turn.as_matrix() * np.array([0.5, 0.1, 0.02])
    covariance = axes @ axes.T
    moved = table[:-1, :3]
    # at an opacity of 0.005 half of the size: 1 times the covariance times a normal vector
    expected = covariance @ covariance
    spread = np.cov(moved.T)
    np.testing.assert_allclose(spread, expected, atol=0.03 * expected.max())
    assert np.abs(moved.mean(axis=0)).max() < 0.01
    assert not table[-1, :3].any()


@pytest.mark.parametrize("opacity", [0.02, 0.5, 0.97])
@pytest.mark.parametrize("shares", [1, 2, 3, 7, 20])
def test_split_gaussians_follow_the_published_equation(opacity, shares):
    part = training.split_opacity(np.array([opacity]), np.array([shares]))[0]
    assert (1 - part) ** shares == pytest.approx(1 - opacity, rel=1e-12)
    total = sum(
        math.comb(i - 1, k) * (-1) ** k * part ** (k + 1) / math.sqrt(k + 1)
        for i in range(1, shares + 1)
        for k in range(i)
    )
    factor = training.split_scale(np.array([opacity]), np.array([shares]))[0]
    assert factor == pytest.approx(opacity / total, rel=1e-9)


def relocated(opacity, budget, seed=0):
    table = np.zeros((budget, 14))
    table[: len(opacity), 10] = np.log(opacity / (1 - opacity))
    table[: len(opacity), 0] = np.arange(len(opacity))
    alive, changed = training.relocate(table, len(opacity), np.random.default_rng(seed))
    return table, alive, changed


def test_the_dead_move_onto_the_living():
    opacity = np.array([0.9, 0.001, 0.5, 0.004])
    table, alive, changed = relocated(opacity, 4)
    assert alive == 4
    assert set(table[[1, 3], 0]) <= {0.0, 2.0}
    assert {1, 3} <= set(changed.tolist())
    for host in (0, 2):
        shares = (table[:, 0] == host).sum()
        kept = 1 / (1 + np.exp(-table[host, 10]))
        assert 1 - (1 - kept) ** shares == pytest.approx(opacity[host], rel=1e-9)


def test_new_ones_are_added_up_to_the_budget_and_never_beyond():
    opacity = np.full(100, 0.5)
    table, alive, changed = relocated(opacity, 200)
    assert alive == 105
    assert set(range(100, 105)) <= set(changed.tolist())
    assert not table[105:].any()
    assert relocated(opacity, 102)[1] == 102
    assert relocated(opacity, 100)[1] == 100


def test_where_none_lives_nothing_changes():
    table, alive, changed = relocated(np.full(5, 0.001), 8)
    assert (alive, len(changed)) == (5, 0)
    np.testing.assert_array_equal(table[:5, 0], np.arange(5))
