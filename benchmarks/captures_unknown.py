"""What `fsel select` is worth on captures from disk, told what will be rendered and not.

    make captures

does all of it: `measure`, `measure --made`, which take the captures in `FSEL_CAPTURES` or folders
that are named, and `page`, which writes docs/results/captures_unknown.md.

One frame in eight is held out and not announced. Each selection of the others is reconstructed by
`gaussians` (128 pixels, 600 steps, 6,000 Gaussians) and by `splats`, or as `--by` says, and scored
on the frames held out: every n-th frame, the rule alone (`--patience 0`), what is kept after trying
on the capture's own frames (the default), and what `--targets` picks, told of the frames held out.
What is tried makes all its planned fits, whatever the time, and is scored with `--seeds` seeds.
`--made` measures on four captures made of each: a pause of a third of its length, six bursts, the
same path filmed twice, and the second time in other light. Rows that are there are not measured
again.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Collection, Iterator
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import binomtest, bootstrap

import fsel
from fsel.data.capture import Capture
from fsel.data.subsets import evenly, subset_key
from fsel.ingest.read import read_capture
from fsel.metrics import score_views
from fsel.reconstruct import reconstructor_of
from fsel.report.statistics import of_places
from fsel.request.patience import Patience
from fsel.request.problem import request_problem
from fsel.request.targets import targets_of
from fsel.request.trials import race_of

EVERY = 8  # one frame in so many is held out
LONG_SIDE = 128
SETTINGS = {
    "gaussians": {"steps": 600, "gaussians": 6000, "background": "mean"},
    "splats": {},
    "radiance_field": {},
}
EVEN, RULE, TRIED, TOLD = "every n-th frame", "the rule alone", "tried", "targets known"
METHODS = (RULE, TRIED, TOLD)
SHORT = {TRIED: "`fsel`, views unknown", TOLD: "`fsel`, views known"}
CELL = ["capture", "start", "k", "seed"]
PAUSE, BURSTS, LIGHT = 1 / 3, 6, 1.4  # share of the frames; how many; factor of the intensities
NOISE = 3.0  # grey levels, of a sensor whose frames show the same
ENDLESS = Patience(float("inf"))
SHARE = 2  # fits of a selection in the first heat, as ten seconds plan


MADE_HEAD = (
    "Made of real captures: the camera stands still for a third of the frames (with noise of 3 "
    "grey levels); half of the frames, in six bursts; every second frame and then the others; the "
    "same with the second pass 1.4 times as bright. One frame in {every} is held out, in turn from "
    "frame {held} on.\n"
)


def paused(capture: Capture) -> Capture:
    """The camera stands still at a third of the way, for a third of the frames."""
    n = len(capture)
    still = np.full(round(n * PAUSE / (1 - PAUSE)), n // 3)
    order = np.concatenate([np.arange(n // 3), still, np.arange(n // 3, n)])
    images = np.asarray(capture.images)[order].astype(np.float64)
    pause = slice(n // 3, n // 3 + len(still))
    images[pause] += np.random.default_rng(0).normal(0, NOISE, images[pause].shape)
    return repeated(capture, order, images)


def in_bursts(capture: Capture) -> Capture:
    """Half of the frames, in six bursts."""
    within = np.arange(len(capture)) * BURSTS / len(capture) % 1
    return capture.subset(np.flatnonzero(within < 0.5))


def filmed_twice(capture: Capture) -> Capture:
    """Every second frame, then the others: two passes along one path."""
    n = len(capture)
    return capture.subset(np.concatenate([np.arange(0, n, 2), np.arange(1, n, 2)]))


def in_other_light(capture: Capture) -> Capture:
    """Two passes, the second one brighter."""
    twice = filmed_twice(capture)
    images = np.asarray(twice.images).astype(np.float64)
    images[(len(capture) + 1) // 2 :] *= LIGHT
    return repeated(twice, np.arange(len(twice)), images)


def repeated(capture: Capture, order: np.ndarray, images: np.ndarray) -> Capture:
    """Frames of a capture in some order, which may repeat them, with other images."""
    points = capture.points
    if points is not None:
        seen = [np.flatnonzero(points.track_frame == frame) for frame in order]
        points = replace(
            points,
            track_point=points.track_point[np.concatenate(seen)],
            track_frame=np.repeat(np.arange(len(order)), [len(part) for part in seen]),
        )
    return replace(
        capture,
        names=tuple(f"{at:05d}" for at in range(len(order))),
        world_to_camera=capture.world_to_camera[order],
        intrinsics=capture.intrinsics[order],
        images=np.clip(np.round(images), 0, 255).astype(np.uint8),
        sequences=tuple(capture.sequences[frame] for frame in order),
        points=points,
        masks=None,
        files=None,
    )


MADE = {
    "pause": paused,
    "bursts": in_bursts,
    "two passes": filmed_twice,
    "other light": in_other_light,
}


def tried(capture: Capture, k: int) -> tuple[np.ndarray, dict[str, object]]:
    """(k,) frames; the name of what was kept after trying, and the fits that it took."""
    problem = request_problem(
        capture, targets_of(capture, None), np.zeros(len(capture)), None, None
    )
    rule = ruled(capture, k)
    race = race_of(problem, rule)
    if race is None:
        return rule, {"kept": "fsel", "fits": 0}
    outcome = race.run(SHARE, ENDLESS)
    return outcome.frames, {"kept": outcome.kept, "fits": outcome.fits}


def ruled(capture: Capture, k: int, targets: np.ndarray | None = None) -> np.ndarray:
    """(k,) frames that the rule picks, without an image being read."""
    chosen = fsel.select(capture, k, targets, patience=0, sharpness=np.zeros(len(capture)))
    return chosen.indices


def picked(
    capture: Capture, held: np.ndarray, k: int, methods: Collection[str]
) -> Iterator[tuple[str, np.ndarray, dict[str, object]]]:
    """Yield method, (k,) frames of the capture, and what is to be told of it."""
    seen = np.setdiff1d(np.arange(len(capture)), held)
    if k >= len(seen) or not methods:
        return
    yield EVEN, seen[evenly(len(seen), k)], {}
    if RULE in methods:
        yield RULE, seen[ruled(capture.subset(seen), k)], {}
    if TRIED in methods:
        frames, more = tried(capture.subset(seen), k)
        yield TRIED, seen[frames], more
    if TOLD in methods:
        yield TOLD, ruled(capture, k, held), {}


def rows(
    capture: Capture, start: int, k: int, methods: dict[str, Collection[str]], seeds: int
) -> Iterator[dict[str, object]]:
    """One a method, reconstructor and seed, of one capture, hold-out and budget.

    Args:
        capture: all frames.
        start: the first that is held out.
        k: how many are picked.
        methods: reconstructor -> those that it is to score, beside every n-th frame.
        seeds: fits of what was tried, where it is not every n-th frame.
    """
    held = np.arange(start, len(capture), EVERY)

    @cache
    def worth(by: str, seed: int, frames: tuple[int, ...]) -> list[float]:
        return scored(capture, by, seed, np.array(frames), held)

    picks = list(picked(capture, held, k, set().union(*methods.values())))
    even = subset_key(picks[0][1]) if picks else ()
    for (by, asked), (method, frames, more) in product(methods.items(), picks):
        key = subset_key(frames)
        fits = 1 if by == "splats" or method != TRIED or key == even else seeds
        for seed in range(fits if method in asked else 0):
            for name, own in ((EVEN, even), (method, key)):
                psnr, ssim = worth(by, seed, own)
                head = {"start": start, "k": k, "by": by, "seed": seed, "method": name}
                yield head | {"psnr": psnr, "ssim": ssim} | (more if name == TRIED else {})


def scored(
    capture: Capture, by: str, seed: int, frames: np.ndarray, held: np.ndarray
) -> list[float]:
    """Mean PSNR in dB and SSIM on the frames held out."""
    settings = SETTINGS[by] if by == "splats" else SETTINGS[by] | {"seed": seed}
    section = {"name": by, "long_side": LONG_SIDE, "settings": settings}
    model = reconstructor_of(capture, section).fit(frames)
    truth = np.asarray(capture.images[held])
    found = score_views(model.render(capture.view(held)), truth, None, ("psnr", "ssim"))
    return found.mean(axis=0).round(5).tolist()


def measure(asked: argparse.Namespace) -> None:
    """Write the rows that are not there yet, so that those of all captures come together."""
    if not asked.folders:
        raise SystemExit(
            f"no capture named, and no COLMAP capture in {home()}. Hint: FSEL_CAPTURES names their "
            "folder; config/captures.yaml says where they come from"
        )
    known = set()
    if asked.rows.exists():
        table = pd.read_json(asked.rows, lines=True)
        columns = ["capture", "start", "k", "by", "method"]
        known = set(table[columns].itertuples(index=False, name=None))
    asked.rows.parent.mkdir(parents=True, exist_ok=True)
    opened = list(captures(asked))
    with asked.rows.open("a") as file:
        for start, k, (name, capture) in product(asked.starts, asked.budgets, opened):
            left = {
                by: [
                    method for method in asked.methods if (name, start, k, by, method) not in known
                ]
                for by in asked.by
            }
            for row in list(rows(capture, start, k, left, asked.seeds)):
                print(json.dumps({"capture": name} | row), file=file, flush=True)
            print(name, start, k, flush=True)


def home() -> Path:
    """The folder of captures."""
    return Path(os.environ.get("FSEL_CAPTURES", "../shared/captures"))


def captures(asked: argparse.Namespace) -> Iterator[tuple[str, Capture]]:
    """Those on disk, or what is made of them, and their names."""
    for folder in asked.folders:
        capture = read_capture(folder, long_side=LONG_SIDE)
        if not asked.made:
            yield folder.name, capture
            continue
        for how, make in MADE.items():
            yield f"{folder.name}, {how}", make(capture)


def page(asked: argparse.Namespace) -> None:
    """Write the page of results."""
    table = pd.read_json(asked.rows, lines=True)
    each = {by: _each(part) for by, part in table.groupby("by")}
    parts = [_head(table), _short(each)]
    for by, gains in each.items():
        parts += [f"## By `{by}`\n", _summary(gains), _by_capture(gains)]
    parts.append(_kept(table[table["by"] == table["by"].iloc[0]]))
    if asked.made_rows:
        made = pd.read_json(asked.made_rows, lines=True)
        held = _held_out(made)
        parts += ["## Pauses, bursts, passes\n", MADE_HEAD.format(every=EVERY, held=held)]
        for by, part in made.groupby("by"):
            parts += [f"By `{by}`. {_by_capture(_each(part))}"]
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
    told = table[table["method"] == TOLD]["start"].unique()
    seeds = table[table["by"] == "gaussians"].pivot_table(
        index=["capture", "start", "k", "method"], columns="seed", values="psnr"
    )
    return (
        "# Real captures, trained Gaussians\n\n"
        f"`make captures` (`benchmarks/captures_unknown.py`), {datetime.now(UTC):%Y-%m-%d}."
        "\n\n"
        f"One frame in {EVERY} is held out, in turn from frame {held} on; picks of the others are "
        "scored on them. Nobody states them to the rule alone (`--patience 0`) and to what is "
        "tried (`fsel select -k`); `fsel` with targets known is told of them, from frame "
        f"{', '.join(map(str, sorted(told)))} on alone. By `gaussians` "
        f"({LONG_SIDE} pixels, {shape['steps']} steps, {shape['gaussians']:,} Gaussians) and "
        "`splats`. Differences are from every n-th frame; intervals are 95 % by Student's t over "
        "captures, each the mean of its hold-outs and seeds. It takes their gains as normal, so "
        "that one capture far ahead widens it on both sides. A bootstrap (BCa, 9,999 draws, seed "
        "0), which is rather too narrow for ten captures, and a sign test of those that differ "
        "from every n-th frame stand beside it. Two fits of one selection by `gaussians` differ by "
        f"{seeds.diff(axis=1).abs().stack().mean():.1f} dB on the mean. What is tried, the margins "
        "of `fsel.request.trials`, and that both reconstructors must agree were chosen on "
        "caliterra, flowerpot, fox, helmet, miku and South Building (their figures flatter), "
        "earlier forms on all ten.\n"
    )


def _held_out(table: pd.DataFrame) -> str:
    """Hold-outs, by their first frames, and the numbers of frames measured with them."""
    starts = table[table["method"] == TRIED].groupby("k")["start"].unique().map(sorted).map(tuple)
    return "; ".join(
        f"{', '.join(map(str, first))} (K = {', '.join(map(str, part.index))})"
        for first, part in starts.to_frame().groupby("start")
    )


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
    for (k, part), method in product(each.groupby(level="k"), METHODS):
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
    found = [method for method in METHODS if ("psnr", method) in each]
    rows = each["psnr"][found].map(lambda gain: "" if np.isnan(gain) else f"{gain:+.2f}")
    cells = rows.agg(" / ".join, axis=1).unstack("k", fill_value="")
    lines = [f"PSNR over every n-th frame, {' / '.join(found)}, dB:\n"]
    lines.append(f"| capture | {' | '.join(f'K = {k}' for k in cells)} |")
    lines.append("|---|" + "---|" * len(cells.columns))
    lines += [f"| {name} | {' | '.join(row)} |" for name, row in cells.iterrows()]
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    commands = parser.add_subparsers(dest="what", required=True)
    command = commands.add_parser("measure")
    found = sorted(path.parent for path in home().glob("*/sparse"))
    command.add_argument("folders", nargs="*", type=Path, default=found, help="captures on disk")
    command.add_argument("--rows", type=Path, required=True, help="file that rows are added to")
    command.add_argument("--made", action="store_true", help="on captures made of them, see above")
    command.add_argument("--starts", type=int, nargs="+", default=[3, 7], help="first held out")
    command.add_argument("--budgets", type=int, nargs="+", default=[10, 15, 20, 30, 50])
    command.add_argument("--by", nargs="+", default=["gaussians", "splats"], choices=SETTINGS)
    command.add_argument("--methods", nargs="+", default=METHODS, choices=METHODS)
    command.add_argument("--seeds", type=int, default=2, help="of the fits of what was tried")
    command = commands.add_parser("page")
    command.add_argument("--rows", type=Path, required=True)
    command.add_argument("--made-rows", type=Path, help="of captures made of them")
    command.add_argument("-o", "--out", type=Path, required=True)
    asked = parser.parse_args()
    globals()[asked.what](asked)


if __name__ == "__main__":
    main()
