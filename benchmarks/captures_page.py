"""A page of docs/results of the rows of `benchmarks/captures_unknown.py`."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from datetime import UTC, datetime
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from captures_unknown import EVEN, EVERY, KNOWN, METHODS, NEAR, RULES, SETTINGS, SIZES, TOLD, TRIED
from scipy.stats import binomtest, bootstrap

from fsel.core.wording import counted
from fsel.evaluation.statistics import of_places

SHORT = {TRIED: "`fsel`, views unknown", TOLD: "`fsel`, views known"}
UNKNOWN = (*RULES, TRIED)
CELL = ["capture", "start", "k", "seed"]
MADE_HEAD = (
    "Made of real captures: the camera stands still for a third of the frames (with noise of 3 "
    "grey levels); half of the frames, in six bursts; every second frame and then the others; the "
    "same with the second pass 1.4 times as bright. One frame in {every} is held out, in turn from "
    "frame {held} on.\n"
)
NEAREST_HEAD = (
    "## Targets known, over Nearest, by `{by}`\n\nDifferences from the frames nearest to the "
    "targets, each in turn (`nearest`). The rule (`--patience 0`) looks at no image. `tried` is "
    "`fsel select --targets`: what small `gaussians` score best on the targets' own images, "
    "which then score. `others tried` looks at every second target alone and is scored on the "
    "rest, and the other way round. Candidates and margin were chosen on the six captures.\n"
)
KNOWN_HEAD = """# Real captures, targets known

