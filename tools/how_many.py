"""Measure what fewer frames lose on real captures, and calibrate `-k auto` by it: `make how_many`.

One frame in eight of each capture is held out. Trained Gaussians are fitted to all others and to
what the rule of `fsel select` picks of them, at 384 pixels with 600 steps whatever the number of
frames; at 128 pixels the same, to evenly spaced frames, and with as many steps a frame as all have.
Rows that are there are kept; then the record in the package is written, which the first of these
kinds calibrates, and what docs/results/how_many.md shows.
"""

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

import fsel
from fsel.core.capture import Capture
from fsel.core.files import write_text
from fsel.core.subsets import evenly
from fsel.evaluation.figures import COLORS, TEXT, name_axes, new_figure, save
from fsel.evaluation.summary import write_csv
from fsel.selection.budget import BOUND, LOSS, RECORD, SHARES, Record, enough, losses
from fsel.selectors.pretrained import FOLDER

HOME = Path(os.environ.get("FSEL_CAPTURES", "../shared/captures"))
EVERY, FIRST = 8, 3  # one frame in so many is held out, from this one on
FRAMES = (45, 70, 100, 20, 30, 12, 8)  # numbers of frames, in the order they are measured
STEPS = 600
GAUSSIANS = {384: 20_000, 128: 6000}  # by pixels of the longer side


class Kind(NamedTuple):
    """What is measured: pixels of the longer side, evenly spaced frames instead of the rule's, and
    steps in proportion to the frames."""

    side: int
    even: bool = False
    in_proportion: bool = False


LARGE, SMALL = "large", "small"
KINDS = {
    LARGE: Kind(384),
    SMALL: Kind(128),
    "even": Kind(128, even=True),
    "in_proportion": Kind(128, in_proportion=True),
}

Rule = Callable[[int], int]  # all frames -> frames kept


def measure(file: Path, kinds: Sequence[str] = tuple(KINDS)) -> Iterator[dict[str, object]]:
    """Yield a row for every kind, number of frames and capture that the file lacks; 0 stands for
    all frames, which the kinds of `SMALL` share."""
    known = set()
    if file.exists():
        lines = file.read_text(encoding="utf-8").splitlines()
        known = {(row["kind"], row["k"], row["capture"]) for row in map(json.loads, lines)}
    folders = sorted(path.parent for path in HOME.glob("*/sparse"))
    for name, k, folder in product(kinds, (0, *FRAMES), folders):
        if (name, k, folder.name) in known or (k == 0 and name not in (LARGE, SMALL)):
            continue
        kind = KINDS[name]
        capture = fsel.read_capture(folder, long_side=kind.side)
        held = np.arange(FIRST, len(capture), EVERY)
        seen = np.setdiff1d(np.arange(len(capture)), held)
        if k < len(seen):
            found = fitted(capture, seen, held, k, kind)
            yield {"kind": name, "k": k, "capture": folder.name, "n": len(seen), **found}


def fitted(
    capture: Capture, seen: np.ndarray, held: np.ndarray, k: int, kind: Kind
) -> dict[str, float]:
    """Return PSNR on the frames held out of a fit to k of those seen, and its seconds."""
    picks = evenly(len(seen), k or len(seen))
    if k and not kind.even:
        own, sharp = capture.subset(seen), np.zeros(len(seen))
        picks = fsel.select(own, k, patience=0, sharpness=sharp).indices
    steps = STEPS * len(picks) // len(seen) if kind.in_proportion else STEPS
    settings: dict[str, Any] = {"steps": steps, "gaussians": GAUSSIANS[kind.side]}
    started = time.process_time()
    model = fsel.fit(capture, seen[picks], "gaussians", background="mean", **settings)
    seconds = round(time.process_time() - started, 2)
    psnr = round(float(fsel.evaluate(capture, model, held)["psnr"].mean()), 4)
    return {"psnr": psnr, "seconds": seconds}


