"""Selection for unknown targets, scored on held-out frames and off the path."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from fsel.data.capture import Capture, Views
from fsel.data.problem import Problem
from fsel.evaluation.evaluator import Evaluator
from fsel.evaluation.measuring import SELECTION, Chance, draw_chance, measure, runs, select
from fsel.evaluation.methods import METHODS
from fsel.experiments import specs
from fsel.experiments.specs import Scenes
from fsel.experiments.studies.beside import views_beside
from fsel.reconstruct import Reconstructor, reconstructor_of
from fsel.report.captions import made_by
from fsel.report.figures import TEXT, new_figure, save, shared_legend, style
from fsel.report.latex import plain_table
from fsel.report.numbers import write_csv
from fsel.report.statistics import of_places
from fsel.report.sweep import place_of
from fsel.request.problem import request_problem
from fsel.request.targets import targets_of
from fsel.utils.files import File, Files, read_table, write_table, write_text
from fsel.workflow import inputs
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job, Table

logger = logging.getLogger(__name__)

EVERY = 8  # one frame in so many is held out, as in the common protocol
STARTS = (0, 2, 4, 6)  # the first of them, in turn
BESIDE = 24  # true views off the path of an embedded capture
REFERENCE = "uniform"
COMPARED = (REFERENCE, "fvs", "kmedoids", "facility", "long_lrm", "fsel")
KNOWN = "known"  # `fsel` that knows the held-out frames
LABELS = {**{name: METHODS[name].label for name in COMPARED}, KNOWN: "fsel, known targets"}
HELD, OFF = "held_out", "off_path"
TITLES = {HELD: "held-out frames", OFF: "views off the path"}
UNITS = {"psnr": "dB"}
COLUMNS = ["views", "method", "k", "n", "psnr", "gain", "ci_low", "ci_high", "least", "most"]
SPREAD = 0.8  # frames between the lines of a figure, so that intervals stand side by side
THIN: dict[str, Any] = {"linewidth": 0.8, "markersize": 2.5, "elinewidth": 0.8}
BOLD: dict[str, Any] = {"linewidth": 2.0, "markersize": 4, "elinewidth": 1.6, "zorder": 3}


def evaluate_unknown_targets(
    folder: File,
    evaluation: File,
    *,
    generated: Mapping | None,
    budgets: Sequence[int],
    seed: int,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Measure every method's picks where nobody says what will be rendered.

    Args:
        evaluation: receives views (`held_out`, `off_path`), start, method, seed, k, psnr, ssim.
        generated: family, seed and frames of an embedded capture, whose views off the path are
            cast; None for others.
        budgets: frames to pick; those that a capture has not enough frames for are left out.
    """
    capture = Capture.load(folder)
    described = read_table(Path(folder) / "descriptors.parquet")
    reconstructor = reconstructor_of(capture, reconstruction)
    beside = None
    if generated is not None:
        beside = views_beside(reconstructor.capture, BESIDE, **generated)
    tables = []
    for start in STARTS:
        held = np.arange(start, len(capture), EVERY)
        evaluator = _evaluator(reconstructor, held, beside)
        picks = picks_of(capture, described, held, budgets, draw_chance(seed, start))
        subsets = picks.groupby([*SELECTION])["frame"]
        evaluator.measure_together([frames.to_numpy() for _, frames in subsets])
        table = measure(evaluator, picks)
        table["views"] = np.where(table["target"] < len(held), HELD, OFF)
        means = table.groupby(["views", *SELECTION])[["psnr", "ssim"]].mean().reset_index()
        tables.append(means.assign(start=start))
        logger.info("every eighth frame from %d held out: %d rows", start, len(means))
    write_table(pd.concat(tables), evaluation, units=UNITS, config=config)


def _evaluator(
    reconstructor: Reconstructor, held: np.ndarray, beside: tuple[Views, np.ndarray] | None
) -> Evaluator:
    """The evaluator on the held-out frames, followed by the views off the path."""
    views, truth = reconstructor.capture.view(held), reconstructor.capture.images[held]
    if beside is not None:
        views, truth = views.joined(beside[0]), np.concatenate([truth, beside[1]])
    return Evaluator(reconstructor, np.arange(len(views)), views, truth)


def picks_of(
    capture: Capture,
    described: pd.DataFrame,
    held: np.ndarray,
    budgets: Sequence[int],
    chance: Chance,
) -> pd.DataFrame:
    """Picks of every method at every budget that there are frames for, as of `measuring.select`.

    What is held out is not in what is selected from, but for `known`.
    """
    seen = np.setdiff1d(np.arange(len(capture)), held)
    sizes = [k for k in budgets if k < len(seen)]
    problem = _problem(capture.subset(seen), None, described.iloc[seen])
    picks = select(problem, runs([METHODS[name] for name in COMPARED]), sizes, chance)
    told = select(_problem(capture, held, described), runs([METHODS["fsel"]]), sizes, chance)
    return pd.concat([picks.assign(frame=seen[picks["frame"]]), told.assign(method=KNOWN)])


def _problem(capture: Capture, held: np.ndarray | None, described: pd.DataFrame) -> Problem:
    sharpness = described["sharpness"].to_numpy(np.float64)
    descriptors = np.stack(described["descriptor"].to_list()).astype(np.float32)
    return request_problem(capture, targets_of(capture, held), sharpness, None, descriptors)


def unknown_targets(
    evaluations: Files,
    table: File,
    numbers: File,
    figures: Files,
    *,
    scenes: Scenes,
    facts: Mapping,
) -> None:
    """PSNR without a request, by method and budget, with the difference from every n-th frame.

    Args:
        table, numbers: receive LaTeX, and the columns of `compared`.
        figures: receive the differences against K.
    """
    rows = pd.concat(
        read_table(path).assign(scene=name, place=place_of(name, facts))
        for name, path in zip(map("/".join, scenes), evaluations, strict=True)
    )
    gains = compared(rows)
    write_csv(gains, numbers)
    parts = [_table(part, str(v), facts) for v, part in gains.groupby("views", sort=True)]
    write_text("\n".join(parts), table)
    _draw(gains, figures)


