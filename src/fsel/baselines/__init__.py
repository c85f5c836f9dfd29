"""Selection methods without training: one file each, one contract (see `fsel.problem`)."""

from fsel.baselines import (
    all_frames,
    dpp,
    facility_location,
    fvs,
    indoor_traj,
    kmedoids,
    long_lrm,
    mvsnet,
    mvsnet_location,
    nearest,
    nerf_director,
    random_,
    sharpest,
    uniform,
    untrained,
)
from fsel.problem import Method

METHODS: dict[str, Method] = {
    module.METHOD.name: module.METHOD
    for module in (
        *(random_, uniform, fvs, nerf_director, mvsnet, mvsnet_location, dpp, kmedoids),
        *(long_lrm, indoor_traj, sharpest, facility_location, nearest, untrained, all_frames),
    )
}
"""In the order of the tables: the paper's, then what a user would reach for."""
