"""What `fsel select` is worth on captures from disk, with targets known and unknown.

    make captures

does all of it, on the captures in `FSEL_CAPTURES` or folders that are named, and
`benchmarks/captures_page.py` writes docs/results/captures_unknown.md.

One frame in eight is held out. Each selection of the others is reconstructed by `gaussians` (600
steps; 6,000 Gaussians at 128 pixels, 20,000 at 384) and by `splats`, or as `--by` says, and scored
on the frames held out: uniform sampling, what people run before poses are known, the rule alone
(`--patience 0`), what is kept after trying on the capture's own frames (the default), and with
`--targets` the frames held out: Nearest, the rule, and what is kept after trying on their images;
once on all of them, which then score too, and once on every second one, the others being those that
score. What is tried makes all its planned fits; it, the rule with targets known and Nearest are
scored with `--seeds` seeds. `--held` holds nine random frames out instead, or nine in a region of
40 % of the frames, each number of `--starts` being a draw. `--made` measures on four captures made
of each: a pause, six bursts, the same path filmed twice, and the second time in other light. Rows
that are there are kept.
"""

from __future__ import annotations

import argparse
import json
import os
from collections import defaultdict
from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

import fsel
from fsel.captures.read import read_capture
from fsel.core.capture import Capture
from fsel.core.subsets import evenly, subset_key
from fsel.metrics import score_views
from fsel.reconstruct import reconstructor_of
from fsel.selection.candidates import RULE as OWN
from fsel.selection.candidates import serving
from fsel.selection.halving import SuccessiveHalving, halving_of, near_targets
from fsel.selection.problem import request_problem
from fsel.selection.small_fits import METRICS, small_fits
from fsel.selection.targets import targets_of
from fsel.selection.validation import STATED, TimeBudget
from fsel.selectors.baselines import PRACTICE

HOME = Path(os.environ.get("FSEL_CAPTURES", "../shared/captures"))
EVERY = 8  # one frame in so many is held out
HELD = {"every": 0.0, "random": 1.0, "region": 0.4}  # shares of the frames that nine are drawn from
NINE = 9
SIZES = {128: 6000, 384: 20_000}  # pixels of the longer side, and Gaussians
SETTINGS = {"gaussians": {"steps": 600, "background": "mean"}, "splats": {}, "radiance_field": {}}
EVEN, RULE, TRIED, TOLD = "evenly spaced", "the rule alone", "tried", "targets known"
NEAR, LOOKED, UNSEEN = "Nearest", "targets known, tried", "targets known, others tried"
RULES = {RULE: "fsel", **{name: name for name in PRACTICE}}  # targets unknown
AIMED = {TOLD: "fsel", NEAR: "nearest"}
KNOWN = (TOLD, LOOKED, UNSEEN)
METHODS = (*RULES, TRIED, NEAR, *KNOWN)
PAUSE, BURSTS, LIGHT = 1 / 3, 6, 1.4  # share of the frames; how many; factor of the intensities
NOISE = 3.0  # grey levels, of a sensor whose frames show the same
ENDLESS = TimeBudget(float("inf"))
SHARE = 2  # fits of a selection in the first heat, as ten seconds plan
ROUNDS = 12  # of exchanges where targets are known, as a minute plans


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


