"""The scheme of an experiment: its trials, every method's picks for them, and what those are worth.

An experiment says which selection problems it has (`Trials.of`); `select` and `evaluate` are the
same for all, and so is the way from what they write to a table's cells and to its rules.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd

from fsel.baselines import METHODS
from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import Split
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import (
    PICK_UNITS,
    Chance,
    Run,
    learned_runs,
    measure,
    measured_units,
    runs,
    select,
)
from fsel.experiments import specs
from fsel.experiments.specs import Scenes, Values
from fsel.metrics import Metrics
from fsel.reconstruct import Reconstructor, reconstructor_of
from fsel.utils.files import File, Files, read_table, write_table
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job, Table

logger = logging.getLogger(__name__)


def unchanged(problem: Problem) -> Problem:
    """The problem as it is."""
    return problem


@dataclass(frozen=True)
class Trial:
    """A selection problem, and what tells it from the others of its experiment.

    Attributes:
        key: column -> value.
        capture: as the methods see it.
        split: of its frames.
        budgets: frames to pick.
        chance: of the methods.
        change: of the problem, by the experiment.
        entered: runs of the learned methods -> all runs; None for those of the experiment.
        scopes: value of the column `scope` -> capture to reconstruct; None for `capture` alone,
            without the column.
        frames: (n,) their numbers in the capture on disk, where they are others.
    """

    key: Mapping[str, Any]
    capture: Capture
    split: Split
    budgets: Sequence[int]
    chance: Chance
    change: Callable[[Problem], Problem] = unchanged
    entered: Callable[[list[Run]], list[Run]] | None = None
    scopes: Mapping[str, Capture] | None = None
    frames: np.ndarray | None = None


@dataclass(frozen=True)
class Trials:
    """The trials of an experiment, and the rules `select_NAME` and `evaluate_NAME` that they take.

    Attributes:
        home: `module:NAME` of this object.
        name: of the rules and of the files.
        of: captures, splits where it takes them, and `settings` as keywords -> trials.
        settings: experiment -> name -> value, or a function of the wildcards that returns it.
        methods: those without training, keys of `fsel.baselines.METHODS`.
        weights: experiment -> scorers of the learned methods.
        captures: folders of the captures within the scene's, with a slash at their end; the first
            holds descriptors, and the files are written to it or above it.
        folder: where the files are written, within the scene's, with a slash at its end.
        splits: whether `of` takes the splits of the experiment's draws.
        masked: whether metrics are taken inside the masks alone.
        metrics: experiment -> metrics.
        minutes: of an evaluation.
    """

    home: str
    name: str
    of: Callable[..., Iterator[Trial]]
    settings: Callable[[Experiment], Values]
    methods: Sequence[str]
    weights: Callable[[Experiment], list[str]] = specs.all_scorers
    captures: Sequence[str] = ("",)
    folder: str = ""
    splits: bool = False
    masked: bool = False
    metrics: Callable[[Experiment], Metrics] = specs.metrics
    minutes: int = 60

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
        """Every method's picks for every trial.

        Args:
            described: their frames' descriptors.
            picks: receives the trials' columns and those of `fsel.evaluation.measuring.select`.
            settings: keywords of `of`.
        """
        table = read_table(described)
        learned, tables = learned_runs(weights), []
        every = [*runs([METHODS[name] for name in self.methods]), *learned]
        for trial in self._trials(folders, splits, settings):
            rows = table if trial.frames is None else table.iloc[trial.frames]
            problem = trial.change(Problem.of(trial.capture, trial.split, rows))
            entered = every if trial.entered is None else trial.entered(learned)
            chosen = select(problem, entered, trial.budgets, trial.chance)
            if trial.frames is not None:
                chosen["frame"] = trial.frames[chosen["frame"]]
            tables.append(chosen.assign(**trial.key))
            logger.info("%s: %d targets", dict(trial.key), len(problem.targets))
        write_table(pd.concat(tables), picks, units=PICK_UNITS, config=config)

    def evaluate(
        self,
        folders: Files,
        picks: File,
        evaluation: File,
        *,
        splits: Files = (),
        settings: Mapping,
        reconstruction: Mapping,
        metrics: Metrics,
        config: str,
    ) -> None:
        """Measure what the picks are worth on each trial's targets.

        Args:
            evaluation: receives the trials' columns and those of
                `fsel.evaluation.measuring.measure`.
            folders, splits, settings, config: as of `select`.
        """
        picked, tables = read_table(picks), []
        evaluator = _evaluators(reconstruction, metrics, self.masked)
        for trial in self._trials(folders, splits, settings):
            own = (picked[list(trial.key)] == list(trial.key.values())).all(axis=1)
            part, frames = picked[own], trial.frames
            if frames is not None:
                part = part.assign(frame=np.searchsorted(frames, part["frame"]))
            for scope, capture in (trial.scopes or {"": trial.capture}).items():
                table = measure(evaluator(capture, trial.split.targets), part)
                if frames is not None:
                    table["target"] = frames[table["target"]]
                columns = {"scope": scope} if trial.scopes else {}
                tables.append(table.assign(**columns, **trial.key))
                logger.info("%s %s: %.2f dB", dict(trial.key), scope, table["psnr"].mean())
        write_table(pd.concat(tables), evaluation, units=measured_units(metrics), config=config)

    def _trials(self, folders: Files, splits: Files, settings: Mapping) -> Iterator[Trial]:
        loaded = [Capture.load(folder) for folder in folders]
        drawn = [[Split.load(path) for path in splits]] if self.splits else []
        return self.of(*loaded, *drawn, **settings)

    @property
    def files(self) -> dict[str, str]:
        """The picks and the evaluation of a scene."""
        place = f"{inputs.SCENE}/{self.folder}"
        measured = f"{place}{{reconstructor}}{self.name}.parquet"
        return {"picks": f"{place}{self.name}_picks.parquet", "evaluation": measured}

    @property
    def jobs(self) -> list[Job]:
        """The rules that select and evaluate."""
        picked = Job(
            self.select,
            name=f"select_{self.name}",
            home=f"{self.home}.select",
            outputs={"picks": self.files["picks"]},
            message=f"Selecting on {{wildcards.dataset}}/{{wildcards.scene}} for {self.name}",
            inputs=lambda experiment: {
                **self._read(experiment),
                "described": f"{inputs.SCENE}/{self.captures[0]}{inputs.FILES['descriptors']}",
                "weights": self.weights(experiment),
            },
            params=lambda experiment: {"settings": self._settings(experiment)},
            size=Size(4000, 60, "capture"),
        )
        measured = Job(
            self.evaluate,
            name=f"evaluate_{self.name}",
            home=f"{self.home}.evaluate",
            outputs={"evaluation": self.files["evaluation"]},
            message=f"Reconstructing {{wildcards.dataset}}/{{wildcards.scene}} for {self.name}",
            inputs=lambda experiment: {**self._read(experiment), "picks": self.files["picks"]},
            params=lambda experiment: {
                "settings": self._settings(experiment),
                "reconstruction": experiment.reconstruction_of,
                "metrics": self.metrics(experiment),
            },
            size=Size(4000, self.minutes, "reconstruction"),
        )
        return [picked, measured]

    def _read(self, experiment: Experiment) -> Values:
        kinds = [*inputs.CAPTURE, "masks"] if self.masked else inputs.CAPTURE
        draws = {"splits": inputs.of_draws(experiment, "split.parquet")} if self.splits else {}
        names = {kind: inputs.FILES[kind] for kind in kinds}
        scene = inputs.SCENE
        return draws | {k: [f"{scene}/{at}{n}" for at in self.captures] for k, n in names.items()}

    def _settings(self, experiment: Experiment) -> Callable[[Any], Values]:
        values = self.settings(experiment)
        return lambda wildcards: {
            name: value(wildcards) if callable(value) else value for name, value in values.items()
        }

    def measured(self, scenes: Scenes) -> list[str]:
        """The evaluations of scenes."""
        name = self.files["evaluation"].removeprefix(f"{inputs.SCENE}/")
        return inputs.of_scenes(scenes, name)


def _evaluators(
    reconstruction: Mapping, metrics: Metrics, masked: bool
) -> Callable[[Capture, np.ndarray], Evaluator]:
    """A function of capture and targets that keeps the last two: what trials share is made once."""

    @lru_cache(2)
    def bound(capture: Capture) -> Reconstructor:
        return reconstructor_of(capture, reconstruction)

    @lru_cache(2)
    def made(capture: Capture, targets: tuple[int, ...]) -> Evaluator:
        return Evaluator.on_frames(bound(capture), np.array(targets), masked, metrics)

    return lambda capture, targets: made(capture, tuple(targets.tolist()))


def table_of(
    function: Callable[..., None],
    trials: Trials,
    *,
    scenes: Callable[[Experiment], Scenes],
    params: Callable[[Experiment], Values],
    jobs: Sequence[Job] = (),
    **words: Any,
) -> Table:
    """The rule that makes a table of trials' evaluations, and the rules before it.

    Args:
        function: of the table, which the files are named by.
        trials: whose evaluations it takes.
        scenes: experiment -> the scenes.
        params: of the function besides `scenes` and `facts`.
        jobs: rules before those of the trials.
        words: title, caption and category of `Table`.
    """
    return Table(
        function,
        **words,
        inputs=lambda experiment: {"evaluations": trials.measured(scenes(experiment))},
        params=lambda experiment: {
            "scenes": scenes(experiment),
            "facts": specs.facts_about(experiment, specs.datasets_of(scenes(experiment))),
            **params(experiment),
        },
        jobs=[*jobs, *trials.jobs],
    )
