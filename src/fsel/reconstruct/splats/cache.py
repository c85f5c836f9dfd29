"""Caches of a bounded size."""

from __future__ import annotations


def make_room(cache: dict, most: int) -> None:
    """Forget the oldest entry of a cache that holds `most`: dictionaries keep order."""
    if cache and len(cache) >= most:
        del cache[next(iter(cache))]
