"""A memory of evaluations on disk, so that a killed job continues instead of starting again."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Self

import numpy as np

logger = logging.getLogger(__name__)

PROGRESS = 100  # evaluations between two progress lines


class Journal:
    """An append-only file of evaluations: one JSON line each, written as soon as it is known.

    Searches are deterministic: a job that starts again asks for the same subsets and is answered
    from here. A line that a kill cut short is dropped; several processes may append at once.

    Args:
        output: the job's output; the journal lies beside it.
        key: fingerprint of everything the evaluations depend on; another key, another journal.
    """

    def __init__(self, output: str | Path, key: str) -> None:
        output = Path(output)
        self.name = output.name
        self.path = output.with_name(f".{self.name}.{key}.journal")
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._known: dict[str, list[float]] = {}
        if self.path.exists():
            self._read()
        self.fresh = 0

    def _read(self) -> None:
        for line in self.path.read_text().splitlines():
            try:
                key, values = json.loads(line)
            except ValueError:
                logger.info("%s: dropping a line that was cut short", self.path.name)
                continue
            self._known[key] = values
        logger.info("%s: continuing after %d evaluations", self.path.name, len(self._known))

    def __enter__(self) -> Self:
        for other in self.path.parent.glob(f".{self.name}.*.journal"):
            if other != self.path:
                other.unlink()
        self._file = self.path.open("a", encoding="utf-8")
        # a line of its own, should the last writer have been cut off within one
        self._file.write("\n" if self._known else "")
        return self

    def __exit__(self, kind, *_) -> None:
        self._file.close()
        if kind is None:
            self.path.unlink(missing_ok=True)

    def remember(
        self, label: Hashable, evaluate: Callable[[np.ndarray], np.ndarray]
    ) -> Callable[[np.ndarray], np.ndarray]:
        """Give `evaluate`, (K,) ascending frames -> metrics, a memory under a label of its own."""

        def remembered(subset: np.ndarray) -> np.ndarray:
            key = f"{label}:{','.join(map(str, subset.tolist()))}"
            if key not in self._known:
                self._known[key] = np.asarray(evaluate(subset), float).tolist()
                self._file.write(json.dumps([key, self._known[key]]) + "\n")
                self._file.flush()
                self.fresh += 1
                if self.fresh % PROGRESS == 0:
                    known = len(self._known)
                    logger.info("%s: %d evaluations, %d of them now", label, known, self.fresh)
            return np.array(self._known[key])

        return remembered
