"""Tables of what ways to learn, and sets of inputs, are worth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from fsel.experiments.learning.cases import INPUT_CASES, LEARNERS
from fsel.experiments.learning.pairs import RULE
from fsel.files import read_table, write_text
from fsel.report.captions import made_by
from fsel.report.latex import difference, number, plain_table, tex
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, draw_means, summarise

MEAN = -1  # the budget of a mean over all budgets, in this module alone
ORDER = ["role", "method", "reference", "k", "mean", "ci_low", "ci_high", "p", "n"]
RECORD = ["lessons", "seeds", "seconds"]


def learning(
    evaluations: Sequence[str | Path],
    logs: Sequence[str | Path],
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[tuple[str, str, str]],
    learners: Sequence[str],
    facts: Mapping,
) -> None:
    """Every learner's PSNR less the rule's.

    Args:
        evaluations: what `picking.evaluate_learned` wrote, one a scene.
        logs: what `learn.learn` wrote, one a learner.
        table: receives LaTeX.
        numbers: receives role, method, reference (of a difference; empty for a mean), k (empty for
            the mean over budgets), mean, ci_low, ci_high, p, n, lessons, seeds, seconds.
        scenes: role, dataset and scene of each evaluation.
        learners: of each log.
        facts: see `captions.made_by`.
    """
    cells = cells_of(evaluations, scenes, facts)
    means, gaps = compared(cells, dict.fromkeys(learners, RULE.name))
    records = pd.concat([read_table(path) for path in logs]).set_index("method")
    _write_numbers(means, gaps, records, numbers)
    roles = list(dict.fromkeys(role for role, _, _ in scenes))
    rows = [_row(RULE.name, r"\textbf{fsel}, the rule", means, gaps, roles, None)]
    for name in learners:
        label = tex(LEARNERS[name].label)
        rows.append(_row(name, label, means, gaps, roles, records.loc[name]))
    head = ["Learner", "requests", "s", *(f"{tex(role)} scenes" for role in roles)]
    text = (
        r"\textbf{Learning from labelled requests.} PSNR (dB), mean over budgets, and in brackets "
        f"the paired difference to the rule with a 95\\% interval over {_places(means, roles)} and "
        "training seeds; bold where that excludes zero. Choices are made on validation scenes. "
        "Seconds are of the processor, for all seeds, labels not counted. " + made_by(facts)
    )
    write_text(plain_table(head, rows, caption=text, label="tab:learning"), table)


def inputs(
    evaluations: Sequence[str | Path],
    log: str | Path,
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[tuple[str, str, str]],
    facts: Mapping,
) -> None:
    """What each group of inputs is worth, added to what the rule reads and left out of all.

    Args:
        evaluations, table, numbers, scenes, facts: as in `learning`.
        log: what `learn.learn_inputs` wrote.
    """
    cells = cells_of(evaluations, scenes, facts)
    references = {name: case.reference for name, case in INPUT_CASES.items()}
    means, gaps = compared(cells, references)
    records = read_table(log).set_index("method")
    _write_numbers(means, gaps, records, numbers)
    roles = list(dict.fromkeys(role for role, _, _ in scenes))
    rows = []
    for name, case in INPUT_CASES.items():
        label = tex(case.label)
        rows.append(_row(name, label, means, gaps, roles, records.loc[name]))
    head = ["Inputs", "requests", "s", *(f"{tex(role)} scenes" for role in roles)]
    text = (
        r"\textbf{Inputs.} PSNR (dB), mean over budgets, of networks that imitate the same labels "
        "from other inputs, alone, without the rule's score. In brackets the paired difference: "
        "of additions to what the rule reads, of omissions to all, with a 95\\% interval over "
        f"{_places(means, roles)} and training seeds, each for its row alone; bold where that "
        "excludes zero. " + made_by(facts)
    )
    write_text(plain_table(head, rows, caption=text, label="tab:inputs"), table)


def cells_of(
    evaluations: Sequence[str | Path], scenes: Sequence[tuple[str, str, str]], facts: Mapping
) -> pd.DataFrame:
    """dataset (the role), scene, place, draw, method, seed, k, psnr; the mean over budgets too."""
    tables = []
    for (role, dataset, scene), path in zip(scenes, evaluations, strict=True):
        name = f"{dataset}/{scene}"
        place = facts.get("places", {}).get(name, name)
        for draw, part in read_table(path).groupby("draw"):
            own = draw_means(part, ["psnr"], by_seed=True)
            mean = own.groupby(["method", "seed"], as_index=False)["psnr"].mean().assign(k=MEAN)
            where = {"dataset": role, "scene": name, "place": place, "draw": draw}
            tables.append(pd.concat([own, mean]).assign(**where))
    return pd.concat(tables, ignore_index=True)


def compared(
    cells: pd.DataFrame, references: Mapping[str, str]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Means of all methods, and differences of each to its reference.

    Args:
        cells: see `cells_of`.
        references: method -> another; empty for none.
    """
    trained = list(references)
    means = summarise(cells, ["psnr"], trained=trained).assign(reference="")
    gaps = []
    for name, reference in references.items():
        if reference:
            pair = cells[cells["method"].isin([name, reference])]
            # the reference's seeds are averaged: only the method's own count as a sample
            found = differences(pair, [name], ["psnr"], trained=[name])
            gaps.append(found[found["reference"] == reference])
    renamed = {"dataset": "role"}
    return means.rename(columns=renamed), pd.concat(gaps).rename(columns=renamed)


def _write_numbers(
    means: pd.DataFrame, gaps: pd.DataFrame, records: pd.DataFrame, numbers: str | Path
) -> None:
    both = pd.concat([means, gaps]).reindex(columns=ORDER)
    both["k"] = both["k"].astype(object).where(both["k"] != MEAN, "")
    write_csv(both.join(records[RECORD], on="method"), numbers)


def _row(
    name: str,
    label: str,
    means: pd.DataFrame,
    gaps: pd.DataFrame,
    roles: Sequence[str],
    record: pd.Series | None,
) -> list[str]:
    """A method's label, its training, and its PSNR in every role."""
    cells = ["", ""] if record is None else [f"{record.lessons:.0f}", f"{record.seconds:.0f}"]
    overall, less = (
        part[(part["method"] == name) & (part["k"] == MEAN)].set_index("role")
        for part in (means, gaps)
    )
    for role in roles:
        text = number(overall.loc[role, "mean"], "psnr")
        if role in less.index:
            text += f" ({difference(*less.loc[role, ['mean', 'ci_low', 'ci_high']])})"
        cells.append(text)
    return [label, *cells]


def _places(means: pd.DataFrame, roles: Sequence[str]) -> str:
    counts = means.groupby("role")["n"].max()
    return ", ".join(f"{counts[role]} {role}" for role in roles) + " scenes"
