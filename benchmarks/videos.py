"""What selections of real videos are worth; writes docs/results/videos.md.

    make videos

The frames that `fsel select -k 40` samples of the videos in `FSEL_VIDEOS` are placed once; one in
eight is held out before anything is picked, another one with each seed. Uniform in time (as
`ffmpeg` and `ns-process-data` take), the sharpest of each interval (`best_n`), `thumbnail`, and
what `fsel select -k` keeps are trained by `gaussians`, at `--side` pixels; with `--paused` as if
the camera had stood still in the middle for a third of the time, which adds no frame but seconds.
Rows that are there are kept.
"""

import argparse
import json
import os
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from captures_unknown import EVERY, SIZES, kept_by, scored

from fsel.captures.lazy import LazyCapture
from fsel.captures.opening import Opening, opened
from fsel.captures.quality.examination import examined
from fsel.core.subsets import subset_key
from fsel.core.wording import counted
from fsel.selection.halving import halving_of
from fsel.selection.request import SelectionRequest, checked_request
from fsel.selection.select import select_frames
from fsel.selectors.baselines.by_pose import in_turn

HOME = Path(os.environ.get("FSEL_VIDEOS", "../shared/videos"))
PAGE = Path(__file__).parents[1] / "docs/results/videos.md"
WANTED = 40  # picks that enough frames are sampled for
FIRST = (3, 7, 1, 5)  # frame held out, by the seed
LEAST_SPARE = 8  # frames that are neither held out nor picked
UNIFORM, FSEL = "uniform", "fsel"
PAUSE = 1 / 3  # of the time
OTHERS = ("best_n", "thumbnail")
METHODS, SCORES = (UNIFORM, FSEL, *OTHERS), ("all", "sharp", "worst tenth")
HEAD = """# Real videos, trained Gaussians

`make videos` (`benchmarks/videos.py`), {date}. Poses come from all sampled frames; one frame in
{every} is held out. PSNR (dB) of uniform sampling in time, and what the others are ahead by: on all
held-out frames / the sharp ones / the worst tenth of each selection. Each of {seeds} holds other
frames out and makes one fit; mean ± its standard error over the videos. In {even} of {runs} runs
`fsel` picked the frames of uniform sampling. With a pause: the camera stands still in the middle
for a third of the time. Frames (blurred): {frames}.

"""


def even_in_time(seconds: np.ndarray, k: int) -> np.ndarray:
    """(k,) ascending rows of (n,) seconds nearest to k times from the first to the last."""
    times = np.linspace(seconds[0], seconds[-1], k)
    return np.sort(in_turn(np.abs(seconds[:, None] - times), k))


def picks_of(method: str, part: LazyCapture, seconds: np.ndarray, k: int) -> np.ndarray:
    """(k,) rows of a part of a video that a method picks."""
    if method == UNIFORM:
        return even_in_time(seconds, k)
    if method != FSEL:
        request = SelectionRequest(part, k, method=method, keep_bad=True)
        return select_frames(checked_request(request)).selection.indices
    outcome = select_frames(checked_request(SelectionRequest(part, k, patience=0)))
    rule, nothing = outcome.selection.indices, np.empty(0, np.int64)
    race = halving_of(outcome.problem, rule, nothing)
    return rule if race is None else kept_by(race)[0]


def paused(lazy: LazyCapture) -> LazyCapture:
    """Return a video's frames as if the camera had stood still in the middle, for `PAUSE`."""
    shots, end = lazy.found["video"], lazy.seconds[-1]
    later = [shot | {"seconds": shot["seconds"] + end * PAUSE / (1 - PAUSE)} for shot in shots]
    half = len(shots) // 2
    return replace(lazy, found=lazy.found | {"video": shots[:half] + later[half:]})


def measure(video: Path, asked: argparse.Namespace, known: set[tuple]) -> None:
    """Write the rows of a video that are not there yet."""
    cells = product(asked.seeds, asked.budgets, asked.methods)
    head = {"side": asked.side, "paused": asked.paused, "video": video.stem}
    cells = [cell for cell in cells if (*head.values(), *cell) not in known]
    if not cells:
        return
    lazy = opened(Opening((video,), wanted=WANTED), long_side=asked.side)
    lazy = paused(lazy) if asked.paused else lazy
    count, seconds = len(lazy.capture), lazy.seconds
    blurred, loaded = examined(lazy).of_kind("blurred"), lazy.loaded(np.arange(count))

    @cache
    def worth(seed: int, frames: tuple[int, ...]) -> np.ndarray:
        held = np.arange(FIRST[seed], count, EVERY)
        return scored(loaded, "gaussians", seed, np.array(frames), held, asked.side)[:, 0]

    for seed, k, method in cells:
        held = np.arange(FIRST[seed], count, EVERY)
        seen = np.setdiff1d(np.arange(count), held)
        if k > len(seen) - LEAST_SPARE:
            continue
        frames = np.sort(seen[picks_of(method, lazy.part(seen), seconds[seen], k)])
        psnr = worth(seed, subset_key(frames))
        row = head | {"seed": seed, "k": k, "method": method}
        row |= {"frames": count, "picks": frames.tolist(), "psnr": psnr.round(3).tolist()}
        row |= {"sharp": (~np.isin(held, blurred)).tolist(), "blurred": len(blurred)}
        with asked.rows.open("a") as file:
            print(json.dumps(row), file=file, flush=True)


