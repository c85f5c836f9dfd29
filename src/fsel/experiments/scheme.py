"""Trials of an experiment, every method's picks for them, what those are worth, and its tables."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table, write_table
from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.evaluation.evaluator import evaluators
from fsel.evaluation.latex import bold_if, number
from fsel.evaluation.measuring import (
    PICK_UNITS,
    SELECTION,
    RngFactory,
    Run,
    learned_runs,
    measure,
    measured_units,
    rng_by_name,
    runs,
    select,
)
from fsel.evaluation.summary import differences, draw_means, leaders, summarise
from fsel.evaluation.sweep import place_of
from fsel.metrics import Metrics
from fsel.selectors.baselines import METHODS

logger = logging.getLogger(__name__)

Scenes = Sequence[tuple[str, str]]
"""Dataset and scene of each."""
KEYS = ["dataset", "method", "k", "metric"]
GAP = ["difference", "difference_low", "difference_high"]


@dataclass(frozen=True)
class ExperimentCase:
    """A selection problem, and what tells it from the others of its experiment.

    Attributes:
        key: column -> value.
        rng_of: see `fsel.evaluation.measuring.RngFactory`.
        problem: capture, split and descriptors of its frames -> the problem.
        entered: runs of the learned methods -> all runs; None for those of the experiment.
        frames: (n,) their numbers in the capture on disk, where they are others.
    """

    key: Mapping[str, Any]
    capture: Capture
    split: Split
    budgets: Sequence[int]
    rng_of: RngFactory
    problem: Callable[[Capture, Split, pd.DataFrame], Problem] = Problem.of
    entered: Callable[[list[Run]], list[Run]] | None = None
    frames: np.ndarray | None = None


def every_draw(
    capture: Capture,
    splits: Sequence[Split],
    *,
    budgets: Sequence[int] = (),
    problem: Callable[[Capture, Split, pd.DataFrame], Problem] = Problem.of,
    **key: Any,
) -> Iterator[ExperimentCase]:
    """Yield a trial for each draw; `key` is the scene's."""
    for draw, split in enumerate(splits):
        yield ExperimentCase(
            {**key, "draw": draw}, capture, split, budgets, rng_by_name(0), problem
        )


@dataclass(frozen=True)
class Trials:
    """The trials of an experiment: what its rules `select_NAME` and `evaluate_NAME` run.

    Attributes:
        of: captures, splits where the rules have them, and `settings` as keywords -> trials.
        methods: those without training, keys of `fsel.selectors.baselines.METHODS`.
        read: files of picks of another rule -> picks with the trials' columns; None for `select`'s.
        by: columns that tell one selection of a trial from another.
        masked: whether metrics are taken inside the masks alone.
    """

    of: Callable[..., Iterator[ExperimentCase]]
    methods: Sequence[str] = ()
    read: Callable[[Files], pd.DataFrame] | None = None
    by: Sequence[str] = SELECTION
    masked: bool = False

    def select(
        self,
        folders: Files,
        described: File,
        weights: Files,
        picks: File,
        *,
        splits: Files = (),
        settings: Mapping,
        config: str,
    ) -> None:
        """Write every method's picks for every trial, the columns of
        `fsel.evaluation.measuring.select` and of the trials; `settings` are keywords of `of`."""
        table = read_table(described)
        learned, tables = learned_runs(weights), []
        every = [*runs([METHODS[name] for name in self.methods]), *learned]
        for trial in self._trials(folders, splits, settings):
            rows = table if trial.frames is None else table.iloc[trial.frames]
            problem = trial.problem(trial.capture, trial.split, rows)
            entered = every if trial.entered is None else trial.entered(learned)
            chosen = pd.DataFrame(select(problem, entered, trial.budgets, trial.rng_of))
            if trial.frames is not None:
                chosen["frame"] = trial.frames[chosen["frame"]]
            tables.append(chosen.assign(**trial.key))
            logger.info("%s: %d targets", dict(trial.key), len(problem.targets))
        write_table(pd.concat(tables), picks, units=PICK_UNITS, config=config)

    def evaluate(
        self,
        folders: Files,
        picks: Files,
        evaluation: File,
        *,
        splits: Files = (),
        settings: Mapping,
        reconstruction: Mapping,
        metrics: Metrics,
        config: str,
    ) -> None:
        """Measure the picks, as `read` takes them, on each trial's targets into `evaluation`."""
        picked = self.read(picks) if self.read else pd.concat(map(read_table, picks))
        tables = []
        evaluator = evaluators(reconstruction, metrics, self.masked)
        for trial in self._trials(folders, splits, settings):
            own = (picked[list(trial.key)] == list(trial.key.values())).all(axis=1)
            part, frames = picked[own], trial.frames
            if frames is not None:
                part = part.assign(frame=np.searchsorted(frames, part["frame"]))
            on_targets = evaluator(trial.capture, trial.split.targets)
            table = pd.DataFrame(measure(on_targets, part, self.by))
            if frames is not None:
                table["target"] = frames[table["target"]]
            tables.append(table.assign(**trial.key))
            logger.info("%s: %.2f dB", dict(trial.key), table["psnr"].mean())
        write_table(pd.concat(tables), evaluation, units=measured_units(metrics), config=config)

    def _trials(self, folders: Files, splits: Files, settings: Mapping) -> Iterator[ExperimentCase]:
        loaded = [Capture.load(folder) for folder in folders]
        drawn = [[Split.load(path) for path in splits]] if splits else []
        return self.of(*loaded, *drawn, **settings)


