"""Reconstruct from frames, and compare what is rendered with frames that were held out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np

from fsel.core.capture import Capture
from fsel.core.wording import unexpected
from fsel.selection.frames import frames_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from fsel.metrics import Metrics
    from fsel.reconstruct import Model
    from fsel.reconstruct.splats.reconstructor import SplatModel


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
        ValueError: for an unknown reconstructor, fewer than two frames, repeated ones, or such that
            the capture does not have.
        TypeError: for what is no capture, or no frames.
        ImportError: when the reconstructor needs a package that is not installed.
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
        TypeError: for what is no capture, no model or no frames.
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
