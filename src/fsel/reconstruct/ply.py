"""The standard 3D Gaussian splatting `.ply` (Kerbl et al. 2023)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

FIELDS = (
    *("x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity"),
    *("scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"),
)
SH_CONSTANT = 0.28209479177387814  # of the degree-zero spherical harmonic


def write(
    path: str | Path, xyz: np.ndarray, rgb: np.ndarray, opacity: np.ndarray, scale: np.ndarray
) -> None:
    """Write isotropic Gaussians, binary little-endian.

    Args:
        path: file to write.
        xyz: (n, 3) positions, world units.
        rgb: (n, 3) in [0, 1].
        opacity: (n,) in (0, 1), stored as a logit.
        scale: (n,) standard deviation, world units, stored as a logarithm.
    """
    table = np.zeros((len(xyz), len(FIELDS)), "<f4")
    clipped = np.clip(opacity, 1e-4, 1 - 1e-4)
    table[:, :3] = xyz
    table[:, 6:9] = (rgb - 0.5) / SH_CONSTANT
    table[:, 9] = np.log(clipped / (1 - clipped))
    table[:, 10:13] = np.log(np.maximum(scale, 1e-12))[:, None]
    table[:, 13] = 1
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(xyz)}"]
    lines += [f"property float {field}" for field in FIELDS]
    header = "\n".join([*lines, "end_header", ""])
    Path(path).write_bytes(header.encode("ascii") + table.tobytes())
