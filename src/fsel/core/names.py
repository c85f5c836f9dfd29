"""Names of frames: their natural order, which of two lists are the same, and seeds from them."""

from __future__ import annotations

import itertools
import re
import zlib
from pathlib import Path


def matched(names: list[str], others: list[str]) -> dict[str, int]:
    """Return other name -> index into `names` by whole names, else file names, else stems: the
    first by which no two are alike."""
    for key in (str, lambda name: Path(name).name, lambda name: Path(name).stem):
        rows = {key(name): i for i, name in enumerate(names)}
        pairs = {other: rows[key(other)] for other in others if key(other) in rows}
        if pairs and len(rows) == len(names) and len(set(pairs.values())) == len(pairs):
            return pairs
    return {}


def distinct(names: list[str]) -> list[str]:
    """Number names that come again: `walk`, `walk-2`."""
    found: list[str] = []
    for name in names:
        numbered = (f"{name}-{n}" for n in itertools.count(2))
        found.append(name if name not in found else next(n for n in numbered if n not in found))
    return found


def natural(name: str) -> list[tuple[int, str]]:
    """Sort key: digit runs compare as numbers."""
    return [(int(p), "") if p.isdecimal() else (-1, p) for p in re.split(r"(\d+)", name) if p]


def check_utf8(path: object) -> None:
    """Refuse a path with a byte that is not UTF-8, which neither COLMAP nor JSON takes."""
    if re.search("[\ud800-\udfff]", str(path)):  # what stands for such a byte
        raise ValueError(f"{str(path)!r}: its name is not UTF-8. Hint: rename it")


def name_seed(*parts: object) -> int:
    """Return a seed made from names and numbers, the same on every machine."""
    return zlib.crc32("/".join(map(str, parts)).encode())