def lost(rows: pd.DataFrame, kind: str = LARGE) -> pd.DataFrame:
    """Return dB that K frames lose against all by a kind: a row each capture and its n, a column
    each K."""
    of_all = rows["k"].eq(0) & rows["kind"].eq(LARGE if kind == LARGE else SMALL)
    own = rows[of_all | (rows["kind"].eq(kind) & rows["k"].ne(0))]
    table = own.pivot(index=["capture", "n"], columns="k", values="psnr")
    return table.drop(columns=0).rsub(table[0], axis=0)


def by_kind(rows: pd.DataFrame) -> pd.DataFrame:
    """Return of each K the mean dB lost by the kinds that were measured with it, over the captures
    that all of them have."""
    tables, means = {kind: lost(rows, kind) for kind in KINDS}, []
    for k in sorted(FRAMES):
        own = pd.DataFrame({kind: table[k] for kind, table in tables.items() if k in table})
        own = own.dropna()
        means.append({"K": k, "captures": len(own), **own.mean()})
    return pd.DataFrame(means, columns=["K", "captures", *KINDS]).query("captures > 0")


def times(rows: pd.DataFrame) -> list[float]:
    """Return seconds of training with each K over those with all frames, medians over captures."""
    table = rows.pivot(index="capture", columns="k", values="seconds")
    ratios: list[float] = table.drop(columns=0).div(table[0], axis=0).median().round(2).tolist()
    return ratios


def calibrated(table: pd.DataFrame) -> Record:
    """Return what shares of the captures that have more than K frames lose with K; the bound is of
    all, of which others keep all frames and lose nothing."""
    bound = list(conformal(table.fillna(0).to_numpy(), SHARES[BOUND]))
    better = [(own.dropna() < 0).mean() for _, own in table.items()]
    n = table.index.get_level_values("n").tolist()
    found = quantiles(table) | {BOUND: bound, "better": better, "wide": [widened(table)]}
    found = {name: np.round(values, 2).tolist() for name, values in found.items()}
    return {"frames": table.columns.tolist(), **found, "total": [min(n), max(n)]}


def quantiles(table: pd.DataFrame) -> dict[str, list[np.ndarray]]:
    """Return by `SHARES` but for the bound, of each K, what captures of more frames lose."""
    known = [own.dropna().to_numpy() for _, own in table.items()]
    shares = {name: share for name, share in SHARES.items() if name != BOUND}
    return {name: [conformal(own, share) for own in known] for name, share in shares.items()}


def widened(table: pd.DataFrame) -> float:
    """Return how many times as wide intervals by the captures with the fewest frames, a half of
    them, have to be for nine in ten losses of the others, which have more."""
    order = np.argsort(table.index.get_level_values("n"), kind="stable")
    few, many = (table.iloc[part] for part in np.array_split(order, 2))
    few = few.loc[:, few.count() > 2]
    low, median, high = map(np.array, quantiles(few).values())
    off = many[few.columns].to_numpy() - median
    times = off / np.where(off > 0, high - median, low - median)
    times = times[np.isfinite(times)]
    return max(1.0, float(conformal(times, SHARES[BOUND]))) if len(times) else 1.0


def conformal(values: np.ndarray, share: float) -> np.ndarray:
    """Return what a further one of (C, ...) values stays below with a probability, (...): the
    ceil(share (C + 1))-th smallest, the largest if there are too few; below a half mirrored."""
    if share < 0.5:
        return -conformal(-values, 1 - share)
    at = min(int(np.ceil(share * (len(values) + 1) - 1e-9)), len(values))
    found: np.ndarray = np.sort(values, axis=0)[at - 1]
    return found


def at(loss: pd.Series, total: int, frames: float) -> float:
    """Return dB that a capture loses with so many frames, between the numbers measured."""
    known = loss.dropna()
    places = -1 / np.sqrt([*known.index, total])
    return float(np.interp(-1 / np.sqrt(min(frames, total)), places, [*known, 0.0]))


def auto(table: pd.DataFrame) -> Rule:
    """Return what `-k auto` keeps: one number of frames for all captures."""
    return partial(enough, calibrated(table), LOSS)


