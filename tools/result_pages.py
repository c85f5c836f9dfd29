"""Write measured tables as pages of the documentation: `python tools/result_pages.py`.

`docs/results/pages.yaml` lists the pages: a title, the command that makes the numbers, sentences,
figures and tables. A table names its csv file, the rows (a pandas query), the columns that stand
`down` and `across` it, and how a `cell` prints a row, or one of `cells` under its heading. `count`
counts the rows of each group for which a condition holds. A page without its csv files stays.
"""

import re
import shutil
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from fsel.core.files import write_text
from fsel.evaluation.summary import read_csv

FOLDER = Path("docs/results")


def markdown(rows: pd.DataFrame, table: Mapping[str, Any], names: Mapping[str, str]) -> str:
    """Return a table of pages.yaml as Markdown.

    Args:
        rows: of its csv file, budgets as numbers and 0 for all frames.
        table: its entry.
        names: printed names of values.

    Raises:
        ValueError: for a query without rows.
    """
    rows = rows.query(table["rows"]) if "rows" in table else rows
    if rows.empty:
        raise ValueError(f"no row with {table.get('rows')}")
    down, across = table["down"], table.get("across", [])
    cells = {head: f"{{{head}}}" for head in table.get("count", {})}
    if cells:
        counted = {head: rows.eval(condition) for head, condition in table["count"].items()}
        rows = rows[down].assign(**counted).groupby(down, sort=False).sum().reset_index()
    cells = cells or table.get("cells") or {"": table["cell"]}
    printed = {head: rows.apply(_printed, axis=1, form=form) for head, form in cells.items()}
    named = rows[[*down, *across]].map(lambda value: _named(value, names | table.get("names", {})))
    grid = named.assign(**printed)
    if across:
        heads, lines = grid[across[0]].unique(), grid[down].drop_duplicates()
        wide = grid.pivot(index=down, columns=across[0], values="")[heads].reset_index()
        grid = lines.merge(wide, on=down).fillna("")
    head = ["" if column in down else column for column in grid.columns]
    return "\n".join(
        f"| {' | '.join(line)} |" for line in [head, ["---"] * len(head), *grid.values]
    )


def _named(value: Any, names: Mapping[str, str]) -> str:
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return names.get(text, text)


def _printed(row: pd.Series, form: str) -> str:
    """Print a row; what has no number is left out."""
    text = re.sub(r" \([^)]*\bnan\b[^)]*\)|, \w+ \+?nan\b", "", form.format(**row))
    return "" if re.search(r"\bnan\b", text) else text


def page(root: Path, name: str, entry: Mapping[str, Any], names: Mapping[str, str]) -> str:
    """Return the text of a page, and copy its figures beside the documentation.

    Raises:
        FileNotFoundError: where a csv file or a figure is missing.
        ValueError: for a table that does not fit its csv file.
    """
    usual = f"results/tables/{name}"
    csvs = [table.get("csv", f"{usual}.csv") for table in entry["tables"]]
    files = {csv: root / csv for csv in csvs}
    made = max(file.stat().st_mtime for file in files.values())
    date = datetime.fromtimestamp(made, UTC).date()
    command = entry.get("command", f"snakemake --cores 2 {usual}.tex")
    parts = [f"# {entry['title']}", f"`{command}`, {date}.", entry["text"].strip()]
    for figure, meaning in entry.get("figures", {}).items():
        shutil.copyfile(root / figure, root / "docs/figures" / Path(figure).name)
        parts.append(f"![{meaning}](../figures/{Path(figure).name})")
    for csv, table in zip(csvs, entry["tables"], strict=True):
        try:
            text = markdown(read_csv(files[csv]), table, names)
        except (KeyError, ValueError, pd.errors.UndefinedVariableError) as error:
            raise ValueError(f"{csv}: {table['caption']}: {error}") from error
        parts.append(f"**{table['caption']}**\n\n{text}")
    for csv, file in files.items():
        parts.append(f"sha256 of `{csv}`: `{sha256(file.read_bytes()).hexdigest()}`")
    return "\n\n".join(parts) + "\n"


def write(root: Path) -> list[str]:
    """Write every page whose csv files are there, and return the names of the others."""
    contents = yaml.safe_load((root / FOLDER / "pages.yaml").read_text(encoding="utf-8"))
    kept = []
    for name, entry in contents["pages"].items():
        try:
            text = page(root, name, entry, contents["names"])
        except FileNotFoundError:
            kept.append(name)
        else:
            write_text(text, root / FOLDER / f"{name}.md")
    return kept


if __name__ == "__main__":
    kept = write(Path())
    if kept:
        sys.stdout.write(f"kept, their numbers are not here: {', '.join(kept)}\n")
