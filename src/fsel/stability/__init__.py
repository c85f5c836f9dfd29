"""Hard cases: small inputs on which careless arithmetic fails, and what their answers are.

The tests and `results/tables/stability.csv` run the same ones.
"""

from fsel.stability.case import Case, Finding, observe, strict
from fsel.stability.images import CASES as IMAGES
from fsel.stability.learning import CASES as LEARNING
from fsel.stability.scenes import CASES as SCENES
from fsel.stability.selection import CASES as SELECTION

CASES: dict[str, Case] = {case.name: case for case in (*SELECTION, *IMAGES, *LEARNING, *SCENES)}
"""Every hard case by name, in the order of the table."""

__all__ = ["CASES", "Case", "Finding", "observe", "strict"]
