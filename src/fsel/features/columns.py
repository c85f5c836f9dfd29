"""Names and positions of a scorer's inputs (paper, section 3.2 and Appendix A.1)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

RELATIONAL = (
    *("d_min_o", "d_mean_o", "d_p25_o", "gamma_min_o", "gamma_mean_o"),
    *("rho_max_o", "rho_mean_o", "rho_std_o"),
    *("tau_tri", "alpha_mean", "b_perp", "b_par", "c_vis"),
)
SHARPNESS = "sharpness"
STATIC = (*RELATIONAL, SHARPNESS)
"""The features that no pick changes."""
CONDITIONED = ("d_min_s", "gamma_min_s", "rho_max_s", "phi_nov")
FEATURES = (*RELATIONAL, *CONDITIONED, SHARPNESS)
"""The paper's 18 features, in order."""
TARGET_GAIN = "target_gain"
NAMES = (*FEATURES, TARGET_GAIN)
"""The inputs in order. The last, `fsel`'s own, is zero in the paper's policies."""
INPUTS = len(NAMES)

APPEARANCE = ("rho_max_o", "rho_mean_o", "rho_std_o", "rho_max_s")


def positions(names: Iterable[str]) -> np.ndarray:
    """Return (m,) int64 where inputs lie among all."""
    return np.array([NAMES.index(name) for name in names], np.int64)


STATIC_INPUTS = positions(STATIC)
CONDITIONED_INPUTS = positions(CONDITIONED)
FOLLOWING_INPUTS = positions((*CONDITIONED, TARGET_GAIN))
"""Those that follow the selection: what the greedy loop computes at every step."""
TARGET_GAIN_INPUT = NAMES.index(TARGET_GAIN)

FOLLOWING = len(FOLLOWING_INPUTS)
D_MIN_S, GAMMA_MIN_S, RHO_MAX_S, PHI_NOV, GAIN = range(FOLLOWING)
"""Columns of those that follow the selection."""
SPREAD = (D_MIN_S, GAMMA_MIN_S, PHI_NOV)
"""Columns of distances to the picks: between centres, axes and bearings."""
