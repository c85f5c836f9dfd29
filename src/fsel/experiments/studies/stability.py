"""The table of hard cases."""

from __future__ import annotations

import logging
from dataclasses import asdict

import numpy as np
import pandas as pd

from fsel.core.files import File, write_text
from fsel.evaluation.latex import MISSING, plain_table, tex
from fsel.evaluation.summary import write_csv
from fsel.experiments.studies.hard_cases import Case, damage, observe, others, selection

logger = logging.getLogger(__name__)

_ALL = (*selection.CASES, *others.CASES, *damage.CASES)
CASES: dict[str, Case] = {case.name: case for case in _ALL}
"""Every hard case by name, in the order of the table."""


def stability(table: File, numbers: File) -> None:
    """Run every hard case and write what was expected, observed and allowed."""
    rows = []
    for case in CASES.values():
        finding = observe(case)
        row = {"case": case.name, "expected": case.expected, **asdict(finding)}
        rows.append(row | {"holds": finding.holds})
        logger.info("%s: %s, error %.2g", case.name, finding.observed, finding.error)
    result = pd.DataFrame(rows)
    write_csv(result, numbers, form="%.3g")
    cells, passed = [], int(result["holds"].sum())
    for row in result.itertuples():
        words = map(tex, (row.case, row.expected, row.observed))
        lost = MISSING if np.isnan(row.lost) else f"{row.lost:.1f}"
        cells.append([*words, f"{row.error:.1e}", f"{row.allowed:.0e}", lost])
    text = plain_table(
        ["Case", "Expected", "Observed", "Error", "Allowed", "Lost"],
        cells,
        caption=rf"\textbf{{Hard cases.}} {passed} of {len(result)} pass. Every case requires "
        "finite numbers and no warning; cases of cameras and columns also that every method "
        "returns at every budget, and that a reconstruction renders. Error: largest deviation from "
        "the float64 or exact answer, or dB behind; allowed: what rounding explains. Lost: dB "
        "of PSNR against the same selection without what makes the case hard.",
        label="tab:stability",
        columns=r"p{.17\linewidth}p{.24\linewidth}p{.35\linewidth}rrr",
    )
    write_text(text, table)
