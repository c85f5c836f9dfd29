"""Selection methods without training: one file each, one contract (see `fsel.problem`)."""

from fsel.baselines import (
    all_frames,
    cover,
    dpp,
    facility_location,
    fisher_rf,
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

PAPER: dict[str, Method] = {
    module.METHOD.name: module.METHOD
    for module in (
        *(random_, uniform, fvs, nerf_director, mvsnet, dpp, kmedoids),
        *(fisher_rf, cover, untrained),
    )
}
"""The paper's baselines, in the order of the tables."""

FURTHER: dict[str, Method] = {
    module.METHOD.name: module.METHOD
    for module in (*(nearest, sharpest, long_lrm, indoor_traj, facility_location, mvsnet_location),)
}
"""What else a user would reach for, in the order of the tables."""

METHODS: dict[str, Method] = {**PAPER, **FURTHER, all_frames.METHOD.name: all_frames.METHOD}
