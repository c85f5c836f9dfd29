"""Layers in NumPy beside torch's, and beside loops."""

import numpy as np
import pytest

from fsel.captures.colmap import layers

RNG = np.random.default_rng(0)


def test_deformable_convolution_is_that_of_a_loop():
    image = RNG.normal(size=(3, 5, 7)).astype(np.float32)
    offsets = RNG.uniform(-4, 4, (18, 5, 7)).astype(np.float32)  # some lie outside
    weight = RNG.normal(size=(2, 3, 3, 3)).astype(np.float32)
    bias = RNG.normal(size=2).astype(np.float32)

    def at(channel, y, x):
        """A value between pixels, which are 0 beyond the edges."""
        total = 0.0
        for row in range(5):
            for column in range(7):
                share = max(0, 1 - abs(y - row)) * max(0, 1 - abs(x - column))
                total += share * image[channel, row, column]
        return total

    expected = np.zeros((2, 5, 7))
    for out, row, column in np.ndindex(expected.shape):
        expected[out, row, column] = bias[out] + sum(
            weight[out, channel, tap // 3, tap % 3]
            * at(
                channel,
                row + tap // 3 - 1 + offsets[2 * tap, row, column],
                column + tap % 3 - 1 + offsets[2 * tap + 1, row, column],
            )
            for channel in range(3)
            for tap in range(9)
        )
    found = layers.deformed(image, offsets, weight, bias)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5)
    still = layers.deformed(image, 0 * offsets, weight, bias)
    np.testing.assert_allclose(still, layers.convolved(image, weight, bias), rtol=1e-4, atol=1e-5)


def test_functions_are_those_of_torch():
    torch = pytest.importorskip("torch")
    values = RNG.normal(0, 5, (4, 6)).astype(np.float32)
    tensor = torch.from_numpy(values.copy())
    np.testing.assert_allclose(layers.selu(values.copy()), torch.selu(tensor), rtol=1e-5)
    np.testing.assert_allclose(layers.sigmoid(values), tensor.sigmoid(), rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(layers.softmax(values, 0), tensor.softmax(dim=0), rtol=1e-5)
