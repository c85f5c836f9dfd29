"""Trained scorers on disk."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from fsel.files import atomic
from fsel.selector.scorer import Scorer


def save_scorer(
    arrays: Mapping[str, np.ndarray],
    policy: str,
    made_by: str,
    seed: int,
    config: str,
    path: str | Path,
) -> None:
    """Write a scorer with its provenance, whole or not at all."""
    provenance = {"policy": policy, "made by": made_by, "seed": str(seed), "config": config}
    with atomic(path) as temporary:
        Scorer(arrays, provenance).save(temporary)
