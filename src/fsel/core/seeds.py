"""Seeds that are made from names."""

from __future__ import annotations

import zlib


def name_seed(*parts: object) -> int:
    """A seed from names and numbers, the same on every machine."""
    return zlib.crc32("/".join(map(str, parts)).encode())
