"""The targets of every draw, their proxies and the candidates."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fsel.captures.layouts.dl3dv import read_protocol
from fsel.core.capture import Capture
from fsel.core.files import File, Files, write_table
from fsel.core.split import evaluation_split, partition


def split(
    folder: File,
    splits: Files,
    *,
    targets: int,
    seed: int,
    every: int | None = None,
    protocol: Mapping[str, str] | None = None,
    config: str,
) -> None:
    """Draw the targets of a capture, or take those of a protocol.

    Args:
        splits: one a draw, see `fsel.core.split.Split.table`.
        every: each so manieth frame is a target; None for targets that are drawn.
        protocol: `file`, `scene` and `folder` of `fsel.captures.layouts.dl3dv`; empty for none.
    """
    capture = Capture.load(folder)
    for draw, output in enumerate(splits):
        held = np.arange(0, len(capture), every) if every else None
        if protocol:
            held = read_protocol(names=capture.names, **protocol).targets
        if held is None:
            made = evaluation_split(capture, draw, seed, targets)
        else:
            made = partition(capture, held, np.arange(len(capture)))
        write_table(made.table(capture.names), output, units={}, config=config)
