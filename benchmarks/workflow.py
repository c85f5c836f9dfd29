"""Where the seconds of a finished run went: jobs, wall and processor time by rule.

    python benchmarks/workflow.py [results]

Reads the benchmark files that every job leaves. Wall seconds add up jobs that ran side by side.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import pandas as pd


def seconds_by_rule(folder: Path) -> pd.DataFrame:
    """One row a rule: jobs, wall and processor seconds in all, seconds of the longest job."""
    paths = sorted(folder.rglob("*.jsonl"))
    if not paths:
        raise SystemExit(f"{folder}: no benchmark files; run the workflow first")
    table = pd.concat(pd.read_json(path, lines=True) for path in paths)
    table["rule"] = [path.relative_to(folder).parts[0].removesuffix(".jsonl") for path in paths]
    table = table.rename(columns={"s": "wall_s", "cpu_time": "cpu_s"})
    table = table.groupby("rule").agg(
        jobs=("wall_s", "size"),
        wall_s=("wall_s", "sum"),
        cpu_s=("cpu_s", "sum"),
        longest_s=("wall_s", "max"),
    )
    table = table.sort_values("wall_s", ascending=False)
    table.loc["in all"] = [*table[["jobs", "wall_s", "cpu_s"]].sum(), table["longest_s"].max()]
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", nargs="?", default="results", type=Path)
    folder = parser.parse_args().results / "benchmarks"
    print(seconds_by_rule(folder).to_string(float_format="%.0f"))


if __name__ == "__main__":
    main()
