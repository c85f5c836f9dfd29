"""The other tables and figures, one file each; none is part of the budget sweep."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fsel.core.registry import Registry

if TYPE_CHECKING:
    from fsel.workflow.tables import Table

TABLES: Registry[Table] = Registry(
    "table",
    {
        "handsign": "fsel.experiments.paper.learned:HANDSIGN",
        "seedvar": "fsel.experiments.paper.learned:SEEDVAR",
        "candidate_pools": "fsel.experiments.studies.candidate_pools:TABLE",
        "ga_vs_learned": "fsel.experiments.paper.ga_vs_learned:TABLE",
        "time_quality": "fsel.experiments.paper.time_quality:TABLE",
        "crosscapture": "fsel.experiments.paper.crosscapture:TABLE",
        "objectcentric": "fsel.experiments.paper.objectcentric:TABLE",
        "feature_sweep": "fsel.experiments.paper.ablation.tables:FEATURE_SWEEP",
        "scorer_arch": "fsel.experiments.paper.ablation.tables:SCORER_ARCH",
        "pose_sources": "fsel.experiments.paper.pose_sources:TABLE",
        "transfer": "fsel.experiments.paper.transfer:TABLE",
        "reconchoice": "fsel.experiments.paper.reconchoice:TABLE",
        "pipeline_figure": "fsel.experiments.paper.pipeline_figure:TABLE",
        "teaser": "fsel.experiments.paper.views:TEASER",
        "qualitative": "fsel.experiments.paper.views:QUALITATIVE",
        "real_world": "fsel.experiments.paper.views:REAL_WORLD",
        "selection_time": "fsel.experiments.studies.selection_time:TABLE",
        "speed_error": "fsel.experiments.studies.speed_error:TABLE",
        "economy": "fsel.experiments.studies.economy:TABLE",
        "stability": "fsel.experiments.studies.stability:TABLE",
    },
)
"""Every table by the name of its rule, in the order of the report."""
