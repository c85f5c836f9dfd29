"""Bounds of a selection by the command line: number and size of frames, time for trials."""

from __future__ import annotations

import argparse

from fsel.captures.lazy import LazyCapture
from fsel.cli.select_options import UNTURNED
from fsel.core.geometry import upright
from fsel.core.problem import Method
from fsel.selection import api
from fsel.selection.budget import SPLATS, THRESHOLD, Auto
from fsel.selection.export import subset
from fsel.selection.focus import Focus
from fsel.selection.targets import Targets
from fsel.selection.validation import TimeBudget


def budget_of(args: argparse.Namespace, opened: LazyCapture) -> int | Auto | None:
    """Number of frames, or how it is to be chosen; None for as many as a cover takes."""
    if args.k != api.AUTO:
        return args.k
    camera = opened.raw.cameras[0]
    scale = (form_of(args, opened).long_side or opened.longest) / opened.longest
    return Auto(
        THRESHOLD if args.threshold is None else args.threshold,
        args.memory if args.vram is None else args.vram,
        (max(1, round(camera.width * scale)), max(1, round(camera.height * scale))),
        args.trainer or SPLATS,
    )


def check_budget(args: argparse.Namespace) -> None:
    """Refuse options of -k auto without it, and a GPU without the trainer that takes it."""
    bounds = (args.threshold, args.memory, args.vram)
    if args.k != api.AUTO and any(bound is not None for bound in bounds):
        raise ValueError(
            "--threshold, --memory and --vram go with -k auto alone, and k is "
            f"{args.k}. Hint: -k auto"
        )
    if (args.vram is None) != (args.trainer is None):
        raise ValueError("--vram and --trainer go together, as --vram 8GB --trainer gsplat")


def form_of(args: argparse.Namespace, opened: LazyCapture) -> subset.Form:
    """Form in which the subset is written."""
    side = args.long_side
    if args.downscale is not None:
        side = max(1, round(opened.longest / args.downscale))
    if side is not None and side >= opened.longest:
        side = None
    turn = None if args.up == UNTURNED else upright(opened.capture.world_to_camera)
    return subset.Form(
        args.link,
        side,
        args.points,
        matched=not args.geometry_only,
        shapes=args.masks,
        undistort=args.undistort,
        turn=turn,
    )


def patience_of(
    args: argparse.Namespace,
    k: int | Auto | None,
    targets: Targets,
    method: Method,
    focus: Focus | None,
) -> TimeBudget:
    """Time for trials of selections, which open images."""
    if args.geometry_only:
        if args.patience:
            raise ValueError(
                "--patience reconstructs from images, which --geometry-only leaves unopened"
            )
        return TimeBudget(0)
    named = not (args.method is None and args.weights is None)
    return api.patience_of(args.patience, k, targets, method, focus, args.cover, named=named)
