"""The adaptive budget beside fixed ones, on evaluation scenes."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files, read_table, write_table, write_text
from fsel.core.split import Split, coverage_split
from fsel.evaluation.captions import made_by
from fsel.evaluation.latex import plain_table, tex
from fsel.evaluation.measuring import chance
from fsel.evaluation.numbers import write_csv
from fsel.experiments import scheme, specs
from fsel.experiments.specs import Scenes, Values
from fsel.experiments.studies import budget_curves
from fsel.experiments.studies.bench import Bench, measure_cold
from fsel.selection.budget import Auto, find, view_shift
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job, Table

logger = logging.getLogger(__name__)

RULES = ("auto", "memory")
UNITS = {"coverage": "%", "psnr": "dB", "seconds": "s, fit and rendering", "bytes": "bytes"}
REQUEST = ["coverage", "draw"]
VALUES = ["k", "psnr", "seconds", "bytes"]
MEAN = "Mean"


def trials(
    capture: Capture, splits: Sequence[Split], *, coverages: Sequence[int], seed: int
) -> Iterator[scheme.Trial]:
    """Yield the experiment's draws (coverage 0), and requests of parts of the capture.

    All observed frames are picked, in the order of `fsel`: fewer are the first of more.

    Args:
        coverages: per cent of the capture that further requests are drawn from.
    """
    requests = [(0, draw, split) for draw, split in enumerate(splits)]
    requests += [(c, 0, coverage_split(capture, c, seed)) for c in coverages]
    for coverage, draw, split in requests:
        every = [len(split.candidates) + len(split.proxies)]
        key = {"coverage": coverage, "draw": draw}
        yield scheme.Trial(key, capture, split, every, chance(0))


def evaluate_budgets(
    folder: File,
    splits: Files,
    record: File,
    picks: File,
    evaluation: File,
    *,
    budgets: Sequence[int],
    coverages: Sequence[int],
    auto: Mapping,
    seed: int,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Measure what the picks that each rule keeps are worth and cost, nothing being cached.

    Args:
        record: what `fsel.experiments.studies.budget_curves.fit_budget` wrote.
        evaluation: receives coverage, draw, rule (`auto`, `memory`: the same within a memory,
            `fixed`), k, psnr, seconds, bytes.
        budgets: fixed ones.
        coverages, seed: see `trials`.
    """
    capture, loaded = Capture.load(folder), [Split.load(path) for path in splits]
    small = capture.resized(reconstruction["long_side"])
    worth = np.array(json.loads(Path(record).read_text(encoding="utf-8"))["worth"])
    rules = [Auto(auto["threshold"]), Auto(auto["threshold"], auto["memory"])]
    picked, rows = read_table(picks).set_index(REQUEST), []
    for trial in trials(capture, loaded, coverages=coverages, seed=seed):
        frames = picked.loc[tuple(trial.key.values()), "frame"].to_numpy(np.int64)
        kept = kept_of(trial, frames, rules, worth, small.size)
        costs = {
            k: _cost(small, frames[:k], trial.split, reconstruction) for k in {*kept, *budgets}
        }
        named = [*zip(RULES, kept, strict=True), *(("fixed", k) for k in budgets)]
        rows += [{**trial.key, "rule": rule, "k": k, **costs[k]} for rule, k in named]
        logger.info("%s: %s", dict(trial.key), costs)
    write_table(pd.DataFrame(rows), evaluation, units=UNITS, config=config)


def kept_of(
    trial: scheme.Trial,
    frames: np.ndarray,
    rules: Sequence[Auto],
    worth: np.ndarray,
    size: tuple[int, int],
) -> list[int]:
    """Number of picks that each rule keeps.

    Args:
        trial: the request.
        frames: all observed ones, in the order that they are picked.
        rules: the budgets to find.
        worth: see `fsel.selection.budget.predicted`.
        size: (width, height) of the images that are reconstructed from.
    """
    pool = np.sort(frames)
    shift = view_shift(trial.capture, pool, trial.capture.view(trial.split.targets))
    ordered = shift[np.searchsorted(pool, frames)]
    return [find(ordered, rule, size, worth).frames for rule in rules]


def _cost(small: Capture, picks: np.ndarray, split: Split, reconstruction: Mapping) -> dict:
    truth = np.asarray(small.images[split.targets])
    place = Bench(small, np.sort(picks), small.view(split.targets), truth, None)
    cost, _ = measure_cold(place, reconstruction)
    seconds = cost["fit_seconds"] + cost["render_seconds"]
    return {"psnr": cost["psnr"], "seconds": seconds, "bytes": cost["bytes"]}


def budget(
    evaluations: Files,
    table: File,
    numbers: File,
    *,
    scenes: Scenes,
    datasets: Mapping[str, str],
    auto: Mapping,
    facts: Mapping,
) -> None:
    """K, PSNR and seconds of both rules beside every fixed budget.

    Args:
        numbers: receives request, rule, k, psnr, seconds and bytes.
    """
    rows = pd.concat(
        read_table(path).assign(scene=f"{datasets[dataset]}, {scene.removeprefix('evaluation')}")
        for (dataset, scene), path in zip(scenes, evaluations, strict=True)
    )
    drawn, sized = rows[rows["coverage"] == 0], rows[rows["coverage"] > 0]
    parts = {"draws": means(drawn, "scene")}
    text = [_table(parts["draws"], "Scene", _caption(parts["draws"], auto, facts), "tab:budget")]
    if len(sized):
        parts["sizes"] = means(sized.assign(scene=sized["coverage"].map("{}%".format)), "scene")
        caption = _sized_caption(parts["sizes"])
        text.append(_table(parts["sizes"], "Targets from", caption, "tab:budget_requests"))
    write_csv(pd.concat(parts, names=["requests"]).reset_index(0), numbers)
    write_text("\n".join(text), table)


