"""COLMAP's steps through pycolmap, in parts that are watched, interrupted and gone on with."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fsel.captures.colmap import features, pairs, sift
from fsel.captures.colmap.camera import pycolmap
from fsel.captures.colmap.estimator import Estimator, checked, named
from fsel.captures.colmap.learned import LONG_SIDE
from fsel.captures.colmap.search_time import SearchTime
from fsel.captures.images import files as image_files
from fsel.captures.images.files import Size
from fsel.captures.images.masks import MASKS
from fsel.captures.images.previews import Progress, in_silence, in_turn, shrunk
from fsel.core.limits import threads
from fsel.core.wording import counted, in_minutes

SIDES = {features.SIFT: sift.SIDE, features.ALIKED: LONG_SIDE}  # of a video, most pixels
SPHERE = "EQUIRECTANGULAR"  # COLMAP's camera that sees all directions
CPU = pycolmap.Device.cpu
SEED, TRIALS = 0, 10_000  # of verification, at most
FILMED_TRIALS = 1000  # of a video's pairs: the same inliers in half of the time
MIN_PLACED = 3
EXHAUSTIVE = 60  # images up to which all pairs of a set without order are matched
FEW = 40  # and of a video: sequential matching saves nothing below
LIT = 64  # grey levels of an image's contrast, below which SIFT's threshold is lowered
DIM, FAINTEST = 0.25, 3  # a step of lowering it, and how many there are
IMAGES, PAIRS = 8, 100  # in a part: what a run that is cut off loses; after each, the time left
FRAME_SECONDS = 0.2, 1.0  # of a core, to find features: fixed, and for a megapixel
PAIR_SECONDS = 0.02, 0.1  # to match a pair, likewise
MAPPING_SECONDS = 0.8  # seconds a frame and megapixel, placed by the global mapper
FILMED_SECONDS = 0.4, 0.02  # all of that for a frame of a video, and a pair
MAPPED_AS = 10  # pairs that take as long to match as a frame to be placed
PAIRS_BESIDE = 14, 18  # pairs of a frame of videos and others: near, far ahead, and alike
MOST_READ, MOST_KEPT = 8.0, 3.0  # megapixels: COLMAP reduces larger images, and keeps 8192 features


@dataclass(frozen=True)
class Part:
    """Images of one camera.

    Of frames of a video, in order, neighbours are matched, and images that look alike; else all
    pairs are, of up to 60 images.
    """

    numbers: Sequence[int]  # one an image, which name it in the database, whatever comes later
    ordered: bool
    panoramic: bool = False  # whether they show all directions

    @property
    def filmed(self) -> bool:
        """Check whether they are a video's, whose features are `sift`'s."""
        return self.ordered and not self.panoramic


@dataclass(frozen=True)
class Work:
    """Settings of a run of structure from motion."""

    folder: Path | None = None  # keeps the database, so that a run that was cut off goes on
    parts: Sequence[Part] = ()  # none for images without order
    breaks: Sequence[int] = ()  # rows of images before which no far ones are matched
    watch: Callable[[str], Progress] = lambda label: in_silence  # a step's name -> wraps its loop
    by: Estimator | None = None  # finds the poses; None for COLMAP's mappers
    features: str = features.SIFT  # that COLMAP works with, one of `features.KINDS`
    masks: Path | Estimator | None = None  # folder, or what makes them: features lie in white alone
    time: SearchTime = field(default_factory=SearchTime)
    say: Callable[[str, str], None] = lambda label, text: None

    @property
    def who(self) -> str:
        """Name of what places the frames."""
        return named(self.features) if self.by is None else self.by.name


def work_of(poses: Mapping[str, Any], devices: bool = True) -> Work:
    """Return the settings of a configuration's `poses`: fields of `Estimator`, or `features`."""
    if "features" not in poses:
        return Work(by=checked(poses, devices))
    if set(poses) > {"features"} or poses["features"] not in features.KINDS:
        allowed = " or ".join(features.KINDS)
        raise ValueError(f"poses: features is {allowed}, alone: {poses}")
    features.check(poses["features"])
    return Work(features=poses["features"])


