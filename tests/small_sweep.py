"""Settings of a sweep that is over in seconds, and small runs of an experiment's trials."""

import pandas as pd

SEARCH = {"k": 4, "stored": 5, "kept": 2}
SEARCH |= {"population": 6, "farthest": 2, "uniform": 2, "generations": 1, "elites": 1}
SEARCH |= {"tournament": 2, "crossover": 0.8, "mutation": 0.3}
RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}


def run_trials(trials, folders, output, weights=(), metrics=("psnr",), **asked):
    """Picks and measurements of an experiment's trials; equal runs pick equal frames."""
    asked, described = {"config": "c", **asked}, folders[0] / "descriptors.parquet"
    picks = [output / "picks.parquet", output / "again.parquet"]
    for path in picks:
        trials.select(folders, described, weights, path, **asked)
    once, again = (pd.read_parquet(path).drop(columns="seconds") for path in picks)
    pd.testing.assert_frame_equal(once, again)
    how = {"reconstruction": RECONSTRUCTION, "metrics": metrics}
    trials.evaluate(folders, picks[:1], output / "measured.parquet", **how, **asked)
    return once, pd.read_parquet(output / "measured.parquet")
