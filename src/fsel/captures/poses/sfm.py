"""Structure from motion on the CPU through pycolmap: points from known poses, poses from images."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from fsel.captures.colmap import mapping, runs
from fsel.captures.colmap.camera import Camera, pycolmap
from fsel.captures.colmap.estimator import Estimator
from fsel.captures.colmap.failures import SLIDES, cause, slides
from fsel.captures.colmap.mapping import Mapped
from fsel.captures.colmap.model import observed, points_of, points_reader, rigid_of, write_model
from fsel.captures.colmap.runs import MIN_PLACED, SEED, Work
from fsel.captures.images import files as image_files
from fsel.captures.images.masks import MASKS, mask_of
from fsel.captures.layouts import colmap
from fsel.captures.layouts.contract import RawCapture
from fsel.core.capture import Capture
from fsel.core.files import emptied
from fsel.core.geometry import viewing_angles
from fsel.core.names import matched
from fsel.core.points import SparsePoints

NEAREST = 48
NEIGHBOURS = 12  # frames that each is matched with when poses are known
MAX_ANGLE = np.radians(60)
DATABASE = "database.db"
log = logging.getLogger(__name__)


class NotPlaced(ValueError):
    """COLMAP placed too few frames: how many was `said`, and why, where the matches tell."""

    def __init__(self, image: image_files.Image, said: str, cause: str) -> None:
        super().__init__(f"{image}: {said}" + (f": {cause}" if cause else ""))
        self.said, self.cause = said, cause


def triangulate(capture: Capture) -> SparsePoints | None:
    """Make sparse points from SIFT matches of the capture's images and its known poses.

    Matching wants images of some 600 to 1000 pixels. None where no match triangulates.
    """
    with TemporaryDirectory() as name:
        folder = Path(name)
        names = [f"{i:06d}.png" for i in range(len(capture))]
        image_files.write(capture.images, folder / "images", names)
        database = folder / DATABASE
        runs.extract(database, folder / "images", names, Work(), camera_each=True)
        model = _posed_model(capture, names, database)
        pairs = [(names[i], names[j]) for i, j in neighbours(capture)]
        runs.match_pairs(database, pairs)
        output = folder / "sparse"
        output.mkdir()
        # on more threads, its bytes would be others each time
        options = pycolmap.IncrementalPipelineOptions(num_threads=1, random_seed=SEED)
        triangulated = pycolmap.triangulate_points(
            model, database, folder / "images", output, options=options
        )
        rows = {name: i for i, name in enumerate(names)}
        frames = {key: rows[image.name] for key, image in triangulated.images.items()}
        points = points_of(observed(triangulated), frames, capture.source)
    log.info("%s: triangulated %d points", capture.source, len(points.xyz) if points else 0)
    return points.without_pixels() if points else None


def neighbours(capture: Capture) -> list[tuple[int, int]]:
    """Return pairs (i, j), i < j, of each frame and 12 of the 48 nearest, within 60 degrees."""
    from scipy.spatial import cKDTree  # here: slow to import, and seldom needed

    near = min(NEAREST, len(capture))
    _, order = cKDTree(capture.centers).query(capture.centers, k=near)
    order = order.reshape(len(capture), near)
    pairs = set()
    for i, row in enumerate(order):
        row = row[row != i]
        alike = row[viewing_angles(capture.axes[i], capture.axes[row]) < MAX_ANGLE]
        pairs |= {(min(i, j), max(i, j)) for j in alike[:NEIGHBOURS].tolist()}
    return sorted(pairs)


def _posed_model(capture: Capture, names: list[str], database: Path) -> pycolmap.Reconstruction:
    """Return a model of the poses, numbered as the database, which gets the known intrinsics."""
    model = pycolmap.Reconstruction()
    rows = {name: i for i, name in enumerate(names)}
    with pycolmap.Database.open(str(database)) as stored:
        for image in stored.read_all_images():
            i = rows[image.name]
            lens = Camera("PINHOLE", *capture.size, tuple(capture.intrinsics[i])).colmap
            lens.camera_id = image.camera_id
            stored.update_camera(lens)
            model.add_camera_with_trivial_rig(lens)
            posed = pycolmap.Image(
                image_id=image.image_id, name=image.name, camera_id=image.camera_id
            )
            model.add_image_with_trivial_frame(posed, rigid_of(capture.world_to_camera[i]))
    return model


def reconstruct(raw: RawCapture, work: Work) -> RawCapture:
    """Return a capture's placed frames, with poses, cameras and points from the images alone."""
    return with_model(raw, place(raw, work).model, f"not placed by {work.who}")


