"""Frame health: what makes a frame bad for a reconstruction, from arrays alone."""

from fsel.health.duplicates import duplicates

__all__ = ["duplicates"]
