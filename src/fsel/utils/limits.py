"""Bounds on what is read, for the readers and for the command line, which imports nothing heavy."""

MAX_ERROR = 0.02
"""Median reprojection or epipolar error, as a share of the images' longer side."""
MOST_PIXELS = 160_000_000
"""Of an image: a panorama of 16384 x 8192 fits, and the largest sensors."""
