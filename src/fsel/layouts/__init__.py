"""Dataset layouts: how captures lie on disk, one file each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fsel.utils.registry import Registry

if TYPE_CHECKING:  # the names alone import nothing
    from fsel.layouts.contract import Layout

LAYOUTS: Registry[Layout] = Registry(
    "layout",
    {
        "scannetpp_dslr": "fsel.layouts.scannetpp:DSLR",
        "scannetpp_iphone": "fsel.layouts.scannetpp:IPHONE",
        "seven_scenes": "fsel.layouts.seven_scenes:LAYOUT",
        "scannet": "fsel.layouts.scannet:LAYOUT",
        "co3d": "fsel.layouts.co3d:LAYOUT",
        "dl3dv": "fsel.layouts.dl3dv:LAYOUT",
        "mipnerf360": "fsel.layouts.mipnerf360:LAYOUT",
        "tanks_and_temples": "fsel.layouts.tanks_and_temples:LAYOUT",
        "nerfstudio": "fsel.layouts.nerfstudio:LAYOUT",
        "colmap": "fsel.layouts.colmap:LAYOUT",
        "images": "fsel.layouts.bare:LAYOUT",
    },
    group="fsel.layouts",
    ahead=True,
)
"""By name, the most particular first: the order in which `auto` asks; other packages' before."""
