"""The selectors beside the search that they imitate (paper, Appendix D.3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from fsel.core.files import File, Files, read_table, write_text
from fsel.evaluation.latex import MISSING, difference, made_by, number, plain_table
from fsel.evaluation.summary import with_all_datasets, write_csv
from fsel.evaluation.sweep import sweep_cells
from fsel.experiments.scheme import GAP, Scenes, Trials, against, every_draw

SEARCH = "search"
PROBLEM = ["dataset", "scene", "draw"]
SUBSET = ["method", "number", "rank"]
AVERAGES = {"random_search": "average_random", SEARCH: "average_search"}
ROWS = {
    "average_random": "Average subset of random search",
    "average_search": "Average subset of the genetic search",
    "random_search": "Random search, fittest on the proxies",
    SEARCH: "Genetic search, fittest on the proxies",
    "less_is_more": r"\textbf{Ours}",
    "fsel": r"\textbf{fsel}",
}


def searched_subsets(draws: Files) -> pd.DataFrame:
    """Return the subsets searched in each draw as picks; rank 0 is the fittest on the proxies."""
    tables = [read_table(path).assign(draw=draw) for draw, path in enumerate(draws)]
    picks = pd.concat([table.assign(number=range(len(table))) for table in tables])
    return picks[["draw", *SUBSET]].assign(frame=picks["subset"]).explode("frame")


def ga_vs_learned(
    evaluations: Files,
    searched: Files,
    table: File,
    numbers: File,
    *,
    problems: Sequence[str],
    scenes: Scenes,
    k: int,
    facts: Mapping,
) -> None:
    """Write the table of average subset, random search, search and selectors, on the targets."""
    swept = sweep_cells(problems, evaluations, facts=facts)
    tables = []
    for (dataset, scene), path in zip(scenes, searched, strict=True):
        met = read_table(path).groupby(["draw", *SUBSET])["psnr"].mean().reset_index()
        met["draw"] = "draw" + met["draw"].astype(str)
        tables.append(met.assign(dataset=dataset, scene=scene))
    subsets = pd.concat(tables)
    averages = subsets.groupby([*PROBLEM, "method"])["psnr"].mean().reset_index()
    averages["method"] = averages["method"].map(AVERAGES)
    fittest = subsets.loc[subsets["rank"] == 0, [*PROBLEM, "method", "psnr"]]
    cells = pd.concat([averages.assign(k=k), fittest.assign(k=k), swept[swept["k"] == k]])
    parts = with_all_datasets(cells).groupby("dataset", sort=False)
    results = [compare_with_search(part).assign(dataset=dataset) for dataset, part in parts]
    write_csv(pd.concat(results), numbers)
    result = results[-1]  # of all datasets, where there are several
    tried = len(subsets[subsets["method"] == SEARCH]) / len(subsets[PROBLEM].drop_duplicates())
    text = (
        rf"\textbf{{Comparison with the genetic search}}, $K{{=}}{k}$, held-out scenes: "
        f"${result['n'].iloc[0]}$. The searches each reconstruct {tried:.0f} subsets a scene and "
        "keep the fittest on the proxies; the selectors reconstruct none. All PSNRs are on the "
        "held-out targets. In brackets: paired 95\\% intervals over scenes and draws; bold where "
        "they exclude zero. Ahead: scenes in which a row's PSNR exceeds the genetic search's. "
        f"{made_by(facts)}"
    )
    head = ["Selection", r"PSNR$\uparrow$ (dB)", "minus search (dB)", "ahead"]
    write_text(plain_table(head, _rows(result), caption=text, label="tab:ga_vs_learned"), table)


def compare_with_search(cells: pd.DataFrame) -> pd.DataFrame:
    """Return the means of `ROWS` on the draws that were searched, their paired differences to the
    search's (NaN for itself), and in how many of n scenes they are `ahead`."""
    cells = cells[cells["method"].isin(ROWS)]
    cells = cells.merge(cells.loc[cells["method"] == SEARCH, PROBLEM], on=PROBLEM)
    result = against(cells, SEARCH)
    scenes = cells.groupby(["method", "scene"])["psnr"].mean().unstack("scene")
    result["ahead"] = (scenes > scenes.loc[SEARCH]).sum(axis=1)
    order = ["k", "mean", "ci_low", "ci_high", *GAP, "ahead", "n"]
    return result.loc[list(ROWS), order].rename_axis("method").reset_index()


def _rows(result: pd.DataFrame) -> list[list[str]]:
    rows = []
    for name, row in result.set_index("method").iterrows():
        cells = [MISSING, MISSING]
        if name != SEARCH:
            cells = [difference(*row[GAP]), f"{row['ahead']:.0f} of {row['n']:.0f}"]
        rows.append([ROWS[name], number(row["mean"], "psnr"), *cells])
    return rows


TRIALS = Trials(every_draw, read=searched_subsets, by=SUBSET)
