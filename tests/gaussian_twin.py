"""3D Gaussian splatting in float64 torch: every Gaussian at every pixel, no tiles, no shortcuts.

The formulas of Kerbl et al. 2023, with the gradients that torch finds. Torch's default must be
float64 while they run.
"""

import math

import torch
import torch.nn.functional as F


def harmonics(degree, directions):
    """(n, (degree + 1)^2) values, from the polynomials in the paper's reference order."""
    x, y, z = directions.unbind(1)
    out = [torch.full_like(x, math.sqrt(1 / (4 * math.pi)))]
    if degree > 0:
        k = math.sqrt(3 / (4 * math.pi))
        out += [-k * y, k * z, -k * x]
    if degree > 1:
        k = math.sqrt(15 / math.pi)
        out += [k / 2 * x * y, -k / 2 * y * z, math.sqrt(5 / math.pi) / 4 * (3 * z**2 - 1)]
        out += [-k / 2 * x * z, k / 4 * (x**2 - y**2)]
    if degree > 2:
        far, near = math.sqrt(35 / (2 * math.pi)) / 4, math.sqrt(21 / (2 * math.pi)) / 4
        out += [-far * y * (3 * x**2 - y**2), math.sqrt(105 / math.pi) / 2 * x * y * z]
        out += [-near * y * (5 * z**2 - 1), math.sqrt(7 / math.pi) / 4 * z * (5 * z**2 - 3)]
        out += [-near * x * (5 * z**2 - 1), math.sqrt(105 / math.pi) / 4 * z * (x**2 - y**2)]
        out += [-far * x * (x**2 - 3 * y**2)]
    return torch.stack(out, dim=1)


def rotations(quaternions):
    """(n, 3, 3) matrices."""
    w, x, y, z = F.normalize(quaternions, dim=1).unbind(1)
    rows = [
        [1 - 2 * (y**2 + z**2), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x**2 + z**2), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x**2 + y**2)],
    ]
    return torch.stack([torch.stack(row, dim=1) for row in rows], dim=1)


def projected(table, pose, k, size, near):
    """Pixels (n, 2), covariances (n, 2, 2), depths (n,), and which are before the camera."""
    local = table[:, :3] @ pose[:, :3].T + pose[:, 3]
    z = local[:, 2]
    tilt = local[:, :2] / z[:, None]
    half = torch.tensor(size) / (2 * k[:2])
    low, high = -k[2:] / k[:2] - 0.3 * half, (torch.tensor(size) - k[2:]) / k[:2] + 0.3 * half
    held = torch.minimum(torch.maximum(tilt, low), high)
    jacobian = torch.zeros(len(table), 2, 3)
    jacobian[:, 0, 0], jacobian[:, 1, 1] = k[0] / z, k[1] / z
    jacobian[:, :, 2] = -k[:2] * held / z[:, None]
    turned = rotations(table[:, 6:10]) * table[:, 3:6].exp()[:, None]
    world = turned @ turned.transpose(1, 2)
    flat = jacobian @ pose[:, :3] @ world @ pose[:, :3].T @ jacobian.transpose(1, 2)
    return k[:2] * tilt + k[2:], flat + 0.3 * torch.eye(2), z, z >= near


def render(table, degree, factor, pose, k, size, near, background):
    """(3, h, w) image."""
    pixel, covariance, depth, before = projected(table, pose, k, size, near)
    center = -pose[:, :3].T @ pose[:, 3]
    values = harmonics(degree, F.normalize(table[:, :3] - center, dim=1))
    coefficients = table[:, 11:].reshape(len(table), -1, 3)[:, : values.shape[1]]
    color = (torch.einsum("nk,nkc->nc", values, coefficients) + 0.5).clamp(min=0)
    opacity = torch.sigmoid(table[:, 10]) * factor
    order = torch.argsort(torch.where(before, depth, torch.inf), stable=True)
    order = order[before[order]]
    x, y = torch.meshgrid(torch.arange(size[0]) + 0.5, torch.arange(size[1]) + 0.5, indexing="xy")
    light, image = torch.ones_like(x), torch.zeros(3, size[1], size[0])
    going = torch.ones_like(x, dtype=torch.bool)
    inverse = torch.linalg.inv(covariance)
    for i in order:
        d = torch.stack([x, y], dim=-1) - pixel[i]
        power = torch.einsum("hwi,ij,hwj->hw", d, inverse[i], d)
        alpha = (opacity[i] * torch.exp(-0.5 * power)).clamp(max=0.99)
        met = going & (alpha >= 1 / 255)
        after = light * (1 - alpha)
        going = going & ~(met & (after < 1e-4))
        met = met & going
        image = image + torch.where(met, alpha * light, 0.0) * color[i][:, None, None]
        light = torch.where(met, after, light)
    return image + light * background[:, None, None]


def ssim_map(image, truth):
    """(3, h, w) with the 11x11 Gaussian window of sigma 1.5 and zeros beyond the image."""
    line = torch.exp(-((torch.arange(11) - 5.0) ** 2) / (2 * 1.5**2))
    line = line / line.sum()
    window = (line[:, None] * line)[None, None]

    def smooth(maps):
        return F.conv2d(maps[:, None], window, padding=5)[:, 0]

    a, b = smooth(image), smooth(truth)
    va, vb = smooth(image**2) - a**2, smooth(truth**2) - b**2
    cov = smooth(image * truth) - a * b
    c1, c2 = 0.01**2, 0.03**2
    return (2 * a * b + c1) * (2 * cov + c2) / ((a**2 + b**2 + c1) * (va + vb + c2))


def loss(image, truth, mask=None):
    """0.8 L1 + 0.2 (1 - SSIM); outside a mask both are black."""
    if mask is not None:
        image, truth = image * mask, truth * mask
    gap = (image - truth).abs().mean()
    return 0.8 * gap + 0.2 * (1 - ssim_map(image, truth).mean())
