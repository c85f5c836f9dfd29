"""Train a policy's scorers from trajectories."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace

from fsel.core.files import File, Files, atomic, chosen, read_columns, write_table
from fsel.selectors.policies import KNOWN
from fsel.selectors.scorer import Linear, Network
from fsel.training import imitation

logger = logging.getLogger(__name__)


def train(
    folders: Files,
    splits: Files,
    features: Files,
    trajectories: File,
    weights: Files,
    logs: Files,
    *,
    scenes: Sequence[str],
    policy: str,
    epochs: int,
    learning_rate: float,
    from_sum: bool = False,
    config: str,
) -> None:
    """Train a policy by imitation (paper, section 3.5), once a seed: 0, 1, ...

    Args:
        splits, features: what `split_labelled` and `features` wrote of them, one a scene.
        weights: receive the scorers.
        logs: receive loss and agreement by epoch and split.
        policy: key of `fsel.selectors.policies.KNOWN`.
        from_sum: as of `fsel.training.imitation.train`.
    """
    places = dict(zip(scenes, zip(folders, splits, features, strict=True), strict=True))
    table = read_columns(trajectories)
    sets = [
        imitation.training_data(chosen(table, table["role"] == role), places, KNOWN[policy])
        for role in ("train", "validation")
    ]
    made = f"behaviour cloning of {len(sets[0])} searched subsets, {epochs} epochs"
    for seed, (path, log) in enumerate(zip(weights, logs, strict=True)):
        fitted, record = imitation.train(
            *sets, seed=seed, epochs=epochs, learning_rate=learning_rate, from_sum=from_sum
        )
        save_scorer(Network(fitted), policy, made, seed, config, path)
        write_table(record, log, units={"loss": "nats"}, config=config)
        losses = dict(zip(record["split"][-2:], record["loss"][-2:].round(4), strict=True))
        logger.info("%s, seed %d: %s; loss %s", policy, seed, made, losses)


def save_scorer(
    scorer: Linear | Network, policy: str, made_by: str, seed: int, config: str, path: File
) -> None:
    """Write a scorer with its provenance, whole or not at all."""
    provenance = {"policy": policy, "made by": made_by, "seed": str(seed), "config": config}
    with atomic(path) as temporary:
        replace(scorer, provenance=provenance).save(temporary)
