"""Choose the frames of a posed capture that a novel-view reconstructor should be fed.

    import fsel

    capture = fsel.read_capture("captures/garden")
    chosen = fsel.select(capture, 30, targets="every:8")
    model = fsel.reconstruct(capture, chosen.indices)
    model.export_ply("garden.ply")

`METHODS`, `LAYOUTS` and `RECONSTRUCTORS` are the registries. Everything is imported when first
used, so that `import fsel` costs nothing.
"""

from importlib import import_module

_HOMES = {
    "read_capture": "fsel.layouts",
    "LAYOUTS": "fsel.layouts",
    "select": "fsel.api",
    "Selection": "fsel.api",
    "Auto": "fsel.request.budget",
    "evaluate": "fsel.api",
    "METHODS": "fsel.methods",
    "RECONSTRUCTORS": "fsel.reconstruct",
}

__all__ = [*_HOMES, "reconstruct"]


def __getattr__(name: str):
    if name == "reconstruct":
        return import_module("fsel.reconstruct")
    if name not in _HOMES:
        raise AttributeError(f"module 'fsel' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
