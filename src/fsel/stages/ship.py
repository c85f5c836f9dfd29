"""Put what was trained into the package: `python -m fsel.stages.ship WEIGHTS BUDGET`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from fsel.files import write_text
from fsel.request import budget
from fsel.selector import pretrained
from fsel.selector.scorer import Scorer


def ship(weights: str | Path, record: str | Path, folder: Path = pretrained.FOLDER) -> None:
    """Write fsel.safetensors, fsel.json with its provenance and hash, and budget.json.

    Args:
        weights: a scorer of the policy `fsel`, as the workflow makes it.
        record: what the adaptive budget predicts by, fitted to that scorer's picks.
        folder: of the package.

    Raises:
        ValueError: for weights of another policy, or of another shape.
    """
    scorer = Scorer.load(weights)
    policy = scorer.provenance.get("policy")
    if policy != pretrained.POLICY.name:
        raise ValueError(
            f"{weights}: made for the policy {policy!r}, not {pretrained.POLICY.name!r}"
        )
    fitted = Path(record).read_text(encoding="utf-8")
    scorer.save(folder / pretrained.WEIGHTS)
    content = {
        "sha256": pretrained.digest(folder),
        "provenance": scorer.provenance,
        "remade by": "make weights",
    }
    write_text(json.dumps(content, indent=2) + "\n", folder / "fsel.json")
    write_text(fitted, folder / budget.RECORD)


if __name__ == "__main__":
    ship(*sys.argv[1:3])
