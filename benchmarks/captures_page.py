"""Page docs/results/captures_unknown.md, of the rows of `benchmarks/captures_unknown.py`."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from captures_unknown import (
    EVEN,
    EVERY,
    LONG_SIDE,
    LOOKED,
    METHODS,
    NEAR,
    RULE,
    SETTINGS,
    TOLD,
    TRIED,
    UNSEEN,
)
from scipy.stats import binomtest, bootstrap

from fsel.evaluation.statistics import of_places

SHORT = {TRIED: "`fsel`, views unknown", TOLD: "`fsel`, views known"}
SHOWN = (RULE, TRIED, TOLD)
CELL = ["capture", "start", "k", "seed"]
MADE_HEAD = (
    "Made of real captures: the camera stands still for a third of the frames (with noise of 3 "
    "grey levels); half of the frames, in six bursts; every second frame and then the others; the "
    "same with the second pass 1.4 times as bright. One frame in {every} is held out, in turn from "
    "frame {held} on.\n"
)
NEAREST_HEAD = (
    "## Targets known, over Nearest\n\nPSNR in dB over that of the frames nearest to the targets, "
    "each target in turn (`nearest`). The rule looks at no image. `tried` is `fsel select "
    "--targets --patience 10s`: what small `gaussians` score best on the targets' own images, "
    "which then score. `others tried` looks at every second target alone and is scored on the "
    "rest, and the other way round, so that no target chose that scores. Candidates and the margin "
    "of 0.2 dB were chosen on the six captures above, from frames 3 and 7 on.\n"
)


def page(asked: argparse.Namespace) -> None:
    """Write the page of results."""
    table = pd.read_json(asked.rows, lines=True)
    each = {by: _each(part) for by, part in table.groupby("by")}
    parts = [_head(table), _short(each)]
    for by, gains in each.items():
        parts += [f"## By `{by}`\n", _summary(gains), _by_capture(gains)]
    parts.append(_kept(table[table["by"] == table["by"].iloc[0]]))
    parts += [NEAREST_HEAD, _over_nearest(each)]
    if asked.made_rows:
        made = pd.read_json(asked.made_rows, lines=True)
        held = _held_out(made)
        parts += ["## Pauses, bursts, passes\n", MADE_HEAD.format(every=EVERY, held=held)]
        for by, part in made.groupby("by"):
            gains = _each(part)
            parts += [f"By `{by}`, means over captures:\n", _by_kind(gains), _by_capture(gains)]
    asked.out.write_text("\n".join(parts))


def _each(table: pd.DataFrame) -> pd.DataFrame:
    """Differences from every n-th frame, one row a budget and capture, over its hold-outs."""
    cells = table.pivot_table(index=CELL, columns="method", values=["psnr", "ssim"])
    found = [method for method in METHODS if ("psnr", method) in cells]
    gains = pd.concat(
        {
            (metric, method): cells[metric, method] - cells[metric, EVEN]
            for metric in ("psnr", "ssim")
            for method in found
        },
        axis=1,
    )
    gains = gains.round(5)  # a mean of equal numbers differs from them by its rounding
    return gains.groupby(["k", "capture", "start"]).mean().groupby(["k", "capture"]).mean()


def _head(table: pd.DataFrame) -> str:
    held, shape = _held_out(table), SETTINGS["gaussians"]
    told = table[table["method"] == TOLD]
    starts, budgets = (", ".join(map(str, sorted(told[by].unique()))) for by in ("start", "k"))
    seeds = table[table["by"] == "gaussians"].pivot_table(
        index=["capture", "start", "k", "method"], columns="seed", values="psnr"
    )
    return (
        "# Real captures, trained Gaussians\n\n"
        f"`make captures` (`benchmarks/captures_unknown.py`), {datetime.now(UTC):%Y-%m-%d}."
        "\n\n"
        f"One frame in {EVERY} is held out, in turn from frame {held} on; picks of the others are "
        "scored on them. Nobody states them to the rule alone (`--patience 0`) and to what is "
        f"tried (`fsel select -k`); `fsel` with targets known is told of them, from frame {starts} "
        f"on (K = {budgets}). By `gaussians` "
        f"({LONG_SIDE} pixels, {shape['steps']} steps, {shape['gaussians']:,} Gaussians) and "
        "`splats`. Differences are from every n-th frame; intervals are 95 % by Student's t over "
        "captures, each the mean of its hold-outs and seeds. It takes their gains as normal, so "
        "that one capture far ahead widens it on both sides. A bootstrap (BCa, 9,999 draws, seed "
        "0), which is rather too narrow for ten captures, and a sign test of those that differ "
        "from every n-th frame stand beside it. Two fits of one selection by `gaussians` differ by "
        f"{seeds.diff(axis=1).abs().stack().mean():.1f} dB on the mean. What is tried, the margins "
        "of `fsel.selection.halving`, and that both reconstructors must agree were chosen on "
        "caliterra, flowerpot, fox, helmet, miku and South Building (their figures flatter), "
        "earlier forms on all ten.\n"
    )


def _held_out(table: pd.DataFrame) -> str:
    """Hold-outs, by their first frames, and the numbers of frames measured with them."""
    tried = table[table["method"] == TRIED].groupby(["k", "capture"])["start"]
    starts = tried.unique().map(sorted).map(tuple).reset_index()
    whole = starts.groupby("k").size()
    parts = []
    for first, part in starts.groupby("start"):
        counts = part.groupby("k").size().items()
        budgets = [f"{k}" if n == whole[k] else f"{k} of {n} captures" for k, n in counts]
        parts.append(f"{', '.join(map(str, first))} (K = {', '.join(budgets)})")
    return "; ".join(parts)


def _short(each: dict[str, pd.DataFrame]) -> str:
    """Means over captures by number of frames, with intervals, and the worst capture."""
    whole = [gains["psnr"][list(SHORT)].dropna() for gains in each.values()]
    budgets = sorted(set.intersection(*(set(gains.index.unique("k")) for gains in whole)))
    lines = [f"| PSNR over every n-th frame, dB | {' | '.join(f'K = {k}' for k in budgets)} |"]
    lines.append("|---|" + "---|" * len(budgets))
    for (method, views), (by, gains) in product(SHORT.items(), each.items()):
        cells = [_cell(gains["psnr", method].xs(k, level="k").dropna()) for k in budgets]
        lines.append(f"| {views}, by `{by}` | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _cell(gains: pd.Series) -> str:
    if len(gains) < 2:
        return f"{gains.mean():+.2f}, one capture"
    reach = of_places(gains.to_numpy())
    return f"{reach.mean:+.2f} ± {reach.high - reach.mean:.2f}, worst {gains.min():+.2f}"


def _resampled(gains: pd.Series) -> str:
    """Interval by bootstrap, which takes no gain as normal, and how many captures are ahead."""
    ahead, behind = int((gains > 0).sum()), int((gains < 0).sum())
    if gains.nunique() < 2:
        return f"| {ahead} / {behind}"
    found = bootstrap((gains.to_numpy(),), np.mean, n_resamples=9999, rng=0)
    low, high = found.confidence_interval
    p = binomtest(ahead, ahead + behind).pvalue
    return f"{low:+.2f} to {high:+.2f} | {ahead} / {behind}, p = {p:.2f}"


def _summary(each: pd.DataFrame) -> str:
    lines = ["| K | captures | method | PSNR, dB | bootstrap | ahead / behind | SSIM | worst |"]
    lines.append("|---|---|---|---|---|---|---|---|")
    for (k, part), method in product(each.groupby(level="k"), SHOWN):
        gains = part.xs(method, axis=1, level=1).dropna()
        if len(gains):
            half = of_places(gains["ssim"].to_numpy())
            lines.append(
                f"| {k} | {len(gains)} | {method} | {_cell(gains['psnr'])} | "
                f"{_resampled(gains['psnr'])} | {half.mean:+.3f} ± {half.high - half.mean:.3f} | "
                f"{gains['ssim'].min():+.3f} |"
            )
    return "\n".join(lines) + "\n"


def _by_capture(each: pd.DataFrame) -> str:
    found = [method for method in SHOWN if ("psnr", method) in each]
    rows = each["psnr"][found].map(lambda gain: "" if np.isnan(gain) else f"{gain:+.2f}")
    cells = rows.agg(" / ".join, axis=1).unstack("k", fill_value="")
    lines = [f"PSNR over every n-th frame, {' / '.join(found)}, dB:\n"]
    lines.append(f"| capture | {' | '.join(f'K = {k}' for k in cells)} |")
    lines.append("|---|" + "---|" * len(cells.columns))
    lines += [f"| {name} | {' | '.join(row)} |" for name, row in cells.iterrows()]
    return "\n".join(lines) + "\n"


def _by_kind(each: pd.DataFrame) -> str:
    """What is tried on made captures, over every n-th frame, by what was done to them."""
    gains = each["psnr", TRIED].dropna().unstack("k")
    kinds = gains.groupby(gains.index.str.partition(", ").get_level_values(2))
    lines = [f"| PSNR over every n-th frame, dB | {' | '.join(f'K = {k}' for k in gains)} |"]
    lines.append("|---|" + "---|" * len(gains.columns))
    for kind, part in kinds:
        lines.append(f"| {kind} | {' | '.join(_cell(part[k].dropna()) for k in gains)} |")
    return "\n".join(lines) + "\n"


def _over_nearest(each: dict[str, pd.DataFrame]) -> str:
    """What is ahead of Nearest, told the targets, by reconstructor and number of frames."""
    methods = [TOLD, LOOKED, UNSEEN]
    lines = ["| K | by | captures | method | PSNR, dB | bootstrap | ahead / behind |"]
    lines.append("|---|---|---|---|---|---|---|")
    for by, found in each.items():
        gains = found["psnr"][[NEAR, *methods]].dropna()
        over = gains[methods].sub(gains[NEAR], axis=0).round(5)
        for (k, part), method in product(over.groupby(level="k"), methods):
            own = part[method]
            head = f"| {k} | `{by}` | {len(own)} | {method} "
            lines.append(f"{head}| {_cell(own)} | {_resampled(own)} |")
    return "\n".join(lines) + "\n"


def _kept(table: pd.DataFrame) -> str:
    tried = table[(table["method"] == TRIED) & (table["seed"] == 0)]
    counts = tried.groupby(["k", "kept"]).size().unstack(fill_value=0)
    lines = ["How often each selection was kept, and the mean number of fits:\n"]
    lines.append(f"| K | {' | '.join(counts.columns)} | fits |")
    lines.append("|---|" + "---|" * (len(counts.columns) + 1))
    for k, row in counts.iterrows():
        fits = tried.loc[tried["k"] == k, "fits"].mean()
        lines.append(f"| {k} | {' | '.join(map(str, row))} | {fits:.0f} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=Path, required=True)
    parser.add_argument("--made-rows", type=Path, help="of captures made of them")
    parser.add_argument("-o", "--out", type=Path, required=True)
    page(parser.parse_args())
