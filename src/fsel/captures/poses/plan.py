"""How long finding poses takes, said before it begins."""

from __future__ import annotations

from fsel.captures.colmap.runs import EXHAUSTIVE, FEW
from fsel.core.wording import counted

EACH, PAIR = (0.2, 1.0), (0.02, 0.05)  # seconds of a core: fixed, and for a megapixel
MAPPING = 0.6  # seconds a frame and megapixel, placed twice
BESIDE = 22  # pairs of a frame: 10 next ones, some far ahead, 8 that look alike
READ, KEPT = 8.0, 3.0  # megapixels: COLMAP reduces larger images, and keeps 8192 features


def plan(frames: int, pixels: int, *, ordered: bool, cores: int) -> str:
    """Return the frames and pairs of a run of COLMAP with SIFT, and about how long it takes."""
    every = frames <= (FEW if ordered else EXHAUSTIVE)
    pairs = frames * (frames - 1) // 2 if every else frames * BESIDE
    size = min(pixels / 1e6, READ)
    kept = min(size, KEPT)
    each = EACH[0] + EACH[1] * size + MAPPING * kept
    minutes = (frames * each + pairs * (PAIR[0] + PAIR[1] * kept)) / cores / 60
    about = f"about {counted(round(minutes), 'minute')}" if minutes >= 1 else "less than a minute"
    return f"{counted(frames, 'frame')}, {pairs:,} pairs: {about} on {counted(cores, 'core')}"