`make real` (`benchmarks/captures_unknown.py`), {date}, trained Gaussians, {side} pixels, {fits} of
each. PSNR over that of the frames nearest to the targets, each target in turn. "Targets known" is
the rule (`--patience 0`); "tried" is `fsel select --targets`, which looks at the targets' images:
small `gaussians` judge five selections on them and, with no more picks than targets, 96 exchanges
of single picks. Candidates and margin were chosen on caliterra, flowerpot, fox, helmet, miku and
South Building, the rule on 14 captures with other targets. Intervals are 95 % by Student's t over
captures, beside a bootstrap and a sign test.
"""
SHARES = {
    "every": "One frame in eight is a target, from frame 3 on",
    "random": "Nine random targets",
    "region": "Nine targets in a region of 40 % of the frames",
}


def page(asked: argparse.Namespace) -> None:
    """Write the page of results."""
    if asked.known:
        asked.out.write_text(_known(asked.known))
        return
    table = pd.read_json(asked.rows, lines=True)
    each = {by: _each(part) for by, part in table.groupby("by")}
    parts = [_head(table), _short(each)]
    for by, gains in each.items():
        parts += [f"## By `{by}`\n", _summary(gains, UNKNOWN), _by_capture(gains)]
    parts.append(_kept(table[table["by"] == table["by"].iloc[0]]))
    for by, gains in each.items():
        if NEAR in gains["psnr"]:
            parts += [NEAREST_HEAD.format(by=by), _summary(gains, KNOWN, over=NEAR)]
    if asked.made_rows:
        made = pd.read_json(asked.made_rows, lines=True)
        held = _held_out(made)
        parts += ["## Pauses, bursts, passes\n", MADE_HEAD.format(every=EVERY, held=held)]
        for by, part in made.groupby("by"):
            gains = _each(part)
            parts += [f"By `{by}`, means over captures:\n", _by_kind(gains), _by_capture(gains)]
    asked.out.write_text("\n".join(parts))


def _known(files: Iterable[Path]) -> str:
    """The page of targets known: a part for each file, which the frames held out name."""
    tables = {file.stem.rpartition("_")[2]: pd.read_json(file, lines=True) for file in files}
    (side,) = {side for table in tables.values() for side in table["side"]}
    fits = counted(max(table["seed"].nunique() for table in tables.values()), "fit")
    parts = [KNOWN_HEAD.format(date=f"{datetime.now(UTC):%Y-%m-%d}", side=side, fits=fits)]
    for held, table in tables.items():
        gains = _each(table)
        parts += [f"## {SHARES[held]}\n", _summary(gains, KNOWN, over=NEAR), _by_capture(gains)]
    return "\n".join(parts)


def _each(table: pd.DataFrame) -> pd.DataFrame:
    """Differences from evenly spaced frames, one row a budget, capture and hold-out."""
    rows = table.groupby([*CELL, "method"])
    cells, there = rows[["psnr", "ssim"]].mean().unstack(), rows.size().unstack()
    gains = {
        # without a number of its own a selection is the one that is evenly spaced
        (metric, method): (cells[metric, method] - cells[metric, EVEN]).fillna(0)[there[method] > 0]
        for metric in ("psnr", "ssim")
        for method in (EVEN, *METHODS)
        if method in there
    }
    # a mean of equal numbers differs from them by its rounding
    return pd.concat(gains, axis=1).round(5).groupby(["k", "capture", "start"]).mean()


def _by_place(each: pd.DataFrame) -> pd.DataFrame:
    return each.groupby(["k", "capture"]).mean()


def _head(table: pd.DataFrame) -> str:
    held, (side,), known = _held_out(table), table["side"].unique(), ""
    if TOLD in set(table["method"]):
        known = f"`fsel` with targets known is given them, from frame {_held_out(table, TOLD)} on. "
    seeds = table[table["by"] == "gaussians"].pivot_table(
        index=["capture", "start", "k", "method"], columns="seed", values="psnr"
    )
    seeds = seeds.diff(axis=1).abs().stack().mean()
    return (
        f"# Real captures, trained Gaussians, {side} pixels\n\n"
        f"`make captures{'' if side == 128 else f'_{side}'}` (`benchmarks/captures_unknown.py`), "
        f"{datetime.now(UTC):%Y-%m-%d}.\n\n"
        f"One frame in {EVERY} is held out, in turn from frame {held} on; picks of the others are "
        "scored on them. Nobody states them to the rule alone (`--patience 0`) and to what is "
        f"tried (`fsel select -k`). {known}By "
        f"{', '.join(f'`{by}`' for by in table['by'].unique())} ({side} pixels; `gaussians`: "
        f"{SETTINGS['gaussians']['steps']} steps, {SIZES[side]:,} Gaussians). Differences are from "
        "evenly spaced frames; intervals are 95 % by Student's t over captures, each the mean of "
        "its hold-outs and seeds. It takes their gains as normal, so that one capture far ahead "
        "widens it on both sides. A bootstrap (BCa, 9,999 draws, seed 0), which is rather too "
        "narrow for ten captures, and a sign test of those that differ from evenly spaced frames "
        "stand beside it. "
        + (f"Two fits of one selection differ by {seeds:.1f} dB on the mean. " if seeds > 0 else "")
        + "What is tried, the margins of `fsel.selection.halving`, and that both reconstructors "
        "must agree were chosen on caliterra, flowerpot, fox, helmet, miku and South Building "
        "(their figures flatter), earlier forms on all but bonsai. That the best of six has to be "
        "beyond chance (Bonferroni) followed a loss of the helmet at 384 pixels, from frame 7 on.\n"
    )


def _held_out(table: pd.DataFrame, method: str = TRIED) -> str:
    """Hold-outs, by their first frames, and the numbers of frames measured with them."""
    held = table[table["method"] == method].groupby(["k", "capture"])["start"]
    starts = held.unique().map(sorted).map(tuple).reset_index()
    whole = starts.groupby("k").size()
    parts = []
    for first, part in starts.groupby("start"):
        counts = part.groupby("k").size().items()
        budgets = [f"{k}" if n == whole[k] else f"{k} of {n} captures" for k, n in counts]
        parts.append(f"{', '.join(map(str, first))} (K = {', '.join(budgets)})")
    return "; ".join(parts)


def _short(each: dict[str, pd.DataFrame]) -> str:
    """Means over captures by number of frames, with intervals, and the worst capture."""
    budgets = sorted({k for gains in each.values() for k in gains.index.unique("k")})
    lines = _header("PSNR over evenly spaced frames, dB", *(f"K = {k}" for k in budgets))
    for (method, views), (by, gains) in product(SHORT.items(), each.items()):
        if method in gains["psnr"]:
            own = _by_place(gains)["psnr", method].dropna()
            cells = [_cell(own[own.index.get_level_values("k") == k]) for k in budgets]
            lines.append(f"| {views}, by `{by}` | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _header(*cells: str) -> list[str]:
    return [f"| {' | '.join(cells)} |", "|" + "---|" * len(cells)]


def _cell(gains: pd.Series, digits: int = 2) -> str:
    if len(gains) < 2:
        return f"{gains.mean():+.{digits}f}, one capture" if len(gains) else ""
    reach = of_places(gains.to_numpy())
    half, least = reach.high - reach.mean, gains.min()
    return f"{reach.mean:+.{digits}f} ± {half:.{digits}f}, worst {least:+.{digits}f}"


def _resampled(gains: pd.Series) -> str:
    """Interval by bootstrap, which takes no gain as normal, and how many captures are ahead."""
    ahead, behind = int((gains > 0).sum()), int((gains < 0).sum())
    if gains.nunique() < 2:
        return f" | {ahead} / {behind}"
    found = bootstrap((gains.to_numpy(),), np.mean, n_resamples=9999, rng=0)
    low, high = found.confidence_interval
    p = binomtest(ahead, ahead + behind).pvalue
    return f"{low:+.2f} to {high:+.2f} | {ahead} / {behind}, p = {p:.2f}"


def _summary(each: pd.DataFrame, methods: Iterable[str], over: str = EVEN) -> str:
    columns = ("captures, hold-outs", "method", "PSNR, dB", "bootstrap", "ahead / behind", "SSIM")
    lines = _header("K", *columns)
    for (k, part), method in product(each.groupby(level="k"), methods):
        if method in part["psnr"]:
            held = (part.xs(method, axis=1, level=1) - part.xs(over, axis=1, level=1)).dropna()
            psnr, ssim = (_by_place(held)[name].round(5) for name in ("psnr", "ssim"))
            count = f"{len(psnr)}, {len(held)}"
            cells = k, count, method, _cell(psnr), _resampled(psnr), _cell(ssim, 3)
            lines.append(f"| {' | '.join(map(str, cells))} |" if len(psnr) else "")
    return "\n".join(filter(None, lines)) + "\n"


def _by_capture(each: pd.DataFrame) -> str:
    found, lines = [method for method in METHODS if method in each["psnr"]], []
    for k, rows in _by_place(each)["psnr"][found].groupby(level="k"):
        cells = rows.droplevel("k").dropna(axis=1, how="all")
        cells = cells.map(lambda gain: "" if np.isnan(gain) else f"{gain:+.2f}")
        lines += [f"PSNR over evenly spaced frames, K = {k}, dB, each over its hold-outs:\n"]
        lines += _header("capture", *cells)
        lines += [f"| {name} | {' | '.join(row)} |" for name, row in cells.iterrows()] + [""]
    return "\n".join(lines)


def _by_kind(each: pd.DataFrame) -> str:
    """What is tried on made captures, over evenly spaced frames, by what was done to them."""
    gains = _by_place(each)["psnr", TRIED].dropna().unstack("k")
    lines = _header("PSNR over evenly spaced frames, dB", *(f"K = {k}" for k in gains))
    for kind, part in gains.groupby(gains.index.str.partition(", ").get_level_values(2)):
        lines.append(f"| {kind} | {' | '.join(_cell(part[k].dropna()) for k in gains)} |")
    return "\n".join(lines) + "\n"


def _kept(table: pd.DataFrame) -> str:
    tried = table[(table["method"] == TRIED) & (table["seed"] == 0)]
    counts = tried.groupby(["k", "kept"]).size().unstack(fill_value=0)
    lines = ["How often each selection was kept, and the mean number of fits:\n"]
    lines += _header("K", *counts.columns, "fits")
    for k, row in counts.iterrows():
        fits = tried.loc[tried["k"] == k, "fits"].mean()
        lines.append(f"| {k} | {' | '.join(map(str, row))} | {fits:.0f} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    rows = parser.add_mutually_exclusive_group(required=True)
    rows.add_argument("--rows", type=Path)
    parser.add_argument("--made-rows", type=Path, help="of captures made of them")
    rows.add_argument("--known", type=Path, nargs="+", help="rows of `--held`, over Nearest alone")
    parser.add_argument("-o", "--out", type=Path, required=True)
    page(parser.parse_args())
