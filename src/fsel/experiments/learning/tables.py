"""Tables of what ways to learn, and sets of inputs, are worth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import pandas as pd

from fsel.experiments.learning.cases import INPUT_CASES, LEARNERS
from fsel.experiments.learning.pairs import RULE
from fsel.files import read_table, write_text
from fsel.report.captions import captures_of, made_by, printed
from fsel.report.latex import difference, number, plain_table, tex
from fsel.report.numbers import write_csv
from fsel.report.summary import differences, draw_means, summarise
from fsel.report.sweep import place_of

MEAN = -1  # the budget of a mean over all budgets, in this module alone
ORDER = ["judge", "role", "method", "reference", "k", "mean", "ci_low", "ci_high", "p", "n"]
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
    again: Sequence[str | Path],
    log: str | Path,
    table: str | Path,
    numbers: str | Path,
    *,
    scenes: Sequence[tuple[str, str, str]],
    judges: Mapping[str, Mapping],
    facts: Mapping,
) -> None:
    """What each group of inputs is worth, added to what the rule reads and left out of all.

    Args:
        evaluations: what `picking.evaluate_learned` wrote by the first judge, one a scene.
        again: by the second, of the same picks or of some of their budgets and draws.
        log: what `learn.learn_inputs` wrote.
        table: receives LaTeX.
        numbers: receives judge, and what `learning` writes.
        scenes: role, dataset and scene of each evaluation.
        judges: name -> `reconstructor` and `long_side` to print, of the two.
        facts: see `captions.made_by`.
    """
    found = [cells_of(paths, scenes, facts) for paths in (evaluations, again)]
    references = {name: case.reference for name, case in INPUT_CASES.items()}
    sides = [compared(cells, references) for cells in found]
    records = read_table(log).set_index("method")
    named = [[part.assign(judge=j) for part in s] for j, s in zip(judges, sides, strict=True)]
    means, gaps = (pd.concat(parts) for parts in zip(*named, strict=True))
    _write_numbers(means, gaps, records, numbers)
    roles = list(dict.fromkeys(role for role, _, _ in scenes))
    rows = []
    for name, case in INPUT_CASES.items():
        row = [tex(case.label), *_training(records.loc[name])]
        rows.append(row + [cell for side in sides for cell in _cells(name, *side, roles)])
    head = ["Inputs", "requests", "s", *[f"{tex(role)} scenes" for role in roles] * len(sides)]
    groups = [("", 2), *((printed(judge), len(roles)) for judge in judges.values())]
    text = _inputs_caption(_places(means, roles), [_measured(cells) for cells in found], facts)
    made = plain_table(head, rows, caption=text, label="tab:inputs", groups=groups)
    write_text(made, table)


def _inputs_caption(places: str, measured: Sequence[str], facts: Mapping) -> str:
    """In LaTeX.

    Args:
        places: see `_places`.
        measured: see `_measured`, of each judge.
        facts: see `captions.made_by`.
    """
    return (
        r"\textbf{Inputs.} PSNR (dB), mean over budgets, of networks that imitate the same labels "
        "from other inputs, alone, without the rule's score. In brackets the paired difference: "
        "of additions to what the rule reads, of omissions to all, with a 95\\% interval over "
        f"{places} and training seeds, each for its row alone; bold where that excludes zero. On "
        f"the left {measured[0]}; on the right picks of the same networks under another "
        f"reconstructor, {measured[1]}. Captures: {captures_of(facts)}; appearance descriptor: "
        rf"\texttt{{{tex(facts['descriptor'])}}}."
    )


def _measured(cells: pd.DataFrame) -> str:
    """Budgets and draws of some cells."""
    budgets = ", ".join(str(k) for k in sorted(set(cells["k"]) - {MEAN}))
    draws = cells["draw"].nunique()
    return f"$K$ = {budgets}, {draws} draw{'s' if draws > 1 else ''} of targets a scene"


def cells_of(
    evaluations: Sequence[str | Path], scenes: Sequence[tuple[str, str, str]], facts: Mapping
) -> pd.DataFrame:
    """dataset (the role), scene, place, draw, method, seed, k, psnr; the mean over budgets too."""
    tables = []
    for (role, dataset, scene), path in zip(scenes, evaluations, strict=True):
        name = f"{dataset}/{scene}"
        place = place_of(name, facts)
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
    both = pd.concat([means, gaps])
    both = both[[column for column in ORDER if column in both]]
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
    trained = ["", ""] if record is None else _training(record)
    return [label, *trained, *_cells(name, means, gaps, roles)]


def _training(record: pd.Series) -> list[str]:
    return [f"{record.lessons:.0f}", f"{record.seconds:.0f}"]


def _cells(
    name: str, means: pd.DataFrame, gaps: pd.DataFrame, roles: Sequence[str]
) -> Iterator[str]:
    """A method's PSNR in every role, with its difference to the reference, if it has one."""
    overall, less = (
        part[(part["method"] == name) & (part["k"] == MEAN)].set_index("role")
        for part in (means, gaps)
    )
    for role in roles:
        text = number(overall.loc[role, "mean"], "psnr")
        if role in less.index:
            text += f" ({difference(*less.loc[role, ['mean', 'ci_low', 'ci_high']])})"
        yield text


def _places(means: pd.DataFrame, roles: Sequence[str]) -> str:
    counts = means.groupby("role")["n"].max()
    return ", ".join(f"{counts[role]} {role}" for role in roles) + " scenes"
