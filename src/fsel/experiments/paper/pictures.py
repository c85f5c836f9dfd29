"""Rendered views of several selections beside the truth: what all figures of views share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from fsel.core.capture import Capture
from fsel.core.files import File, Files
from fsel.core.subsets import evenly
from fsel.evaluation.numbers import write_csv
from fsel.evaluation.plan import plan_positions
from fsel.evaluation.views import Shown, draw
from fsel.experiments.studies.footprint import fit_and_render
from fsel.metrics import METRICS, score_views
from fsel.reconstruct import needs_gpu, reconstructor_of
from fsel.selection.frames import frames_of
from fsel.selectors.baselines import METHODS, PAPER
from fsel.selectors.policies import POLICIES

LABELS = {name: m.label for name, m in METHODS.items()} | {
    name: policy.label for name, policy in POLICIES.items()
}
STRONGEST = "strongest"  # stands for a method that `strongest_baseline` names
VIEWED = ("all", "uniform", STRONGEST, "less_is_more", "fsel")
WARM_FRAMES, WARM_SIDE = 4, 32  # of a reconstruction that only compiles


def strongest_baseline(evaluation: pd.DataFrame, k: int, but: Sequence[str]) -> str:
    """The paper's baseline with the highest mean PSNR at a budget, some left out.

    Args:
        evaluation: method, seed, k, target, psnr.
        k: the budget.
        but: baselines that have columns of their own.
    """
    external = [name for name in PAPER if name not in {*but, "untrained"}]
    rivals = evaluation[(evaluation["k"] == k) & evaluation["method"].isin(external)]
    if rivals.empty:
        raise ValueError(f"no baseline of {external} was evaluated at a budget of {k}")
    return str(rivals.groupby("method")["psnr"].mean().idxmax())


def resolved(methods: Sequence[str], evaluation: pd.DataFrame, k: int) -> list[str]:
    """The methods, `STRONGEST` replaced by the name of the strongest that is not among them."""
    return [strongest_baseline(evaluation, k, methods) if m == STRONGEST else m for m in methods]


def draw_views(
    capture: Capture,
    picked: pd.DataFrame,
    evaluation: pd.DataFrame,
    targets: np.ndarray,
    figures: Files,
    numbers: File,
    *,
    views: int,
    k: int,
    reconstruction: Mapping,
    note: str,
    methods: Sequence[str],
) -> None:
    """Targets rendered from each selection, its cameras from above below them.

    Args:
        capture: at the pictures' size or larger.
        picked: method, k, order, name of one seed; frames are found in the capture by their names.
        evaluation: from which `strongest` is found.
        targets: (T,) held-out frames.
        numbers: receives method, k, role (`target` or `selected`), frame, x, y in world units and,
            of targets, the metrics; of each method, the processor's seconds of its reconstruction
            and of rendering all targets.
        methods: columns, in order. `strongest` is the paper's baseline with the highest PSNR at k
            that is not among them.
        views: targets drawn, evenly spaced in capture order; one is the middle one.
        k: frames; `all` takes its own number.
        note: what made the numbers.
    """
    places, drawn = plan_positions(capture), spaced(len(targets), views)
    tiny = reconstructor_of(capture, {**reconstruction, "long_side": WARM_SIDE})
    tiny.fit(targets[:WARM_FRAMES]).render(tiny.capture.view(targets[:1]))
    columns, tables = [], []
    for method in resolved(methods, evaluation, k):
        frames = frames_of(capture, picks_of(picked, method, k))
        rendered, scores, seconds = render_cold(capture, frames, targets, reconstruction)
        cost = f"{len(frames)} frames, {seconds:.1f} s"
        title = f"{LABELS[method]}\n{cost}\nmean {scores[:, 0].mean():.2f} dB"
        columns.append(Shown(title, rendered[drawn], scores[drawn, 0], frames))
        tables.append(_table(method, frames, targets, scores, seconds, places))
    write_csv(pd.concat(tables), numbers)
    small = capture.resized(reconstruction["long_side"])
    truth = np.asarray(small.images[targets[drawn]])
    text = (
        "Heading: frames, processor seconds to reconstruct and to render "
        f"{len(targets)} held-out views, their mean PSNR. Inset: mean absolute error of the "
        "colours. Below: cameras from above, selected ones as large dots, held-out views as "
        f"diamonds. {note}"
    )
    draw(truth, columns, places, targets, figures, text)


def spaced(count: int, views: int) -> np.ndarray:
    """(views,) evenly spaced numbers below `count`, ends included; one is the middle one."""
    if views == 1:
        return np.array([count // 2])
    return evenly(count, views)


def render_cold(
    capture: Capture, frames: np.ndarray, targets: np.ndarray, reconstruction: Mapping
) -> tuple[np.ndarray, np.ndarray, float]:
    """Targets rendered from frames by a reconstructor that has cached nothing yet.

    Args:
        frames: (K,) to reconstruct from.
        targets: (T,) to render.

    Returns:
        (T, h, w, 3) float32 views, (T, 3) metrics as `METRICS`, and the processor's seconds of
        fitting and rendering; of a GPU by the clock.
    """
    reconstructor, gpu = reconstructor_of(capture, reconstruction), needs_gpu(reconstruction)
    views = reconstructor.capture.view(targets)
    rendered, _, *seconds = fit_and_render(reconstructor, np.sort(frames), views, gpu)
    truth = np.asarray(reconstructor.capture.images[targets])
    return rendered, score_views(rendered, truth), sum(seconds)


def _table(
    method: str,
    frames: np.ndarray,
    targets: np.ndarray,
    scores: np.ndarray,
    seconds: float,
    places: np.ndarray,
) -> pd.DataFrame:
    selected = pd.DataFrame({"role": "selected", "frame": frames})
    held_out = pd.DataFrame({"role": "target", "frame": targets})
    held_out[list(METRICS)] = scores
    table = pd.concat([held_out, selected], ignore_index=True)
    table[["x", "y"]] = places[table["frame"]]
    head = {"method": method, "k": len(frames), "seconds": seconds}
    columns = [*head, "role", "frame", "x", "y", *METRICS]
    return table.assign(**head)[columns]


def picks_of(picked: pd.DataFrame, method: str, k: int) -> list[str]:
    """Names of a method's frames at a budget; of one that takes every frame, all of them.

    Args:
        picked: method, k, order, name of one seed.
        method, k: which.
    """
    part = picked[picked["method"] == method]
    part = part if method == "all" else part[part["k"] == k]
    return part.sort_values("order")["name"].tolist()
