"""Comparison of a run's tables with those that the documentation quotes, to the byte.

    python -m fsel.workflow.reference [--write] [--tables results/tables] [--reference docs/results]

Without `--write` the command compares, and exits with 1 where a table differs. With it, the tables
of this run become the ones to compare with.
"""

from __future__ import annotations

import argparse
import csv
import shutil
import sys
from pathlib import Path

from fsel.core.checksums import sha256_of

NAMES = ("ksweep.csv", "heatmap.csv")
SUMS = "sha256.txt"
KEYS = ("dataset", "method", "k", "metric", "reference", "rivals")  # columns that name a row

Rows = dict[tuple[str, ...], dict[str, str]]


def compare(tables: Path, reference: Path) -> list[str]:
    """Compare the tables of a run with the reference.

    Args:
        tables: folder of the run's tables.
        reference: folder of the reference, with `sha256.txt` in the form of `sha256sum`.

    Returns:
        A sentence for each table that differs, naming the cell that differs most.

    Raises:
        FileNotFoundError: for a table that is not there, with how to make it.
    """
    stated = dict(line.split()[::-1] for line in (reference / SUMS).read_text().splitlines())
    told = []
    for name in NAMES:
        if not (tables / name).exists():
            raise FileNotFoundError(f"no {tables / name}. Hint: make ksweep")
        if sha256_of(tables / name) != stated[name]:
            told.append(f"{name}: {difference(tables / name, reference / name)}")
    return told


def write(tables: Path, reference: Path) -> None:
    """Make the tables of a run the reference."""
    reference.mkdir(parents=True, exist_ok=True)
    for name in NAMES:
        shutil.copyfile(tables / name, reference / name)
    sums = [f"{sha256_of(reference / name)}  {name}\n" for name in NAMES]
    (reference / SUMS).write_text("".join(sums))


def difference(path: Path, reference: Path) -> str:
    """Say which cell of two tables differs most, and how many do."""
    own, other = _rows(path), _rows(reference)
    if own.keys() != other.keys():
        alone = sorted(own.keys() ^ other.keys())
        return f"{len(alone)} rows are in one of the two alone, such as {', '.join(alone[0])}"
    gaps = [
        (_gap(own[key][column], other[key][column]), key, column)
        for key in own
        for column in own[key]
        if own[key][column] != other[key][column]
    ]
    if not gaps:
        return "the rows are equal, their order is not"
    _, key, column = max(gaps)
    cell = f"{column} of {', '.join(key)} is {own[key][column]}, not {other[key][column]}"
    return f"{len(gaps)} cells differ, the most: {cell}"


def _rows(path: Path) -> Rows:
    """Rows of a table by the columns that name them."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {tuple(row[key] for key in KEYS if key in row): row for row in rows}


def _gap(first: str, second: str) -> float:
    """Distance of two numbers; infinite between words."""
    try:
        return abs(float(first) - float(second))
    except ValueError:
        return float("inf")


def main(arguments: list[str] | None = None) -> int:
    """Compare or write, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--tables", type=Path, default=Path("results/tables"))
    parser.add_argument("--reference", type=Path, default=Path("docs/results"))
    options = parser.parse_args(arguments)
    if options.write:
        write(options.tables, options.reference)
        return 0
    told = compare(options.tables, options.reference)
    print("\n".join(told) or f"{' and '.join(NAMES)} are equal to {options.reference} to the byte")
    return 1 if told else 0


if __name__ == "__main__":
    sys.exit(main())
