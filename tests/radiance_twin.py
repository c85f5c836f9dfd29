"""The field in float64 torch, slow and plain; gradients by automatic differentiation."""

import itertools

import torch


def contracted(point):
    """A point in the cube of half-side 2."""
    r = point.abs().max()
    return point if r <= 1 else (2 - 1 / r) * point / r


def positions(ray, near, late, step, side):
    """(n, 3) contracted places of a ray's samples: Euler's steps of equal contracted length."""
    origin, direction = torch.as_tensor(ray[:3]), torch.as_tensor(ray[3:])
    t, ahead, found = torch.tensor(near, dtype=torch.float64), late * step, []
    wall = 2 - 0.25 * 4 / (side - 1)
    while True:
        turn = torch.autograd.functional.jacobian(contracted, origin + t * direction)
        t = t + ahead / torch.linalg.norm(turn @ direction)
        ahead = step
        place = contracted(origin + t * direction)
        if place.abs().max() >= wall:
            return torch.stack(found) if found else torch.zeros((0, 3), dtype=torch.float64)
        found.append(place)


def interpolated(place, values, side):
    """Trilinear value at a contracted place; values (side, side, side, m)."""
    at = (place + 2) * (side - 1) / 4
    low = at.floor()
    part = at - low
    total = 0
    for corner in itertools.product((0, 1), repeat=3):
        share = torch.prod(torch.where(torch.tensor(corner) == 1, part, 1 - part))
        i, j, k = (low.long() + torch.tensor(corner)).tolist()
        total = total + share * values[i, j, k]
    return total


def harmonics(direction, count):
    x, y, z = direction
    basis = [1.0, x, y, z, 2 * x * y, 2 * y * z, 2 * x * z, x * x - y * y, (3 * z * z - 1) / 2]
    return torch.tensor(basis[:count], dtype=torch.float64)


def colour_of(ray, near, late, grid, density, color, background):
    """Light of one ray through (side, side, side) densities and (.., B, 3) raw colours.

    Args:
        grid: step, side, and (side**3,) bool occupied cells.
    """
    step, side, occupied = grid
    basis = harmonics(ray[3:], color.shape[3])
    left, total = torch.ones((), dtype=torch.float64), torch.zeros(3, dtype=torch.float64)
    for place in positions(ray, near, late, step, side):
        i, j, k = ((place + 2) * (side - 1) / 4).long().tolist()
        if not occupied[(i * side + j) * side + k]:
            continue
        sigma = torch.exp(interpolated(place, density[..., None], side)[0])
        raw = interpolated(place, color.reshape(side, side, side, -1), side).reshape(-1, 3)
        alpha = 1 - torch.exp(-sigma * step)
        total = total + left * alpha * torch.sigmoid(basis @ raw)
        left = left * (1 - alpha)
    return total + left * background
