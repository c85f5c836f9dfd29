"""Choose the frames of a posed capture that a novel-view reconstructor should be fed.

    import fsel

    capture = fsel.read_capture("captures/garden")
    chosen = fsel.select(capture, 30, targets="every:8")
    model = fsel.fit(capture, chosen.indices)
    model.export_ply("garden.ply")

`METHODS`, `LAYOUTS` and `RECONSTRUCTORS` are the registries. Everything is imported when first
used, so that `import fsel` costs nothing.
"""

from importlib import import_module

TYPE_CHECKING = False  # what `typing` has, which takes longer to import than all of this
if TYPE_CHECKING:  # the same names, for type checkers and editors
    from typing import Any

    from fsel.api import Selection, evaluate, fit, select
    from fsel.evaluation.methods import METHODS
    from fsel.ingest.examination import bad_frames
    from fsel.ingest.read import read_capture
    from fsel.layouts import LAYOUTS
    from fsel.reconstruct import RECONSTRUCTORS
    from fsel.request.budget import Auto
    from fsel.request.patience import Patience
    from fsel.request.refine import Refine

_HOMES = {
    "read_capture": "fsel.ingest.read",
    "bad_frames": "fsel.ingest.examination",
    "LAYOUTS": "fsel.layouts",
    "select": "fsel.api",
    "Selection": "fsel.api",
    "Auto": "fsel.request.budget",
    "Patience": "fsel.request.patience",
    "Refine": "fsel.request.refine",
    "fit": "fsel.api",
    "evaluate": "fsel.api",
    "METHODS": "fsel.evaluation.methods",
    "RECONSTRUCTORS": "fsel.reconstruct",
}

__all__ = [
    "LAYOUTS",
    "METHODS",
    "RECONSTRUCTORS",
    "Auto",
    "Patience",
    "Refine",
    "Selection",
    "bad_frames",
    "evaluate",
    "fit",
    "read_capture",
    "select",
]


def __getattr__(name: str) -> "Any":
    if name not in _HOMES:
        raise AttributeError(f"module 'fsel' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
