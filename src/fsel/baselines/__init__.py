"""Selection methods without training: one file each, one contract (see `fsel.data.problem`)."""

from fsel.data.problem import Method
from fsel.utils.registry import Registry

PAPER: Registry[Method] = Registry(
    "method",
    {
        "random": "fsel.baselines.random_:METHOD",
        "uniform": "fsel.baselines.uniform:METHOD",
        "fvs": "fsel.baselines.fvs:METHOD",
        "nerf_director": "fsel.baselines.nerf_director:METHOD",
        "mvsnet": "fsel.baselines.mvsnet:METHOD",
        "dpp": "fsel.baselines.dpp:METHOD",
        "kmedoids": "fsel.baselines.kmedoids:METHOD",
        "fisher_rf": "fsel.baselines.fisher_rf:METHOD",
        "cover": "fsel.baselines.cover:METHOD",
        "untrained": "fsel.baselines.untrained:METHOD",
    },
)
"""The paper's baselines, in the order of the tables."""

FURTHER: Registry[Method] = Registry(
    "method",
    {
        "nearest": "fsel.baselines.nearest:METHOD",
        "sharpest": "fsel.baselines.sharpest:METHOD",
        "long_lrm": "fsel.baselines.long_lrm:METHOD",
        "indoor_traj": "fsel.baselines.indoor_traj:METHOD",
        "facility": "fsel.baselines.facility_location:METHOD",
        "mvsnet_location": "fsel.baselines.mvsnet_location:METHOD",
    },
)
"""Further methods, in the order of the tables."""

HOMES = {**PAPER.homes, **FURTHER.homes, "all": "fsel.baselines.all_frames:METHOD"}
GROUP = "fsel.baselines"  # of entry points
METHODS: Registry[Method] = Registry("method", HOMES, group=GROUP)

LATER: Registry[Method] = Registry(
    "method",
    {
        "indoor_traj_dpp": "fsel.baselines.indoor_traj_dpp:METHOD",
        "fisher_rf_gaussians": "fsel.baselines.on_gaussians:FISHER_RF",
        "cover_gaussians": "fsel.baselines.on_gaussians:COVER",
        "avs": "fsel.baselines.avs:METHOD",
    },
)
"""Methods that `fsel compare` and `fsel select` know, and the workflow's tables leave out."""
