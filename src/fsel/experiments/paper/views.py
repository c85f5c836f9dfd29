"""Figures of views: of each dataset, of the full sequence, and of one capture from others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table
from fsel.evaluation.captions import note
from fsel.experiments import specs
from fsel.experiments.paper import crosscapture, pictures
from fsel.experiments.paper.pictures import draw_views
from fsel.experiments.specs import Values
from fsel.selection.frames import frames_of
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.tables import Job, Table


def qualitative(
    folder: File,
    split: File,
    selections: File,
    evaluations: Files,
    figures: Files,
    numbers: File,
    *,
    facts: Mapping,
    methods: Sequence[str],
    views: int,
    k: int,
    reconstruction: Mapping,
) -> None:
    """Held-out views rendered from each method's selection, its cameras from above below them.

    Args:
        folder: a canonical capture of the scene with images large enough.
        selections: what `fsel.stages.select` wrote for it; the first seed of each is shown.
        evaluations: of the scene's draws.
        numbers, methods, views, k: see `pictures.draw_views`.
    """
    capture, roles = Capture.load(folder), read_table(split)
    targets = frames_of(capture, roles[roles["role"] == "target"]["name"].tolist())
    evaluation = pd.concat([read_table(path) for path in evaluations])
    picked = read_table(selections).query("seed == 0")
    shown: Values = {"methods": methods, "views": views, "k": k, "reconstruction": reconstruction}
    draw_views(capture, picked, evaluation, targets, figures, numbers, **shown, note=note(facts))


def real_world(
    folder: File,
    selected_from: File,
    picks: File,
    evaluation: File,
    figures: Files,
    numbers: File,
    *,
    facts: Mapping,
    methods: Sequence[str],
    views: int,
    k: int,
    reconstruction: Mapping,
) -> None:
    """Targets of the first sequence, rendered from what methods picked among the others.

    Args:
        folder: a canonical capture of several sequences with images large enough.
        selected_from: frames.parquet of the capture that was selected from; names connect the two.
        picks, evaluation: what the jobs of `crosscapture.TRIALS` wrote.
        numbers, methods, views, k: see `pictures.draw_views`; `all` is every frame of the other
            sequences.
    """
    capture = Capture.load(folder)
    every = read_table(evaluation).query("draw == 0")
    passes = set(every["held_out"])
    held_out = next(name for name in capture.sequences if name in passes)
    measured = every.query("held_out == @held_out")
    names = read_table(selected_from)["name"]
    targets = frames_of(capture, names[np.unique(measured["target"])].tolist())
    # of a sequence split, no held-out pass is selected from
    rest = set(capture.sequences) - passes or set(capture.sequences) - {held_out}
    others = [n for n, of in zip(capture.names, capture.sequences, strict=True) if of in rest]
    picked = read_table(picks).query("held_out == @held_out and draw == 0 and seed == 0")
    all_others = pd.DataFrame({"method": "all", "name": others, "order": range(len(others))})
    picked = pd.concat([picked, all_others])
    text = f"Views of {held_out}, frames of {len(rest)} other captures of it. {note(facts)}"
    shown: Values = {"methods": methods, "views": views, "k": k, "reconstruction": reconstruction}
    draw_views(capture, picked, measured, targets, figures, numbers, **shown, note=text)


def _of_scene(experiment: Experiment, scene: str) -> Values:
    """The files of dataset/scene that a figure is made of."""
    folder, draws = f"<results>/{scene}", range(experiment.config["draws"])
    return {
        **inputs.capture(folder=f"{folder}/pictures"),
        "split": f"{folder}/draw0/split.parquet",
        "selections": f"{folder}/draw0/selections.parquet",
        "evaluations": [f"{folder}/draw{n}/evaluation.parquet" for n in draws],
    }


def _of_dataset(experiment: Experiment) -> Values:
    """The same of the first evaluation scene of the dataset in the wildcards."""
    files = {d: _of_scene(experiment, f"{d}/{s}") for d, s in inputs.first_scenes(experiment)}

    def chosen(name: str) -> Callable[[Any], Any]:
        return lambda wildcards: files[wildcards.dataset][name]

    return {name: chosen(name) for name in next(iter(files.values()))}


def _of_room(experiment: Experiment) -> Values:
    """Files of the first place that was filmed in several passes."""
    folder = f"<results>/{inputs.joined(inputs.rooms(experiment))[0]}"
    return {
        **inputs.capture(folder=f"{folder}/pictures"),
        "selected_from": f"{folder}/frames.parquet",
        "picks": f"{folder}/crosscapture_picks.parquet",
        "evaluation": f"{folder}/crosscapture.parquet",
    }


def _figure(
    function: Callable[..., None],
    drawn: str,
    files: Callable[[Experiment], Values],
    params: Callable[[Experiment], Values],
    *,
    jobs: Sequence[Job] = (),
    **words: Any,
) -> Table:
    """The rule of a figure of views, its files named so."""
    return Table(
        function,
        outputs={"figures": inputs.figure_files(drawn), "numbers": f"<figures>/{drawn}.csv"},
        inputs=files,
        params=params,
        size=pictures.SIZE,
        category="Paper",
        jobs=[*pictures.JOBS, *jobs],
        programs=pictures.check,
        **words,
    )


CAPTION = (
    "Held-out views rendered from each selection, and the selected cameras from above; open "
    "diamonds are the targets."
)

QUALITATIVE = _figure(
    qualitative,
    "qualitative_{dataset}",
    _of_dataset,
    lambda experiment: {
        **pictures.settings(experiment, 3, experiment.budget_near(40)),
        "facts": lambda wildcards: pictures.facts(experiment, [wildcards.dataset]),
    },
    title="Views",
    caption=CAPTION,
    targets=lambda experiment: [
        f"<figures>/qualitative_{dataset}.pdf" for dataset in experiment.labels()
    ],
)

TEASER = _figure(
    qualitative,
    "teaser",
    lambda experiment: _of_scene(experiment, inputs.joined(experiment.evaluation_scenes)[0]),
    lambda experiment: {
        **pictures.settings(experiment, 1, experiment.budget_near(30)),
        "facts": pictures.facts(experiment, [experiment.evaluation_scenes[0][0]]),
    },
    name="teaser",
    title="Full sequence, Uniform, ours",
    caption=CAPTION,
)

REAL_WORLD = _figure(
    real_world,
    "real_world",
    _of_room,
    lambda experiment: {
        **pictures.settings(experiment, 3, max(crosscapture.budgets_of(experiment))),
        "facts": pictures.facts(experiment, specs.datasets_of(inputs.rooms(experiment)[:1])),
    },
    jobs=crosscapture.TABLE.jobs,
    title="One capture from others of the place",
    caption="Held-out views of one capture, rendered from what each method selects among other "
    "captures of the place, and the selected cameras from above; open diamonds are the targets.",
)
