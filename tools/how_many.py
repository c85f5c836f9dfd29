"""Measure what fewer frames lose on real captures, and calibrate `-k auto` by it: `make how_many`.

One frame in eight of each capture is held out. Trained Gaussians (600 steps, whatever the number of
frames) are fitted to all others and to what the rule of `fsel select` picks of them. Rows that are
there are kept; then the record in the package, the page and its plot are written.
"""

import argparse
import json
import os
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import fsel
from fsel.core.files import write_text
from fsel.selection.budget import LOSS, QUANTILES, RECORD, HowMany, losses
from fsel.selectors.pretrained import FOLDER

HOME = Path(os.environ.get("FSEL_CAPTURES", "../shared/captures"))
EVERY, FIRST = 8, 3  # one frame in so many is held out, from this one on
FRAMES = (20, 45, 70, 8, 30, 12, 100)  # numbers of frames, in the order they are measured
SETTINGS: dict[str, Any] = {"steps": 600, "gaussians": 6000, "background": "mean"}
SIDE = 128  # pixels


def measure(file: Path) -> Iterator[dict[str, object]]:
    """Yield a row for every capture and number of frames that the file lacks; 0 stands for all."""
    known = set()
    if file.exists():
        known = {(row["capture"], row["k"]) for row in map(json.loads, file.open())}
    folders = sorted(path.parent for path in HOME.glob("*/sparse"))
    for k, folder in product((0, *FRAMES), folders):
        if (folder.name, k) in known:
            continue
        capture = fsel.read_capture(folder, long_side=SIDE)
        held = np.arange(FIRST, len(capture), EVERY)
        seen = np.setdiff1d(np.arange(len(capture)), held)
        if k >= len(seen):
            continue
        own, sharp = capture.subset(seen), np.zeros(len(seen))
        picks = fsel.select(own, k, patience=0, sharpness=sharp).indices if k else slice(None)
        started = time.process_time()
        model = fsel.fit(capture, seen[picks], "gaussians", **SETTINGS)
        seconds = round(time.process_time() - started, 2)
        psnr = round(float(fsel.evaluate(capture, model, held)["psnr"].mean()), 4)
        yield {"capture": folder.name, "n": len(seen), "k": k, "psnr": psnr, "seconds": seconds}


def lost(rows: pd.DataFrame) -> pd.DataFrame:
    """Return dB that K frames lose against all: a row each capture and its n, a column each K."""
    table = rows.pivot(index=["capture", "n"], columns="k", values="psnr")
    return table.drop(columns=0).rsub(table[0], axis=0)


def calibrated(table: pd.DataFrame) -> dict[str, Any]:
    """Return the record of captures' losses: quantiles of the rate a at each K.

    Beyond the last K that a capture has frames for, its rate there counts.
    """
    n = table.index.get_level_values("n").to_numpy(float)[:, None]
    frames = table.columns.to_numpy()
    rates = (table / (1 / np.sqrt(frames) - 1 / np.sqrt(n))).ffill(axis=1).to_numpy()
    found = {name: conformal(rates, share).round(3).tolist() for name, share in SHARES.items()}
    return {"frames": frames.tolist(), **found, "captures": len(table)}


def conformal(values: np.ndarray, share: float) -> np.ndarray:
    """Return (K,) the quantiles of (C, K) values that a next one stays below with a probability.

    The ceil(share (C + 1))-th smallest of C, or the largest; below a half, mirrored.
    """
    if share < 0.5:
        return -conformal(-values, 1 - share)
    at = min(int(np.ceil(share * (len(values) + 1) - 1e-9)), len(values))
    return np.sort(values, axis=0)[at - 1]