def linked(files: Sequence[image_files.Image], folder: Path, work: Work) -> list[str]:
    """Return the images under plain names: links to files, copies of frames of a video.

    COLMAP gets the frames of a filmed part at the size that features are found at: it allows for
    errors of a few pixels, and features found in a reduced image are wrong by more in a large one.
    """
    folder.mkdir(exist_ok=True)
    parts = [(f"{at:02d}_{i:06d}", p.filmed) for at, p in enumerate(work.parts) for i in p.numbers]
    parts = parts or [(f"{i:06d}", False) for i in range(len(files))]
    most = SIDES[work.features]

    def place(at: int) -> str:
        (stem, filmed), file = parts[at], files[at]
        longest = max(_size(file)) if filmed and work.by is None else 0
        if isinstance(file, Path) and longest <= most:
            name = f"{stem}{file.suffix}"
            (folder / name).unlink(missing_ok=True)
            (folder / name).symlink_to(file.resolve())
            return name
        name = f"{stem}.png"
        if not (folder / name).is_file():
            image = shrunk(file, longest, most) if longest > most else image_files.load(file)
            image_files.write(image[None], folder, [name])
        return name

    return in_turn(place, files)


def extract(
    database: Path, folder: Path, names: Sequence[str], work: Work, *, camera_each: bool = False
) -> None:
    """Store features of new images, each with a camera of its own or one for a part and size.

    Images get their numbers in order before all cores look for features: the database is the same
    on any number of cores.
    """
    mode = pycolmap.CameraMode.PER_IMAGE if camera_each else pycolmap.CameraMode.SINGLE
    with pycolmap.Database.open(str(database)) as stored:
        there = stored.read_all_images()
        known = {image.name for image in there if stored.exists_keypoints(image.image_id)}
    wanted = [name for name in names if name not in known]
    most = max(IMAGES, 2 * threads())
    groups = _alike(folder, wanted, camera_each)
    batches = [(*key, part) for key, group in groups.items() for part in _batches(group, most)]
    for kind, contrast, part in work.watch("features")(batches, len(batches)):
        options = pycolmap.FeatureExtractionOptions(num_threads=threads())
        options.sift.peak_threshold *= contrast
        source = work.parts[int(kind[0])] if kind is not None and kind[0] else None
        filmed = source is not None and source.filmed
        reader = _reader(database, folder, kind, source)
        pycolmap.import_images(database, folder, mode, part, reader)
        if filmed or work.features != features.SIFT:
            (sift if work.features == features.SIFT else features).extract(database, folder, part)
            continue
        pycolmap.extract_features(
            database,
            folder,
            image_names=part,
            camera_mode=mode,
            reader_options=reader,
            extraction_options=options,
            device=device(),
        )


def _alike(folder: Path, names: Sequence[str], camera_each: bool) -> dict[tuple, list[str]]:
    """Return the images of each kind, a part and size or None for a camera each, and contrast."""
    files = [folder / name for name in names]
    groups: dict[tuple, list[str]] = {}
    contrasts = in_turn(lambda at: _contrast(files[at]), files)
    for name, contrast in zip(names, contrasts, strict=True):
        kind = None if camera_each else (_part_of(name), _size(folder / name))
        groups.setdefault((kind, contrast), []).append(name)
    return groups


def _reader(
    database: Path, folder: Path, kind: tuple[str, Size] | None, source: Part | None
) -> pycolmap.ImageReaderOptions:
    """Return the masks and the camera of the images of a part and size, None for one each."""
    reader = pycolmap.ImageReaderOptions()
    if source is not None and source.panoramic:
        reader.camera_model = SPHERE
    if (masks := folder.with_name(MASKS)).is_dir():
        reader.mask_path = masks
    if kind is not None and (camera := _camera_of(database, *kind)) is not None:
        reader.existing_camera_id = camera
    return reader


def device() -> pycolmap.Device:
    """Return a GPU where pycolmap is built for NVIDIA's (pycolmap-cuda12) and one is there."""
    gpu = pycolmap.has_cuda and shutil.which("nvidia-smi")
    return pycolmap.Device.auto if gpu else CPU


def _size(path: image_files.Image) -> Size:
    """Return (width, height); (0, 0) of an image that cannot be read, for COLMAP to pass over."""
    try:
        return image_files.size_of(path)
    except ValueError:
        return 0, 0


def _contrast(path: Path) -> float:
    """Share of a lit image's contrast, a power of 1/4: SIFT's threshold is of the absolute one."""
    try:
        grey = image_files.load(path, cv2.IMREAD_REDUCED_GRAYSCALE_4)
    except ValueError:
        return 1.0
    low, high = np.percentile(grey, [1, 99])
    shares = (DIM**power for power in range(FAINTEST))
    return next((share for share in shares if high - low >= LIT * share), DIM**FAINTEST)


def _part_of(name: str) -> str:
    """Return the part that a name of `linked` tells; empty where there are no parts."""
    part, between, _ = name.partition("_")
    return part if between else ""


def _camera_of(database: Path, part: str, size: Size) -> int | None:
    """Return the camera of the images of a part and a (width, height), where one was stored."""
    with pycolmap.Database.open(str(database)) as stored:
        alike = {c.camera_id for c in stored.read_all_cameras() if (c.width, c.height) == size}
        cameras = [i.camera_id for i in stored.read_all_images() if _part_of(i.name) == part]
    return next((camera for camera in cameras if camera in alike), None)


