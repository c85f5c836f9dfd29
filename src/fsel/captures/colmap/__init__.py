"""COLMAP: its cameras, binary models, runs and undistortion."""
