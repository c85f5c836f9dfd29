"""The adaptive budget beside fixed ones, on evaluation scenes."""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.split import Split, coverage_split
from fsel.evaluation.measuring import Run, chance, picks_at, runs
from fsel.experiments import specs
from fsel.experiments.specs import Scenes
from fsel.experiments.studies import budget_curves
from fsel.experiments.studies.bench import Bench, measure_cold
from fsel.report.captions import made_by
from fsel.report.latex import plain_table, tex
from fsel.report.numbers import write_csv
from fsel.report.sweep import of_scenes
from fsel.request.budget import Auto, find, most, view_shift
from fsel.utils.files import File, Files, read_table, write_table, write_text
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


def select_budgets(
    folder: File,
    splits: Files,
    weights: File,
    record: File,
    picks: File,
    *,
    budgets: Sequence[int],
    coverages: Sequence[int],
    auto: Mapping,
    seed: int,
    long_side: int,
    config: str,
) -> None:
    """`fsel`'s picks: what the rules keep of them, and every fixed number.

    Args:
        splits: split.parquet, one a draw of the experiment.
        record: what `fsel.experiments.studies.budget_curves.fit_budget` wrote.
        picks: receives coverage (0: a draw of the experiment), draw, rule (`auto`, `memory`: the
            same within a memory, `fixed`), k, order, frame.
        budgets: fixed ones.
        coverages: per cent of the capture that further requests are drawn from.
        seed: of those requests.
        long_side: pixels of the images that are reconstructed from, whose memory counts.
    """
    capture, (run,) = Capture.load(folder), runs([], [weights])
    described = read_table(Path(folder) / "descriptors.parquet")
    worth = np.array(json.loads(Path(record).read_text(encoding="utf-8"))["worth"])
    size = capture.resized(long_side).size
    rules = [Auto(auto["threshold"]), Auto(auto["threshold"], auto["memory"])]
    tables = []
    requests = [(0, draw, Split.load(path)) for draw, path in enumerate(splits)]
    requests += [(coverage, 0, coverage_split(capture, coverage, seed)) for coverage in coverages]
    for coverage, draw, split in requests:
        problem = Problem.of(capture, split, described)
        frames, kept = kept_of(problem, run, rules, max(budgets), worth, size)
        rows = [*zip(RULES, kept, strict=True), *(("fixed", k) for k in budgets)]
        for rule, k in rows:
            head = {"coverage": coverage, "draw": draw, "rule": rule, "k": k}
            tables.append(pd.DataFrame({**head, "order": range(k), "frame": frames[:k]}))
        logger.info("%d %%, request %d: %s", coverage, draw, dict(zip(RULES, kept, strict=True)))
    write_table(pd.concat(tables), picks, units={"coverage": "%"}, config=config)


def kept_of(
    problem: Problem,
    run: Run,
    rules: Sequence[Auto],
    least: int,
    worth: np.ndarray,
    size: tuple[int, int],
) -> tuple[np.ndarray, list[int]]:
    """Picks in order, at least so many, and how many of them each rule keeps.

    Args:
        problem: the selection problem.
        run: of a nested method.
        rules: the budgets to find.
        least: picks, where the pool has as many.
        worth: see `fsel.request.budget.predicted`.
        size: (width, height) of the images that are reconstructed from.
    """
    pool = problem.pool(run.method.pool)
    shift = view_shift(problem.capture, pool, problem.targets)
    count = max(most(shift, rule, worth) for rule in rules)
    count = min(max(count, least), len(shift))
    (picks,) = picks_at(problem, run, [count], chance(0))
    rows = np.searchsorted(pool, picks.frames)
    return picks.frames, [find(shift[rows], rule, size, worth).frames for rule in rules]


def evaluate_budgets(
    folder: File,
    splits: Files,
    picks: File,
    evaluation: File,
    *,
    seed: int,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Measure what those picks are worth and cost, nothing being cached.

    Args:
        splits: split.parquet, one a draw of the experiment.
        evaluation: receives coverage, draw, rule, k, psnr, seconds, bytes.
        seed: of the requests beyond the experiment's draws.
    """
    capture = Capture.load(folder)
    small = capture.resized(reconstruction["long_side"])
    rows = []
    for (coverage, draw), part in read_table(picks).groupby(REQUEST, sort=False):
        split = coverage_split(capture, coverage, seed) if coverage else Split.load(splits[draw])
        costs: dict[int, dict] = {}
        for (rule, k), kept in part.groupby(["rule", "k"], sort=False):
            if k not in costs:  # fewer picks are the first of more
                frames = kept["frame"].to_numpy(np.int64)
                costs[k] = _cost(small, frames, split, reconstruction)
            rows.append({"coverage": coverage, "draw": draw, "rule": rule, "k": k, **costs[k]})
        logger.info("%d %%, request %d: %s", coverage, draw, costs)
    write_table(pd.DataFrame(rows), evaluation, units=UNITS, config=config)


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
        read_table(item["path"]).assign(
            scene=f"{datasets[item['dataset']]}, {item['scene'].removeprefix('evaluation')}"
        )
        for item in of_scenes(scenes, evaluations)
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


def _picked(experiment: Experiment) -> dict[str, Any]:
    return {
        **specs.described_draws(experiment),
        "weights": experiment.fsel[0],
        "record": budget_curves.RECORD,
    }


def _settings(experiment: Experiment) -> dict[str, Any]:
    return {
        **{key: experiment.config[key] for key in ("budgets", "coverages", "auto")},
        "seed": specs.scene_seed(experiment, "budget"),
        "long_side": experiment.reconstruction["long_side"],
    }


PICKED = Job(
    select_budgets,
    outputs={"picks": f"{inputs.SCENE}/budgets_picks.parquet"},
    message="Selecting adaptive and fixed numbers of frames of "
    "{wildcards.dataset}/{wildcards.scene}",
    inputs=_picked,
    params=_settings,
    size=Size(2000, 10, "capture"),
)

EVALUATED = Job(
    evaluate_budgets,
    outputs={"evaluation": f"{inputs.SCENE}/{{reconstructor}}budgets.parquet"},
    message="Measuring adaptive and fixed budgets on {wildcards.dataset}/{wildcards.scene}",
    inputs=lambda experiment: specs.picks_of_draws(experiment, "budgets_picks.parquet"),
    params=lambda experiment: {
        "seed": specs.scene_seed(experiment, "budget"),
        "reconstruction": experiment.reconstruction_of,
    },
    size=Size(4000, 30, "reconstruction"),
)

TABLE = Table(
    budget,
    inputs=lambda experiment: {
        "evaluations": inputs.of_scenes(
            experiment.evaluation_scenes, "{reconstructor}budgets.parquet"
        )
    },
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
    jobs=[*budget_curves.JOBS, PICKED, EVALUATED],
)
