"""Put what was refined into the package: `python -m fsel.stages.ship SCORER BUDGET`."""

from __future__ import annotations

import sys
from pathlib import Path

from fsel.files import write_text
from fsel.request import budget
from fsel.selector import pretrained
from fsel.selector.scorer import Scorer


def ship(path: str | Path, record: str | Path, folder: Path = pretrained.FOLDER) -> None:
    """Write fsel.json, coefficients with their provenance, and budget.json.

    Args:
        path: a scorer of the policy `fsel`, as the workflow makes it.
        record: what the adaptive budget predicts by, fitted to that scorer's picks.
        folder: of the package.

    Raises:
        ValueError: for a scorer of another policy, or of another kind.
    """
    scorer = Scorer.load(path)
    policy = scorer.provenance.get("policy")
    if policy != pretrained.POLICY.name:
        raise ValueError(f"{path}: made for the policy {policy!r}, not {pretrained.POLICY.name!r}")
    pretrained.POLICY.check(scorer)
    fitted = Path(record).read_text(encoding="utf-8")
    scorer.save(folder / pretrained.FILE)
    write_text(fitted, folder / budget.RECORD)


if __name__ == "__main__":
    ship(*sys.argv[1:3])