def one_share(table: pd.DataFrame) -> Rule:
    """Return the smallest share of the frames, in hundredths, with the guarantee of `-k auto`."""
    shares = np.arange(1, 101) / 100
    lost_at = [[at(row, n, np.ceil(x * n)) for x in shares] for (_, n), row in table.iterrows()]
    over = conformal(np.array(lost_at), SHARES[BOUND]) > LOSS
    return lambda total: int(np.ceil(total * shares[np.flatnonzero(over).max(initial=-1) + 1]))


def left_out(table: pd.DataFrame, rule: Callable[[pd.DataFrame], Rule]) -> pd.DataFrame:
    """Return n, what a rule keeps of each capture by all others, and dB lost with these frames."""
    rows = []
    for place, (name, n) in enumerate(table.index):
        frames = rule(table.drop(table.index[place]))(n)
        rows.append((name, n, frames, at(table.iloc[place], n, frames)))
    return pd.DataFrame(rows, columns=["capture", "n", "frames", "loss"]).set_index("capture")


def covered(table: pd.DataFrame) -> pd.DataFrame:
    """Return of each K the captures, the share inside their 90 % interval by all others, the median
    width of these intervals in dB, and the share that lose no more than the bound."""
    rows: list[tuple[float, ...]] = []
    for place in range(len(table)):
        known, own = table.iloc[place].dropna(), calibrated(table.drop(table.index[place]))
        low, _, high, bound = losses(own, known.index.to_numpy(), table.index[place][1])
        inside, held = (low <= known) & (known <= high), known <= bound
        rows += zip(known.index, inside, high - low, held, known, strict=True)
    each = pd.DataFrame(rows, columns=["K", "inside", "width", "within", "loss"]).groupby("K")
    return each.agg(
        captures=("inside", "size"),
        loss=("loss", "median"),
        inside=("inside", "mean"),
        width=("width", "median"),
        within=("within", "mean"),
    )


RULES = {"auto": auto, "share": one_share}


def draw(table: pd.DataFrame, path: Path) -> None:
    """Draw losses against K, a line each capture, and their 90 % interval."""
    figure = new_figure((TEXT, 3.2))
    axis = figure.subplots()
    for (_, n), row in table.iterrows():
        known = row.dropna()
        axis.plot([*known.index, n], [*-known, 0], color="0.6", linewidth=0.7)
    frames = np.geomspace(table.columns.min(), table.columns.max(), 99)
    low, median, high, _ = -losses(calibrated(table), frames)
    axis.fill_between(frames, high, low, color=COLORS[1], alpha=0.25, linewidth=0)
    axis.plot(frames, median, color=COLORS[1])
    axis.set_xscale("log")
    ticks = [*table.columns, 200]
    axis.set_xticks(ticks, list(map(str, ticks)), minor=False)
    axis.minorticks_off()
    name_axes(axis, "frames kept", "PSNR against all frames (dB)")
    save(figure, [path])


def write(rows: pd.DataFrame, folder: Path) -> None:
    """Write the record of the package, and what docs/results/how_many.md shows."""
    table, time_of = lost(rows), {"time": times(rows[rows["kind"] == LARGE])}
    write_text(json.dumps({**calibrated(table), **time_of}, indent=2) + "\n", FOLDER / RECORD)
    draw(table, folder / "how_many.png")
    write_csv(covered(table).assign(**time_of).reset_index(), folder / "intervals.csv")
    kept = {name: left_out(table, rule) for name, rule in RULES.items()}
    rules = [
        (name, own["frames"].mean(), share.mean(), (own["loss"] <= LOSS).mean(), own["loss"].max())
        for name, own in kept.items()
        for share in [own["frames"] / own["n"]]
    ]
    columns = ["rule", "frames", "share", "within", "most"]
    write_csv(pd.DataFrame(rules, columns=columns), folder / "rules.csv")
    each = table.add_prefix("K").reset_index("n").join(kept["auto"].drop(columns="n"))
    write_csv(each.reset_index(), folder / "captures.csv")
    write_csv(by_kind(rows), folder / "kinds.csv")


if __name__ == "__main__":
    rows = Path(sys.argv[1])
    rows.parent.mkdir(parents=True, exist_ok=True)
    with rows.open("a") as file:
        for row in measure(rows):
            print(json.dumps(row), file=file, flush=True)
    write(pd.read_json(rows, lines=True), rows.parent)
