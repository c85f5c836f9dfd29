"""A capture's poses as COLMAP finds them in its images, beside the given ones."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from fsel.captures.poses import sfm
from fsel.captures.read import read_folder
from fsel.core.capture import Capture
from fsel.core.files import File, write_table
from fsel.core.subsets import evenly
from fsel.experiments import specs
from fsel.experiments.paper.pose_errors import pose_errors
from fsel.experiments.specs import Values
from fsel.stages.describe import describe
from fsel.stages.generate import generate
from fsel.workflow import inputs
from fsel.workflow.experiment import Experiment
from fsel.workflow.refusal import refuse
from fsel.workflow.resources import Size
from fsel.workflow.tables import Job

logger = logging.getLogger(__name__)


def estimate_poses(
    source: File,
    given_folder: File,
    estimated_folder: File,
    errors: File,
    *,
    frames: int,
    matching_side: int,
    long_side: int,
    at_least: int,
    reading: Mapping,
    config: str,
) -> None:
    """Two canonical captures of the frames that COLMAP places: given poses, and its own.

    Both hold the same images, straightened by the given lens, and its intrinsics; COLMAP finds
    poses and points from them. Points come with the poses.

    Args:
        given_folder, estimated_folder: receive the captures.
        errors: receives name, placed, degrees, percent: of every frame, see `pose_errors`.
        frames: how many of the source's are used, evenly spaced.
        matching_side: longer side in pixels of the images matched.
        long_side: of the images stored.
        at_least: frames that the experiment needs.
        reading: further keywords of `fsel.captures.read.read_folder`.

    Raises:
        ValueError: when COLMAP places fewer frames than are needed.
    """
    capture = _straight(source, frames, matching_side, reading)
    kept, poses, points = sfm.estimate(capture)
    if len(kept) < at_least:
        raise ValueError(
            f"{source}: COLMAP placed {len(kept)} of {len(capture)} frames, {at_least} are needed "
            "(targets, as many proxies, and the largest budget tried). Hint: raise `poses.frames`, "
            "or `poses.width` and `poses.height`, or lower `targets`"
        )
    placed = capture.subset(kept)
    estimated = replace(placed, world_to_camera=poses, points=points)
    placed.resized(long_side).save(given_folder)
    estimated.resized(long_side).save(estimated_folder)
    table = pd.DataFrame({"name": placed.names, "placed": True})
    table["degrees"], table["percent"] = pose_errors(poses, placed.world_to_camera)
    lost = [name for name in capture.names if name not in set(placed.names)]
    table = pd.concat([table, pd.DataFrame({"name": lost, "placed": False})])
    units = {"degrees": "degrees", "percent": "per cent of the scene's size"}
    write_table(table, errors, units=units, config=config)
    logger.info("%s: %d of %d frames\n%s", source, len(kept), len(capture), table.describe())


def _straight(source: File, frames: int, long_side: int, reading: Mapping) -> Capture:
    """Frames of a capture, evenly spaced, undistorted, in memory."""
    with TemporaryDirectory() as store:
        whole = read_folder(source, long_side=long_side, store=Path(store), **reading).capture
        return whole.subset(evenly(len(whole), frames))


def least_frames(experiment: Experiment) -> int:
    """Least frames whose poses must be found: targets, their proxies, candidates to select."""
    return int(2 * experiment.config["targets"] + experiment.budget_near(30))


def _large_capture(experiment: Experiment) -> Values:
    """The scene with images large enough to be matched: embedded ones are filmed anew."""
    frames, needed = experiment.config["inexact_poses"]["frames"], least_frames(experiment)
    if frames < needed:
        refuse(
            f"inexact_poses.frames is {frames}, the experiment needs {needed}: targets, as many "
            f"proxies, and a budget of {experiment.budget_near(30)}",
            "raise inexact_poses.frames, or lower targets or budgets",
        )
    return {"source": specs.filmed_anew(experiment, "poses/data")}


def _settings(experiment: Experiment) -> Values:
    config = experiment.config["inexact_poses"]
    return {
        **inputs.ingested(experiment, experiment.config["long_side"]),
        "frames": config["frames"],
        "matching_side": max(config["width"], config["height"]),
        "at_least": least_frames(experiment),
    }


def filming(name: str, folder: str, size: Callable[[Experiment], Values]) -> Job:
    """The rule of a name that films an embedded capture anew into a folder of the scene's."""
    return Job(
        generate,
        name=name,
        outputs={"folder": f"{inputs.SCENE}/{folder}"},
        message=f"Generating {{wildcards.dataset}}/{{wildcards.scene}} with images in {folder}",
        params=lambda experiment: {**inputs.embedded(experiment), **size(experiment)},
        size=Size(2000),
    )


FILMED = filming(
    "generate_large",
    "poses/data",
    lambda experiment: {
        key: experiment.config["inexact_poses"][key] for key in ("frames", "width", "height")
    },
)

POSED = Job(
    estimate_poses,
    outputs={
        **specs.two_captures("poses"),
        "errors": f"{inputs.SCENE}/poses/errors.parquet",
    },
    message="Estimating the poses of {wildcards.dataset}/{wildcards.scene} from its images",
    inputs=_large_capture,
    params=_settings,
    size=Size(4000, 60, "capture"),
)


def describing(name: str, folder: str) -> Job:
    """The rule of a name that describes the frames of a capture in a folder of the scene's."""
    place = f"{inputs.SCENE}/{folder}"
    return Job(
        describe,
        name=name,
        outputs={"descriptors": f"{place}/descriptors.parquet"},
        message=f"Describing {{wildcards.dataset}}/{{wildcards.scene}}, {folder}",
        inputs=lambda experiment: inputs.capture(inputs.BARE, place),
        params=lambda experiment: experiment.config["appearance"],
        size=Size(2000, 30, "capture"),
    )


JOBS = (FILMED, POSED, describing("describe_posed", "poses/given"))
