"""Needs of a configuration that are not here: datasets, reconstructors, weights, packages."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from fsel.captures.colmap.runs import work_of
from fsel.core.programs import MissingRequirement
from fsel.features import appearance
from fsel.metrics import lpips
from fsel.reconstruct import check_needs
from fsel.selectors import pretrained
from fsel.workflow.datasets import Section
from fsel.workflow.experiment import Experiment
from fsel.workflow.refusal import MissingProgram, refuse
from fsel.workflow.rules import Tables
from fsel.workflow.settings import PAGE

STAND_INS = Path("config", "stand_ins.yaml")


def check(experiment: Experiment, tables: Tables, configfiles: Sequence[str]) -> None:
    """Refuse a run that needs what is not here, with one page of all of it.

    Args:
        experiment: the run's.
        tables: the paper's, for what can be made without.
        configfiles: those that the run was given.

    Raises:
        Refusal: for a dataset that is not there, unless `allow_missing` is true or the labelled one
            is among them; for anything else that is not there; for what is wrong in itself.
    """
    others = missing_programs(experiment)
    check_scorers(experiment)
    datasets = experiment.datasets
    needed = experiment.trained in datasets.missing or not datasets.entries
    refused = datasets.missing and (needed or not experiment.config["allow_missing"])
    if others or refused:
        others += tables.missing_programs()
    if refused:
        count = len(datasets.missing) + len(datasets.entries)
        lines = [f"  {reason}" for reason in datasets.missing.values()]
        if others:
            lines += [f"and {len(others)} of what else is named is not here:"]
            lines += [f"  {line}" for line in others]
            lines += _without(experiment, tables, configfiles)
        refuse(
            f"no folders (from {Path.cwd()}) for {len(datasets.missing)} of {count} datasets:\n"
            + "\n".join(lines),
            "put each dataset there, correct the path, or leave its entry out; `allow_missing: "
            "true` makes what can be made without, and captions name what is missing",
        )
    if others:
        lines = [*(f"  {line}" for line in others), *_without(experiment, tables, configfiles)]
        refuse(
            f"{len(others)} of what is named is not here:\n" + "\n".join(lines),
            "get each as it says; paths are from the folder of the run. docs/reconstructors.md "
            "has the licences",
        )


def check_reconstructors(named: Mapping[str, Section], where: str) -> None:
    """Refuse reconstructors that cannot work here, before any job."""
    if lines := [line for own in named.items() for line in _missing_of(where, *own)]:
        raise MissingProgram(lines, PAGE)


def check_poses(where: str, poses: str | Section) -> None:
    """Refuse a program for poses that cannot work here, before any job."""
    if lines := _missing_poses(where, poses):
        refuse("\n".join(lines), PAGE)


def missing_programs(experiment: Experiment) -> list[str]:
    """List what the run needs besides datasets and is not here, a line each.

    Raises:
        Refusal: for settings that are wrong in themselves.
    """
    named = [("reconstruction", *each) for each in experiment.reconstructors.items()]
    if experiment.labeller != experiment.reconstruction:
        named.append(("search.reconstruction", "labels", experiment.labeller))
    lines = [line for each in named for line in _missing_of(*each)]
    for dataset, entry in experiment.datasets.entries.items():
        lines += _missing_poses(f"datasets.{dataset}.poses", entry["poses"])
    config = experiment.config
    checks: list[tuple[Callable[..., object], Section]]
    checks = [(appearance.check, config["appearance"])]
    own_lpips = experiment.wants_lpips and not experiment.fetches_lpips
    if own_lpips:
        checks.append((lpips.located, config["lpips"]))
    for check, settings in checks:
        try:
            check(**settings)
        except (FileNotFoundError, ImportError) as error:
            lines.append(str(error))
        except ValueError as error:
            refuse(str(error), PAGE)
    # a check ends at the file that it misses, and a page has all
    wanted = {
        "timm": config["appearance"]["kind"] == "dinov2",
        "lpips": own_lpips,
    }
    missing = [name for name, needed in wanted.items() if needed and not find_spec(name)]
    if missing:
        lines.append(f"packages {', '.join(missing)}: pip install 'fsel[weights]'")
    return lines


def check_scorers(experiment: Experiment) -> None:
    """Refuse scorers of the configuration that are not there, or are none of their policy."""
    for policy, paths in experiment.config["training"]["weights"].items():
        for path in paths:
            try:
                pretrained.own(path, policy)
            except (ValueError, OSError) as error:
                refuse(
                    f"training.weights.{policy}: {error}",
                    "the workflow writes such files, in results/selector",
                )


def _missing_of(where: str, name: str, section: Section) -> list[str]:
    """List what a reconstructor needs and is not here; the first line says whose it is."""
    return _lacking(f"{where}, {name}", partial(check_needs, section))


def _missing_poses(where: str, poses: str | Section) -> list[str]:
    """List what a program for poses needs and is not here."""
    return [] if isinstance(poses, str) else _lacking(where, partial(work_of, poses))


def _lacking(where: str, check: Callable[..., object]) -> list[str]:
    """List what a check of a program misses; refuse what is wrong in itself."""
    # a cluster's nodes have the GPUs that its login node lacks
    elsewhere = shutil.which("sbatch") is not None
    try:
        check(devices=not elsewhere)
    except MissingRequirement as error:
        return f"{where}: {error}".replace("\n", "\n  ").splitlines()
    except ValueError as error:
        refuse(f"{where}: {error}", PAGE)
    return []


def _without(experiment: Experiment, tables: Tables, configfiles: Sequence[str]) -> list[str]:
    """Describe how a run goes without what is not here, and what it makes then."""
    files = [*map(Path, configfiles), experiment.folder / STAND_INS]
    given = " ".join(os.path.relpath(path) for path in files)
    allowed = " --config allow_missing=True" if experiment.datasets.missing else ""
    lines = [
        "without: `splats`, GMSD and `lab_hog` in the place of what is missing, by",
        f"  snakemake paper --cores 2 --configfile {given}{allowed}",
    ]
    if experiment.trained in experiment.datasets.missing:
        return [*lines, "  once the dataset of training.dataset is there"]
    made, left_out = tables.possible()
    names = ", ".join(path.rsplit("/")[-1] for path in made)
    return [*lines, f"  which makes {names}", *left_out]
