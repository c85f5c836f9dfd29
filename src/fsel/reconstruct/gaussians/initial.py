"""Start of the optimisation: only what the selected frames give."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from fsel.core.capture import Capture
from fsel.reconstruct.gaussians.parameters import C0, COLOR, LOGIT, MEAN, SCALE, TURN, width_of
from fsel.reconstruct.selected import Frame
from fsel.reconstruct.splats import Splats

OPACITY = 0.5  # at the start (Kheradmand et al. 2024)
NEIGHBOURS = 3  # whose distances give a Gaussian its size (Kerbl et al. 2023)
STEREO_SIDE = 128  # pixels of the longer side at which stereo runs
SMALLEST = 1e-4  # standard deviation, where the neighbours are in the same place


def from_splats(capture: Capture) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n, 3) and colours (n, 3) in [0, 1] of the frames' splats."""
    small = capture.resized(STEREO_SIDE)
    model = Splats(small).fit(np.arange(len(small)))
    return model.positions, model.colors.astype(np.float64) / 255


def from_points(capture: Capture) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n, 3) and colours (n, 3) in [0, 1] of the sparse points, or refuse none."""
    if capture.points is None or not len(capture.points.xyz):
        raise ValueError(
            f"{capture.source}: no sparse point is seen by two of the {len(capture)} selected "
            "frames. Hint: initial: splats"
        )
    return capture.points.xyz, capture.points.rgb / 255


def table_of(
    xyz: np.ndarray, rgb: np.ndarray, frame: Frame, degree: int, budget: int, seed: int
) -> np.ndarray:
    """Return (min(n, budget), c) float32 round Gaussians, as large as the way to their neighbours.

    Args:
        xyz: (n, 3) world units.
        rgb: (n, 3) in [0, 1].
        frame: the normalised frame.
        degree: of the harmonics; all but the first start at zero.
        budget: of them are drawn where there are more.
        seed: of the draw.
    """
    if len(xyz) > budget:
        drawn = np.random.default_rng(seed).choice(len(xyz), budget, replace=False)
        drawn.sort()
        xyz, rgb = xyz[drawn], rgb[drawn]
    local = (xyz - frame.origin) / frame.unit
    table = np.zeros((len(xyz), width_of(degree)), np.float32)
    table[:, MEAN] = local
    spacing = np.full(len(local), 0.1)
    if len(local) > 1:  # root mean square distance to the nearest others
        gaps = cKDTree(local).query(local, min(NEIGHBOURS + 1, len(local)))[0][:, 1:]
        spacing = np.maximum(np.sqrt((gaps**2).mean(axis=1)), SMALLEST)
    table[:, SCALE] = np.log(spacing)[:, None]
    table[:, TURN.start] = 1
    table[:, LOGIT] = np.log(OPACITY / (1 - OPACITY))
    table[:, COLOR : COLOR + 3] = (rgb - 0.5) / C0
    return table
