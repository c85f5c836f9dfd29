"""From a folder on disk to a canonical capture: read, check, open, find poses."""
