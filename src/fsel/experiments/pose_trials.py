"""Selectors on poses that are not exact: estimated from the images, or disturbed on purpose."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.baselines import FURTHER, PAPER
from fsel.capture import Capture
from fsel.evaluation import Evaluator
from fsel.experiments.crosscapture import budget_picks
from fsel.experiments.pose_errors import perturbed
from fsel.files import write_table
from fsel.metrics import METRIC_UNITS, METRICS
from fsel.problem import Method, Problem
from fsel.reconstruct import Reconstructor, reconstructor_of
from fsel.selector.policies import POLICIES
from fsel.selector.scorer import Scorer
from fsel.split import evaluation_split

logger = logging.getLogger(__name__)

SELECTORS = {**PAPER, **FURTHER}
EXACT, ESTIMATED = "none", "estimated"  # what was done to the poses
SELECTOR, BOTH = "selector", "both"  # who works with the poses that result
Judge = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Trial:
    """What every set of poses is tried with.

    Attributes:
        runs: methods, each with the number of its seed.
        described: descriptors.parquet, of all frames.
        budgets: frames to pick.
        targets: held-out views of a draw.
        seed: of the scene.
        split_seed: of the scene's draws of targets.
    """

    runs: list[tuple[Method, int]]
    described: pd.DataFrame
    budgets: Sequence[int]
    targets: int
    seed: int
    split_seed: int

    @classmethod
    def of(cls, folder: str | Path, weights: Mapping[str, Sequence[str | Path]], **rest) -> Trial:
        """Every selector: those without training, and the scorers of each learned one."""
        runs = [(method, s) for method in SELECTORS.values() for s in range(method.seeds)]
        for name, paths in weights.items():
            runs += [(POLICIES[name].method(Scorer.load(p)), s) for s, p in enumerate(paths)]
        return cls(runs, pd.read_parquet(Path(folder) / "descriptors.parquet"), **rest)

    def drawn(self, capture: Capture, draw: int) -> np.ndarray:
        """The targets of a draw: at random, independent of the poses."""
        return evaluation_split(capture, draw, self.split_seed, self.targets).targets

    def measured(self, seen: Capture, draw: int, judges: Mapping[str, Judge]) -> pd.DataFrame:
        """What the picks of every run are worth; proxies too are matched by the poses seen.

        Args:
            seen: the capture with the poses that selectors are given.
            draw: of the targets.
            judges: scope -> metrics of a subset.

        Returns:
            draw, method, seed, k, scope, metrics.
        """
        split = evaluation_split(seen, draw, self.split_seed, self.targets)
        problem = Problem.of(seen, split, self.described)
        rows = [
            (draw, method.name, s, k, scope, *judge(picks))
            for method, s in self.runs
            for k, picks in budget_picks(problem, method, self.budgets, [self.seed, draw, s])
            for scope, judge in judges.items()
        ]
        return pd.DataFrame(rows, columns=["draw", "method", "seed", "k", "scope", *METRICS])


def judge_of(reconstructor: Reconstructor, targets: np.ndarray) -> Judge:
    """Mean metrics of subsets on the targets, each distinct one reconstructed once."""
    evaluate = Evaluator.on_frames(reconstructor, targets)
    known = cache(lambda subset: evaluate(np.array(subset)))
    return lambda picks: known(tuple(np.sort(picks).tolist()))


def measure_estimated(
    given: str | Path,
    estimated: str | Path,
    weights: Mapping[str, Sequence[str | Path]],
    output: str | Path,
    *,
    draws: int,
    reconstruction: Mapping,
    config: str,
    **settings,
) -> None:
    """Every selector on given poses, and on estimated ones.

    Args:
        given: a canonical capture with its descriptors.
        estimated: the same images, other poses.
        weights: learned method -> its scorers, one a training seed.
        output: receives draw, method, seed, k, scope, metrics, change: with change `none` all is
            made with the given poses; with `estimated` and scope `selector` the reconstruction is
            still, with scope `both` nothing is.
        draws: of targets.
        reconstruction: the config's section.
        config: digest of the parameters.
        settings: `budgets`, `targets`, `seed`, `split_seed`; see `Trial`.
    """
    trial = Trial.of(given, weights, **settings)
    captures = {EXACT: Capture.load(given), ESTIMATED: Capture.load(estimated)}
    built = {name: reconstructor_of(c, reconstruction) for name, c in captures.items()}
    tables = []
    for draw in range(draws):
        targets = trial.drawn(captures[EXACT], draw)
        exact, own = (judge_of(built[name], targets) for name in (EXACT, ESTIMATED))
        table = trial.measured(captures[EXACT], draw, {BOTH: exact})
        tables.append(table.assign(change=EXACT))
        table = trial.measured(captures[ESTIMATED], draw, {SELECTOR: exact, BOTH: own})
        tables.append(table.assign(change=ESTIMATED))
    write_table(pd.concat(tables), output, units=METRIC_UNITS, config=config)


def measure_noise(
    folder: str | Path,
    weights: Mapping[str, Sequence[str | Path]],
    output: str | Path,
    *,
    levels: Mapping[str, Sequence[float]],
    noises: int,
    reconstruction: Mapping,
    config: str,
    **settings,
) -> None:
    """Every selector on poses with ever more noise, in rotations and in centres; first draw.

    Sparse points stay where they are.

    Args:
        folder: a canonical capture with its descriptors.
        weights: learned method -> its scorers, one a training seed.
        output: receives draw, method, seed, k, scope, metrics, change (`none`, or a key of
            `levels`), level, noise (its seed); scope as in `measure_estimated`.
        levels: `degrees` and `percent` -> levels, see `fsel.experiments.pose_errors.perturbed`.
        noises: seeds of the noise.
        reconstruction: the config's section.
        config: digest of the parameters.
        settings: as in `measure_estimated`.
    """
    trial, capture = Trial.of(folder, weights, **settings), Capture.load(folder)
    targets = trial.drawn(capture, 0)
    exact = judge_of(reconstructor_of(capture, reconstruction), targets)
    table = trial.measured(capture, 0, {BOTH: exact})
    tables = [table.assign(change=EXACT, level=0.0, noise=0)]
    for change, level in [(name, level) for name in levels for level in levels[name]]:
        for noise in range(noises):
            amounts = {"degrees": 0.0, "percent": 0.0, change: level}
            rng = np.random.default_rng([trial.seed, noise])
            poses = perturbed(capture.world_to_camera, **amounts, rng=rng)
            seen = replace(capture, world_to_camera=poses)
            own = judge_of(reconstructor_of(seen, reconstruction), targets)
            table = trial.measured(seen, 0, {SELECTOR: exact, BOTH: own})
            tables.append(table.assign(change=change, level=float(level), noise=noise))
        logger.info("%s %g: %.2f dB", change, level, tables[-1]["psnr"].mean())
    write_table(pd.concat(tables), output, units=METRIC_UNITS, config=config)