def cells_of(
    scenes: Scenes,
    evaluations: Files,
    metrics: Metrics,
    facts: Mapping,
    by: Sequence[str] = ("draw",),
) -> pd.DataFrame:
    """Return method, k, the metrics, dataset, scene (`dataset/scene`), place and the columns of
    `by`, a row a trial, method and budget: means over targets, then over seeds."""
    tables = []
    for (dataset, scene), path in zip(scenes, evaluations, strict=True):
        name = f"{dataset}/{scene}"
        where = {"dataset": dataset, "scene": name, "place": place_of(name, facts)}
        for key, part in read_table(path).groupby(list(by)):
            columns = where | dict(zip(by, key, strict=True))
            tables.append(draw_means(part, metrics).assign(**columns))
    return pd.concat(tables, ignore_index=True)


def with_leads(cells: pd.DataFrame, methods: Sequence[str], metrics: Metrics) -> pd.DataFrame:
    """Return `summarise`'s means with `leads`: each 95 % interval to all others excludes zero."""
    means = summarise(cells, metrics)
    gaps = differences(cells, methods, metrics)
    ahead = {(name, *key) for name, part in gaps.groupby("dataset") for key in leaders(part)}
    keys = zip(*(means[key] for key in KEYS), strict=True)
    return means.assign(leads=[key in ahead for key in keys])


def against(cells: pd.DataFrame, reference: str) -> pd.DataFrame:
    """Return by method the mean PSNR at one budget and `GAP`, paired, to a reference."""
    gaps = differences(cells, cells["method"].unique().tolist(), ["psnr"])
    gaps = gaps[gaps["reference"] == reference].set_index("method")[["mean", "ci_low", "ci_high"]]
    gaps.columns = pd.Index(GAP)
    return summarise(cells, ["psnr"]).set_index("method").join(gaps)


def led_rows(
    means: pd.DataFrame,
    labels: Mapping[str, str],
    columns: Sequence[tuple[str, int]],
    metrics: Metrics,
) -> list[list[str]]:
    """Return a row for each method of `labels`: its label, then a cell for each dataset and budget
    of `columns` and metric, of the means of `with_leads`."""
    values = means.set_index(KEYS)
    cells = [(dataset, k, metric) for dataset, k in columns for metric in metrics]
    rows = []
    for name, label in labels.items():
        found = [(values.loc[(dataset, name, k, metric)], metric) for dataset, k, metric in cells]
        texts = [bold_if(row["leads"], number(row["mean"], metric)) for row, metric in found]
        rows.append([label, *texts])
    return rows