def match(database: Path, names: Sequence[str], work: Work) -> None:
    """Match and verify pairs of images, near ones first, so that they connect all where time runs
    out. Pairs that the database has are passed over, and those of images matched before."""
    done = database.with_suffix(".txt")  # names of images whose pairs were all matched
    known = set(done.read_text(encoding="utf-8").splitlines()) if done.is_file() else set()
    chosen = _chosen(database, names, work.parts or [Part(range(len(names)), False)])
    chosen = [(i, j) for i, j in chosen if not known.issuperset((names[i], names[j]))]
    chosen.sort(key=lambda pair: (pair[1] - pair[0], pair))
    filmed = bool(work.parts) and all(part.filmed for part in work.parts)
    batches, began = _batches(chosen, PAIRS), time.monotonic()
    for at, part in enumerate(work.watch("matching")(batches, len(batches))):
        if work.time.left <= 0:
            return
        named = [(names[i], names[j]) for i, j in part]
        if work.features != features.SIFT:
            features.match(database, named)  # what is matched is verified below
        elif filmed and device() == CPU:
            sift.match(database, named)
        match_pairs(database, named, FILMED_TRIALS if filmed else TRIALS)
        if not at and len(batches) > 1:
            each = (time.monotonic() - began) / PAIRS
            left = each * (len(chosen) - PAIRS + MAPPED_AS * len(names))
            work.say("plan", f"{in_minutes(left)} left")
    done.write_text("\n".join(names), encoding="utf-8")


def _chosen(database: Path, names: Sequence[str], parts: Sequence[Part]) -> pairs.Pairs:
    """Pairs (i, j), i < j: near ones of each part, and those that look alike in it and beyond."""
    if len(names) <= (FEW if any(part.ordered for part in parts) else EXHAUSTIVE):
        return pairs.every_pair(len(names))
    near, within, beside, first = [], [], [], 0
    for part in parts:
        count = len(part.numbers)
        every = not part.ordered and count <= EXHAUSTIVE
        close = pairs.every_pair(count) if every else pairs.in_sequence(count)
        near += [(first + i, first + j) for i, j in close]
        own = [(first + i, first + j) for i, j in pairs.every_pair(count)]
        beside += [(i, j) for i, j in own if part.ordered and j - i <= pairs.OVERLAP]
        within += own
        first += count
    described = pairs.described(database, names)
    filmed = all(part.ordered for part in parts)
    most, known = pairs.FILMED if filmed else pairs.LOOPS, near + beside
    found = set(near) | set(pairs.alike(described, known, most))
    if len(parts) > 1:  # those that look most alike are often of one part
        found |= set(pairs.alike(described, within))
    return sorted(found)


def match_pairs(database: Path, names: Sequence[tuple[str, str]], trials: int = TRIALS) -> None:
    """Match and verify some pairs of images, by name; each pair draws its samples by one seed."""
    verification = pycolmap.TwoViewGeometryOptions()
    verification.ransac.random_seed, verification.ransac.max_num_trials = SEED, trials
    listed = database.with_name("pairs.txt")
    listed.write_text("".join(f"{one} {other}\n" for one, other in names), encoding="utf-8")
    pycolmap.match_image_pairs(
        database,
        matching_options=pycolmap.FeatureMatchingOptions(num_threads=threads()),
        pairing_options=pycolmap.ImportedPairingOptions(match_list_path=str(listed)),
        verification_options=verification,
        device=device(),
    )


def _batches(items: Sequence, size: int) -> list[list]:
    return [list(items[at : at + size]) for at in range(0, len(items), max(size, 1))]


def plan(frames: int, pixels: int, *, ordered: bool, cores: int) -> str:
    """Return the frames and pairs of a run of COLMAP with SIFT, and about how long it takes."""
    every = frames <= (FEW if ordered else EXHAUSTIVE)
    matched = frames * (frames - 1) // 2 if every else frames * PAIRS_BESIDE[not ordered]
    kept = min(pixels / 1e6, MOST_KEPT)
    one, pair = FILMED_SECONDS
    if not ordered:
        one = FRAME_SECONDS[0] + FRAME_SECONDS[1] * min(pixels / 1e6, MOST_READ)
        one, pair = one + MAPPING_SECONDS * kept, PAIR_SECONDS[0] + PAIR_SECONDS[1] * kept
    about = in_minutes((frames * one + matched * pair) / cores)
    return f"{counted(frames, 'frame')}, {matched:,} pairs: {about} on {counted(cores, 'core')}"
