"""Models of the package `ffgs` from files that are on disk; nothing is downloaded here."""

from __future__ import annotations

import json
import logging
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from fsel.reconstruct.feed_forward.settings import FeedForwardSettings

FILES = ("config.json", "processor_config.json", "model.safetensors")  # of a saved model

logger = logging.getLogger(__name__)


def package() -> ModuleType:
    """`ffgs`, which is an optional extra.

    Raises:
        ImportError: with what to install.
    """
    try:
        import ffgs
        import ffgs.zoo
    except (ImportError, RuntimeError) as error:  # the latter of torchvision
        raise ImportError(
            f"the package ffgs does not work here ({error}). Hint: pip install "
            "'fsel[feed_forward]', with the torchvision that belongs to the installed torch"
        ) from error
    return ffgs


def check(settings: FeedForwardSettings) -> None:
    """Refuse a model or weights that are not on disk.

    Raises:
        ImportError: when the package is not installed.
        ValueError: for a name that is neither a folder nor in the zoo.
        FileNotFoundError: for a missing file, with the command that fetches it.
    """
    zoo, folder = package().zoo, Path(settings.model)
    if folder.is_dir():
        for name in FILES:
            if not (folder / name).is_file():
                raise FileNotFoundError(f"model: {folder / name} is missing")
        if settings.weights is not None:
            raise ValueError(
                f"model {settings.model} is a folder with weights; weights must be null"
            )
        return
    known = zoo.list_models()
    if settings.model not in known:
        raise ValueError(
            f"model is {settings.model!r}, neither a folder nor in the zoo of ffgs; allowed: "
            f"{', '.join(known)}"
        )
    _file(zoo.get_entry(settings.model), settings.weights)


def pipeline_of(settings: FeedForwardSettings):
    """The model on its device. The last one is kept: captures and subsets share it."""
    overrides = json.dumps(dict(settings.processor), sort_keys=True)
    return _loaded(settings.model, settings.weights, settings.device, overrides)


@lru_cache(maxsize=1)
def _loaded(model: str, weights: str | None, device: str, overrides: str):
    ffgs, changed = package(), json.loads(overrides)
    if Path(model).is_dir():
        return ffgs.GSPipeline.from_pretrained(model, device=device, processor_overrides=changed)
    entry = ffgs.zoo.get_entry(model)
    spec, file = ffgs.get_model_spec(entry.model_type), _file(entry, weights)
    digest = ffgs.zoo.sha256_file(file)
    if digest != entry.weights.sha256:
        raise ValueError(
            f"{file}: sha256 is {digest}; the zoo of ffgs states {entry.weights.sha256} for "
            f"{model}. Hint: {_command(entry)}"
        )
    network = spec.model_cls(**entry.model)
    network.load_state_dict(_state(file, spec.convert_state_dict))
    processor = spec.processor_cls(entry.processor, **changed)
    logger.info("%s from %s; licence: %s", model, file, entry.license)
    return ffgs.GSPipeline(network, processor, entry.model_type).to(device)


def _file(entry, weights: str | None) -> Path:
    """File of a zoo model's weights: the given one, or that in the cache of Hugging Face."""
    if weights is not None:
        if not Path(weights).is_file():
            raise FileNotFoundError(f"weights: no file {weights}. Hint: {_command(entry)}")
        return Path(weights)
    from huggingface_hub import try_to_load_from_cache

    pinned = entry.weights
    cached = try_to_load_from_cache(pinned.repo, pinned.file, revision=pinned.revision)
    if not isinstance(cached, str):
        raise FileNotFoundError(
            f"weights of {entry.name} are not in the cache of Hugging Face. Hint: {_command(entry)}"
        )
    return Path(cached)


def _command(entry) -> str:
    pinned = entry.weights
    return (
        f"`hf download {pinned.repo} {pinned.file} --revision {pinned.revision}` fetches them "
        f"(licence: {entry.license})"
    )


def _state(file: Path, convert) -> dict:
    import torch
    from safetensors.torch import load_file

    if file.suffix == ".safetensors":
        state = load_file(file)
    else:
        state = torch.load(file, map_location="cpu", weights_only=True)
    return state if convert is None else convert(state)