def held_out(capture: Capture, how: str, start: int) -> np.ndarray:
    """(T,) frames, ascending: one in eight from `start` on, or nine of that draw."""
    n, rng = len(capture), np.random.default_rng([start, 7])
    if how == "every":
        return np.arange(start, n, EVERY)
    gap = np.linalg.norm(capture.centers - capture.centers[rng.integers(n)], axis=1)
    near = np.argsort(gap, kind="stable")[: round(n * HELD[how])]
    return np.sort(rng.choice(near, min(NINE, len(near) // 2), replace=False))


def kept_by(race: SuccessiveHalving, rounds: int = 0) -> tuple[np.ndarray, dict[str, object]]:
    """(k,) frames that a race keeps; their selection's name, and the fits that it took."""
    outcome = race.run(SHARE, ENDLESS, rounds)
    return outcome.frames, {"kept": outcome.kept, "fits": outcome.fits}


def tried(capture: Capture, k: int) -> tuple[np.ndarray, dict[str, object]]:
    """(k,) frames that are kept after trying on the capture's own."""
    targets, rule = targets_of(capture, None), selected(capture, k)
    problem = request_problem(capture, targets, np.zeros(len(capture)), None, None)
    race = halving_of(problem, rule, np.empty(0, np.int64))
    return (rule, {"kept": "fsel", "fits": 0}) if race is None else kept_by(race)


def selected(
    capture: Capture, k: int, method: str = "fsel", targets: np.ndarray | None = None
) -> np.ndarray:
    """(k,) frames that a method picks; `fsel` and Nearest read no image."""
    sharpness = None if method in PRACTICE else np.zeros(len(capture))
    return fsel.select(capture, k, targets, method, patience=0, sharpness=sharpness).indices


def told(
    capture: Capture, held: np.ndarray, k: int, methods: Collection[str]
) -> Iterator[tuple[str, list[np.ndarray], dict[str, object]]]:
    """What `picked` yields of the frames held out, their images being read."""
    targets = targets_of(capture, held)
    problem = request_problem(capture, targets, np.zeros(len(capture)), None, None)
    rule = selected(capture, k, targets=held)
    picks = {OWN: rule} | serving(problem, rule, held)
    picks = {name: np.sort(frames) for name, frames in picks.items()}
    near = near_targets(problem, k, held)
    score = small_fits(capture, held, [*picks.values(), near])

    @cache
    def scores(frames: tuple[int, ...], seed: int) -> np.ndarray:
        return score(np.array(frames), seed)

    def kept(rows: slice) -> tuple[np.ndarray, dict[str, object]]:
        def own(frames: np.ndarray, seed: int) -> np.ndarray:
            return scores(subset_key(frames), seed)[rows]

        race = SuccessiveHalving(own, picks, held[rows], STATED, near)
        return kept_by(race, ROUNDS if len(near) else 0)

    if LOOKED in methods:
        frames, more = kept(slice(None))
        yield LOOKED, [frames] * 2, more
    if UNSEEN in methods:
        (even, _), (odd, _) = (kept(slice(first, None, 2)) for first in range(2))
        yield UNSEEN, [odd, even], {}


def picked(
    capture: Capture, held: np.ndarray, k: int, methods: Collection[str]
) -> Iterator[tuple[str, list[np.ndarray], dict[str, object]]]:
    """Yield method, (k,) frames scored on every second one held out and on the rest, and more."""
    seen = np.setdiff1d(np.arange(len(capture)), held)
    if k >= len(seen) or not methods:
        return
    yield EVEN, [seen[evenly(len(seen), k)]] * 2, {}
    own = capture.subset(seen)
    for name in RULES.keys() & methods:
        yield name, [seen[selected(own, k, RULES[name])]] * 2, {}
    if TRIED in methods:
        frames, more = tried(own, k)
        yield TRIED, [seen[frames]] * 2, more
    for name in AIMED.keys() & methods:
        yield name, [selected(capture, k, AIMED[name], held)] * 2, {}
    if {LOOKED, UNSEEN} & set(methods):
        yield from told(capture, held, k, methods)


def rows(
    capture: Capture,
    start: int,
    k: int,
    methods: dict[str, Collection[str]],
    made: dict[tuple[str, int, str], list[float]],
    asked: argparse.Namespace,
) -> Iterator[dict[str, object]]:
    """One a method, reconstructor and seed, of one capture, first frame held out and budget.

    `methods` are those that each reconstructor is to score, beside evenly spaced frames; `made` has
    the scores of reconstructors, seeds and frames that are known, and receives the new ones.
    """
    held = held_out(capture, asked.held, start)

    @cache
    def worth(by: str, seed: int, frames: tuple[int, ...]) -> np.ndarray:
        return scored(capture, by, seed, np.array(frames), held, asked.side)

    picks = list(picked(capture, held, k, set().union(*methods.values())))
    even = [subset_key(frames) for frames in picks[0][1]] if picks else []
    for (by, wanted), (method, parts, more) in product(methods.items(), picks):
        keys = [subset_key(frames) for frames in parts]
        once = by == "splats" or method not in (TRIED, LOOKED, *AIMED) or keys == even
        fits = 1 if once else asked.seeds
        for seed in range(fits if method in wanted else 0):
            for name, own in ((EVEN, even), (method, keys)):
                if (key := (by, seed, str(own))) not in made and keys != even:
                    each = [worth(by, seed, frames)[at::2] for at, frames in enumerate(own)]
                    made[key] = np.concatenate(each).mean(axis=0).round(5).tolist()
                scores = dict(zip(METRICS, made.get(key, (None, None)), strict=True))
                head = {"side": asked.side, "start": start, "k": k, "by": by, "seed": seed}
                found = {"method": name, "frames": str(own), **scores}
                yield head | found | (more if name != EVEN else {})


def scored(
    capture: Capture, by: str, seed: int, frames: np.ndarray, held: np.ndarray, side: int
) -> np.ndarray:
    """(F, 2) PSNR in dB and SSIM of the frames held out."""
    settings = SETTINGS[by] if by == "splats" else SETTINGS[by] | {"seed": seed}
    if by == "gaussians":
        settings |= {"gaussians": SIZES[side]}
    section = {"name": by, "long_side": side, "settings": settings}
    model = reconstructor_of(capture, section).fit(frames)
    truth = np.asarray(capture.images[held])
    return score_views(model.render(capture.view(held)), truth, None, METRICS)


def measure(asked: argparse.Namespace) -> None:
    """Write the rows that are not there yet, so that those of all captures come together."""
    if not asked.folders:
        raise SystemExit(
            f"no capture named, and no COLMAP capture in {HOME}. Hint: FSEL_CAPTURES names their "
            "folder; config/captures.yaml says where they come from"
        )
    known, made = set(), defaultdict(dict)
    if asked.rows.exists() and asked.rows.stat().st_size:
        table = pd.read_json(asked.rows, lines=True)
        columns = ["capture", "start", "k", "by", "method"]
        known = set(table[columns].itertuples(index=False, name=None))
        for row in table.itertuples():
            if row.psnr == row.psnr:  # null where evenly spaced frames were not fitted
                made[row.capture, row.start][row.by, row.seed, row.frames] = [row.psnr, row.ssim]
    asked.rows.parent.mkdir(parents=True, exist_ok=True)
    opened = list(captures(asked))
    with asked.rows.open("a") as file:
        for start, k, (name, capture) in product(asked.starts, asked.budgets, opened):
            done = {key[3:] for key in known if key[:3] == (name, start, k)}
            left = {by: [m for m in asked.methods if (by, m) not in done] for by in asked.by}
            for row in list(rows(capture, start, k, left, made[name, start], asked)):
                print(json.dumps({"capture": name} | row), file=file, flush=True)
            print(name, start, k, flush=True)


def captures(asked: argparse.Namespace) -> Iterator[tuple[str, Capture]]:
    """Those on disk, or what is made of them, and their names."""
    for folder in asked.folders:
        capture = read_capture(folder, long_side=asked.side)
        if not asked.made:
            yield folder.name, capture
            continue
        for how, make in MADE.items():
            yield f"{folder.name}, {how}", make(capture)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    found = sorted(path.parent for path in HOME.glob("*/sparse"))
    parser.add_argument("folders", nargs="*", type=Path, default=found, help="captures on disk")
    parser.add_argument("--rows", type=Path, required=True, help="file that rows are added to")
    parser.add_argument("--side", type=int, default=128, choices=SIZES, help="pixels")
    parser.add_argument("--made", action="store_true", help="on captures made of them, see above")
    parser.add_argument("--held", default="every", choices=HELD, help="which frames are held out")
    parser.add_argument("--starts", type=int, nargs="+", default=[3, 7], help="first, or draws")
    parser.add_argument("--budgets", type=int, nargs="+", default=[10, 15, 20, 30, 50])
    parser.add_argument("--by", nargs="+", default=["gaussians", "splats"], choices=SETTINGS)
    parser.add_argument("--methods", nargs="+", default=METHODS, choices=METHODS)
    parser.add_argument("--seeds", type=int, default=2, help="of the fits, see above")
    measure(parser.parse_args())
