"""Put a trained scorer into the package: `python -m fsel.pipeline.ship WEIGHTS`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from fsel import shipped
from fsel.pipeline.files import write_text
from fsel.scorer import Scorer


def ship(weights: str | Path, folder: Path = shipped.FOLDER) -> None:
    """Write fsel.safetensors, and fsel.json with its provenance and hash.

    Args:
        weights: a scorer of the policy `fsel`, as the workflow makes it.
        folder: of the package.

    Raises:
        ValueError: for weights of another policy, or of another shape.
    """
    scorer = Scorer.load(weights)
    policy = scorer.provenance.get("policy")
    if policy != shipped.POLICY.name:
        raise ValueError(f"{weights}: made for the policy {policy!r}, not {shipped.POLICY.name!r}")
    scorer.save(folder / shipped.WEIGHTS)
    record = {
        "sha256": shipped.digest(folder),
        "provenance": scorer.provenance,
        "remade by": "make weights",
    }
    write_text(json.dumps(record, indent=2) + "\n", folder / "fsel.json")


if __name__ == "__main__":
    ship(sys.argv[1])
