"""Select frames of many recordings for trainers; nothing is evaluated."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from fsel.captures.lazy import open_capture
from fsel.core.files import File, Files, repeated, write_table
from fsel.evaluation.measuring import PICK_UNITS
from fsel.evaluation.summary import write_csv
from fsel.selection.api import select

TABLE = "scenes.csv"

logger = logging.getLogger(__name__)


def curate(
    sources: Files,
    folder: File,
    *,
    scenes: Mapping[str, Mapping[str, Any]],
    request: Mapping[str, Any],
    form: Mapping[str, Any],
    config: str,
) -> None:
    """Select frames of captures in their own layout, and write them as `fsel select` does.

    A scene that is refused is named in scenes.csv, with the reason, and the others go on.

    Args:
        folder: receives scenes.csv and one folder a scene: a capture of the picks that trainers
            read, and selections.parquet, one row a pick, see `fsel.evaluation.measuring.select`.
        scenes: name -> its `seed`, and how it is read: keywords of `read_folder`; `points` that are
            not there are triangulated among the picks, as by `fsel select`.
        request: keywords of `fsel.select`.
        form: keywords of `fsel.Selection.export`.
    """
    rows = []
    for source, (scene, own) in zip(sources, scenes.items(), strict=True):
        row: dict[str, Any] = {"scene": scene, "frames": 0, "picked": 0, "refused": ""}
        began = time.process_time()
        try:
            reading = {key: own[key] for key in own if key not in ("seed", "points")}
            capture = open_capture(source, **reading).capture
            chosen = select(capture, seed=own["seed"], **request)
            out = chosen.export(Path(folder, scene), **form)
            same = {"method": request["method"], "seed": 0, "k": len(chosen)}
            picks = {"order": range(len(chosen)), "frame": chosen.indices, "name": chosen.names}
            table = repeated(same | {"seconds": chosen.seconds}, len(chosen)) | picks
            write_table(table, out / "selections.parquet", units=PICK_UNITS, config=config)
            row |= {"frames": len(capture), "picked": len(chosen)}
        except Exception as fault:  # of ten thousand recordings some are broken
            logger.exception("%s is refused", source)
            row["refused"] = str(fault) or type(fault).__name__
        rows.append(row | {"core_seconds": time.process_time() - began})
    write_csv(pd.DataFrame(rows), Path(folder, TABLE))


def selections(folders: Files, table: File) -> None:
    """Write one row a scene from the folders that `curate` wrote; print how many are refused.

    Raises:
        ValueError: when every scene is refused.
    """
    parts = [pd.read_csv(Path(folder, TABLE), keep_default_na=False) for folder in folders]
    every = pd.concat([part.assign(part=f) for part, f in zip(parts, folders, strict=True)])
    refused = every[every["picked"] == 0]
    if len(refused):
        said = f"{len(refused)} of {len(every)} scenes are refused, the first: "
        said += refused["refused"].iloc[0]
        if len(refused) == len(every):
            raise ValueError(said)
        print(f"{said}; see {table}", file=sys.stderr)
    write_csv(every, table)
