"""What labels by another reconstructor change for `ours`: the same problems, searched by each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import spearmanr

from fsel.files import read_table, write_text
from fsel.report.captions import captures_of, printed
from fsel.report.latex import difference, number, plain_table, tex
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, summarise
from fsel.report.sweep import named, sweep_cells

ORDER = ["judge", "labels", "reference", "k", "metric", "mean", "ci_low", "ci_high", "n"]


def label_judge(
    evaluations: Sequence[str | Path],
    labels: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    problems: Sequence[str],
    labellers: Mapping[str, Mapping],
    judges: Mapping[str, Mapping],
    labelled: int,
    budgets: Sequence[int],
    facts: Mapping,
) -> None:
    """Mean PSNR of `ours` trained on each labeller's subsets, under each judge.

    Args:
        evaluations: what `fsel.stages.evaluate` wrote of the scorers of the first labeller under
            the first judge, one a problem; then of the next labeller; then of the next judge.
        labels: what `fsel.stages.label` wrote by the first labeller, one a labelled item; then by
            the next.
        table: receives LaTeX.
        numbers: receives judge, labels, reference (of a difference; empty for a mean), k, metric,
            mean, ci_low, ci_high, n. The metric `spearman` has no judge: see `agreement`.
        problems: `dataset/scene/draw0` of each evaluation of one labeller and judge.
        labellers, judges: name -> `reconstructor` and `long_side` to print.
        labelled: items that each of them labelled.
        budgets: one column of each judge.
        facts: see `captions.captures_of`, and `places`.
    """
    cells = _cells(evaluations, problems, list(labellers), list(judges), facts)
    first, *others = labellers
    means = summarise(cells, ["psnr"], trained=list(labellers)).assign(reference="")
    gaps = differences(cells, others, ["psnr"], trained=list(labellers))
    gaps = gaps[gaps["reference"] == first]
    agreed = {
        name: agreement(labels[:labelled], labels[at * labelled : (at + 1) * labelled])
        for at, name in enumerate(labellers)
    }
    pairs = {"labels": others, "mean": [agreed[name] for name in others]}
    known = pd.DataFrame(pairs).assign(
        judge="", reference=first, metric="spearman", k="", n=labelled
    )
    both = pd.concat([means, gaps]).rename(columns={"dataset": "judge", "method": "labels"})
    write_csv(pd.concat([both, known])[ORDER], numbers)
    columns = [(judge, k) for judge in judges for k in budgets]
    rows = [_row(means, gaps, name, columns, agreed[name], name == first) for name in labellers]
    head = ["Labels by", "agreement", *(f"$K{{=}}{k}$" for _, k in columns)]
    groups = [("", 1)] + [(printed(judge), len(budgets)) for judge in judges.values()]
    scenes = len({problem.rpartition("/")[0] for problem in problems})
    text = caption(labellers, labelled, scenes, len(problems), facts)
    made = plain_table(head, rows, caption=text, label="tab:label_judge", groups=groups)
    write_text(made, table)


def agreement(own: Sequence[str | Path], other: Sequence[str | Path]) -> float:
    """Mean over items of Spearman's rank correlation of the fitness of the first generation.

    The searches of an item begin with the same subsets, drawn from the same seed.

    Args:
        own, other: labels of the same items by two reconstructors.

    Returns:
        NaN where the fitness of one is the same for all subsets.
    """
    found = []
    for mine, theirs in zip(own, other, strict=True):
        first, second = (_first_generation(path) for path in (mine, theirs))
        shared = first.index.intersection(second.index)
        pair = first[shared], second[shared]
        varied = len(shared) > 1 and all(part.nunique() > 1 for part in pair)
        found.append(spearmanr(*pair).statistic if varied else np.nan)
    return float(np.mean(found))


def _first_generation(path: str | Path) -> pd.Series:
    """Subset -> fitness."""
    labels = read_table(path)
    first = labels[labels["generation"] == 0]
    return pd.Series(first["fitness"].to_numpy(), index=[tuple(s) for s in first["subset"]])


def _cells(
    evaluations: Sequence[str | Path],
    problems: Sequence[str],
    labellers: Sequence[str],
    judges: Sequence[str],
    facts: Mapping,
) -> pd.DataFrame:
    """dataset (the judge), method (the labeller), scene, place, draw, seed, k, psnr."""
    paths, tables = iter(evaluations), []
    for judge in judges:
        for labeller in labellers:
            own = [next(paths) for _ in problems]
            cells = sweep_cells(named(problems, own), ["psnr"], facts=facts, by_seed=True)
            scene = cells["dataset"] + "/" + cells["scene"]
            tables.append(cells.assign(dataset=judge, scene=scene, method=labeller))
    return pd.concat(tables, ignore_index=True)


def _row(
    means: pd.DataFrame,
    gaps: pd.DataFrame,
    name: str,
    columns: Sequence[tuple[str, int]],
    agreed: float,
    first: bool,
) -> list[str]:
    """A labeller's PSNR under every judge, with its difference to the first labeller."""
    own = means[means["method"] == name].set_index(["dataset", "k"])["mean"]
    less = gaps[gaps["method"] == name].set_index(["dataset", "k"])
    cells = []
    for column in columns:
        text = number(own[column], "psnr")
        if not first:
            text += f" ({difference(*less.loc[column, ['mean', 'ci_low', 'ci_high']])})"
        cells.append(text)
    return [rf"\texttt{{{tex(name)}}}", "" if first else f"{agreed:.2f}", *cells]


def caption(
    labellers: Mapping[str, Mapping], labelled: int, scenes: int, problems: int, facts: Mapping
) -> str:
    """What was labelled by what, and how much, in LaTeX; arguments as in `label_judge`.

    Args:
        labellers, labelled, facts: see `label_judge`.
        scenes, problems: that the scorers are judged on.
    """
    names = ", ".join(map(printed, labellers.values()))
    return (
        r"\textbf{Labels by another reconstructor.} PSNR (dB) on held-out targets of ours, "
        f"trained on {labelled} label items that each of {names} has searched with the same "
        "settings and seeds, under each judge. In brackets: the paired difference to the first "
        f"row, with a 95\\% interval over {scenes} scenes ({problems} draws of targets) and the "
        "training seeds; bold where that excludes zero. Agreement: Spearman's correlation, with "
        "the first row, of the fitness of the subsets that both searches begin with, averaged over "
        "items. The searches are shorter than the paper's, and the items fewer: the rows compare "
        f"with each other alone. Captures: {captures_of(facts)}."
    )
