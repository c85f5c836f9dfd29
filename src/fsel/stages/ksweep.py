"""The budget sweep's tables from the evaluations of all scenes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fsel.core.files import File, Files, write_text
from fsel.core.problem import MOST_FRAMES
from fsel.evaluation.latex import made_by, sweep_table, tex
from fsel.evaluation.summary import differences as paired
from fsel.evaluation.summary import summarise, with_all_datasets, write_csv
from fsel.evaluation.sweep import LABELS, LEARNED, row_groups, sweep_cells, with_all_label
from fsel.metrics import Metrics, directions, headings


def ksweep(
    evaluations: Files,
    oracles: Files,
    table: File,
    numbers: File,
    differences: File,
    *,
    problems: Sequence[str],
    searched: Sequence[str],
    datasets: Mapping[str, str],
    budgets: Sequence[int],
    metrics: Metrics,
    facts: Mapping,
) -> None:
    """Write the table "Input budget sweep", its numbers with intervals, and paired differences.

    Args:
        evaluations, oracles: what `fsel.stages.evaluate` and `search_oracle` wrote.
        numbers, differences: receive means, and the learned methods' differences to every other.
        problems, searched: `dataset/scene/draw0` of each of the evaluations and oracles.
        facts: what the caption says, see `caption`.
    """
    names, files = list(metrics), ([*problems, *searched], [*evaluations, *oracles])
    cells = with_all_datasets(sweep_cells(*files, names, facts=facts, by_seed=True))
    means = summarise(cells, names, trained=list(LEARNED))
    write_csv(means, numbers)
    write_csv(paired(cells, list(LEARNED), names, trained=list(LEARNED)), differences)
    groups = row_groups(cells, budgets)
    known = {**facts, "searched": any("search" in group for group in groups)}
    text = sweep_table(
        means,
        datasets={name: tex(label) for name, label in with_all_label(datasets).items()},
        groups=groups,
        ranked=list(LABELS),
        budgets=budgets,
        higher_is_better=directions(metrics),
        caption=caption(known, metrics),
        label="tab:ksweep_all",
    )
    write_text(text, table)


def caption(facts: Mapping, metrics: Metrics) -> str:
    """Say in LaTeX which captures, reconstructor, descriptor and metric made the table.

    Args:
        facts: as in `made_by`, and search_k, draws, oracle_draws, oracle_dataset, searched (whether
            the searches have rows), and `hold_out` of the config.
    """
    thinned = f"{MOST_FRAMES:,} evenly spread ones where a capture has more"
    references = f"all frames without selection ({thinned})."
    if facts["searched"]:
        references = (
            "searches, which reconstruct hundreds of subsets of every scene "
            rf"({tex(facts['oracle_dataset'])} alone, $K{{=}}{facts['search_k']}$, "
            f"{facts['oracle_draws']} of {facts['draws']} target draws), and {references}"
        )
    targets = ""
    if every := facts.get("hold_out", {}).get("every"):
        targets = (
            f"One frame in {every} is a target that no method knows, and all begin with the same "
            f"{facts['hold_out']['first']} views. "
        )
    return (
        r"\textbf{Input budget sweep across datasets}. Each cell reports "
        f"{'~/~'.join(headings(metrics))}, averaged over targets, target draws and seeds within a "
        "scene, then over scenes; the best selection of each column is in bold. "
        f"{targets}{made_by(facts)} Between rules: the paper's baselines, further ones, the "
        f"learned selectors, and for reference {references}"
    )
