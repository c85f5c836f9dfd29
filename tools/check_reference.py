"""Compare the tables of a run with those of docs/results, to the byte.

    python tools/check_reference.py [--write] [--tables results/tables] [--reference docs/results]

The pages of docs/results say which csv files they print; those of another table are named too,
where the run has made it and it holds no seconds. The exit code is 1 where anything differs.
`--write` makes the tables of this run the reference.
"""

import argparse
import csv
import hashlib
import re
import shutil
import sys
from pathlib import Path

NAMES = ("ksweep.csv", "heatmap.csv")
SUMS = "sha256.txt"
KEYS = ("dataset", "method", "k", "metric", "reference", "rivals")  # columns that name a row

MEASURED = re.compile(r"(^|_)(s|seconds|ms|mb)$")  # columns that no two runs share
PRINTED = re.compile(r"^sha256 of `(.+)`: `(\w+)`$", re.MULTILINE)

Rows = dict[tuple[str, ...], dict[str, str]]


def compare(tables: Path, reference: Path) -> list[str]:
    """Return a sentence for each table that differs, naming the cell that differs most.

    Args:
        tables: folder of the run's tables.
        reference: folder of the reference, with `sha256.txt` in the form of `sha256sum`.
    """
    expected = dict(line.split()[::-1] for line in (reference / SUMS).read_text().splitlines())
    return [
        f"{name}: {difference(tables / name, reference / name)}"
        for name in NAMES
        if sha256_of(tables / name) != expected[name]
    ]


def write(tables: Path, reference: Path) -> None:
    """Make the tables of a run the reference."""
    for name in NAMES:
        shutil.copyfile(tables / name, reference / name)
    sums = [f"{sha256_of(reference / name)}  {name}\n" for name in NAMES]
    (reference / SUMS).write_text("".join(sums))


def stale(reference: Path, root: Path) -> list[str]:
    """Name the pages of `reference` that print another table than the one below `root`."""
    found = []
    for page in sorted(reference.glob("*.md")):
        for name, digest in PRINTED.findall(page.read_text(encoding="utf-8")):
            path = root / name
            if path.exists() and not _measured(path) and sha256_of(path) != digest:
                found.append(f"{page}: {name} has changed; `make docs` writes the page anew")
    return found


def _measured(path: Path) -> bool:
    with path.open(encoding="utf-8") as file:
        return any(map(MEASURED.search, file.readline().strip().split(",")))


def difference(path: Path, reference: Path) -> str:
    """Describe which cell of two tables differs most, and how many differ."""
    own, other = _rows(path), _rows(reference)
    if own.keys() != other.keys():
        alone = sorted(own.keys() ^ other.keys())
        return f"{len(alone)} rows are in only one of the two, such as {', '.join(alone[0])}"
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


def sha256_of(path: Path) -> str:
    """Return the digest of a file, as `sha256sum` writes it."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _rows(path: Path) -> Rows:
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {tuple(row[key] for key in KEYS if key in row): row for row in rows}


def _gap(first: str, second: str) -> float:
    """Return the distance of two numbers; infinite between words."""
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
    found = compare(options.tables, options.reference) + stale(options.reference, Path())
    print("\n".join(found) or f"{' and '.join(NAMES)} are equal to {options.reference} to the byte")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
