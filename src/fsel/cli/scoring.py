"""Metrics of `fsel compare` and `fsel render`, and how they are printed."""

from __future__ import annotations

import argparse
from collections.abc import Mapping

from fsel.cli.console import Console
from fsel.core.files import cache
from fsel.metrics import METRICS, REGISTERED, Metrics, checked, published
from fsel.metrics.lpips import NET

WIDTH = 6  # letters of a column


def metrics_of(args: argparse.Namespace, console: Console) -> Metrics:
    """Return the metrics of a command line, with LPIPS's published weights fetched if need be."""
    named = tuple(args.metrics or METRICS)
    if "psnr" not in named:
        raise ValueError(f"--metrics are {','.join(named)}; psnr, used for ranking, is missing")
    if "lpips" in named and published.found(NET) is None:
        weights = cache() / published.file_of(NET)
        console.say("lpips", f"downloading the weights of {NET} once, to {weights}")
        published.fetch(NET, weights)
    return checked(named)


def heading(metrics: Metrics) -> str:
    """Return the columns' titles."""
    return "  ".join(f"{REGISTERED[name].label:>{WIDTH}}" for name in metrics)


def columns(row: Mapping, metrics: Metrics) -> str:
    """Return a row's values, to print below `heading`."""
    return "  ".join(f"{REGISTERED[name].printed(row[name]):>{WIDTH}}" for name in metrics)
