"""Frame health: what makes a frame bad for a reconstruction, from arrays alone."""

from fsel.ingest.health.duplicates import duplicates
from fsel.ingest.health.findings import Finding, Health

__all__ = ["Finding", "Health", "duplicates"]