def means(rows: pd.DataFrame, by: str) -> pd.DataFrame:
    """Table of request, rule, budget (of fixed ones, else 0), k, psnr, seconds, bytes.

    The last row is the mean of all.

    Args:
        rows: what `evaluate_budgets` wrote.
        by: column that tells the table's rows.
    """
    rows = rows.assign(budget=rows["k"].where(rows["rule"] == "fixed", 0))
    keys = ["rule", "budget"]
    each = rows.groupby([by, *keys], sort=False)[VALUES].mean().reset_index()
    whole = each.groupby(keys, sort=False)[VALUES].mean().reset_index().assign(**{by: MEAN})
    both = pd.concat([each, whole], ignore_index=True).rename(columns={by: "request"})
    return both.assign(k=both["k"].round(2))


def at_same_number(rows: pd.DataFrame) -> tuple[float, float]:
    """Mean frames of `auto`, and PSNR where every request gets that number, interpolated between
    the fixed budgets; NaN where it is none between them.

    Args:
        rows: see `means`.
    """
    whole = rows[rows["request"] == MEAN].set_index("rule")
    fixed = whole.loc[["fixed"]].sort_values("budget")
    frames = float(whole.loc["auto", "k"])
    psnr = np.interp(frames, fixed["budget"], fixed["psnr"], left=np.nan, right=np.nan)
    return frames, float(psnr)


def _table(rows: pd.DataFrame, first: str, caption: str, label: str) -> str:
    budgets = sorted(rows.loc[rows["rule"] == "fixed", "budget"].unique())
    cells = []
    for request, part in rows.groupby("request", sort=False):
        ruled = part.set_index(["rule", "budget"])
        kept = [ruled.loc[(rule, 0)] for rule in RULES]
        fixed = [ruled.loc[("fixed", budget)] for budget in budgets]
        texts = [_cell(row) for row in fixed]
        best = int(np.argmax([row["psnr"] for row in fixed]))
        texts[best] = rf"\textbf{{{texts[best]}}}"
        own = (text for row in kept for text in (f"{row['k']:.1f}", _cell(row)))
        cells.append([tex(request), *own, *texts])
    head = [first, *("$K$", "PSNR / ms") * 2, *(f"$K={budget}$" for budget in budgets)]
    groups = [("auto", 2), ("auto, within memory", 2), ("PSNR / ms of a fixed $K$", len(budgets))]
    return plain_table(head, cells, caption=caption, label=label, groups=groups)


def _cell(row: pd.Series) -> str:
    return f"{row['psnr']:.2f} / {1e3 * row['seconds']:.0f}"


def _caption(rows: pd.DataFrame, auto: Mapping, facts: Mapping) -> str:
    return (
        r"\textbf{Adaptive budget.} \texttt{fsel}'s picks in order, kept until no further ones are "
        f"predicted to bring {auto['threshold']:g} dB each; the same within {auto['memory']:,} "
        r"bytes of splats; and fixed numbers of frames, the best of a row in bold. Milliseconds of "
        "reconstruction and rendering on one thread, nothing cached. "
        f"{facts['draws']} draws of targets a scene. {_same(rows)} {made_by(facts)}"
    )


def _sized_caption(rows: pd.DataFrame) -> str:
    return (
        r"\textbf{Adaptive budget and the size of the request.} The same where targets come from a "
        rf"part of the capture: means over all scenes, one draw each. {_same(rows)}"
    )


def _same(rows: pd.DataFrame) -> str:
    frames, psnr = at_same_number(rows)
    if np.isnan(psnr):
        return f"Mean number of frames of auto: {frames:.1f}, beyond the fixed ones."
    return (
        f"Every request served by the mean number of frames of auto, {frames:.1f}: {psnr:.2f} dB "
        "(between budgets, interpolated)."
    )


def _settings(experiment: Experiment) -> Values:
    return {
        "coverages": experiment.config["coverages"],
        "seed": specs.scene_seed(experiment, "budget"),
    }


TRIALS = scheme.Trials(
    f"{__name__}:TRIALS",
    "budgets",
    trials,
    settings=_settings,
    weights=lambda experiment: experiment.fsel[:1],
    draws=specs.draws,
)

EVALUATED = Job(
    evaluate_budgets,
    outputs={"evaluation": TRIALS.files["evaluation"]},
    message="Measuring adaptive and fixed budgets on {wildcards.dataset}/{wildcards.scene}",
    inputs=lambda experiment: {
        **inputs.capture(),
        "splits": inputs.of_draws(experiment, "split.parquet"),
        "record": budget_curves.RECORD,
        "picks": TRIALS.files["picks"],
    },
    params=lambda experiment: {
        **_settings(experiment),
        **{key: experiment.config[key] for key in ("budgets", "auto")},
        "reconstruction": experiment.reconstruction_of,
    },
    size=Size(4000, 30, "reconstruction"),
)

TABLE = Table(
    budget,
    inputs=lambda experiment: {"evaluations": TRIALS.measured(experiment.evaluation_scenes)},
    params=lambda experiment: {
        "scenes": experiment.evaluation_scenes,
        "datasets": experiment.labels(),
        "auto": experiment.config["auto"],
        "facts": experiment.facts_of,
    },
    category="Speed",
    title="Adaptive budget",
    caption="Frames, PSNR and seconds of reconstruction where the number of frames is found "
    "(`-k auto`), with and without a bound on memory, beside fixed numbers; by scene, and by how "
    "much of the capture is asked for.",
    jobs=[*budget_curves.JOBS, TRIALS.jobs[0], EVALUATED],
)
