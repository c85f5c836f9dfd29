"""The Python calls: select frames, fit a reconstruction to them, evaluate it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

import numpy as np

from fsel.captures import opening
from fsel.captures.colmap.camera import pycolmap
from fsel.captures.images import video
from fsel.captures.layouts import colmap, nerfstudio
from fsel.captures.lazy import LazyCapture, open_capture, opened, posed
from fsel.core.capture import Capture
from fsel.core.problem import Method
from fsel.core.wording import unexpected
from fsel.selection.budget import Auto, HowMany
from fsel.selection.focus import Focus
from fsel.selection.frames import Wish, frames_of
from fsel.selection.outcome import Selection
from fsel.selection.request import Describe, SelectionRequest, SharpnessOf, checked_request, vet
from fsel.selection.select import select_frames
from fsel.selection.targets import Request
from fsel.selection.validation import TimeBudget

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from fsel.metrics import Metrics
    from fsel.reconstruct import Model
    from fsel.reconstruct.splats.reconstructor import SplatModel

ACCEPTED = (
    "a folder, a video, a Capture (fsel.read_capture), a pycolmap.Reconstruction, or the content "
    "of a transforms.json"
)
Source: TypeAlias = Capture | str | Path | Mapping[str, Any] | pycolmap.Reconstruction


def select(
    capture: Source,
    k: int | str | Auto,
    targets: Request = None,
    method: str | Method | None = None,
    seed: int = 0,
    *,
    weights: str | Path | None = None,
    patience: float | TimeBudget | None = None,
    sharpness: np.ndarray | SharpnessOf | None = None,
    focus: Focus | str | Path | Sequence[float] | None = None,
    descriptors: np.ndarray | Describe | None = None,
    always: Wish = None,
    never: Wish = None,
    keep_bad: bool = False,
    views: bool = False,
) -> Selection:
    """Choose the k frames that best serve the views to be rendered.

    Args:
        capture: a folder, a video (COLMAP finds its poses), a `Capture` (`fsel.read_capture`), a
            `pycolmap.Reconstruction`, or the content of a transforms.json. Images of the last two
            are read from the current folder; without them, poses and points alone decide.
        k: number of frames. `auto`, or `fsel.Auto` with your own loss and memory, chooses it, see
            `fsel.selection.budget`.
        targets: views to be rendered; None for anything that the capture shows. `every:8`, names or
            numbers of frames, or a .txt file of names hold frames out, which are never picked;
            `orbit`, `trajectory`, a .json camera path, `fsel.Views`, or (T, 3, 4) poses, world to
            camera with OpenCV axes, hold out none.
        method: a key of `METHODS`, or a method of your own; None for `fsel`, or for the method of
            `weights`.
        seed: of methods that draw at random.
        weights: file of a scorer that the workflow trained, in place of one in the package.
        patience: seconds for validating selections on the capture's own frames, or on the images
            of targets that are frames, see `fsel.selection.halving`; 0 for the rule alone. None:
            ten, or sixty with at least k such targets; 0 with a `method`, `focus` or other targets.
            `fsel.TimeBudget` also reports progress and can stop it.
        sharpness: (N,) of every frame, or what measures it of some; else measured on the images.
        focus: an object that targets must see: a folder of masks, the six numbers of a box, or a
            `fsel.selection.focus.Focus`.
        descriptors: (N, D) of every frame, or what computes them for a capture; else `lab_hog`.
        always, never: names or numbers of frames, or files of names: those picked first, by methods
            that score frames, and those never picked; frames in both are replaced.
        views: whether views of panoramas are picked one by one, not k panoramas with all of theirs.
        keep_bad: whether bad frames may be picked. Otherwise those that `fsel.bad_frames` lists are
            left out, except of a `Capture` that was not read from image files.

    Raises:
        ValueError: for a request that cannot be met: too few frames, an unknown method, weights of
            another method, targets that do not fit the capture.
        TypeError: for an argument of another type.

    Example:
        >>> chosen = fsel.select("captures/garden", 20, targets="every:8")
        >>> len(chosen.names), len(chosen.held_out)
        (20, 10)
    """
    request = SelectionRequest(
        source=None,
        k=k,
        targets=targets,
        method=method,
        seed=seed,
        weights=weights,
        patience=patience,
        sharpness=sharpness,
        focus=focus,
        descriptors=descriptors,
        always=always,
        never=never,
        keep_bad=keep_bad,
        views=views,
    )
    vet(request)  # poses that are to be found take minutes
    opened = captured(capture, k if isinstance(k, int) and not views else 0, views)
    return select_frames(checked_request(replace(request, source=opened))).selection


def how_many(capture: Source) -> HowMany:
    """Predict what fewer frames than all lose, before poses are trained on.

    Args:
        capture: as of `select`; its bad frames do not count.

    Returns:
        The table that `fsel info` prints.

    Raises:
        ValueError: for a capture of fewer than three frames.

    Example:
        >>> table = fsel.how_many("captures/garden")
        >>> [row.frames for row in table.rows]
        [8, 12, 20, 30, 45, 70]
    """
    found = select(capture, Auto(), patience=0).budget
    assert found is not None
    return found.table


def captured(source: Source, wanted: int = 0, views: bool = False) -> Capture | LazyCapture:
    """Open a capture; a video yields more frames where so many are `wanted`, and is refused where
    `views` are to be picked and it is no panorama."""
    if isinstance(source, Capture):
        return source
    if isinstance(source, str | Path):
        path = Path(source)
        if not video.is_video(path):
            return open_capture(path)
        return opening.opened(opening.Opening((path,), wanted=wanted, views=views))
    if isinstance(source, Mapping):
        name, layout = "transforms.json", nerfstudio.LAYOUT
        raw = nerfstudio.from_json(Path(name), Path(), content=dict(source))
    elif isinstance(source, pycolmap.Reconstruction):
        name, layout = "reconstruction", colmap.LAYOUT
        raw = colmap.from_model(source, Path(), Path(name))
    else:
        raise unexpected("capture", source, ACCEPTED)
    if any(Path(str(file)).is_file() for file in raw.images):
        return opened(layout, raw, Path())
    return posed(name, raw)


@overload
def fit(
    capture: Capture,
    frames: ArrayLike,
    reconstructor: Literal["splats"] = "splats",
    **settings: Any,
) -> SplatModel: ...


@overload
def fit(capture: Capture, frames: ArrayLike, reconstructor: str, **settings: Any) -> Model: ...


def fit(
    capture: Capture, frames: ArrayLike, reconstructor: str = "splats", **settings: Any
) -> Model:
    """Reconstruct a capture's scene from some of its frames.

    Args:
        capture: at the size to reconstruct at: the `long_side` of `fsel.read_capture`.
        frames: numbers or names of two or more distinct frames.
        reconstructor: a key of `RECONSTRUCTORS`.
        settings: of the reconstructor.

    Returns:
        A model: `render(views)` gives (T, h, w, 3) float32 images; that of `splats` also has
        `export_ply(path)`, which writes standard Gaussian splats.

    Raises:
        ValueError: for an unknown reconstructor, fewer than two frames, repeated ones, or frames
            that the capture does not have.
        TypeError: if an argument is not a capture, or not frames.
        ImportError: when the reconstructor needs a package that is not installed.

    Example:
        >>> capture = fsel.read_capture("captures/garden", long_side=48)
        >>> model = fsel.fit(capture, range(0, 80, 8))
        >>> model.render(capture.view([1, 2])).shape
        (2, 36, 48, 3)
    """
    from fsel.reconstruct import RECONSTRUCTORS

    factory, chosen = RECONSTRUCTORS.checked(reconstructor), _frames(capture, frames)
    return factory(capture, **settings).fit(chosen)


def evaluate(
    capture: Capture, model: Model, targets: ArrayLike, metrics: Metrics | None = None
) -> dict[str, np.ndarray]:
    """Compare a model's renderings with frames that it was not made from.

    Args:
        capture: what the model was made from, at the same size.
        model: what `fit` returns.
        targets: numbers or names of T held-out frames.
        metrics: keys of `fsel.metrics.REGISTERED`, or key -> settings, as
            `{"psnr": {}, "lpips": {"net": "alex", "weights": path}}`; None for `psnr` in dB, `ssim`
            and `gmsd` (lower is better).

    Returns:
        Metric -> (T,) float64.

    Raises:
        ValueError, FileNotFoundError, ImportError: for an unknown metric, or what one refuses.
        TypeError: if an argument is not a capture, a model or frames.

    Example:
        >>> capture = fsel.read_capture("captures/garden", long_side=48)
        >>> model = fsel.fit(capture, range(0, 80, 8))
        >>> sorted(fsel.evaluate(capture, model, [1, 2]))
        ['gmsd', 'psnr', 'ssim']
    """
    from fsel.metrics import METRICS, checked, score_views

    if not hasattr(model, "render"):
        raise unexpected("model", model, "what fsel.fit returned")
    chosen = METRICS if metrics is None else checked(metrics)
    frames = _frames(capture, targets)
    truth = np.asarray(capture.images[frames])
    scores = score_views(model.render(capture.view(frames)), truth, None, chosen)
    return dict(zip(chosen, scores.T, strict=True))


def _frames(capture: Capture, frames: ArrayLike) -> np.ndarray:
    """(n,) int64 distinct frames by name or number, of what must be a capture."""
    if not isinstance(capture, Capture):
        raise unexpected("capture", capture, "a Capture. Hint: fsel.read_capture(folder)")
    found = frames_of(capture, frames)
    if len(found) < np.size(frames) and np.asarray(frames).dtype != bool:
        raise ValueError(f"frames are repeated: {np.size(frames)} are named, {len(found)} distinct")
    return found