def compared(rows: pd.DataFrame) -> pd.DataFrame:
    """Table of views, method, k, n (places), psnr, gain over uniform and its bounds.

    The bounds are ci_low and ci_high, and the least and most gain of a place.

    Args:
        rows: of all scenes, what `evaluate_unknown_targets` wrote with the columns scene
            and place; scenes of one place are averaged.
    """
    scenes = rows.groupby(["views", "k", "method", "place", "scene"])["psnr"].mean()
    each = scenes.groupby(["views", "k", "method", "place"]).mean()
    out = []
    for (views, k), part in each.groupby(level=["views", "k"]):
        cells = part.droplevel(["views", "k"]).unstack("method")
        for method in [name for name in LABELS if name in cells]:
            gain = (cells[method] - cells[REFERENCE]).to_numpy()
            interval = of_places(gain)
            mean, low, high, *_ = interval
            ends = gain.min(), gain.max()
            out.append((views, method, k, len(cells), cells[method].mean(), mean, low, high, *ends))
    return pd.DataFrame(out, columns=COLUMNS)


def _table(gains: pd.DataFrame, views: str, facts: Mapping) -> str:
    budgets = sorted(gains["k"].unique())
    cells = []
    for method, part in gains.groupby("method", sort=False):
        row = part.set_index("k")
        texts = []
        for k in budgets:
            beyond = row.loc[k, "ci_low"] > 0
            text = f"{row.loc[k, 'psnr']:.2f} ({row.loc[k, 'gain']:+.2f})"
            texts.append(rf"\textbf{{{text}}}" if beyond else text)
        cells.append([LABELS[str(method)], *texts, f"{part['least'].min():+.2f}"])
    head = ["Selection", *(f"$K={k}$" for k in budgets), "worst"]
    count = gains.groupby("k")["n"].first()
    by_budget = ", ".join(f"{n} at $K={k}$" for k, n in count.items())
    counted = by_budget if count.nunique() > 1 else str(count.iloc[0])
    caption = (
        rf"\textbf{{Unknown targets, {TITLES[views]}.}} PSNR in dB where nobody says what will "
        "be rendered, and in brackets the difference from uniform, bold where its 95\\% interval "
        f"over scenes is above zero; last the worst scene. One frame in {EVERY} is held out and "
        f"not announced, with {len(STARTS)} beginnings; known targets: \\texttt{{fsel}} is told of "
        f"them. Scenes: {counted}. {made_by(facts)}"
    )
    return plain_table(head, cells, caption=caption, label=f"tab:unknown_targets_{views}")


def _draw(gains: pd.DataFrame, figures: Files) -> None:
    kinds = [views for views in TITLES if (gains["views"] == views).any()]
    figure = new_figure((TEXT, 2.8))
    for axis, views in zip(figure.subplots(1, len(kinds), squeeze=False)[0], kinds, strict=True):
        part = gains[(gains["views"] == views) & (gains["method"] != REFERENCE)]
        for number, (method, line) in enumerate(part.groupby("method", sort=False)):
            beside = SPREAD * (number - (part["method"].nunique() - 1) / 2)
            reach = [line["gain"] - line["ci_low"], line["ci_high"] - line["gain"]]
            drawn = style(number) | (BOLD if method == "fsel" else THIN)
            at, label = line["k"] + beside, LABELS[str(method)]
            axis.errorbar(at, line["gain"], np.nan_to_num(reach), label=label, **drawn)
        axis.axhline(0, color="0.6", linewidth=0.8)
        title = f"{TITLES[views]}, {gains.loc[gains['views'] == views, 'n'].max()} scenes"
        axis.set_title(title, fontsize=8)
        axis.set_xlabel("frames picked", fontsize=8)
        axis.set_ylabel("dB over uniform", fontsize=8)
        axis.tick_params(labelsize=7)
    shared_legend(figure, "lower", 3)
    save(figure, figures)


EVALUATED = Job(
    evaluate_unknown_targets,
    outputs={"evaluation": f"{inputs.SCENE}/{{reconstructor}}unknown_targets.parquet"},
    message="Selecting from {wildcards.dataset}/{wildcards.scene} for views that nobody states",
    inputs=lambda experiment: inputs.capture(inputs.DESCRIBED),
    params=lambda experiment: {
        "generated": lambda wildcards: experiment.generated(wildcards.dataset, wildcards.scene),
        "budgets": experiment.config["budgets"],
        "seed": specs.scene_seed(experiment, "untold"),  # its former name: the draws stay
        "reconstruction": experiment.reconstruction_of,
    },
    size=Size(4000, 30, "reconstruction"),
)

TABLE = Table(
    unknown_targets,
    outputs={
        **inputs.table_files("{reconstructor}unknown_targets"),
        "figures": inputs.figure_files("{reconstructor}unknown_targets"),
    },
    inputs=lambda experiment: {
        "evaluations": inputs.of_scenes(
            experiment.evaluation_scenes, "{reconstructor}unknown_targets.parquet"
        )
    },
    params=lambda experiment: {
        "scenes": experiment.evaluation_scenes,
        "facts": experiment.facts_of,
    },
    category="Beyond the paper",
    title="Unknown targets",
    caption="PSNR of selections where nobody says what will be rendered, on frames that were held "
    "out and not announced and, of embedded captures, on true views off the path; with the "
    "difference from uniform.",
    jobs=[EVALUATED],
)
