"""Ingestion of a folder on disk: it is read, checked, opened, and becomes a canonical capture."""
