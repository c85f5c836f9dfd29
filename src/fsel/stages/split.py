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
    protocol: Mapping[str, str] | None = None,
    config: str,
) -> None:
    """Draw the targets of a capture, or take those of a protocol.

    Args:
        splits: one a draw, see `fsel.core.split.Split.table`.
        protocol: `file`, `scene` and `folder` of `fsel.captures.layouts.dl3dv`; empty for none.
    """
    capture = Capture.load(folder)
    for draw, output in enumerate(splits):
        if protocol:
            held = read_protocol(names=capture.names, **protocol).targets
            made = partition(capture, held, np.arange(len(capture)))
        else:
            made = evaluation_split(capture, draw, seed, targets)
        write_table(made.table(capture.names), output, units={}, config=config)
