"""Bounds of a selection by the command line: number and size of frames, time for trials."""

from __future__ import annotations

import argparse

from fsel import api
from fsel.data.problem import Method
from fsel.export import subset
from fsel.ingest.lazy import LazyCapture
from fsel.request.budget import THRESHOLD, Auto
from fsel.request.focus import Focus
from fsel.request.memory import SPLATS
from fsel.request.patience import Patience
from fsel.request.refine import Refine
from fsel.request.targets import Targets


def budget_of(asked: argparse.Namespace, opened: LazyCapture) -> int | Auto | None:
    """Number of frames, or how it is to be chosen; None for as many as a cover takes."""
    if asked.k != api.AUTO:
        return asked.k
    camera = opened.raw.cameras[0]
    scale = (form_of(asked, opened).long_side or opened.longest) / opened.longest
    return Auto(
        THRESHOLD if asked.threshold is None else asked.threshold,
        asked.memory if asked.vram is None else asked.vram,
        (max(1, round(camera.width * scale)), max(1, round(camera.height * scale))),
        asked.trainer or SPLATS,
    )


def check_budget(asked: argparse.Namespace) -> None:
    """Refuse options of -k auto without it, and a GPU without the trainer that takes it."""
    bounds = (asked.threshold, asked.memory, asked.vram)
    if asked.k != api.AUTO and any(bound is not None for bound in bounds):
        raise ValueError(
            "--threshold, --memory and --vram go with -k auto alone, and k is "
            f"{asked.k}. Hint: -k auto"
        )
    if (asked.vram is None) != (asked.trainer is None):
        raise ValueError("--vram and --trainer go together, as --vram 8GB --trainer gsplat")


def form_of(asked: argparse.Namespace, opened: LazyCapture) -> subset.Form:
    """Form in which the subset is written."""
    side = asked.long_side
    if asked.downscale is not None:
        side = max(1, round(opened.longest / asked.downscale))
    if side is not None and side >= opened.longest:
        side = None
    return subset.Form(asked.link, side, asked.points, not asked.geometry_only, asked.masks)


def refine_of(asked: argparse.Namespace) -> Refine | None:
    """Limit of the swaps, and what scores them; None without `--refine`."""
    if asked.refine is None:
        if asked.reconstructor is not None:
            raise ValueError(
                f"--reconstructor is {asked.reconstructor}, which scores swaps alone. "
                "Hint: --refine 30s"
            )
        return None
    if asked.geometry_only:
        raise ValueError("--refine reconstructs from images, which --geometry-only leaves unopened")
    return Refine(asked.refine, reconstructor=asked.reconstructor or Refine.reconstructor)


def patience_of(
    asked: argparse.Namespace,
    k: int | Auto | None,
    targets: Targets,
    method: Method,
    focus: Focus | None,
) -> Patience:
    """Time for trials of selections, which open images."""
    if asked.geometry_only:
        if asked.patience:
            raise ValueError(
                "--patience reconstructs from images, which --geometry-only leaves unopened"
            )
        return Patience(0)
    named = _named(asked)
    return api.patience_of(asked.patience, k, targets, method, focus, asked.cover, named=named)


def k_center_of(
    asked: argparse.Namespace,
    k: int | Auto | None,
    targets: Targets,
    method: Method,
    focus: Focus | None,
) -> bool:
    """Whether no frame may be far from the picks: where the rule alone would choose unseen."""
    stated = _named(asked) or api.stated_beside(k, targets, method, focus, asked.cover)
    return asked.geometry_only and not stated


def _named(asked: argparse.Namespace) -> bool:
    """Whether the method is stated."""
    return not (asked.method is None and asked.weights is None)
