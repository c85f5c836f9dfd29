"""Needs of a configuration that are not here: datasets, reconstructors, weights, packages.

What asks a reconstructor, a network or a scorer is imported where the configuration names one:
rules are read in an environment with Snakemake alone, and in fewer seconds.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from importlib.util import find_spec
from threading import Thread
from typing import Any

from fsel.core.programs import MissingRequirement
from fsel.reconstruct import check_needs
from fsel.workflow.datasets import Section
from fsel.workflow.experiment import Experiment
from fsel.workflow.schema import MissingProgram, Refusal
from fsel.workflow.settings import PAGE


def check_reconstructors(named: Mapping[str, Section], where: str) -> None:
    """Refuse reconstructors that cannot work here, before any job."""
    if lines := _missing_of((where, *each) for each in named.items()):
        raise MissingProgram("\n".join(lines), PAGE)


def check_poses(where: str, poses: str | Section) -> None:
    """Refuse a program for poses that cannot work here, before any job."""
    if lines := _missing_poses(where, poses):
        raise Refusal("\n".join(lines), PAGE)


def missing_programs(experiment: Experiment) -> list[str]:
    """List what the run needs besides datasets and is not here, a line each; refuse settings that
    are wrong in themselves."""
    named = [("reconstruction", *each) for each in experiment.reconstructors.items()]
    if experiment.labeller != experiment.reconstruction:
        named.append(("search.reconstruction", "labels", experiment.labeller))
    lines = _missing_of(named)
    for dataset, entry in experiment.datasets.entries.items():
        lines += _missing_poses(f"datasets.{dataset}.poses", entry["poses"])
    config = experiment.config
    checks: list[tuple[Callable[..., object], Section]] = []
    if config["appearance"] != {"kind": "lab_hog", "weights": None}:
        from fsel.features import appearance

        checks.append((appearance.check, config["appearance"]))
    if experiment.wants_lpips and not experiment.fetches_lpips:
        from fsel.metrics import lpips

        checks.append((lpips.located, config["lpips"]))
    for check, settings in checks:
        try:
            check(**settings)
        except (FileNotFoundError, ImportError) as error:
            lines.append(str(error))
        except ValueError as error:
            raise Refusal(str(error), PAGE) from error
    # a check ends at the file that it misses, and a page has all
    if config["appearance"]["kind"] == "dinov2" and not find_spec("timm"):
        lines.append("package timm: pip install 'fsel[weights]'")
    return lines


def check_scorers(experiment: Experiment) -> None:
    """Refuse scorers of the configuration that are not there, or are none of their policy."""
    for policy, paths in experiment.config["training"]["weights"].items():
        for path in paths:
            from fsel.selectors import pretrained

            try:
                pretrained.own(path, policy)
            except (ValueError, OSError) as error:
                raise Refusal(
                    f"training.weights.{policy}: {error}",
                    "the workflow writes such files, in results/selector",
                ) from error


def check_storage(provider: Any, prefix: str, write: bool = False, seconds: float = 20) -> None:
    """Refuse a storage of results that does not answer in time, that lacks the bucket or, with
    `write`, that takes no file: an empty one, `.fsel`, stays there."""
    probe = provider.object(os.path.join(prefix, ".fsel"))
    faults = [f"no answer in {seconds:g} s"]

    def ask() -> None:
        try:
            # the plugin for S3 would make a bucket that is not there
            if not probe.exists() and not getattr(probe, "bucket_exists", lambda: True)():
                raise FileNotFoundError("no such bucket, or no right to see it")
            if write:
                probe.local_path().parent.mkdir(parents=True, exist_ok=True)
                probe.local_path().touch()
                probe.store_object()
            faults.clear()
        except Exception as error:
            faults[:] = [f"{type(error).__name__}: {error}"]

    asking = Thread(target=ask, daemon=True)
    asking.start()
    asking.join(seconds)
    if faults and probe.is_valid_query():  # else Snakemake says how one is written
        hint = "a bucket or folder that you may read and write; look at credentials and endpoint"
        raise SystemExit(f"--default-storage-prefix {prefix}: {faults[0]}\nHint: name {hint}")


def _missing_of(named: Iterable[tuple[str, str, Section]]) -> list[str]:
    """List what reconstructors need and is not here: the key, the name and the section of each."""
    checks = [(f"{where}, {name}", partial(check_needs, section)) for where, name, section in named]
    return [line for each in checks for line in _lacking(*each)]


def _missing_poses(where: str, poses: str | Section) -> list[str]:
    """List what a program for poses needs and is not here."""
    if isinstance(poses, str):
        return []
    from fsel.captures.colmap.runs import work_of

    return _lacking(where, partial(work_of, poses))


def _lacking(where: str, check: Callable[..., object]) -> list[str]:
    """List what a check of a program misses; refuse what is wrong in itself."""
    # a cluster's nodes have the GPUs that its login node lacks
    elsewhere = shutil.which("sbatch") is not None
    try:
        check(devices=not elsewhere)
    except MissingRequirement as error:
        return f"{where}: {error}".replace("\n", "\n  ").splitlines()
    except ValueError as error:
        raise Refusal(f"{where}: {error}", PAGE) from error
    return []
