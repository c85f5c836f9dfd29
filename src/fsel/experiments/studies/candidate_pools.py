"""`less_is_more` and the baselines with equal candidate pools and knowledge of the targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from fsel.baselines import METHODS, PAPER
from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.evaluation import measuring
from fsel.evaluation.measuring import Run
from fsel.experiments import specs
from fsel.experiments.draws import measure_draws
from fsel.reconstruct import reconstructor_of
from fsel.report.captions import made_by
from fsel.report.latex import difference, number, plain_table
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, draw_means, summarise
from fsel.report.sweep import BASELINES, LEARNED, place_of
from fsel.selector import pretrained
from fsel.selector.policies import POLICIES
from fsel.utils.files import read_table, write_table, write_text
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job, Table

OURS = POLICIES["less_is_more"]
SETTINGS = {
    "candidates": "from P, targets known by proxies",
    "observed": "from P and O, targets known by proxies",
    "targets": "from P and O, target poses known",
}
POLICY = {
    "candidates": OURS,
    "observed": replace(OURS, pool="observed"),
    "targets": replace(OURS, pool="observed", reference="targets"),
}
"""The paper's policy with the pool of its baselines, and with that of `fsel`."""
BY = ["draw", "setting", *measuring.SELECTION]


def select_pools(
    folder: str | Path,
    splits: Sequence[str | Path],
    weights: Sequence[str | Path],
    rules: Sequence[str | Path],
    picks: str | Path,
    *,
    budgets: Sequence[int],
    seeds: Sequence[int],
    config: str,
) -> None:
    """Picks of ours and the paper's baselines from P, and from P and O; and with target poses.

    Only Nearest and `fsel` look at target poses: they stand beside ours where it does.

    Args:
        folder: a canonical capture with its descriptors.
        splits: split.parquet, one a draw.
        weights: scorers of `less_is_more`, one a training seed; nothing is trained anew.
        rules: scorers of `fsel`.
        picks: receives draw, setting and the columns of `fsel.evaluation.measuring.select`.
        budgets: frames to pick.
        seeds: one a draw.
        config: digest of the parameters.
    """
    learned = [pretrained.own(path) for path in weights]
    others = {
        "candidates": measuring.runs(PAPER.values()),
        "observed": measuring.runs(PAPER.values()),
        "targets": measuring.runs([METHODS["nearest"]], rules),
    }
    tables = []
    for draw, (split, seed) in enumerate(zip(splits, seeds, strict=True)):
        known = Problem.load(folder, split)
        for setting, policy in POLICY.items():
            problem = replace(known, proxies_free=setting != "candidates")
            ours = [Run(policy.method(m.scorer), seed) for seed, m in enumerate(learned)]
            contenders = [*others[setting], *ours]
            chosen = measuring.select(problem, contenders, budgets, measuring.chance(seed))
            tables.append(chosen.assign(draw=draw, setting=setting))
    write_table(pd.concat(tables), picks, units=measuring.PICK_UNITS, config=config)


def evaluate_pools(
    folder: str | Path,
    splits: Sequence[str | Path],
    picks: str | Path,
    evaluation: str | Path,
    *,
    reconstruction: Mapping,
    config: str,
) -> None:
    """Measure what those picks are worth; equal picks are reconstructed once.

    Args:
        folder: a canonical capture.
        splits: split.parquet, one a draw.
        picks: what `select_pools` wrote.
        evaluation: receives draw, setting and the columns of `fsel.evaluation.measuring.measure`.
        reconstruction: the config's section.
        config: digest of the parameters.
    """
    reconstructor = reconstructor_of(Capture.load(folder), reconstruction)
    table = measure_draws(reconstructor, splits, read_table(picks), BY)
    write_table(table, evaluation, units=measuring.measured_units(), config=config)


