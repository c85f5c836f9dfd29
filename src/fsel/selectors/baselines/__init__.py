"""Selection methods without training, by one contract (see `fsel.core.problem`)."""

from fsel.core.problem import Method
from fsel.core.registry import Registry

PAPER: Registry[Method] = Registry(
    "method",
    {
        "random": "fsel.selectors.baselines.simple:RANDOM",
        "uniform": "fsel.selectors.baselines.simple:UNIFORM",
        "fvs": "fsel.selectors.baselines.by_pose:FVS",
        "nerf_director": "fsel.selectors.baselines.by_shared_points:NERF_DIRECTOR",
        "mvsnet": "fsel.selectors.baselines.by_shared_points:MVSNET",
        "dpp": "fsel.selectors.baselines.by_appearance:DPP",
        "kmedoids": "fsel.selectors.baselines.kmedoids:METHOD",
        "fisher_rf": "fsel.selectors.baselines.by_reconstruction:FISHER_RF",
        "cover": "fsel.selectors.baselines.by_reconstruction:COVER",
        "untrained": "fsel.selectors.policies:UNTRAINED",
    },
)
"""The paper's baselines, in the order of the tables."""

FURTHER: Registry[Method] = Registry(
    "method",
    {
        "nearest": "fsel.selectors.baselines.by_pose:NEAREST",
        "sharpest": "fsel.selectors.baselines.simple:SHARPEST",
        "long_lrm": "fsel.selectors.baselines.by_pose:LONG_LRM",
        "indoor_traj": "fsel.selectors.baselines.by_appearance:INDOOR_TRAJ",
        "facility": "fsel.selectors.baselines.by_appearance:FACILITY",
        "mvsnet_location": "fsel.selectors.baselines.by_shared_points:MVSNET_LOCATION",
    },
)
"""Further methods, in the order of the tables."""

WITHOUT_POSES = ("best_n", "alicevision", "thumbnail")
_HOMES = {n: f"fsel.selectors.baselines.before_poses:{n.upper()}" for n in WITHOUT_POSES}
_HOMES["warp_rf"] = "fsel.selectors.baselines.by_reconstruction:WARP_RF"
PRACTICE: Registry[Method] = Registry("method", _HOMES)
"""What tools do before poses are known, and WarpRF; in the workflow's tables by `practice`."""

HOMES = {**PAPER.homes, **FURTHER.homes, "all": "fsel.selectors.baselines.simple:ALL"}
GROUP = "fsel.selectors.baselines"  # of entry points
METHODS: Registry[Method] = Registry("method", HOMES, group=GROUP)
