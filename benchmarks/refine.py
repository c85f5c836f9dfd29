"""What `fsel select --refine` gains on captures from disk, by what judges its swaps.

    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/refine.py measure FOLDER... \
        --rows results/refine.jsonl
    python benchmarks/refine.py page --rows results/refine.jsonl -o docs/results/refine.md

One frame in eight is held out. Where views are unknown, swaps begin with what `fsel select -k`
keeps after trying; where they are known, with the picks of `fsel` for the frames held out. Each
judge swaps for some seconds of the processor. `gaussians` at 128 pixels score the outcome on the
frames held out, as `benchmarks/captures_unknown.py` does, with `--seeds` seeds. Rows that are there
are not measured again.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from captures_unknown import EVERY, LONG_SIDE, SETTINGS, ruled, scored, tried

from fsel.captures.read import read_capture
from fsel.core.capture import Capture
from fsel.core.problem import Problem
from fsel.core.subsets import subset_key
from fsel.reconstruct import reconstructor_of
from fsel.selection.problem import request_problem
from fsel.selection.refine import SETTINGS as JUDGES
from fsel.selection.refine import Swapped
from fsel.selection.swaps import confirmed, problem_swaps, scoring
from fsel.selection.targets import targets_of

TRUTH = "gaussians"
VIEWS = ("unknown", "known")
CELL = ["capture", "start", "k", "views", "judge", "seconds"]


def climbed(
    problem: Problem, picks: np.ndarray, judge: str, seconds: Sequence[float]
) -> dict[float, Swapped]:
    """The best picks after some seconds of the processor, once the first fit has compiled."""
    found, began = {}, None
    reconstructor = reconstructor_of(problem.capture, scoring(judge))
    for best in problem_swaps(reconstructor, problem, picks, np.random.default_rng(0)):
        now = time.process_time()
        began = began or now
        found |= {
            limit: replace(best, reconstructor=judge) for limit in seconds if now - began < limit
        }
        if now - began >= max(seconds):
            break
    return found


def begun(
    capture: Capture, held: np.ndarray, k: int, views: str
) -> tuple[Problem, np.ndarray, np.ndarray]:
    """Make the problem, name its frames by those of the whole capture, and pick without swaps."""
    if views == "known":
        part, frames, targets = capture, np.arange(len(capture)), held
        picks = ruled(capture, k, held)
    else:
        frames, targets = np.setdiff1d(np.arange(len(capture)), held), None
        part = capture.subset(frames)
        picks = tried(part, k)[0]
    problem = request_problem(part, targets_of(part, targets), np.zeros(len(part)), None, None)
    return problem, frames, picks


def rows(
    capture: Capture, cell: dict[str, object], judges: Sequence[str], asked: argparse.Namespace
) -> Iterator[dict[str, object]]:
    """Yield one row a judge and limit of seconds."""
    held = np.arange(cell["start"], len(capture), EVERY)
    problem, frames, before = begun(capture, held, cell["k"], cell["views"])

    @cache
    def worth(picks: tuple[int, ...]) -> float:
        found = [
            scored(capture, TRUTH, at, np.array(picks), held)[:, 0].mean()
            for at in range(asked.seeds)
        ]
        return float(np.mean(found))

    for judge in judges:
        for limit, swapped in climbed(problem, before, judge, asked.seconds).items():
            kept = confirmed(problem, before, swapped) if problem.whole else swapped
            after, start = subset_key(frames[swapped.picks]), subset_key(frames[before])
            yield {
                "judge": judge,
                "seconds": limit,
                "tried": swapped.tried,
                "shown": round(swapped.gain, 5),
                "swaps": round(worth(after) - worth(start), 5),
                "kept": kept.kept,
            }


def measure(asked: argparse.Namespace) -> None:
    """Write the rows that are not there yet."""
    known = set()
    if asked.rows.exists():
        known = set(pd.read_json(asked.rows, lines=True)[CELL].itertuples(index=False, name=None))
    asked.rows.parent.mkdir(parents=True, exist_ok=True)
    opened = {folder.name: read_capture(folder, long_side=LONG_SIDE) for folder in asked.folders}
    with asked.rows.open("a") as file:
        for views, start, k, name in product(asked.views, asked.starts, asked.budgets, opened):
            head = {"capture": name, "start": start, "k": k, "views": views}
            left = [
                judge
                for judge in asked.judges
                if any(
                    (name, start, k, views, judge, limit) not in known for limit in asked.seconds
                )
            ]
            for row in rows(opened[name], head, left, asked) if left else ():
                print(json.dumps(head | row), file=file, flush=True)
            print(views, start, k, name, flush=True)


def page(asked: argparse.Namespace) -> None:
    """Write the page of results."""
    table = pd.read_json(asked.rows, lines=True)
    parts = [_head(table)]
    for views, part in table.groupby("views", sort=False):
        parts += [f"## Views {views}\n", _table(part)]
    asked.out.write_text("\n".join(parts))


def _head(table: pd.DataFrame) -> str:
    starts = ", ".join(map(str, sorted(table["start"].unique())))
    return (
        "# What `--refine` gains\n\n"
        f"`python benchmarks/refine.py`, {datetime.now(UTC):%Y-%m-%d}. One core.\n\n"
        f"One frame in {EVERY} is held out, from frame {starts} on. Each judge swaps picks at 64 "
        "pixels for some seconds of the processor. PSNR of the held-out frames by `gaussians` "
        f"({LONG_SIDE} pixels, {SETTINGS[TRUTH]['steps']} steps, "
        f"{SETTINGS[TRUTH]['gaussians']:,} Gaussians, two seeds) over that of the picks before any "
        "swap, dB. With views unknown: of all swaps / of what is kept, which is 0 where frames "
        "that scored no swap do not confirm them; the swaps begin with what `fsel select -k` "
        "keeps after trying. `shown` is the mean gain on the frames that scored the swaps. Two "
        "fits of one selection differ by about 0.5 dB.\n"
    )


def _table(part: pd.DataFrame) -> str:
    """One row a judge, budget and limit of seconds; a column a capture."""
    names = sorted(part["capture"].unique())
    heads = ["K", "judge", "seconds", "subsets", "shown", *names, "mean", "worst"]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for (k, judge, seconds), cell in part.groupby(["k", "judge", "seconds"]):
        gains = cell.assign(kept=cell["swaps"].where(cell["kept"], 0.0))
        gains = gains.groupby("capture")[["swaps", "kept"]].mean().reindex(names)
        outcomes = [gains.loc[name] for name in names] + [gains.mean(), gains.min()]
        lines.append(
            f"| {k} | `{judge}` | {seconds:g} | {cell['tried'].median():.0f} | "
            f"{cell['shown'].mean():+.2f} | "
            f"{' | '.join(_pair(pair, part) for pair in outcomes)} |"
        )
    return "\n".join(lines) + "\n"


def _pair(gains: pd.Series, part: pd.DataFrame) -> str:
    """Gain of all swaps, and of those kept where some are taken back."""
    if gains.isna().any():
        return ""
    confirmed_too = f" / {gains['kept']:+.2f}" if part["views"].iloc[0] == "unknown" else ""
    return f"{gains['swaps']:+.2f}{confirmed_too}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    commands = parser.add_subparsers(dest="what", required=True)
    command = commands.add_parser("measure")
    command.add_argument("folders", nargs="+", type=Path, help="captures on disk")
    command.add_argument("--rows", type=Path, required=True, help="file that rows are added to")
    command.add_argument("--views", nargs="+", default=VIEWS, choices=VIEWS)
    command.add_argument("--starts", type=int, nargs="+", default=[3], help="first held out")
    command.add_argument("--budgets", type=int, nargs="+", default=[10, 20])
    command.add_argument("--judges", nargs="+", default=list(JUDGES), choices=JUDGES)
    command.add_argument("--seconds", type=float, nargs="+", default=[10, 60])
    command.add_argument("--seeds", type=int, default=2, help="of the fits that score")
    command = commands.add_parser("page")
    command.add_argument("--rows", type=Path, required=True)
    command.add_argument("-o", "--out", type=Path, required=True)
    asked = parser.parse_args()
    globals()[asked.what](asked)


if __name__ == "__main__":
    main()
