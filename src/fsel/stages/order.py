"""Order the searched subsets of all labelled scenes into trajectories."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fsel.core.files import File, Files, by_column, read_columns, write_table
from fsel.training.labelled import read_problems
from fsel.training.ordering import ordered_item


def order(
    folders: Files,
    splits: Files,
    features: Files,
    labels: Files,
    trajectories: File,
    *,
    scenes: Mapping[str, str],
    coverages: Mapping[str, Sequence[int]],
    kept: int,
    config: str,
) -> None:
    """Order the fittest subsets of every labelled problem into trajectories (paper, Eq. 3 and 5).

    Args:
        splits, features: what `split_labelled` and `features` wrote of them, one a scene.
        labels: what `fsel.stages.label` wrote, one a coverage level of each scene.
        trajectories: receives one row a trajectory: scene, role, coverage, rank, fitness, weight,
            picks.
        scenes: scene -> role, `train` or `validation`.
        coverages: scene -> the levels it is labelled at, per cent.
        kept: subsets a problem.

    Raises:
        ValueError: for features of other candidates than the split's, or subsets with frames that
            are no candidates.
    """
    rows = []
    paths = iter(labels)
    files = zip(folders, splits, features, strict=True)
    for (scene, role), places in zip(scenes.items(), files, strict=True):
        problems = read_problems(*places)
        for coverage in coverages[scene]:
            head = {"scene": scene, "role": role, "coverage": coverage}
            path = next(paths)
            found = ordered_item(problems[coverage], read_columns(path), kept, path)
            rows += [head | row for row in found]
    write_table(by_column(rows), trajectories, units={"coverage": "percent"}, config=config)
