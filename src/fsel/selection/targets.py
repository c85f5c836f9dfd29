"""Targets: what a person wants rendered, in words or as a file, as poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from fsel.core.capture import Capture, Views
from fsel.core.geometry import check_poses, pairwise_distances, pose_distance
from fsel.core.subsets import evenly
from fsel.core.wording import counted
from fsel.selection.frames import LISTS, Wish, frames_of, frames_wished, named_in
from fsel.selection.paths import camera_path, orbit, trajectory, views_at, whole

MOST_VIEWS = 60  # neighbours on a denser path lead to the same frames
FAR = 3.0  # extents of a capture beyond which a view cannot be of the same world
ROUNDING = 1e-9  # of the centres' greatest coordinate: cameras in one place differ by less
WORDS = ("every:N", "orbit", "trajectory", "a .json camera path", "a .txt list of frame names")
ALL = "the whole capture"
ORBIT, TRAJECTORY = "orbit", "trajectory"
EVERY = "every:"

NO_FRAMES = np.empty(0, np.int64)

Request = None | str | Path | Views | Sequence[str] | Sequence[int] | np.ndarray


@dataclass(frozen=True)
class Targets:
    """Views to select for, and int64 frames of the capture that may not be selected.

    Attributes:
        views: T poses.
        frames: those that are held out; empty where the views are no frames of the capture.
        kind: where the views come from, in words.
        far: (T,) bool, views so far from every camera that no frame can show what they see.
        blind: those that see nothing of the object of interest.
        never: those that a person does not want.
        always: those that a person wants: selected first.
        dropped: those that are wanted and, which counts, unwanted: their neighbours replace them.
        bad: those that are bad, see `fsel.captures.quality`.
    """

    views: Views
    frames: np.ndarray
    kind: str
    far: np.ndarray
    blind: np.ndarray = field(default_factory=lambda: NO_FRAMES)
    never: np.ndarray = field(default_factory=lambda: NO_FRAMES)
    always: np.ndarray = field(default_factory=lambda: NO_FRAMES)
    dropped: np.ndarray = field(default_factory=lambda: NO_FRAMES)
    bad: np.ndarray = field(default_factory=lambda: NO_FRAMES)

    def as_many_as(self, k: int) -> bool:
        """Whether views are stated, and no fewer than k frames."""
        return self.kind != ALL and k <= len(self.views)

    def pool(self, capture: Capture) -> np.ndarray:
        """(n,) int64 the frames that may be selected, ascending."""
        unwanted = np.concatenate([frames for frames, _, _ in self.left_out()])
        return np.setdiff1d(np.arange(len(capture)), unwanted)

    def wished(self, capture: Capture, always: Wish = None, never: Wish = None) -> Targets:
        """The same with frames that are always, and never, to be selected; never prevails.

        Raises:
            ValueError: for frames that the capture does not have, or that cannot be selected.
        """
        wanted, unwanted = (frames_wished(capture, wish) for wish in (always, never))
        gone = np.isin(wanted, unwanted)
        wished = replace(self, never=unwanted, always=wanted[~gone], dropped=wanted[gone])
        for frames, why, _ in self.left_out():
            for lost in np.intersect1d(wanted, frames):
                raise ValueError(
                    f"frame {capture.names[lost]!r} is to be selected always, and {why}"
                )
        return wished

    def with_stand_ins(self, capture: Capture, k: int) -> Targets:
        """The same with the nearest free frame of each dropped one, up to k wanted ones."""
        always, centers, axes = self.always, capture.centers, capture.axes
        for lost in self.dropped[: k - len(always)]:
            free = np.setdiff1d(self.pool(capture), always)
            apart = pose_distance(centers[free], axes[free], centers[[lost]], axes[[lost]])
            always = np.append(always, free[apart.argmin()])
        return replace(self, always=always)

    def left_out(self) -> list[tuple[np.ndarray, str, str]]:
        """Frames that may not be selected, (n,) numbers, and why, of one and of several."""
        return [
            (self.frames, "is held out as a target", "being held out as targets"),
            (self.blind, "sees nothing of the object", "not seeing the object"),
            (self.never, "is never to be selected", "being unwanted"),
            (self.bad, "is bad", "being bad (`keep_bad=True` keeps them)"),
        ]

    def seeing(self, corners: np.ndarray, capture: Capture) -> Targets:
        """The views that see any of (C, 3) points of an object, to be served by frames that do.

        Raises:
            ValueError: when no view does.
        """
        kept = np.flatnonzero(sees(self.views, corners).any(axis=1))
        if not len(kept):
            raise ValueError(
                f"{_where(capture)}none of {counted(len(self.views), 'target view')} ({self.kind}) "
                "sees the object; is its position in the capture's world frame?"
            )
        blind = np.flatnonzero(~sees(capture.views, corners).any(axis=1))
        return replace(self, views=self.views.subset(kept), far=self.far[kept], blind=blind)


def targets_of(capture: Capture, request: Request, most: int = MOST_VIEWS) -> Targets:
    """Read a request; a path has as many views as `most`.

    None is the whole capture; `every:N` holds out every N-th frame, the first included; `orbit` and
    `trajectory` are paths made from the cameras; a file is a .json camera path, or a .txt with a
    frame name a line, which are held out as names or numbers of frames are; poses are `Views`, or
    (T, 3, 4) or (T, 4, 4) numbers, world to camera with OpenCV axes, seen with the capture's first
    intrinsics.

    Raises:
        ValueError: for a request that is none of these, names that the capture does not have, or
            views that all lie far from every camera.
        FileNotFoundError: when a file is not there.
    """
    check_targets(request)
    if request is None:
        return _request(capture, whole(capture, MOST_VIEWS), ALL)
    if isinstance(request, Views):
        return _request(capture, request, "given poses", most)
    if isinstance(request, str) and (request.startswith(EVERY) or "." not in request):
        return _of_word(capture, request, most)
    if isinstance(request, str | Path):
        return _of_file(capture, Path(request), most)
    if np.asarray(request).ndim == 3:
        return _request(capture, _views(capture, np.asarray(request)), "given poses", most)
    frames = np.sort(frames_of(capture, request, "targets"))
    return _held_out(capture, frames, counted(len(frames), "given frame"))


def check_targets(request: Request) -> None:
    """Refuse words that stand for no targets, and files that are not there or of another kind."""
    allowed = f"allowed: {', '.join(WORDS)}"
    if isinstance(request, str) and (request.startswith(EVERY) or "." not in request):
        step = request.removeprefix(EVERY)
        every = step != request and step.isdecimal() and int(step) > 1
        if request not in (ORBIT, TRAJECTORY) and not every:
            raise ValueError(f"targets are {request!r}; {allowed}, where N is 2 or more")
    elif isinstance(request, str | Path):
        if not Path(request).is_file():
            raise FileNotFoundError(f"{request}: no such file of targets; {allowed}")
        if Path(request).suffix not in ("", ".json", *LISTS):
            raise ValueError(f"{request}: is no file of targets; {allowed}")


def check_count(
    k: int,
    targets: Targets,
    capture: Capture,
    panorama: np.ndarray | None = None,
    *,
    everything: bool = False,
) -> None:
    """Refuse more frames than may be selected, and, of a method that takes everything, fewer.

    Where frames have an (N,) number of their `panorama`, these are counted.
    """
    number = np.arange(len(capture)) if panorama is None else panorama
    most = len(np.unique(number[targets.pool(capture)]))
    wanted = len(np.unique(number[targets.always]))
    gone = targets.left_out()
    why = "".join(f", {len(frames)} {text}" for frames, _, text in gone if len(frames))
    if not 1 <= k <= most:
        raise ValueError(
            f"k is {k}; allowed: 1 to {most}, the {'frames' if panorama is None else 'panoramas'} "
            f"of {capture.source} that may be selected{why}"
        )
    if wanted > k:
        raise ValueError(f"k is {k}, but {wanted} frames must always be selected")
    if everything and k != most:
        raise ValueError(
            f"k is {k}, and this method takes every frame; allowed: {most}, the frames of "
            f"{capture.source} that may be selected{why}"
        )


def _views(capture: Capture, poses: np.ndarray) -> Views:
    """Views at (T, 3, 4) or (T, 4, 4) poses."""
    if poses.shape[1:] not in ((3, 4), (4, 4)) or poses.dtype.kind not in "fiu":
        raise ValueError(
            f"targets are an array of {poses.shape} {poses.dtype}; allowed: (T, 3, 4) or "
            "(T, 4, 4) numbers, world to camera"
        )
    poses = poses[:, :3].astype(np.float64)
    check_poses([f"target {at}" for at in range(len(poses))], poses, "given poses")
    return views_at(poses, capture)


def _where(capture: Capture) -> str:
    """Begin a refusal that only the capture can be blamed for."""
    return f"{capture.source}: " if capture.source else ""


def _of_word(capture: Capture, word: str, most: int) -> Targets:
    if word == ORBIT:
        try:
            views = orbit(capture, most)
        except ValueError as error:
            raise ValueError(f"{_where(capture)}{error}") from error
        return _request(capture, views, "an orbit", most)
    if word == TRAJECTORY:
        return _request(capture, trajectory(capture, most), "the smoothed camera path", most)
    step = word.removeprefix(EVERY)
    frames = np.arange(0, len(capture), min(int(step), len(capture)))
    return _held_out(capture, frames, f"one frame in {step}, held out")


def _of_file(capture: Capture, path: Path, most: int) -> Targets:
    if path.suffix == ".json":
        return _request(capture, camera_path(path, capture), f"the poses of {path.name}", most)
    frames = np.sort(named_in(path, capture))
    return _held_out(capture, frames, f"{counted(len(frames), 'frame')} of {path.name}, held out")


def _held_out(capture: Capture, frames: np.ndarray, kind: str) -> Targets:
    if len(frames) > len(capture) - 2:
        raise ValueError(
            f"{_where(capture)}{kind}: {len(frames)} of {len(capture)} frames are targets; "
            "at least two must remain to select from"
        )
    return replace(_request(capture, capture.view(frames), kind), frames=frames)


def _request(capture: Capture, views: Views, kind: str, most: int = MOST_VIEWS) -> Targets:
    """Thin the views evenly, and see that they are of this world."""
    views = views.subset(evenly(len(views), most))
    centers = capture.centers
    extent = np.linalg.norm(centers - centers.mean(axis=0), axis=1).max()
    gap = pairwise_distances(views.centers, centers).min(axis=1)
    far = gap > max(FAR * extent, ROUNDING * np.abs(centers).max())
    if far.all():
        raise ValueError(
            f"{_where(capture)}{kind}: every target view is far from every camera, the "
            f"nearest {gap.min():.4g} away where the capture reaches {extent:.4g} from its middle. "
            "Are they in another world frame? Hint: nerfstudio's viewer exports paths in its own; "
            "put dataparser_transforms.json of the training run beside the path"
        )
    return Targets(views, NO_FRAMES, kind, far)


def sees(views: Views, points: np.ndarray) -> np.ndarray:
    """(T, C) bool: the points lie in front of the view and inside its image."""
    moved = np.einsum("tij,cj->tci", views.world_to_camera[:, :, :3], points)
    moved += views.world_to_camera[:, None, :, 3]
    depth = np.where(moved[..., 2] > 0, moved[..., 2], np.inf)
    focal, middle = views.intrinsics[:, None, :2], views.intrinsics[:, None, 2:]
    pixel = moved[..., :2] / depth[..., None] * focal + middle
    inside = ((pixel >= 0) & (pixel <= np.array(views.size))).all(axis=-1)
    return inside & (moved[..., 2] > 0)
