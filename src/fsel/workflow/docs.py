"""Numbers in the README and docs/, from the results of a run: `python -m fsel.workflow.docs`.

docs/results.yaml names each quoted result: the csv file it comes from, the rows (a pandas query)
and what is made of them. docs/results.json is the snapshot of their texts, committed; the pages
hold them between markers. A result whose file this checkout lacks keeps its text.

    table: results/tables/ksweep.csv
    rows: dataset == 'all' and metric == 'psnr' and method == 'fsel'
    value: mean         # a column, or `count`, `mean of X`, `min of X`, `max of X`
    format: .2f         # several values are joined by " / "

With `down` (one column, or several) the result is a Markdown table, in order of appearance: one
`value` against the column `across`, or the columns that `value` lists. `names` gives printed names
of both. The budget of all frames is 0.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from fsel.report.numbers import read_csv
from fsel.utils.files import write_text

DEFINITIONS = Path("docs/results.yaml")
SNAPSHOT = Path("docs/results.json")
FIGURES = {
    Path("results/figures") / name: Path("docs/figures") / name
    for name in ("heatmap.png", "swaps.png")
}
MARKED = re.compile(r"(<!-- result: (\w+) -->)(.*?)(<!-- end -->)", re.S)


def quoted(table: pd.DataFrame, definition: Mapping[str, Any]) -> str:
    """The text of one result.

    Args:
        table: the rows of its csv file, budgets as numbers.
        definition: its entry in docs/results.yaml.

    Returns:
        numbers joined by " / ", or the lines of a Markdown table.

    Raises:
        ValueError: where no row answers.
    """
    rows = table.query(definition["rows"]) if "rows" in definition else table
    if rows.empty and definition["value"] != "count":
        raise ValueError(f"no row with {definition['rows']}")
    if "down" in definition:
        return _grid(rows, definition)
    form = definition.get("format", "")
    return " / ".join(format(value, form) for value in _values(rows, definition["value"]))


def _values(rows: pd.DataFrame, value: str) -> list[Any]:
    if value == "count":
        return [len(rows)]
    how, _, column = value.rpartition(" of ")
    return [rows[column].agg(how)] if how else rows[column].tolist()


def _grid(rows: pd.DataFrame, definition: Mapping[str, Any]) -> str:
    names, form = definition.get("names", {}), definition.get("format", "")
    keys = [definition["down"]] if isinstance(definition["down"], str) else definition["down"]
    rows = rows.assign(place=pd.factorize(rows[keys].agg(tuple, axis=1))[0])
    if "across" in definition:
        across, value = definition["across"], definition["value"]
        grid = rows.pivot(index=["place", *keys], columns=across, values=value)
        grid = grid[rows[across].unique()]
    else:
        grid = rows.set_index(["place", *keys])[definition["value"]]
    columns = [f"{c:g}" if isinstance(c, float) else str(c) for c in grid.columns]
    heads = ["" for _ in keys] + [names.get(column, column) for column in columns]
    lines = [heads, ["---"] * len(heads)]
    for (_, *where), values in zip(grid.index, grid.to_numpy(), strict=True):
        cells = ("" if pd.isna(cell) else format(cell, form) for cell in values)
        lines.append([*(names.get(str(name), str(name)) for name in where), *cells])
    return "\n" + "".join(f"| {' | '.join(line)} |\n" for line in lines)


def gather(
    definitions: Mapping[str, Mapping[str, Any]], old: Mapping[str, str], root: Path
) -> tuple[dict[str, str], list[str]]:
    """Texts of all results, and the names of those that keep the text they had.

    Raises:
        ValueError: for a result with neither a file nor an old text, or a wrong definition.
    """
    texts, kept = {}, []
    for name, definition in definitions.items():
        path = root / definition["table"]
        if path.is_file():
            try:
                texts[name] = quoted(read_csv(path), definition)
            except (ValueError, KeyError, pd.errors.UndefinedVariableError) as error:
                raise ValueError(f"{DEFINITIONS}: {name}, {path}: {error}") from error
        elif name in old:
            texts[name] = old[name]
            kept.append(name)
        else:
            raise ValueError(f"{DEFINITIONS}: {name}: {path} is missing. Make it first.")
    return texts, kept


def with_results(page: str, texts: Mapping[str, str]) -> str:
    """The page with every marked text as `texts` has it.

    Raises:
        KeyError: for a marker without a result.
    """
    return MARKED.sub(lambda found: f"{found[1]}{texts[found[2]]}{found[4]}", page)


def pages(root: Path) -> list[Path]:
    """The README and docs/."""
    return [root / "README.md", *sorted((root / "docs").glob("*.md"))]


def write(root: Path) -> list[str]:
    """Rewrite the snapshot and the pages of a checkout; returns the results that were kept."""
    definitions = yaml.safe_load((root / DEFINITIONS).read_text(encoding="utf-8"))
    snapshot = root / SNAPSHOT
    old = json.loads(snapshot.read_text(encoding="utf-8")) if snapshot.exists() else {}
    texts, kept = gather(definitions, old, root)
    write_text(json.dumps(texts, indent=1, ensure_ascii=False) + "\n", snapshot)
    for page in pages(root):
        write_text(with_results(page.read_text(encoding="utf-8"), texts), page)
    for source, target in FIGURES.items():
        if (root / source).exists():
            shutil.copyfile(root / source, root / target)
    return kept


if __name__ == "__main__":
    kept = write(Path())
    if kept:
        sys.stdout.write(f"kept, their files are not here: {', '.join(kept)}\n")
