"""Where the seconds of a finished run went: jobs, wall and processor time by rule.

    python benchmarks/workflow.py [results]

Reads the benchmark and the log that every job leaves. Wall seconds add up jobs that ran side by
side. Processor seconds are from the logs: Snakemake's benchmarks sample theirs, and lack what came
after the last sample.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import pandas as pd

USED = re.compile(r"done in .* s, (\d+\.\d) s of the processor")


def seconds_by_rule(results: Path) -> pd.DataFrame:
    """One row a rule: jobs, wall and processor seconds in all, seconds of the longest job."""
    paths = sorted((results / "benchmarks").rglob("*.jsonl"))
    if not paths:
        raise SystemExit(f"{results}: no benchmark files; run the workflow first")
    names = [path.relative_to(results / "benchmarks") for path in paths]
    table = pd.concat(pd.read_json(path, lines=True) for path in paths)
    table = table.rename(columns={"s": "wall_s"})
    table["rule"] = [name.parts[0].removesuffix(".jsonl") for name in names]
    table["cpu_s"] = [processor_seconds(results / "logs" / name) for name in names]
    table = table.groupby("rule").agg(
        jobs=("wall_s", "size"),
        wall_s=("wall_s", "sum"),
        cpu_s=("cpu_s", "sum"),
        longest_s=("wall_s", "max"),
    )
    table = table.sort_values("wall_s", ascending=False)
    table.loc["in all"] = [*table[["jobs", "wall_s", "cpu_s"]].sum(), table["longest_s"].max()]
    return table


def processor_seconds(path: Path) -> float:
    """What a job's log says at its end."""
    matches = USED.findall(path.with_suffix(".log").read_text(encoding="utf-8"))
    return float(matches[-1]) if matches else float("nan")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", nargs="?", default="results", type=Path)
    print(seconds_by_rule(parser.parse_args().results).to_string(float_format="%.0f"))


if __name__ == "__main__":
    main()
