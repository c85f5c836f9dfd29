"""The table of hard cases."""

from __future__ import annotations

import logging
from dataclasses import asdict

import pandas as pd

from fsel.core.files import File, write_text
from fsel.evaluation.latex import plain_table, tex
from fsel.evaluation.summary import write_csv
from fsel.experiments.studies.hard_cases import Case, observe, others, selection

logger = logging.getLogger(__name__)

CASES: dict[str, Case] = {case.name: case for case in (*selection.CASES, *others.CASES)}
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
        cells.append([*words, f"{row.error:.1e}", f"{row.allowed:.0e}"])
    text = plain_table(
        ["Case", "Expected", "Observed", "Error", "Allowed"],
        cells,
        caption=rf"\textbf{{Hard cases.}} {passed} of {len(result)} pass. Every case requires "
        "finite numbers and no warning; cases of cameras and columns also that every method "
        "returns at every budget, and that a reconstruction renders. Error: largest deviation from "
        "the float64 or exact answer; allowed: what rounding explains.",
        label="tab:stability",
        columns=r"p{.17\linewidth}p{.24\linewidth}p{.35\linewidth}rr",
    )
    write_text(text, table)
