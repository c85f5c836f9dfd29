"""Views of one capture rendered from other captures of the place (paper, `fig:real_world`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fsel.data.capture import Capture
from fsel.experiments import specs
from fsel.experiments.paper import crosscapture, pictures
from fsel.experiments.paper.pictures import draw_views, frames_named, picks_of, resolved
from fsel.experiments.specs import Values
from fsel.report.captions import note
from fsel.utils.files import File, Files, read_table
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.tables import Table


def real_world(
    folder: File,
    selected_from: File,
    picks: File,
    evaluation: File,
    figures: Files,
    numbers: File,
    *,
    methods: Sequence[str],
    views: int,
    k: int,
    reconstruction: Mapping,
    facts: Mapping,
) -> None:
    """Targets of the first sequence, rendered from what methods picked among the others.

    Args:
        folder: a canonical capture of several sequences with images large enough.
        selected_from: frames.parquet of the capture that was selected from; names connect the two.
        picks: what `crosscapture.select_crosscapture` wrote.
        evaluation: what `crosscapture.evaluate_crosscapture` wrote.
        numbers: see `pictures.draw_views`.
        methods, views, k, reconstruction, facts: as in `qualitative.qualitative`; `all` is every
            frame of the other sequences.
    """
    capture = Capture.load(folder)
    every = read_table(evaluation).query("draw == 0")
    passes = set(every["held_out"])
    held_out = next(name for name in capture.sequences if name in passes)
    measured = every.query("held_out == @held_out")
    names = read_table(selected_from)["name"]
    targets = frames_named(capture, names[np.unique(measured["target"])].tolist())
    picked = read_table(picks).query("held_out == @held_out and draw == 0 and seed == 0")
    # of a sequence split, no held-out pass is selected from
    rest = set(capture.sequences) - passes or set(capture.sequences) - {held_out}
    others = np.flatnonzero(np.isin(capture.sequences, list(rest)))
    chosen = {
        method: others if method == "all" else frames_named(capture, picks_of(picked, method, k))
        for method in resolved(methods, measured, k)
    }
    draw_views(
        capture,
        chosen,
        targets,
        figures,
        numbers,
        views=views,
        reconstruction=reconstruction,
        note=f"Views of {held_out}, frames of {len(rest)} other captures of it. {note(facts)}",
    )


def _files(experiment: Experiment) -> Values:
    """Files of the first place that was filmed in several passes."""
    folder = f"<results>/{inputs.joined(inputs.rooms(experiment))[0]}"
    return {
        **inputs.capture(folder=f"{folder}/pictures"),
        "selected_from": f"{folder}/frames.parquet",
        "picks": f"{folder}/crosscapture_picks.parquet",
        "evaluation": f"{folder}/crosscapture.parquet",
    }


TABLE = Table(
    real_world,
    outputs={"figures": inputs.figure_files("real_world"), "numbers": "<figures>/real_world.csv"},
    inputs=_files,
    params=lambda experiment: {
        **pictures.settings(experiment, 3, max(crosscapture.budgets_of(experiment))),
        "facts": pictures.facts(experiment, specs.datasets_of(inputs.rooms(experiment)[:1])),
    },
    size=pictures.SIZE,
    category="Paper",
    title="One capture from others of the place",
    caption="Held-out views of one capture, rendered from what each method selects among other "
    "captures of the place, and the selected cameras from above; open diamonds are the targets.",
    jobs=[*pictures.JOBS, *crosscapture.TABLE.jobs],
    needs=[pictures.check],
)
