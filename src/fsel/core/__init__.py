"""A capture, its parts and a selection problem, as arrays."""
