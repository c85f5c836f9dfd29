"""Views of selections: rendered targets of several methods, and their cameras."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pandas as pd

from fsel.data.capture import Capture
from fsel.experiments.paper import pictures
from fsel.experiments.paper.pictures import draw_views, frames_named, picks_of, resolved
from fsel.experiments.specs import Values
from fsel.report.captions import note
from fsel.utils.files import File, Files, read_table
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.tables import Table


def qualitative(
    folder: File,
    split: File,
    selections: File,
    evaluations: Files,
    figures: Files,
    numbers: File,
    *,
    methods: Sequence[str],
    views: int,
    k: int,
    reconstruction: Mapping,
    facts: Mapping,
) -> None:
    """Held-out views rendered from each method's selection, its cameras from above below them.

    Args:
        folder: a canonical capture of the scene with images large enough; frames are found in it by
            their names.
        selections: what `fsel.stages.select` wrote for it.
        evaluations: of the scene's draws, from which `strongest` is found.
        numbers: see `pictures.draw_views`.
        methods: columns, in order; the first training or random seed of each is shown. `strongest`
            is the paper's baseline with the highest PSNR at k that is not among them.
        views: targets drawn.
        k: frames; `all` takes its own number.
    """
    capture = Capture.load(folder)
    roles = read_table(split)
    targets = frames_named(capture, roles[roles["role"] == "target"]["name"].tolist())
    evaluation = pd.concat([read_table(path) for path in evaluations])
    picked = read_table(selections).query("seed == 0")
    chosen = {
        method: frames_named(capture, picks_of(picked, method, k))
        for method in resolved(methods, evaluation, k)
    }
    draw_views(
        capture,
        chosen,
        targets,
        figures,
        numbers,
        views=views,
        reconstruction=reconstruction,
        note=note(facts),
    )


CAPTION = (
    "Held-out views rendered from each selection, and the selected cameras from above; open "
    "diamonds are the targets."
)


def _of_scene(experiment: Experiment, scene: str) -> Values:
    """The files of dataset/scene that a figure is made of."""
    draws = range(experiment.config["draws"])
    folder = f"<results>/{scene}"
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


def _first(experiment: Experiment) -> str:
    return "/".join(experiment.evaluation_scenes[0])


QUALITATIVE = Table(
    qualitative,
    outputs={
        "figures": inputs.figure_files("qualitative_{dataset}"),
        "numbers": "<figures>/qualitative_{dataset}.csv",
    },
    inputs=_of_dataset,
    params=lambda experiment: {
        **pictures.settings(experiment, 3, experiment.budget_near(40)),
        "facts": lambda wildcards: pictures.facts(experiment, [wildcards.dataset]),
    },
    size=pictures.SIZE,
    category="Paper",
    title="Views",
    caption=CAPTION,
    jobs=pictures.JOBS,
    needs=[pictures.check],
    targets=lambda experiment: [
        f"<figures>/qualitative_{dataset}.pdf" for dataset in experiment.labels()
    ],
)

TEASER = Table(
    qualitative,
    name="teaser",
    outputs={"figures": inputs.figure_files("teaser"), "numbers": "<figures>/teaser.csv"},
    inputs=lambda experiment: _of_scene(experiment, _first(experiment)),
    params=lambda experiment: {
        **pictures.settings(experiment, 1, experiment.budget_near(30)),
        "facts": pictures.facts(experiment, [_first(experiment).partition("/")[0]]),
    },
    size=pictures.SIZE,
    category="Paper",
    title="Full sequence, Uniform, ours",
    caption=CAPTION,
    jobs=pictures.JOBS,
    needs=[pictures.check],
)
