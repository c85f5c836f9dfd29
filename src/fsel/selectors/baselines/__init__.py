"""Selection methods without training, by one contract (see `fsel.core.problem`)."""

from fsel.core.problem import Method
from fsel.core.registry import Registry

PAPER: Registry[Method] = Registry(
    "method",
    {
        "random": "fsel.selectors.baselines.simple:RANDOM",
        "uniform": "fsel.selectors.baselines.simple:UNIFORM",
        "fvs": "fsel.selectors.baselines.fvs:METHOD",
        "nerf_director": "fsel.selectors.baselines.nerf_director:METHOD",
        "mvsnet": "fsel.selectors.baselines.mvsnet:METHOD",
        "dpp": "fsel.selectors.baselines.dpp:METHOD",
        "kmedoids": "fsel.selectors.baselines.kmedoids:METHOD",
        "fisher_rf": "fsel.selectors.baselines.fisher_rf:METHOD",
        "cover": "fsel.selectors.baselines.cover:METHOD",
        "untrained": "fsel.selectors.baselines.untrained:METHOD",
    },
)
"""The paper's baselines, in the order of the tables."""

FURTHER: Registry[Method] = Registry(
    "method",
    {
        "nearest": "fsel.selectors.baselines.nearest:METHOD",
        "sharpest": "fsel.selectors.baselines.simple:SHARPEST",
        "long_lrm": "fsel.selectors.baselines.long_lrm:METHOD",
        "indoor_traj": "fsel.selectors.baselines.indoor_traj:METHOD",
        "facility": "fsel.selectors.baselines.facility_location:METHOD",
        "mvsnet_location": "fsel.selectors.baselines.mvsnet:LOCATION",
    },
)
"""Further methods, in the order of the tables."""

WITHOUT_POSES = (
    *("best_n", "lichtfeld", "alicevision", "thumbnail", "correlation", "drift"),
    "farthest_appearance",
)
_HOMES = {n: f"fsel.selectors.baselines.before_poses:{n.upper()}" for n in WITHOUT_POSES}
_HOMES["warp_rf"] = "fsel.selectors.baselines.warp_rf:METHOD"
PRACTICE: Registry[Method] = Registry("method", _HOMES)
"""What tools do before poses are known, and WarpRF; in the workflow's tables by `practice`."""

HOMES = {**PAPER.homes, **FURTHER.homes, "all": "fsel.selectors.baselines.simple:ALL"}
GROUP = "fsel.selectors.baselines"  # of entry points
METHODS: Registry[Method] = Registry("method", HOMES, group=GROUP)
