"""Poses that are found a second time, by other chance: where both differ, neither is sure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsel.captures.colmap.bindings import pycolmap
from fsel.captures.colmap.runs import SEED, Work, build
from fsel.captures.poses.sfm import DATABASE

UNSURE = 3.0  # degrees between two sets of poses: sure ones differ by tenths
MOST = 150  # frames up to which they are found again: the time grows with their square
OTHER = 0.1  # share of the frames by which the sets' numbers differ where they are by chance


def repeated(model: pycolmap.Reconstruction, work: Work) -> dict | None:
    """Frames that COLMAP places with another seed, and degrees that both sets of poses differ by.

    Args:
        model: as COLMAP made it in the folder of `work`, where its matches are.
        work: how.

    Returns:
        `placed` and `degrees`, the latter None for fewer than two frames of both; None where a
        program placed them, no matches are kept, or more than 150 were placed.
    """
    count = model.num_reg_images()
    if work.by is not None or work.folder is None or count > MOST:
        return None
    quiet = replace(work, watch=lambda label: work.watch(f"{label} again"))
    database = work.folder / DATABASE
    found = build(database, work.folder, count, quiet, refine=True, start=None, seed=SEED + 1)
    second = max(found.values(), key=lambda m: m.num_reg_images(), default=None)
    if second is None:
        return {"placed": 0, "degrees": None}
    both = sorted(set(model.reg_image_ids()) & set(second.reg_image_ids()))
    first, other = (
        np.array([m.images[i].cam_from_world().matrix()[:, :3] for i in both])
        for m in (model, second)
    )
    degrees = round(apart(first, other), 2) if len(both) > 1 else None
    return {"placed": second.num_reg_images(), "degrees": degrees}


def apart(first: np.ndarray, other: np.ndarray) -> float:
    """Median over pairs of frames of the degrees between their turns in two worlds.

    Args:
        first, other: (n, 3, 3) rotations of the same two frames or more, world to camera.
    """
    turns = np.einsum("nij,nik->njk", other, first)  # all the same where the sets agree
    cosines = (np.einsum("nij,mij->nm", turns, turns) - 1) / 2
    rows, columns = np.triu_indices(len(turns), 1)
    return float(np.degrees(np.median(np.arccos(np.clip(cosines[rows, columns], -1, 1)))))


def doubt(found: dict) -> str:
    """Sentence on poses that are not sure; empty where they are."""
    again = found.get("repeated")
    if not again:
        return ""
    placed = len(found["placed"])
    if abs(again["placed"] - placed) > OTHER * placed:
        said = f"COLMAP places {again['placed']} frames, not {placed}"
    elif again["degrees"] is not None and again["degrees"] > UNSURE:
        said = f"COLMAP's poses differ by {again['degrees']:.0f} degrees"
    else:
        return ""
    return f"the poses may be wrong: with another seed {said}"
