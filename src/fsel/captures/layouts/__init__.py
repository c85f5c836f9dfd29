"""Dataset layouts: how captures lie on disk, one file each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fsel.core.registry import Registry

if TYPE_CHECKING:  # the names alone import nothing
    from fsel.captures.layouts.contract import Layout

LAYOUTS: Registry[Layout] = Registry(
    "layout",
    {
        "scannetpp_dslr": "fsel.captures.layouts.scannetpp:DSLR",
        "scannetpp_iphone": "fsel.captures.layouts.scannetpp:IPHONE",
        "seven_scenes": "fsel.captures.layouts.seven_scenes:LAYOUT",
        "scannet": "fsel.captures.layouts.scannet:LAYOUT",
        "co3d": "fsel.captures.layouts.co3d:LAYOUT",
        "dl3dv": "fsel.captures.layouts.dl3dv:LAYOUT",
        "mipnerf360": "fsel.captures.layouts.mipnerf360:LAYOUT",
        "tanks_and_temples": "fsel.captures.layouts.tanks_and_temples:LAYOUT",
        "polycam": "fsel.captures.layouts.polycam:LAYOUT",
        "record3d": "fsel.captures.layouts.record3d:LAYOUT",
        "nerfstudio": "fsel.captures.layouts.nerfstudio:LAYOUT",
        "colmap": "fsel.captures.layouts.colmap:LAYOUT",
        "opensfm": "fsel.captures.layouts.opensfm:LAYOUT",
        "metashape": "fsel.captures.layouts.metashape:LAYOUT",
        "realityscan": "fsel.captures.layouts.realityscan:LAYOUT",
        "images": "fsel.captures.layouts.bare:LAYOUT",
    },
    group="fsel.captures.layouts",
    ahead=True,
)
"""By name, the most particular first: the order in which `auto` asks; other packages' before."""
