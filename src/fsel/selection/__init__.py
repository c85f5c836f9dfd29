"""Requests: targets, camera paths, an object of interest, a number of frames."""
