"""Data parser of nerfstudio that trains on a selection and evaluates on the frames held out.

    ns-train splatfacto fsel-data --data captures/garden --k 30

The selection is made once, by the settings below, and kept in the user's cache.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field
from pathlib import Path

from nerfstudio.data.dataparsers.base_dataparser import DataparserOutputs
from nerfstudio.data.dataparsers.nerfstudio_dataparser import (
    Nerfstudio,
    NerfstudioDataParserConfig,
)
from nerfstudio.plugins.registry_dataparser import DataParserSpecification

from fsel.captures.opening import locked
from fsel.core.files import cache, digest
from fsel.selection.api import select
from fsel.selection.export.subset import SPLIT


@dataclass
class FselConfig(NerfstudioDataParserConfig):
    """Settings of the data parser."""

    _target: type = field(default_factory=lambda: Selected)
    """target class to instantiate"""
    k: int = 30
    """How many frames train."""
    targets: str = "every:8"
    """The frames that are held out and evaluate: every:N, or a .txt file with a name a line."""
    method: str = "fsel"
    """What selects, see fsel select --method."""
    seed: int = 0
    """Seed of methods that draw at random."""
    long_side: int | None = None
    """Pixels that the images' longer side is reduced to."""
    load_3D_points: bool = True
    """Whether Gaussians start from the points that the picks see."""


@dataclass
class Selected(Nerfstudio):
    """Parser of a selection, which is written as nerfstudio's own layout and read by its own."""

    config: FselConfig

    def _generate_dataparser_outputs(self, split: str = "train") -> DataparserOutputs:
        given, chosen = self.config, copy(self.config)
        chosen.data = selection(given) / SPLIT
        self.config = chosen
        try:
            return super()._generate_dataparser_outputs(split)
        finally:
            self.config = given


def selection(config: FselConfig) -> Path:
    """The folder of a selection, made where it is not there yet."""
    if config.downscale_factor not in (None, 1):
        raise ValueError(
            f"downscale_factor is {config.downscale_factor}; fsel-data reduces images by "
            "--long-side PIXELS"
        )
    source = config.data.resolve()
    files = [source] if source.is_file() else sorted(p for p in source.rglob("*") if p.is_file())
    stamps = [(str(p), p.stat().st_size, p.stat().st_mtime_ns) for p in files]
    settings = {name: getattr(config, name) for name in ("k", "targets", "method", "seed")}
    folder = cache() / "nerfstudio" / digest(settings | {"side": config.long_side, "files": stamps})
    folder.parent.mkdir(parents=True, exist_ok=True)
    with locked(folder.with_suffix(".lock")):
        if not folder.is_dir():
            chosen = select(source, config.k, config.targets, config.method, config.seed)
            link = config.long_side is None
            chosen.export(folder, link=link, long_side=config.long_side)
    return folder


SPECIFICATION = DataParserSpecification(
    FselConfig(), "A capture in any layout that fsel reads, or a video: k selected frames train."
)
