"""Hard cases: small inputs on which careless arithmetic fails, and what their answers are.

They ask for exact answers, not for a mean over scenes, so that no trials are made of them. The
tests and `results/tables/stability.csv` run the same ones.
"""

from fsel.experiments.studies.hard_cases.case import Case, Finding, observe, strict
from fsel.experiments.studies.hard_cases.images import CASES as IMAGES
from fsel.experiments.studies.hard_cases.learning import CASES as LEARNING
from fsel.experiments.studies.hard_cases.scenes import CASES as SCENES
from fsel.experiments.studies.hard_cases.selection import CASES as SELECTION

CASES: dict[str, Case] = {case.name: case for case in (*SELECTION, *IMAGES, *LEARNING, *SCENES)}
"""Every hard case by name, in the order of the table."""

__all__ = ["CASES", "Case", "Finding", "observe", "strict"]