def scores_of(rows: pd.DataFrame) -> pd.Series:
    """The scores, dB, of a method's rows, over the frames held out with all seeds."""
    psnr, sharp = (np.concatenate(rows[name].to_list()) for name in ("psnr", "sharp"))
    worst = np.sort(psnr)[: max(1, len(psnr) // 10)]
    parts = (psnr, psnr[sharp.astype(bool)] if any(sharp) else psnr, worst)
    return pd.Series(dict(zip(SCORES, (part.mean() for part in parts), strict=True)))


def page(rows: pd.DataFrame) -> str:
    """Return the page of the rows: each cell has the three scores."""
    cells = ["side", "paused", "k", "video", "method"]
    table = rows.groupby(cells)[["psnr", "sharp"]].apply(scores_of).unstack("method")
    each = rows.groupby("video").first()
    frames = ", ".join(f"{v} {r.frames} ({r.blurred})" for v, r in each.iterrows())
    seeds = counted(rows["seed"].nunique(), "seed")
    head = {"every": EVERY, "seeds": seeds, "date": f"{datetime.now(UTC):%Y-%m-%d}"}
    picks = rows.pivot(index=[*cells[:-1], "seed"], columns="method", values="picks")
    runs = picks[[UNIFORM, FSEL]].dropna()
    head |= {"even": (runs[UNIFORM] == runs[FSEL]).sum(), "runs": len(runs)}
    text = HEAD.format(**head, frames=frames)
    for (side, pause, k), part in table.groupby(level=cells[:3]):
        part = part.droplevel(cells[:3]).dropna(axis=1, how="all")
        methods = [m for m in METHODS[1:] if m in part["all"]]
        gains = {m: np.array([part[s][m] - part[s][UNIFORM] for s in SCORES]).T for m in methods}
        names = " | ".join(f"`{method}`" for method in methods)
        text += f"## K = {k}, {side} pixels{', with a pause' if pause else ''}\n\n"
        text += f"| video | uniform | {names} |\n"
        text += "|---" * (2 + len(methods)) + "|\n"
        for at, video in enumerate(part.index):
            own = " / ".join(f"{part[s][UNIFORM].iloc[at]:.1f}" for s in SCORES)
            text += f"| {video} | {own} | {' | '.join(_cell(gains[m][at]) for m in methods)} |\n"
        means = [
            _cell(gains[m].mean(0), gains[m].std(0) / max(len(part) - 1, 1) ** 0.5) for m in methods
        ]
        text += f"| mean | | {' | '.join(means)} |\n"
        text += f"| worst | | {' | '.join(_cell(gains[m].min(0)) for m in methods)} |\n\n"
    return text.rstrip() + "\n"


def _cell(gains: np.ndarray, errors: Sequence[float] = ()) -> str:
    """Return dB with their errors, a dash where not every video was measured."""
    if np.isnan(gains).any():
        return "–"
    off = [f" ± {error:.2f}" for error in errors] or [""] * len(gains)
    return " / ".join(f"{gain:+.2f}{more}" for gain, more in zip(gains, off, strict=True))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    found = sorted(path for path in HOME.glob("*") if path.suffix in (".mp4", ".m4v", ".mov"))
    parser.add_argument("videos", nargs="*", type=Path, default=found)
    parser.add_argument("--rows", type=Path, default=Path("results/videos.jsonl"))
    parser.add_argument("--side", type=int, default=128, choices=SIZES, help="pixels")
    parser.add_argument("--paused", action="store_true", help="with a pause, see above")
    parser.add_argument("--budgets", type=int, nargs="+", default=[20, 40, 80])
    parser.add_argument("--methods", nargs="+", default=METHODS, choices=METHODS)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2, 3])
    asked = parser.parse_args()
    asked.rows.parent.mkdir(parents=True, exist_ok=True)
    old = pd.read_json(asked.rows, lines=True) if asked.rows.is_file() else pd.DataFrame()
    cells = old.get(["side", "paused", "video", "seed", "k", "method"], old)
    known = set(cells.itertuples(index=False, name=None))
    for video in asked.videos:
        measure(video, asked, known)
    PAGE.write_text(page(pd.read_json(asked.rows, lines=True)), encoding="utf-8")
