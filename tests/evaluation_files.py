"""Evaluation files with given PSNRs."""

import pandas as pd

from fsel.metrics import METRICS

FACTS = {"embedded": ["Tanks & Temples"], "real": [], "descriptor": "lab_hog"}
FACTS |= {"reconstructor": "splats", "long_side": 64}


def written(folder, values: dict) -> tuple[list[str], list]:
    """Problems and paths of files with one target; (scene, draw) -> {(method, seed, k): PSNR}."""
    problems, paths = [], []
    for (scene, draw), runs in values.items():
        rows = [(m, s, k, 0, v, 0.5, 0.1) for (m, s, k), v in runs.items()]
        path = folder / f"{scene}-{draw}-{len(paths)}.parquet"
        columns = ["method", "seed", "k", "target", *METRICS]
        pd.DataFrame(rows, columns=columns).to_parquet(path)
        problems.append(f"d/{scene}/{draw}")
        paths.append(path)
    return problems, paths
