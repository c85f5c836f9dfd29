"""Number of frames that a trainer can take in a memory, by what each is published to need.

A trainer needs a fixed part, so much a frame, so much a pixel of each frame, and so much a
Gaussian. The numbers of Gaussians a frame are the most that was seen, so that what is allowed fits.
docs/reconstructors.md has the table with its sources. What `splats` needs is counted.
"""

from __future__ import annotations

from dataclasses import dataclass

LEAST = 2  # frames that a reconstruction needs
SPLATS = "splats"
CARD = 0.9  # share of a GPU's memory that is filled; the rest is for its driver, context and gaps


@dataclass(frozen=True)
class Need:
    """Bytes that a trainer needs at its peak.

    Attributes:
        fixed: whatever the frames.
        frame: for each frame.
        pixel: for each pixel of each frame.
        gaussians: for each frame, at most.
        gaussian: bytes for each of those.
        share: of the memory that may be filled.
    """

    fixed: float = 0
    frame: float = 0
    pixel: float = 0
    gaussians: int = 0
    gaussian: float = 0
    share: float = CARD

    def of(self, frames: int, size: tuple[int, int]) -> float:
        """Bytes of memory that so many frames of (width, height) pixels ask for."""
        return (self.fixed + frames * self.each(size)) / self.share

    def each(self, size: tuple[int, int]) -> float:
        """Bytes for one frame more."""
        width, height = size
        return self.frame + self.pixel * width * height + self.gaussians * self.gaussian


TRAINERS = {
    # gsplat's documentation, "Evaluation": a line through the peaks of seven scenes of Mip-NeRF 360
    # (1.2 to 6.3 million Gaussians) misses them by 0.06 GB at most; most Gaussians a frame: stump
    "gsplat": Need(fixed=0.22e9, gaussians=45_000, gaussian=1776),
    # the same; its images lie on the GPU as bytes (nerfstudio 1.1.5, method_configs.py)
    "splatfacto": Need(fixed=0.22e9, pixel=3, gaussians=45_000, gaussian=1776),
    # NerfBaselines' results: 3,796 MiB with 109 frames of stump, 3,980 MiB with 272 of room
    "nerfacto": Need(fixed=3.86e9, frame=1.2e6),
    # the paper: 4.6 GB at K = 30, 5.9 at 40, 17.8 at 130; its size of images is not stated
    "long-lrm": Need(fixed=0.65e9, frame=0.132e9),
}
NEEDS = {SPLATS: Need(pixel=32, share=1)} | TRAINERS  # position, opacity, depth, colour in float32


def within(memory: float, size: tuple[int, int], trainer: str = SPLATS) -> int:
    """The largest number of frames that fit.

    Args:
        memory: bytes.
        size: (width, height) of the images that are reconstructed from.
        trainer: a key of `NEEDS`.

    Raises:
        ValueError: for an unknown trainer, or when not even two frames fit.
    """
    if trainer not in NEEDS:
        raise ValueError(f"trainer is {trainer!r}; allowed: {', '.join(NEEDS)}")
    need = NEEDS[trainer]
    least = need.of(LEAST, size)
    if memory < least:
        what = f"the splats of {LEAST} frames" if trainer == SPLATS else f"{trainer} of {LEAST}"
        raise ValueError(
            f"memory is {memory} bytes; allowed: {least:.0f} or more, which {what} of "
            f"{size[0]}x{size[1]} may take, and fewer cannot be reconstructed. Hint: allow more"
            + (", or reconstruct from smaller images" if need.pixel else "")
        )
    return int((memory * need.share - need.fixed) // need.each(size))
