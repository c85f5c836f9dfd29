"""The targets of a labelled scene at every coverage level, their proxies and the candidates."""

from __future__ import annotations

from collections.abc import Sequence

from fsel.core.capture import Capture
from fsel.core.files import File, repeated, stacked, write_table
from fsel.core.split import coverage_split


def split_labelled(
    folder: File, splits: File, *, coverages: Sequence[int], seed: int, config: str
) -> None:
    """Draw the targets of a scene that will be labelled at each of the coverages, in per cent.

    See the paper's Appendix A.2. `splits` receives `fsel.core.split.Split.table`, with the
    coverage.
    """
    capture = Capture.load(folder)
    parts = []
    for coverage in coverages:
        table = coverage_split(capture, coverage, seed).table(capture.names)
        parts.append(table | repeated({"coverage": coverage}, len(table["frame"])))
    write_table(stacked(parts), splits, units={"coverage": "percent"}, config=config)
