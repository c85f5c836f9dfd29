"""The library's face: select frames, fit a reconstruction to them, evaluate it."""

from fsel.selection.cover import check_cover, served
from fsel.selection.problem import as_read, described, measured
from fsel.selection.reconstruction import evaluate, fit
from fsel.selection.request import (
    ALL_FRAMES,
    AUTO,
    LEAST_FRAMES,
    checked_request,
    method_of,
    number_of,
    patience_of,
    stated_beside,
    without_bad,
)
from fsel.selection.select import Selection, select

__all__ = [
    "ALL_FRAMES",
    "AUTO",
    "LEAST_FRAMES",
    "Selection",
    "as_read",
    "check_cover",
    "checked_request",
    "described",
    "evaluate",
    "fit",
    "measured",
    "method_of",
    "number_of",
    "patience_of",
    "select",
    "served",
    "stated_beside",
    "without_bad",
]
