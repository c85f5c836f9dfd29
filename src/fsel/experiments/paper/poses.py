"""Costs of inexact poses for the selectors: the table and the figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from fsel.core.files import File, Files, read_table, write_text
from fsel.evaluation import curves
from fsel.evaluation.captions import made_by, note
from fsel.evaluation.latex import difference, number, plain_table
from fsel.evaluation.numbers import write_csv
from fsel.evaluation.summary import summarise
from fsel.evaluation.sweep import LABELS, PLAIN, of_scenes
from fsel.experiments.paper import estimate_poses, pose_trials
from fsel.experiments.paper.pose_trials import BOTH, ESTIMATED, EXACT, SELECTOR
from fsel.experiments.specs import Scenes, Values
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.tables import Table

MARKED = ("uniform", "fvs", "kmedoids", "cover", "nearest", "untrained", "less_is_more", "fsel")
PLACE = {name: at for at, name in enumerate(LABELS)}
CASE = ["change", "level", "scope"]
SHARED = ["scene", "draw", "method", "k"]
SIGNS = {"degrees": r"^\circ", "percent": r"\%"}


def changes(measured: Sequence[Mapping]) -> pd.DataFrame:
    """PSNR under every change of the poses, and its paired difference to exact poses.

    Args:
        measured: dataset, scene, path of what `evaluate_estimated` or `evaluate_noise` wrote.

    Returns:
        change, level (NaN where it has none), scope, method, k, mean, ci_low, ci_high, difference,
        difference_low, difference_high, n (scenes); means over seeds, then draws, then scenes.
    """
    cells = pd.concat([_cells(item) for item in measured])
    exact = cells[cells["change"] == EXACT].set_index(SHARED)["psnr"].rename("exact")
    cells = cells.join(exact, on=SHARED).assign(dataset="poses")
    cells["difference"] = cells["psnr"] - cells["exact"]
    parts = []
    for case, part in cells.groupby(CASE, sort=False, dropna=False):
        table = summarise(part, ["psnr", "difference"]).set_index(["method", "k"])
        gaps = table[table["metric"] == "difference"][["mean", "ci_low", "ci_high"]]
        gaps.columns = ["difference", "difference_low", "difference_high"]
        table = table[table["metric"] == "psnr"][["mean", "ci_low", "ci_high", "n"]].join(gaps)
        parts.append(table.reset_index().assign(**dict(zip(CASE, case, strict=True))))
    order = [*CASE, "method", "k", "mean", "ci_low", "ci_high", *gaps.columns, "n"]
    return pd.concat(parts)[order].reset_index(drop=True)


def _cells(item: Mapping) -> pd.DataFrame:
    """Means over targets, then over the seeds of methods and noise; methods in `LABELS`' order."""
    table = read_table(item["path"])
    if "level" not in table:
        table = table.assign(level=float("nan"))
    keys = ["draw", *CASE, "method", "k"]
    if "noise" not in table:
        table = table.assign(noise=0)
    runs = table.groupby([*keys, "noise", "seed"], sort=False, dropna=False)["psnr"].mean()
    means = runs.groupby(keys, sort=False, dropna=False).mean().reset_index()
    means = means.sort_values("method", key=lambda names: names.map(PLACE), kind="stable")
    return means.assign(scene=f"{item['dataset']}/{item['scene']}")


def poses(
    estimated: Files,
    noise: Files,
    errors: Files,
    table: File,
    numbers: File,
    figures: Files,
    drawn: File,
    *,
    scenes: Scenes,
    budgets: Sequence[int],
    facts: Mapping,
) -> None:
    """Given against estimated poses, and against noisy ones, for every selector.

    Args:
        estimated, noise: evaluations of both kinds of trials, one a scene.
        errors: what `estimate_poses` wrote, one a scene.
        table: receives two LaTeX tables.
        numbers: receives captures (`registered` or `usual`) and what `changes` returns.
        figures, drawn: receive PSNR against the noise, and what the figure is made of.
        scenes, budgets, facts: of each file; columns of the first table; of the captions.
    """
    registered, usual = (changes(of_scenes(scenes, paths)) for paths in (estimated, noise))
    both = [registered.assign(captures="registered"), usual.assign(captures="usual")]
    numbered = pd.concat(both)
    write_csv(numbered[["captures", *registered.columns]], numbers)
    first = _estimated_table(registered, errors, budgets, facts)
    write_text(f"{first}\n{_noise_table(usual, facts)}", table)
    write_csv(usual, drawn)
    marked = {name: PLAIN[name] for name in MARKED if name in set(usual["method"])}
    text = (
        f"K = {usual['k'].iloc[0]}; means over {usual['n'].max()} scenes, first draw; noise: root "
        f"mean square of normal angles and offsets; grey: the other selectors. {note(facts)}"
    )
    curves.pose_noise(usual, marked, figures, text)


