"""Put what was trained into the package: `python tools/ship_weights.py FILE...`."""

import sys
from collections.abc import Iterable
from pathlib import Path

from fsel.selectors import pretrained


def ship(paths: Iterable[str | Path], folder: Path = pretrained.FOLDER) -> None:
    """Write scorers with their provenance.

    Args:
        paths: what the workflow made: scorers of `fsel.selectors.pretrained.FILES`, each of which
            takes the place of that of its policy.
        folder: of the package.

    Raises:
        ValueError: for a scorer that does not come with the package, or that
            `fsel.selectors.pretrained.own` refuses; then nothing is written.
    """
    scorers = {path: pretrained.own(path) for path in paths}
    for path, method in scorers.items():
        if method.name not in pretrained.FILES:
            allowed = ", ".join(pretrained.FILES)
            raise ValueError(f"{path}: policy {method.name!r} does not ship; these do: {allowed}")
    for method in scorers.values():
        method.scorer.save(folder / pretrained.FILES[method.name])


if __name__ == "__main__":
    ship(sys.argv[1:])
