"""Splats from multi-view stereo on the CPU: the default reconstructor."""

from fsel.reconstruct.splats.reconstructor import SplatModel, Splats, SplatSettings

__all__ = ["SplatModel", "SplatSettings", "Splats"]
