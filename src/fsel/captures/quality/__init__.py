"""Frame health: what makes a frame bad for a reconstruction, from arrays alone."""

from fsel.captures.quality.duplicates import duplicates
from fsel.captures.quality.findings import Finding, Health

__all__ = ["Finding", "Health", "duplicates"]
