"""Frame health: what makes a frame bad for a reconstruction, from arrays alone."""

from fsel.captures.quality.findings import Finding, Health
from fsel.captures.quality.photometry import duplicates

__all__ = ["Finding", "Health", "duplicates"]