def candidate_pools(
    evaluations: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[tuple[str, str]],
    budgets: Sequence[int],
    facts: Mapping,
) -> None:
    """Mean PSNR over all evaluation scenes, a block of rows a setting.

    Args:
        evaluations: what `evaluate_pools` wrote, one a scene.
        table: receives LaTeX.
        numbers: receives setting, method, reference (of a difference of ours to it; empty for a
            mean), k, mean, ci_low, ci_high, n.
        scenes: dataset and scene of each file.
        budgets: columns.
        facts: see `captions.made_by`.
    """
    cells = _cells(scenes, evaluations, facts)
    means = summarise(cells, ["psnr"]).assign(reference="")
    gaps = differences(cells, [OURS.name], ["psnr"])
    both = pd.concat([means, gaps]).rename(columns={"dataset": "setting"})
    order = ["setting", "method", "reference", "k", "mean", "ci_low", "ci_high", "n"]
    write_csv(both[order], numbers)
    text = (
        r"\textbf{Equal candidate pools.} PSNR (dB) of the same weights of ours and of "
        "baselines, where all may pick the same frames and know the same of the targets; the paper "
        "compares the first row of ours with the baselines of the second block. In brackets beside "
        "ours: its paired difference to the strongest other row of the block, with a 95\\% "
        f"interval over {means['n'].max()} scenes; bold where that excludes zero. {made_by(facts)}"
    )
    rows = [row for setting in SETTINGS for row in _block(means, gaps, setting, budgets)]
    head = ["Selection", *(f"$K{{=}}{k}$" for k in budgets)]
    write_text(plain_table(head, rows, caption=text, label="tab:candidate_pools"), table)


def _cells(
    scenes: Sequence[tuple[str, str]], evaluations: Sequence[str | Path], facts: Mapping
) -> pd.DataFrame:
    """Table of dataset (the setting), scene, place, draw, method, k, psnr.

    The values are means over targets and seeds.
    """
    tables = []
    for scene, path in zip(map("/".join, scenes), evaluations, strict=True):
        place = place_of(scene, facts)
        for (draw, kind), part in read_table(path).groupby(["draw", "setting"]):
            where = {"dataset": kind, "scene": scene, "place": place, "draw": draw}
            tables.append(draw_means(part, ["psnr"]).assign(**where))
    return pd.concat(tables, ignore_index=True)


def _block(
    means: pd.DataFrame, gaps: pd.DataFrame, setting: str, budgets: Sequence[int]
) -> list[list[str]]:
    """A heading, the baselines, and ours with its distance to the strongest of them."""
    part = means[means["dataset"] == setting].set_index(["method", "k"])["mean"]
    less = gaps[gaps["dataset"] == setting].set_index(["reference", "k"])
    labels = {name: label for name, label in {**BASELINES, **LEARNED}.items() if name in part}
    others = [name for name in labels if name != OURS.name]
    rows = [[rf"\textit{{{SETTINGS[setting]}}}", *[""] * len(budgets)]]
    for name in others:
        rows.append([labels[name], *(number(part[name, k], "psnr") for k in budgets)])
    own = []
    for k in budgets:
        strongest = max(others, key=lambda name: part[name, k])
        gap = less.loc[(strongest, k), ["mean", "ci_low", "ci_high"]]
        own.append(f"{number(part[OURS.name, k], 'psnr')} ({difference(*gap)})")
    return [*rows, [labels[OURS.name], *own]]


def _picked(experiment: Experiment) -> dict[str, Any]:
    return {
        **specs.described_draws(experiment),
        "weights": experiment.weights("less_is_more"),
        "rules": experiment.fsel,
    }


PICKED = Job(
    select_pools,
    outputs={"picks": f"{inputs.SCENE}/candidate_pools_picks.parquet"},
    message="Selecting frames of {wildcards.dataset}/{wildcards.scene} from equal pools",
    inputs=_picked,
    params=lambda experiment: {
        "budgets": experiment.config["budgets"],
        "seeds": experiment.draw_seeds,
    },
    size=Size(4000, 60, "capture"),
)

EVALUATED = Job(
    evaluate_pools,
    outputs={"evaluation": f"{inputs.SCENE}/{{reconstructor}}candidate_pools.parquet"},
    message="Reconstructing {wildcards.dataset}/{wildcards.scene} from picks of equal pools",
    inputs=lambda experiment: specs.picks_of_draws(experiment, "candidate_pools_picks.parquet"),
    params=lambda experiment: {"reconstruction": experiment.reconstruction_of},
    size=Size(4000, 120, "reconstruction"),
)

TABLE = Table(
    candidate_pools,
    outputs=inputs.table_files("{reconstructor}candidate_pools"),
    message="Writing ours and the baselines with equal candidate pools",
    inputs=lambda experiment: {
        "evaluations": inputs.of_scenes(
            experiment.evaluation_scenes, "{reconstructor}candidate_pools.parquet"
        )
    },
    params=lambda experiment: {
        "scenes": experiment.evaluation_scenes,
        "budgets": experiment.config["budgets"],
        "facts": experiment.facts_of,
    },
    category="Paper",
    title="Equal candidate pools",
    caption="PSNR of the same weights of ours and of the paper's baselines with equal candidate "
    "pools: picking from P, from P and O, and knowing the targets' poses. Means over all "
    "evaluation scenes; differences in the csv.",
    jobs=[PICKED, EVALUATED],
)