def _estimated_table(
    changed: pd.DataFrame, errors: Files, budgets: Sequence[int], facts: Mapping
) -> str:
    values = changed.set_index(["change", "scope", "method", "k"])
    middle = budgets[len(budgets) // 2]
    rows = []
    for name in _present(changed):
        row = [LABELS[name]]
        for k in budgets:
            row += [number(values.loc[(EXACT, BOTH, name, k), "mean"], "psnr")]
            row += [_gap(values.loc[(ESTIMATED, BOTH, name, k)])]
        rows.append([*row, _gap(values.loc[(ESTIMATED, SELECTOR, name, middle)])])
    text = (
        r"\textbf{Robustness to estimated poses.} PSNR (dB) with given poses, and how much it "
        "changes with poses and points that COLMAP finds in the images, intrinsics being given; in "
        f"the last column it is the selector alone that has them. {_registered(errors)} In "
        "brackets: paired 95\\% intervals over scenes and draws; bold where they exclude zero. "
        f"Scenes: {changed['n'].max()}. {made_by(facts)}"
    )
    head = ["Selection", *["given", "COLMAP"] * len(budgets), "selector alone"]
    groups = [(f"$K{{=}}{k}$", 2) for k in budgets] + [(f"$K{{=}}{middle}$", 1)]
    return plain_table(head, rows, caption=text, label="tab:poses", groups=groups)


def _registered(errors: Files) -> str:
    """Say how many frames COLMAP placed, and how well."""
    tables = [read_table(path) for path in errors]
    every = pd.concat(tables)
    medians = pd.concat([table[["degrees", "percent"]].median() for table in tables], axis=1)
    least, most = medians.min(axis=1), medians.max(axis=1)
    return (
        f"It placed {every['placed'].sum()} of {len(every)} frames; the others are left out of "
        "both. After the best similarity, scenes' median errors are "
        rf"${least['degrees']:.2f}^\circ$ to ${most['degrees']:.2f}^\circ$ and "
        rf"{least['percent']:.2f}\% to {most['percent']:.2f}\% of the scene's size, the largest "
        "distance of a camera from the cameras' mean."
    )


def _noise_table(changed: pd.DataFrame, facts: Mapping) -> str:
    values = changed.set_index([*CASE, "method"])
    cases = changed[changed["change"] != EXACT][CASE].drop_duplicates()
    cases = cases.sort_values(["scope", "change", "level"], ascending=[False, True, True])
    rows = []
    for name in _present(changed):
        row = [LABELS[name], number(values.loc[(EXACT, 0.0, BOTH, name), "mean"], "psnr")]
        for case in cases.itertuples(index=False):
            row.append(_gap(values.loc[(*case, name)], interval=False))
        rows.append(row)
    k = changed["k"].iloc[0]
    text = (
        rf"\textbf{{Noise in poses}}, $K{{=}}{k}$: PSNR (dB) without, and how much it changes "
        "when the selector alone, or selector and reconstruction, are given rotations or camera "
        "centres with Gaussian noise, whose root mean square heads the columns (of centres in per "
        "cent of the scene's size). Bold: the paired 95\\% interval, which the csv gives, excludes "
        f"zero. Scenes: {changed['n'].max()}, first draw. {made_by(facts)}"
    )
    levels = [f"${level:g}{SIGNS[change]}$" for change, level, _ in cases.to_numpy()]
    groups = [("", 1)]
    for scope, part in cases.groupby("scope", sort=False):
        who = "selector alone" if scope == SELECTOR else "selector and reconstruction"
        groups.append((who, len(part)))
    head = ["Selection", "exact", *levels]
    return plain_table(head, rows, caption=text, label="tab:pose_noise", groups=groups)


def _present(changed: pd.DataFrame) -> list[str]:
    """Selectors that were measured, in the order of the tables."""
    return [name for name in LABELS if name in set(changed["method"])]


def _gap(row: pd.Series, interval: bool = True) -> str:
    bounds = row["difference_low"], row["difference_high"]
    return difference(row["difference"], *bounds, interval=interval)


def _measured(experiment: Experiment) -> Values:
    scenes = inputs.first_scenes(experiment)
    return {
        "estimated": pose_trials.ESTIMATES.measured(scenes),
        "noise": pose_trials.NOISE.measured(scenes),
        "errors": inputs.of_scenes(scenes, "poses/errors.parquet"),
    }


TABLE = Table(
    poses,
    outputs={
        **inputs.table_files("{reconstructor}poses"),
        "figures": inputs.figure_files("{reconstructor}pose_noise"),
        "drawn": "<figures>/{reconstructor}pose_noise.csv",
    },
    inputs=_measured,
    params=lambda experiment: {
        "scenes": inputs.first_scenes(experiment),
        "budgets": pose_trials.budgets_tried(experiment),
        "facts": experiment.facts_of,
    },
    category="Paper",
    title="Estimated and noisy poses",
    caption="PSNR of every selector with given poses, with poses that COLMAP finds in the images, "
    "and with Gaussian noise in rotations and camera centres, seen by the selector alone or by "
    "the reconstruction too. Paired 95% intervals are in the csv.",
    jobs=[*estimate_poses.JOBS, *pose_trials.ESTIMATES.jobs, *pose_trials.NOISE.jobs],
)
