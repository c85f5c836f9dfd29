"""Choose the frames of a posed capture that a novel-view reconstructor should be fed.

    import fsel

    chosen = fsel.select("captures/garden", 30, targets="every:8")
    chosen.export("garden30")

    capture = fsel.read_capture("captures/garden", long_side=256)
    model = fsel.fit(capture, chosen.names, "gaussians")
    print(fsel.evaluate(capture, model, chosen.held_out)["psnr"].mean())
    model.export_ply("garden.ply")

`select` picks frames, `fit` reconstructs from them, `evaluate` compares renderings with frames that
were held out. `set_threads` sets how many threads work, all cores by default. `METHODS`, `LAYOUTS`,
`METRICS` and `RECONSTRUCTORS` are the registries. Everything is imported when first used, so that
`import fsel` costs nothing.
"""

from importlib import import_module

TYPE_CHECKING = False  # what `typing` has, which takes longer to import than all of this
if TYPE_CHECKING:  # the same names, for type checkers and editors
    from typing import Any

    from fsel.captures.layouts import LAYOUTS
    from fsel.captures.quality.examination import bad_frames
    from fsel.captures.read import read_capture
    from fsel.core.capture import Capture, Views
    from fsel.core.limits import set_threads
    from fsel.evaluation.methods import METHODS
    from fsel.metrics import REGISTERED as METRICS
    from fsel.reconstruct import RECONSTRUCTORS
    from fsel.selection.api import evaluate, fit, how_many, select
    from fsel.selection.budget import Auto
    from fsel.selection.outcome import Selection
    from fsel.selection.validation import TimeBudget

_HOMES = {
    "read_capture": "fsel.captures.read",
    "Capture": "fsel.core.capture",
    "Views": "fsel.core.capture",
    "bad_frames": "fsel.captures.quality.examination",
    "LAYOUTS": "fsel.captures.layouts",
    "select": "fsel.selection.api",
    "Selection": "fsel.selection.outcome",
    "Auto": "fsel.selection.budget",
    "TimeBudget": "fsel.selection.validation",
    "fit": "fsel.selection.api",
    "how_many": "fsel.selection.api",
    "evaluate": "fsel.selection.api",
    "set_threads": "fsel.core.limits",
    "METHODS": "fsel.evaluation.methods",
    "METRICS": "fsel.metrics",
    "RECONSTRUCTORS": "fsel.reconstruct",
}
_CALLED = {"METRICS": "REGISTERED"}  # at home

__all__ = [
    "LAYOUTS",
    "METHODS",
    "METRICS",
    "RECONSTRUCTORS",
    "Auto",
    "Capture",
    "Selection",
    "TimeBudget",
    "Views",
    "bad_frames",
    "evaluate",
    "fit",
    "how_many",
    "read_capture",
    "select",
    "set_threads",
]


def __getattr__(name: str) -> "Any":
    if name == "__version__":
        from importlib.metadata import version

        return version("fsel")
    if name not in _HOMES:
        raise AttributeError(f"module 'fsel' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), _CALLED.get(name, name))


def __dir__() -> "list[str]":
    return [*__all__, "__version__"]
