"""Trained scorers on disk."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from fsel.core.files import atomic
from fsel.selectors.scorer import Linear, Network


def save_scorer(
    scorer: Linear | Network, policy: str, made_by: str, seed: int, config: str, path: str | Path
) -> None:
    """Write a scorer with its provenance, whole or not at all."""
    provenance = {"policy": policy, "made by": made_by, "seed": str(seed), "config": config}
    with atomic(path) as temporary:
        replace(scorer, provenance=provenance).save(temporary)
