"""The other tables and figures, one file each; none is part of the budget sweep."""

from fsel.utils.registry import Registry
from fsel.workflow.tables import Table

TABLES: Registry[Table] = Registry(
    "table",
    {
        "handsign": "fsel.experiments.paper.handsign:TABLE",
        "stability": "fsel.experiments.studies.stability:TABLE",
        "swaps": "fsel.experiments.studies.swaps:TABLE",
    },
)
"""Every table by the name of its rule, in the order of the report."""