def place(raw: RawCapture, work: Work, start: pycolmap.Reconstruction | None = None) -> Mapped:
    """Return the best model built from a capture's images, its images named as the frames.

    The world is COLMAP's, or the program's, own; nothing is aligned to poses that the capture came
    with. COLMAP goes on with a model that was made in the same folder; programs start anew.

    Raises:
        NotPlaced: when fewer than three frames could be placed.
    """
    with nullcontext(work.folder) if work.folder else TemporaryDirectory() as name:
        folder = Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        names = runs.linked(raw.images, folder / "images", work)
        if work.by is not None:
            models = [colmap.load_model(path) for path in work.by.models(folder)]
            found: Mapped | None = Mapped(max(models, key=lambda model: model.num_reg_images()))
        else:
            found = _mapped(raw, names, folder, work, start)
        placed = found.model.num_reg_images() if found else 0
        log.info("%s placed %d of %d frames", work.who, placed, len(names))
        if found is None or placed < MIN_PLACED:
            said = f"{work.who} placed {placed} of {len(names)} frames"
            said += f"; at least {MIN_PLACED} are needed"
            raise NotPlaced(raw.images[0], said, "" if work.by else cause(folder / DATABASE))
        both = [model for model in (found.model, found.other) if model is not None]
        images = [image for model in both for image in model.images.values()]
        rows = matched(names, [image.name for image in images])
        for image in images:
            if image.name not in rows:
                raise ValueError(f"{work.who} placed {image.name!r}, none of {names[:3]} ...")
            image.name = raw.names[rows[image.name]]
    return found


def _mapped(
    raw: RawCapture,
    names: Sequence[str],
    folder: Path,
    work: Work,
    start: pycolmap.Reconstruction | None,
) -> Mapped | None:
    """Return what COLMAP's mappers build in a folder."""
    database, begun = folder / DATABASE, None
    if work.masks is not None:
        _mask(raw, names, folder, work.masks)
    runs.extract(database, folder / "images", names, work)
    runs.match(database, names, work)
    if slides(database):
        said = f"COLMAP cannot place its {len(names)} frames"
        raise NotPlaced(raw.images[0], said, SLIDES)
    if start is not None:  # its images are named as the frames, those of the database otherwise
        stored, renamed = dict(zip(raw.names, names, strict=True)), pycolmap.Reconstruction(start)
        for image in renamed.images.values():
            image.name = stored[image.name]
        begun = folder / "begun"
        write_model(renamed, begun)
    if work.breaks:
        mapping.separate(database, names, work.breaks)
    return mapping.build(database, folder, len(names), work, begun)


def _mask(raw: RawCapture, names: Sequence[str], folder: Path, masks: Path | Estimator) -> None:
    """Write the masks of images, which features are kept to, as `masks/NAME.png`, if not there."""
    output, known = folder / MASKS, dict(enumerate(raw.names))
    output.mkdir(exist_ok=True)
    new = [i for i, name in enumerate(names) if not (output / f"{name}.png").is_file()]
    place = folder / "masking"
    if isinstance(masks, Estimator) and new:
        emptied(place)
        made = runs.linked([raw.images[i] for i in new], place / "images", Work())
        masks.write(place, place / MASKS, "masks")
        known = dict(zip(new, made, strict=True))
    given = masks if isinstance(masks, Path) else place / MASKS
    for i in new:
        white = mask_of(given, known[i], raw.images[i]) * np.uint8(255)
        size = image_files.size_of(folder / "images" / names[i])
        white = cv2.resize(white, size, interpolation=cv2.INTER_AREA)
        image_files.write(white[None], output, [f"{names[i]}.png"])


def with_model(raw: RawCapture, model: pycolmap.Reconstruction, reason: str) -> RawCapture:
    """Return images with another model's poses, cameras and points; drop others for `reason`."""
    posed = {image.name: image for image in model.images.values() if image.has_pose}
    rows = matched(raw.names, sorted(posed))
    if not rows:
        raise ValueError(f"none of the model's images {sorted(posed)[:3]} is in the capture")
    kept = sorted(rows.values())
    images = [posed[name] for name in sorted(rows, key=rows.__getitem__)]
    return replace(
        raw.subset(kept, reason),
        world_to_camera=np.array([image.cam_from_world().matrix() for image in images]),
        cameras=[colmap.camera_of(model.cameras[image.camera_id]) for image in images],
        points=points_reader(model, [image.image_id for image in images]),
    )
