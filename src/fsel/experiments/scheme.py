"""The scheme of an experiment: its trials, every method's picks for them, and what those are worth.

An experiment says which selection problems it has (`Trials.of`); `select` and `evaluate` are the
same for all, and so is the way from what they write to a table's cells and to its rules.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table, write_table
from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.evaluation.evaluator import evaluators
from fsel.evaluation.measuring import (
    PICK_UNITS,
    SELECTION,
    Chance,
    Run,
    chance,
    learned_runs,
    measure,
    measured_units,
    runs,
    select,
)
from fsel.experiments import specs
from fsel.experiments.specs import Scenes, Values
from fsel.metrics import Metrics
from fsel.selectors.baselines import METHODS
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job, Table, nothing

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Trial:
    """A selection problem, and what tells it from the others of its experiment.

    Attributes:
        key: column -> value.
        capture: as the methods see it.
        split: of its frames.
        budgets: frames to pick.
        chance: of the methods.
        problem: capture, split and descriptors of its frames -> the problem.
        entered: runs of the learned methods -> all runs; None for those of the experiment.
        frames: (n,) their numbers in the capture on disk, where they are others.
    """

    key: Mapping[str, Any]
    capture: Capture
    split: Split
    budgets: Sequence[int]
    chance: Chance
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
) -> Iterator[Trial]:
    """Yield a trial a draw; `budgets` where methods without chance select, `key` is the scene's."""
    for draw, split in enumerate(splits):
        yield Trial({**key, "draw": draw}, capture, split, budgets, chance(0), problem)


@dataclass(frozen=True)
class Trials:
    """The trials of an experiment, and the rules `select_NAME` and `evaluate_NAME` that they take.

    Attributes:
        home: `module:NAME` of this object.
        name: of the rules and of the files.
        of: captures, splits where it takes them, and `settings` as keywords -> trials.
        settings: experiment -> name -> value, or a function of the wildcards that returns it.
        methods: those without training, keys of `fsel.selectors.baselines.METHODS`.
        weights: experiment -> scorers of the learned methods.
        picks: experiment -> files of picks that another rule makes; None for `select`.
        read: those files -> picks with the trials' columns, which the files have without it.
        by: columns that tell one selection of a trial from another.
        captures: folders of the captures within the scene's, with a slash at their end; the first
            holds descriptors, and the files are written to it or above it.
        folder: where the files are written, within the scene's, with a slash at its end.
        draws: experiment -> the draws whose splits `of` takes; None where it takes none.
        masked: whether metrics are taken inside the masks alone.
        metrics: experiment -> metrics.
        minutes: of an evaluation.
    """

    home: str
    name: str
    of: Callable[..., Iterator[Trial]]
    settings: Callable[[Experiment], Mapping[str, Any]] = nothing
    methods: Sequence[str] = ()
    weights: Callable[[Experiment], list[str]] = attrgetter("scorers")
    picks: Callable[[Experiment], list[str]] | None = None
    read: Callable[[Files], pd.DataFrame] | None = None
    by: Sequence[str] = SELECTION
    captures: Sequence[str] = ("",)
    folder: str = ""
    draws: Callable[[Experiment], Iterable[int]] | None = None
    masked: bool = False
    metrics: Callable[[Experiment], Metrics] = attrgetter("metrics")
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
            problem = trial.problem(trial.capture, trial.split, rows)
            entered = every if trial.entered is None else trial.entered(learned)
            chosen = pd.DataFrame(select(problem, entered, trial.budgets, trial.chance))
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
        """Measure what the picks are worth on each trial's targets.

        Args:
            picks: what `read` takes, or of `select`.
            evaluation: receives the trials' columns and those of
                `fsel.evaluation.measuring.measure`.
            folders, splits, settings, config: as of `select`.
        """
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

    def _trials(self, folders: Files, splits: Files, settings: Mapping) -> Iterator[Trial]:
        loaded = [Capture.load(folder) for folder in folders]
        drawn = [[Split.load(path) for path in splits]] if self.draws else []
        return self.of(*loaded, *drawn, **settings)

    @property
    def files(self) -> dict[str, str]:
        """The picks and the evaluation of a scene."""
        place = f"{inputs.SCENE}/{self.folder}"
        measured = f"{place}{{reconstructor}}{self.name}.parquet"
        return {"picks": f"{place}{self.name}_picks.parquet", "evaluation": measured}

    @property
    def jobs(self) -> list[Job]:
        """The rules that select, unless another one does, and evaluate."""
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
            inputs=lambda experiment: {
                **self._read(experiment),
                "picks": self.picks(experiment) if self.picks else [self.files["picks"]],
            },
            params=lambda experiment: {
                "settings": self._settings(experiment),
                "reconstruction": experiment.reconstruction_of,
                "metrics": self.metrics(experiment),
            },
            size=Size(4000, self.minutes, "reconstruction"),
        )
        return [measured] if self.picks else [picked, measured]

    def _read(self, experiment: Experiment) -> Values:
        kinds = [*inputs.CAPTURE, "masks"] if self.masked else inputs.CAPTURE
        draws: Values = {}
        if self.draws:
            draws["splits"] = inputs.of_draws(experiment, "split.parquet", self.draws(experiment))
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


def table_of(
    function: Callable[..., None],
    trials: Trials,
    *,
    scenes: Callable[[Experiment], Scenes],
    params: Callable[[Experiment], Mapping[str, Any]] = nothing,
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
