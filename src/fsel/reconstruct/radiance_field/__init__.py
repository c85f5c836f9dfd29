"""A radiance field on a sparse voxel grid, optimised on the CPU: the NeRF family.

Volume rendering as Mildenhall et al. 2020; a grid of density and of spherical harmonics of colour
with total variation, as Plenoxels (Fridovich-Keil et al. 2022); interpolation before activation,
coarse to fine, as DVGO (Sun et al. 2022); contracted space as Mip-NeRF 360 (Barron et al. 2022).
"""

from fsel.reconstruct.radiance_field.reconstructor import RadianceField, RadianceModel
from fsel.reconstruct.radiance_field.training import RadianceSettings

__all__ = ["RadianceField", "RadianceModel", "RadianceSettings"]
