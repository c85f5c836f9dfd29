"""Selection for unknown targets, scored on held-out frames and off the path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache, partial
from operator import attrgetter
from typing import Any

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table, write_text
from fsel.core.problem import Problem
from fsel.core.split import Split
from fsel.evaluation.captions import made_by
from fsel.evaluation.figures import TEXT, new_figure, save, shared_legend, style
from fsel.evaluation.latex import plain_table
from fsel.evaluation.measuring import SELECTION, Run, draw_chance, runs
from fsel.evaluation.methods import METHODS
from fsel.evaluation.numbers import write_csv
from fsel.evaluation.statistics import of_places
from fsel.evaluation.sweep import place_of
from fsel.experiments import scheme, specs
from fsel.experiments.specs import Scenes
from fsel.experiments.studies.beside import views_beside
from fsel.selection.problem import request_problem
from fsel.selection.targets import targets_of
from fsel.workflow import inputs

EVERY = 8  # one frame in so many is held out, as in the common protocol
STARTS = (0, 2, 4, 6)  # the first of them, in turn
BESIDE = 24  # true views off the path of an embedded capture
REFERENCE = "uniform"
COMPARED = (REFERENCE, "fvs", "kmedoids", "facility", "long_lrm", "fsel")
KNOWN = "known"  # `fsel` that knows the held-out frames
LABELS = {**{name: METHODS[name].label for name in COMPARED}, KNOWN: "fsel, known targets"}
HELD, OFF = "held_out", "off_path"
TITLES = {HELD: "held-out frames", OFF: "views off the path"}
COLUMNS = ["views", "method", "k", "n", "psnr", "gain", "ci_low", "ci_high", "least", "most"]
SPREAD = 0.8  # frames between the lines of a figure, so that intervals stand side by side
THIN: dict[str, Any] = {"linewidth": 0.8, "markersize": 2.5, "elinewidth": 0.8}
BOLD: dict[str, Any] = {"linewidth": 2.0, "markersize": 4, "elinewidth": 1.6, "zorder": 3}


def trials(
    capture: Capture, *, generated: Mapping | None, budgets: Sequence[int], seed: int
) -> Iterator[scheme.Trial]:
    """Yield every eighth frame held out and not announced, from four beginnings; then announced.

    What is held out is not in what is selected from, but where it is known.

    Args:
        generated: family, seed and frames of an embedded capture, whose views off the path are
            cast; None for others.
        budgets: those that a capture has not enough frames for are left out.
    """
    beside = lru_cache(partial(views_beside, count=BESIDE, **generated)) if generated else None
    every, none = np.arange(len(capture)), np.empty(0, np.int64)
    for start in STARTS:
        held = every[start::EVERY]
        seen = np.setdiff1d(every, held)
        split, chance = Split(held, none, none, none), draw_chance(seed, start)
        sizes = [k for k in budgets if k < len(seen)]
        for known in (False, True):
            yield scheme.Trial(
                {"start": start, "known": known},
                capture if known else capture.subset(seen),
                split,
                sizes,
                chance,
                problem=partial(_problem, known),
                entered=partial(_entered, known),
                frames=every if known else seen,
                whole=capture,
                beside=beside,
            )


def _problem(known: bool, capture: Capture, split: Split, described: pd.DataFrame) -> Problem:
    sharpness = described["sharpness"].to_numpy(np.float64)
    descriptors = np.stack(described["descriptor"].to_list()).astype(np.float32)
    targets = targets_of(capture, split.targets if known else None)
    return request_problem(capture, targets, sharpness, None, descriptors)


def _entered(known: bool, learned: list[Run]) -> list[Run]:
    return runs([METHODS[name] for name in (["fsel"] if known else COMPARED)])


def scores_of(scene: str, path: File, facts: Mapping) -> pd.DataFrame:
    """Table of scene, place, views, start, method, seed, k, psnr: means over views.

    Args:
        scene: `dataset/scene`.
        path: what the job of `TRIALS` wrote of it.
    """
    rows = read_table(path)
    rows["views"] = np.where(rows["target"] < 0, OFF, HELD)
    rows["method"] = rows["method"].mask(rows["known"], KNOWN)
    means = rows.groupby(["start", "views", *SELECTION])["psnr"].mean().reset_index()
    return means.assign(scene=scene, place=place_of(scene, facts))


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
    pairs = zip(map("/".join, scenes), evaluations, strict=True)
    gains = compared(pd.concat(scores_of(name, path, facts) for name, path in pairs))
    write_csv(gains, numbers)
    parts = [_table(part, str(v), facts) for v, part in gains.groupby("views", sort=True)]
    write_text("\n".join(parts), table)
    _draw(gains, figures)


def compared(rows: pd.DataFrame) -> pd.DataFrame:
    """Table of views, method, k, n (places), psnr, gain over uniform and its bounds.

    The bounds are ci_low and ci_high, and the least and most gain of a place.

    Args:
        rows: `scores_of` all scenes; those of one place are averaged.
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


TRIALS = scheme.Trials(
    f"{__name__}:TRIALS",
    "unknown_targets",
    trials,
    settings=lambda experiment: {
        "generated": lambda wildcards: experiment.generated(wildcards.dataset, wildcards.scene),
        "budgets": experiment.config["budgets"],
        "seed": specs.scene_seed(experiment, "untold"),  # its former name: the draws stay
    },
    weights=lambda experiment: [],
    metrics=lambda experiment: ("psnr",),
    minutes=30,
)

TABLE = scheme.table_of(
    unknown_targets,
    TRIALS,
    scenes=attrgetter("evaluation_scenes"),
    outputs={
        **inputs.table_files("{reconstructor}unknown_targets"),
        "figures": inputs.figure_files("{reconstructor}unknown_targets"),
    },
    category="Beyond the paper",
    title="Unknown targets",
    caption="PSNR of selections where nobody says what will be rendered, on frames that were held "
    "out and not announced and, of embedded captures, on true views off the path; with the "
    "difference from uniform.",
)
