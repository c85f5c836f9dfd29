"""Metrics of `fsel compare` and `fsel render`, how they are printed, and what the pictures are
called."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence

from fsel.cli.console import Console
from fsel.core.files import cache
from fsel.metrics import METRICS, REGISTERED, Metrics, checked, published
from fsel.metrics.lpips import NET

WIDTH = 6  # letters of a column
PERCEPTUAL = ("psnr", "ssim", "lpips")  # where a setting of LPIPS is given


def metrics_of(args: argparse.Namespace, console: Console) -> Metrics:
    """Return the metrics that a command line asks for, once each is known to work.

    LPIPS's published weights are fetched where they are not yet, into the user's cache.

    Raises:
        ValueError, FileNotFoundError, ImportError: see `fsel.metrics.checked`; or for metrics
            without `psnr`, which tables rank by.
        OSError: when the weights cannot be fetched.
    """
    own = args.lpips_net is not None or args.lpips_weights is not None
    named = tuple(args.metrics or (PERCEPTUAL if own else METRICS))
    if "psnr" not in named or len(set(named)) < len(named):
        raise ValueError(f"--metrics are {','.join(named)}; psnr is among them, and each is once")
    if "lpips" not in named:
        if own:
            raise ValueError("--lpips-net and --lpips-weights are settings of lpips in --metrics")
        return checked(named)
    net = args.lpips_net or NET
    weights = args.lpips_weights or published.found(net)
    if weights is None and net in published.PICKLES:
        weights = cache() / published.file_of(net)
        console.say("lpips", f"fetching the weights of {net}, once, to {weights}")
        published.fetch(net, weights)
    lpips = {"net": net, "weights": weights and str(weights)}
    return checked({name: lpips if name == "lpips" else {} for name in named})


def heading(metrics: Metrics) -> str:
    """Return the columns' titles."""
    return "  ".join(f"{REGISTERED[name].label:>{WIDTH}}" for name in metrics)


def columns(row: Mapping, metrics: Metrics) -> str:
    """Return a row's values, to print below `heading`."""
    return "  ".join(f"{REGISTERED[name].printed(row[name]):>{WIDTH}}" for name in metrics)


def file_names(names: Sequence[str]) -> list[str]:
    """Return a distinct file name for each frame; folders become a part of the name.

    Where that makes two names equal (`a/b` and `a_b`, or `B` and `b` where case does not count),
    each name is followed by its number.
    """
    flat = [name.replace("/", "_") for name in names]
    if len({name.casefold() for name in flat}) == len(flat):
        return flat
    return [f"{name}_{at:04d}" for at, name in enumerate(flat)]
