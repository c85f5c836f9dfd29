"""Metrics of `fsel compare` and `fsel render`, how they are printed, and what the pictures are
called."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence

from fsel.metrics import METRICS, REGISTERED, Metrics, checked

WIDTH = 6  # letters of a column


def metrics_of(args: argparse.Namespace) -> Metrics:
    """The metrics that a command line asks for, once each is known to work.

    Raises:
        ValueError, FileNotFoundError, ImportError: see `fsel.metrics.checked`; or for a backbone
            without weights.
    """
    if args.lpips_weights is None:
        if args.lpips_net is not None:
            raise ValueError(
                f"--lpips-net is {args.lpips_net} without --lpips-weights, the file of its weights"
            )
        return METRICS
    lpips = {"net": args.lpips_net or "vgg", "weights": str(args.lpips_weights)}
    return checked({"psnr": {}, "ssim": {}, "lpips": lpips})


def heading(metrics: Metrics) -> str:
    """The columns' titles: PSNR is in dB; of GMSD and LPIPS less is better."""
    return "  ".join(f"{REGISTERED[name].label:>{WIDTH}}" for name in metrics)


def columns(row: Mapping, metrics: Metrics) -> str:
    """A row's values below `heading`."""
    return "  ".join(f"{row[name]:{WIDTH}.{2 if name == 'psnr' else 4}f}" for name in metrics)


def file_names(names: Sequence[str]) -> list[str]:
    """A name for a file of each frame, no two equal: folders become a part of the name.

    Where that makes two names equal (`a/b` and `a_b`, or `B` and `b` where case does not count),
    each name is followed by its number.
    """
    flat = [name.replace("/", "_") for name in names]
    if len({name.casefold() for name in flat}) == len(flat):
        return flat
    return [f"{name}_{at:04d}" for at, name in enumerate(flat)]
